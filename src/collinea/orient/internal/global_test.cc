// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/global.h"

#include <gtest/gtest.h>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/orient/internal/position_averaging.h"
#include "collinea/orient/internal/rotation_averaging.h"
#include "collinea/orient/internal/test_pairs.h"
#include "collinea/orient/orient.h"

namespace collinea {
namespace {

const collinea::Run kRun;

// Cameras turned at random; pairs of each with the next four, exact but for `noise_rad`.
struct Rotations {
  std::vector<Eigen::Quaterniond> exact;
  std::vector<RelativeRotation> pairs;

  // The largest angle to the truth after the best turn of the whole, which is that of camera 0.
  [[nodiscard]] double worst_rad(const std::vector<Eigen::Quaterniond>& found) const {
    double worst = 0;
    const Eigen::Quaterniond world = found[0].conjugate() * exact[0];
    for (std::size_t i = 0; i < exact.size(); ++i)
      worst = std::max(worst, found[i].angularDistance(exact[i] * world.conjugate()));
    return worst;
  }
};

Rotations rotations(int count, double noise_rad) {
  Random random(5);
  Rotations result;
  for (int i = 0; i < count; ++i) result.exact.push_back(rotation_by(2 * testing::normal3(random)));
  for (int i = 0; i < count; ++i)
    for (int k = i + 1; k <= std::min(i + 4, count - 1); ++k)
      result.pairs.push_back(
          {i, k,
           (rotation_by(noise_rad * testing::normal3(random)) * result.exact[k] * result.exact[i].conjugate())
               .normalized(),
           1});
  return result;
}

TEST(AverageRotations, ExactPairsGiveExactRotations) {
  const Rotations r = rotations(40, 0);
  EXPECT_LT(r.worst_rad(average_rotations(40, r.pairs, kRun)), 1e-9);
}

TEST(AverageRotations, WrongPairsDoNoHarm) {
  Rotations r = rotations(40, 1e-3);
  const double without = r.worst_rad(average_rotations(40, r.pairs, kRun));
  for (std::size_t i = 3; i < r.pairs.size(); i += 10) r.pairs[i].second_from_first = rotation_by({0.5, -1, 0.3});
  EXPECT_LT(r.worst_rad(average_rotations(40, r.pairs, kRun)), 2 * without + 1e-3);
}

// A strip whose pairs all pitch by a little too much, as with a wrong lens, with the bases between its cameras.
TEST(RotateTowards, TakesAwayWhatErrorsCommonToAllPairsAddUpTo) {
  constexpr int kCount = 40;
  const Eigen::Vector3d across(0, 0, 1);  // of the line x and of the side line y below
  std::vector<RelativeRotation> pairs;
  std::vector<SeenDirection> directions;
  std::vector<Eigen::Quaterniond> cameras;
  for (int i = 0; i < kCount; ++i) {
    cameras.push_back(rotation_by(0.02 * (i - kCount / 2) * across));  // bent; the truth is no rotation at all
    if (i > 0) pairs.push_back({i - 1, i, rotation_by(0.02 * across), 1});
    for (const Eigen::Vector3d& base : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)})
      directions.push_back({i, base, base, 0.05});
  }
  rotate_towards(pairs, directions, cameras, kRun);
  for (int i = 0; i < kCount; ++i)
    EXPECT_LT(cameras[i].angularDistance(Eigen::Quaterniond::Identity()), i > 5 && i < kCount - 6 ? 0.01 : 0.03) << i;
}

TEST(RotateTowards, AWrongDirectionDoesNoHarm) {
  std::vector<SeenDirection> directions;
  std::vector<Eigen::Quaterniond> cameras{rotation_by({0.1, -0.05, 0.2})};
  for (const Eigen::Vector3d& base :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, -1, 0)})
    directions.push_back({0, base, base, 0.02});
  directions.push_back({0, {0, 0, 1}, {1, 0, 0}, 0.02});
  rotate_towards({}, directions, cameras, kRun);
  EXPECT_LT(cameras[0].angularDistance(Eigen::Quaterniond::Identity()), 0.02);
}

// Cameras on a grid with directions to their neighbours in a frame that is turned against the world.
struct Positions {
  std::vector<Eigen::Vector3d> exact;
  std::vector<RelativeDirection> directions;  // in the world
  std::vector<ReceivedPosition> received;
};

