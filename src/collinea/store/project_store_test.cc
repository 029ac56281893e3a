// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/project_store.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "collinea/store/sqlite.h"
#include "collinea/store/test_project_store.h"

namespace collinea {
namespace {

TEST_F(ProjectStoreTest, ANewProjectIsEmpty) {
  const ProjectStore store = open();
  EXPECT_EQ(store.folder(), folder_);
  EXPECT_TRUE(fs::exists(folder_ / "block.db"));
  const auto block = store.read_block();
  ASSERT_TRUE(block);
  EXPECT_TRUE(block->images.empty() && !block->georeference);
  EXPECT_TRUE(store.features_done()->empty());
  EXPECT_TRUE(store.read_pairs()->empty());
  EXPECT_TRUE(store.read_steps()->empty());
  EXPECT_FALSE(store.read_step("detect")->has_value());
}

TEST_F(ProjectStoreTest, TheSetupComesBackBitByBitAfterReopening) {
  const Block block = setup_block();
  { ASSERT_TRUE(open().write_setup(block)); }
  const auto read = open().read_setup();
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_TRUE(read->georeference);
  EXPECT_EQ(read->georeference->crs, "EPSG:32633");
  EXPECT_TRUE(same_bits(read->georeference->origin_latitude_deg, block.georeference->origin_latitude_deg));
  EXPECT_TRUE(same_bits(read->georeference->origin_height_m, -0.0));
  expect_same_cameras(*read, block);
  expect_same_images(*read, block);
  expect_same_control(*read, block);
}

TEST_F(ProjectStoreTest, TheOrientationComesBackBitByBitAndLeavesTheSetupAlone) {
  const Block setup = setup_block(), oriented = oriented_block(6000);  // 24,000 observations: more than one chunk
  ProjectStore store = open();
  ASSERT_TRUE(store.write_setup(setup));
  ASSERT_TRUE(store.write_orientation(oriented));
  const auto block = store.read_block();
  ASSERT_TRUE(block) << block.error().message;
  expect_same_cameras(*block, oriented);
  expect_same_images(*block, oriented);
  expect_same_control(*block, oriented);
  expect_same_orientation(*block, oriented);
  const auto again = store.read_setup();
  ASSERT_TRUE(again);
  expect_same_cameras(*again, setup);
  expect_same_control(*again, setup);
  EXPECT_TRUE(oriented_images(*again).empty() && again->points.empty() && again->observations.empty());
}

TEST_F(ProjectStoreTest, TiesComeOneByOneAndTheOrientationWithoutThem) {
  const Block oriented = oriented_block(6000);
  ProjectStore store = open();
  ASSERT_TRUE(store.write_setup(setup_block()));
  ASSERT_TRUE(store.write_orientation(oriented));
  auto block = store.read_orientation();
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_TRUE(block->points.empty() && block->observations.empty());
  expect_same_cameras(*block, oriented);
  expect_same_control(*block, oriented);
  std::size_t points = 0;
  Block with_ties = *block;
  ASSERT_TRUE(store.read_ties(*block, [&](PointId id, const TiePoint& point, auto observations) {
    EXPECT_TRUE(with_ties.points.empty() || with_ties.points.rbegin()->first < id);
    with_ties.points[id] = point;
    for (const Observation& seen : observations) EXPECT_EQ(seen.point, id);
    with_ties.observations.insert(with_ties.observations.end(), observations.begin(), observations.end());
    ++points;
  }));
  EXPECT_EQ(points, oriented.points.size());
  expect_same_orientation(with_ties, oriented);
  block->images.erase(oriented.observations.back().image);
  EXPECT_FALSE(store.read_ties(*block, [](auto, const auto&, auto) {}));
}

TEST_F(ProjectStoreTest, ASmallerOrientationReplacesALargerOne) {
  ProjectStore store = open();
  ASSERT_TRUE(store.write_setup(setup_block()));
  ASSERT_TRUE(store.write_orientation(oriented_block(6000)));
  const Block small = oriented_block(2);
  ASSERT_TRUE(store.write_orientation(small));
  expect_same_orientation(*store.read_block(), small);
}

TEST_F(ProjectStoreTest, AnAdjustmentKeepsWhatItBeganWith) {
  const Block found = oriented_block(6000);
  Block adjusted = oriented_block(50);
  adjusted.images.begin()->second.bend = {Eigen::Vector3d(0.1, 0.2, 0.97), 3e-5};
  BlockCovariances covariances;
  Random random(7);
  const auto symmetric = [&](Eigen::Index size) {
    const Eigen::MatrixXd any = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return random.normal(); });
    return Eigen::MatrixXd(any + any.transpose());
  };
  for (const auto& [image, pose] : oriented_images(adjusted)) covariances.poses[image] = symmetric(6);
  for (const auto& [camera, its] : adjusted.cameras) covariances.cameras[camera] = symmetric(11);
  for (std::size_t i = 0; i < adjusted.points.size(); ++i) covariances.points.emplace_back(symmetric(3));
  ProjectStore store = open();
  ASSERT_TRUE(store.write_setup(setup_block()));
  ASSERT_TRUE(store.write_orientation(found));
  EXPECT_TRUE(store.read_covariances()->poses.empty());
  expect_same_orientation(*store.read_found(), found);
  for (int times = 0; times < 2; ++times) {  // the second begins where the first did
    ASSERT_TRUE(store.write_adjustment(adjusted, covariances));
    const Block block = *store.read_block();
    expect_same_orientation(block, adjusted);
    EXPECT_EQ(block.images.begin()->second.bend.per_tangent_rad, 3e-5);
    EXPECT_EQ(block.images.begin()->second.bend.down_in_cam, Eigen::Vector3d(0.1, 0.2, 0.97));
    const Block before = *store.read_found();
    expect_same_orientation(before, found);
    EXPECT_EQ(before.images.begin()->second.bend.per_tangent_rad, 0);
    const auto known = store.read_covariances();
    ASSERT_TRUE(known) << known.error().message;
    EXPECT_TRUE(known->poses == covariances.poses && known->cameras == covariances.cameras);
    EXPECT_TRUE(known->points == covariances.points);
  }
  const Block other = oriented_block(2);
  ASSERT_TRUE(store.write_orientation(other));  // of another orientation nothing was adjusted yet
  EXPECT_TRUE(store.read_covariances()->points.empty());
  expect_same_orientation(*store.read_found(), other);
}

TEST_F(ProjectStoreTest, AnOrientationOfVanishedImagesIsErasedWithThem) {
  ProjectStore store = open();
  Block setup = setup_block();
  ASSERT_TRUE(store.write_setup(setup));
  ASSERT_TRUE(store.write_orientation(oriented_block(3)));
  ASSERT_TRUE(store.write_setup(setup));
  EXPECT_EQ(store.read_block()->points.size(), 3u);
  setup.images.erase({2});
  ASSERT_TRUE(store.write_setup(setup));
  EXPECT_EQ(store.read_block()->points.size(), 0u);
}

TEST_F(ProjectStoreTest, FeaturesComeBackBitByBit) {
  Random random(3);
  Features features;
  for (int i = 0; i < 300; ++i) {
    features.keypoints.push_back({float(random.normal()), float(random.normal()), 1.5f, -0.0f, 1e-30f});
    for (auto& byte : features.descriptors.emplace_back()) byte = std::uint8_t(random.bits());
  }
  ProjectStore store = open();
  ASSERT_TRUE(store.write_features({5}, features, "abc"));
  ASSERT_TRUE(store.write_features({2}, {}, "def"));
  const auto read = store.read_features({5});
  ASSERT_TRUE(read);
  ASSERT_EQ(read->keypoints.size(), 300u);
  EXPECT_EQ(std::memcmp(read->keypoints.data(), features.keypoints.data(), 300 * sizeof(Keypoint)), 0);
  EXPECT_EQ(read->descriptors, features.descriptors);
  const auto keypoints = store.read_keypoints({5});
  EXPECT_EQ(std::memcmp(keypoints->data(), features.keypoints.data(), 300 * sizeof(Keypoint)), 0);
  EXPECT_TRUE(store.read_features({2})->keypoints.empty());
  EXPECT_EQ(*store.features_done(), (std::map<ImageId, std::string>{{{2}, "def"}, {{5}, "abc"}}));
  ASSERT_TRUE(store.erase_features({5}));
  const auto deleted = store.read_features({5});
  ASSERT_FALSE(deleted);
  EXPECT_EQ(deleted.error().code, Errc::kNotFound);
}