Positions positions(int rows, int columns, double sigma_m, double noise_rad) {
  Random random(6);
  Positions p;
  for (int i = 0; i < rows * columns; ++i) {
    p.exact.emplace_back(20.0 * (i % columns), 35.0 * (i / columns), 100 + random.normal());
    p.received.push_back({p.exact[i] + sigma_m * testing::normal3(random), Eigen::Vector3d::Constant(sigma_m)});
  }
  for (int i = 0; i < rows * columns; ++i)
    for (const int k : {i + 1, i + columns, i + columns + 1})
      if (k < rows * columns && (k == i + columns || i % columns + 1 < columns)) {
        const Eigen::Vector3d base = (p.exact[k] - p.exact[i]).normalized();
        p.directions.push_back({i, k, (rotation_by(noise_rad * testing::normal3(random)) * base).normalized()});
      }
  return p;
}

TEST(WorldFromDirections, FindsTheRotationDespiteWrongPositions) {
  Positions p = positions(5, 8, 0.5, 0.002);
  p.received[11].position_in_world += Eigen::Vector3d(60, -40, 20);
  const Eigen::Quaterniond world_from_frame = rotation_by({0.4, -1.1, 2});
  for (RelativeDirection& pair : p.directions) pair.direction = world_from_frame.conjugate() * pair.direction;
  const auto found = world_from_directions(p.directions, p.received);
  ASSERT_TRUE(found);
  EXPECT_LT(found->angularDistance(world_from_frame), 0.02);
}

TEST(WorldFromDirections, OneStripFixesNoRotation) {
  const Positions p = positions(1, 12, 0.05, 0);
  EXPECT_FALSE(world_from_directions(p.directions, p.received));
}

TEST(AveragePositions, DirectionsMakePositionsBetter) {
  const Positions p = positions(6, 10, 1.5, 0.005);
  const auto found = average_positions(p.directions, p.received, kRun);
  double before = 0, after = 0;
  for (std::size_t i = 0; i < p.exact.size(); ++i) {
    before += (p.received[i].position_in_world - p.exact[i]).squaredNorm();
    after += (found[i] - p.exact[i]).squaredNorm();
  }
  EXPECT_LT(std::sqrt(after), 0.5 * std::sqrt(before));
}

TEST(AveragePositions, ACameraWithoutPositionIsPlacedByItsDirections) {
  Positions p = positions(5, 8, 0.1, 0);
  p.received[18] = {};
  const auto found = average_positions(p.directions, p.received, kRun);
  EXPECT_LT((found[18] - p.exact[18]).norm(), 0.5);
}

Block survey() {
  return testing::test_block(
      {.rows = 4, .columns = 7, .points = 700, .sigma_px = 0.3, .position_sigma_m = 0.5, .control = 0});
}

TEST(OrientGlobally, FindsWhatGrowthFinds) {
  testing::Matched matched = testing::matched(survey());
  matched.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  std::map<OrientMode, Block> found;
  for (const OrientMode mode : {OrientMode::kIncremental, OrientMode::kGlobal}) {
    OrientOptions options;
    options.mode = mode;
    const auto done = orient(matched.setup, matched.pairs, matched.source(), options, kRun);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(count_oriented(done->block), 28u);
    found[mode] = done->block;
  }
  EXPECT_LT(testing::centre_rms_m(found.at(OrientMode::kGlobal), found.at(OrientMode::kIncremental), false), 0.01);
}

TEST(OrientGlobally, DoesNotDependOnThreads) {
  testing::Matched matched = testing::matched(survey());
  matched.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  OrientOptions options;
  options.mode = OrientMode::kGlobal;
  std::vector<Block> found;
  for (const int threads : {1, 2}) {
    collinea::Run run;
    run.threads = threads;
    found.push_back(orient(matched.setup, matched.pairs, matched.source(), options, run)->block);
  }
  for (const auto& [image, pose] : oriented_images(found[0])) {
    EXPECT_EQ(pose.translation, pose_of(found[1], image).translation);
    EXPECT_EQ(pose.rotation.coeffs(), pose_of(found[1], image).rotation.coeffs());
  }
  ASSERT_EQ(found[0].observations.size(), found[1].observations.size());
}

TEST(OrientGlobally, RefusesToBeginFromPositionsThatAreNotToBeUsed) {
  testing::Matched matched = testing::matched(survey());
  matched.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  OrientOptions options;
  options.mode = OrientMode::kGlobal;
  options.use_positions = false;
  const auto done = orient(matched.setup, matched.pairs, matched.source(), options, kRun);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
}

TEST(OrientGlobally, SaysWhenPositionsDoNotFixTheBlock) {
  const testing::Matched matched = testing::matched(testing::test_block({.points = 600}));  // none
  OrientOptions options;
  options.mode = OrientMode::kGlobal;
  const auto done = orient(matched.setup, matched.pairs, matched.source(), options, kRun);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