TEST_F(ProjectStoreTest, FeaturesFollowTheirImagesToNewNumbers) {
  ProjectStore store = open();
  for (const std::uint32_t id : {0u, 1u, 2u, 5u})
    ASSERT_TRUE(store.write_features({id}, {std::vector<Keypoint>(id), std::vector<Descriptor>(id)},
                                     "of " + std::to_string(id)));
  EXPECT_EQ(store.count_features({5}), 5u);
  EXPECT_FALSE(store.count_features({3}));
  ASSERT_TRUE(store.renumber_features({{{0}, {1}}, {{1}, {2}}, {{5}, {3}}, {{7}, {8}}}));
  EXPECT_EQ(*store.features_done(), (std::map<ImageId, std::string>{{{1}, "of 0"}, {{2}, "of 1"}, {{3}, "of 5"}}));
  EXPECT_EQ(store.count_features({3}), 5u);
  ASSERT_TRUE(store.renumber_features({{{1}, {2}}, {{2}, {1}}}));
  EXPECT_EQ(*store.features_done(), (std::map<ImageId, std::string>{{{1}, "of 1"}, {{2}, "of 0"}, {{3}, "of 5"}}));
}

TEST_F(ProjectStoreTest, TheHashOfTheSetupChangesWithEveryPartOfIt) {
  ProjectStore store = open();
  const auto hash_of = [&](const Block& block) {
    EXPECT_TRUE(store.write_setup(block));
    return store.setup_hash().value();
  };
  const Block setup = setup_block();
  const std::uint64_t first = hash_of(setup);
  std::vector<Block> changed(9, setup);
  changed[0].georeference->origin_height_m += 1e-9;
  changed[1].cameras.begin()->second.prior.sigma_f_px += 1e-9;
  changed[2].images.begin()->second.position->sigma_m.z() *= 2;
  changed[3].control.begin()->second.sigma_m.x() *= 2;
  changed[4].control.begin()->second.role = ControlRole::kControl;
  changed[5].control_observations.front().sigma_px *= 2;
  changed[6].geodetic.front().sigma *= 2;
  changed[7].geodetic.clear();
  changed[8].control_observations.back().shape.correlation = 0;
  for (const Block& other : changed) EXPECT_NE(hash_of(other), first);
  EXPECT_EQ(hash_of(setup), first);
  ASSERT_TRUE(store.write_orientation(oriented_block(3)));
  EXPECT_EQ(store.setup_hash(), first);
}

TEST_F(ProjectStoreTest, WhatCameOfAStepCanBeSaidAnewInItsPlace) {
  ProjectStore store = open();
  ASSERT_TRUE(store.write_step({"a", "b", 1, 2, 3, ImportRecord{.images = 3}}));
  ASSERT_TRUE(store.write_step({"c", "d", 1, 2, 3, DetectRecord{}}));
  ASSERT_TRUE(store.write_outcome(ImportRecord{.images = 4}));
  ASSERT_TRUE(store.write_outcome(MatchRecord{}));  // of no step that is done
  const auto steps = store.read_steps().value();
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].inputs_hash, "a");
  EXPECT_EQ(std::get<ImportRecord>(steps[0].outcome).images, 4u);
}

TEST_F(ProjectStoreTest, PairsComeBackSortedAndCanBeErasedByInputs) {
  ImagePair good = failed_pair({1}, {4});
  good.geometry = PairGeometry::kPlanar;
  good.matches = {{1, 2}, {7, 0xfffffffeu}};
  good.second_from_first = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0, 1.0 / 3, 0}};
  good.median_parallax_rad = 0.1;
  good.putative = 55;
  const ImagePair failed = failed_pair({0}, {9});
  ProjectStore store = open();
  ASSERT_TRUE(store.write_pairs({good, failed}, "v1"));
  auto read = store.read_pairs();
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].first, ImageId{0});
  EXPECT_EQ((*read)[0].geometry, PairGeometry::kNone);
  EXPECT_TRUE((*read)[0].matches.empty());
  const ImagePair& back = (*read)[1];
  EXPECT_EQ(back.geometry, PairGeometry::kPlanar);
  EXPECT_EQ(back.matches, good.matches);
  EXPECT_EQ(back.putative, 55);
  EXPECT_TRUE(same_bits(back.median_parallax_rad, 0.1));
  EXPECT_TRUE(same_vector(back.second_from_first.rotation.coeffs(), good.second_from_first.rotation.coeffs()));
  EXPECT_TRUE(same_vector(back.second_from_first.translation, good.second_from_first.translation));
  ASSERT_TRUE(store.write_pairs({failed}, "v2"));
  EXPECT_EQ(store.pairs_done("v1")->size(), 1u);
  ASSERT_TRUE(store.erase_pairs_except("v2"));
  EXPECT_EQ(*store.pairs_done("v2"), (std::vector<std::pair<ImageId, ImageId>>{{{0}, {9}}}));
  EXPECT_TRUE(store.pairs_done("v1")->empty());
}

TEST_F(ProjectStoreTest, StepsAreKeptInTheOrderTheyWereWritten) {
  ProjectStore store = open();
  ASSERT_TRUE(store.write_step({"a", "b", 1.5, 2.25, 1e9, ImportRecord{}}));
  ASSERT_TRUE(store.write_step({"b", "c", 1, 2, 3, DetectRecord{.features = 3}}));
  ASSERT_TRUE(store.write_step({"x", "y", 1, 2, 3, ImportRecord{}}));
  const auto steps = store.read_steps();
  ASSERT_EQ(steps->size(), 2u);
  EXPECT_EQ((*steps)[0].name(), "detect");
  EXPECT_EQ(std::get<DetectRecord>((*steps)[0].outcome).features, 3u);
  EXPECT_EQ((*steps)[1].inputs_hash, "x");
  EXPECT_EQ((*store.read_step("import"))->output_hash, "y");
  ASSERT_TRUE(store.erase_step("import"));
  EXPECT_FALSE(store.read_step("import")->has_value());
}

TEST_F(ProjectStoreTest, ADamagedRecordIsAnErrorAndOneOfAnotherVersionIsNamedSo) {
  ProjectStore store = open();
  ASSERT_TRUE(store.write_step({"a", "b", 1, 2, 3, DetectRecord{.features = 3}}));
  auto database = sqlite::Database::open(folder_ / "block.db");
  ASSERT_TRUE(database);
  ASSERT_TRUE(database->execute("UPDATE step_records SET record = substr(record, 1, length(record) - 1)"));
  EXPECT_EQ(store.read_step("detect").error().code, Errc::kBadFormat);
  EXPECT_NE(store.read_step("detect").error().message.find("block.db"), std::string::npos);
  EXPECT_EQ(store.read_steps().error().code, Errc::kBadFormat);
  ASSERT_TRUE(database->execute("UPDATE step_records SET record = x'63'"));
  EXPECT_EQ(store.read_step("detect").error().code, Errc::kUnsupported);
  EXPECT_EQ(store.read_outcome<DetectRecord>().error().code, Errc::kUnsupported);
  EXPECT_EQ(store.read_outcome<MatchRecord>().error().code, Errc::kNotFound);
}

// Once steps were kept as text in a table of its own.
TEST_F(ProjectStoreTest, StepsOfAProjectFromBeforeCountAsNotDone) {
  (void)open();
  {
    auto database = sqlite::Database::open(folder_ / "block.db");
    ASSERT_TRUE(database);
    ASSERT_TRUE(
        database->execute("DROP TABLE step_records; CREATE TABLE steps (name TEXT, report_json TEXT); "
                          "INSERT INTO steps VALUES ('detect', '{}')"));
  }
  const auto looked_at = ProjectStore::open_read_only(folder_);
  ASSERT_TRUE(looked_at);
  EXPECT_TRUE(looked_at->read_steps()->empty());
  EXPECT_FALSE(looked_at->read_step("detect")->has_value());
  ProjectStore store = open();
  EXPECT_TRUE(store.read_steps()->empty());
  ASSERT_TRUE(store.write_step({"a", "b", 1, 2, 3, DetectRecord{}}));
  EXPECT_EQ(store.read_steps()->size(), 1u);
}

TEST_F(ProjectStoreTest, CanBeReadWhereNothingCanBeWritten) {
  const StepRecord step{"in", "out", 1, 2, 3, OrientationRecord{}};
  ASSERT_TRUE(open().write_step(step));
  fs::rename(folder_, folder_.string() + " 100% #1?");
  const fs::path folder = folder_.string() + " 100% #1?";
  const auto files = [&] { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); };
  const auto before = files();
  {
    auto store = ProjectStore::open_read_only(folder);
    ASSERT_TRUE(store) << store.error().message;
    const auto found = store->read_step("orient");
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ((*found)->output_hash, "out");
    EXPECT_TRUE(store->read_setup());
    EXPECT_EQ(store->write_step(step).error().code, Errc::kBadInput);
    EXPECT_EQ(files(), before);
  }
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  {
    const auto store = ProjectStore::open_to_read(folder);
    EXPECT_TRUE(store && store->read_steps());
  }
  fs::permissions(folder, fs::perms::owner_all);
  fs::remove_all(folder);
  EXPECT_EQ(ProjectStore::open_to_read(folder).error().code, Errc::kNotFound);
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(ProjectStoreTest, ManyThreadsMayWriteAtOnce) {
  ProjectStore store = open();
  std::vector<int> failures(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        Features features;
        features.keypoints.resize(10 + t);
        features.descriptors.resize(10 + t);
        for (std::uint32_t i = 0; i < 10; ++i) failures[t] += !store.write_features({10 * t + i}, features, "h");
      });
  }
  EXPECT_EQ(failures, std::vector<int>(4, 0));
  EXPECT_EQ(store.features_done()->size(), 40u);
  EXPECT_EQ(store.read_keypoints({35})->size(), 13u);
}

TEST_F(ProjectStoreTest, AFileThatIsNoDatabaseIsRefusedAndLeftAlone) {
  fs::create_directories(folder_);
  const std::string garbage(5000, 'x');
  std::ofstream(folder_ / "block.db") << garbage;
  const auto store = ProjectStore::open(folder_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Errc::kBadFormat);
  EXPECT_NE(store.error().message.find("block.db"), std::string::npos);
  EXPECT_EQ(fs::file_size(folder_ / "block.db"), 5000u);
}

TEST_F(ProjectStoreTest, ADatabaseOfANewerVersionIsRefused) {
  open();
  std::fstream file(folder_ / "block.db", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(60);  // user_version in SQLite's file header
  file.write("\0\0\0\x63", 4);
  file.close();
  const auto store = ProjectStore::open(folder_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Errc::kUnsupported);
}

TEST_F(ProjectStoreTest, DamagedBytesNeverCrash) {
  {
    ProjectStore store = open();
    ASSERT_TRUE(store.write_setup(setup_block()));
    ASSERT_TRUE(store.write_orientation(oriented_block(50)));
    ASSERT_TRUE(store.write_features({1}, {.keypoints = {{}}, .descriptors = {{}}}, "h"));
    ASSERT_TRUE(store.write_pairs({failed_pair({1}, {2})}, "h"));
  }
  std::ifstream input(folder_ / "block.db", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(input)), {});
  int refused = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Random random(11, std::uint64_t(trial));
    std::string bytes = whole;
    if (trial % 4 == 0) bytes.resize(random.below(std::uint32_t(whole.size())));
    for (int i = 0; i < 400 && !bytes.empty(); ++i)
      bytes[random.below(std::uint32_t(bytes.size()))] = char(random.bits());
    std::ofstream(folder_ / "block.db", std::ios::binary) << bytes;
    const auto store = ProjectStore::open(folder_);
    if (!store || !store->read_block()) ++refused;
    if (!store) continue;
    (void)store->read_setup();
    (void)store->read_features({1});
    (void)store->read_pairs();
  }
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace collinea
