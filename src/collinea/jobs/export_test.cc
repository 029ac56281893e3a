// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/export.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/edit/make_edits.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(Export, ATiePointOfVeryManyImagesHasTheLargestNumberThereIs) {
  const TestFolder folder;
  Block block;
  block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
  block.points[PointId{0}].position_in_world = {0, 0, 10};
  for (std::uint32_t i = 0; i < 300; ++i) {
    block.images[ImageId{i}] = {.file = std::to_string(i) + ".jpg", .camera = CameraId{0}};
    set_pose(block, ImageId{i}, {});
    block.observations.push_back({.image = ImageId{i}, .point = PointId{0}, .pixel = {500, 400}});
  }
  Settings settings;
  settings.photos = (folder / "").string();
  auto project = create_project(folder / "project", settings, {});
  ASSERT_TRUE(project) << project.error().message;
  ASSERT_TRUE(project->store.write_setup(block));
  ASSERT_TRUE(project->store.write_orientation(block));
  ASSERT_TRUE(export_block(*project, folder / "out", {.format = ExportFormat::kTiePoints}));
  const auto cloud = read_ply(folder / "out/tie_points.ply");
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 1u);
  EXPECT_EQ(cloud->front().images, 255);
}

// A project with a cloud of 20,000 points over 100 m, of three classes.
class EditedCloud : public ::testing::Test {
 protected:
  void SetUp() override {
    Block block;
    block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
    block.images[ImageId{0}] = {.file = "a.jpg", .camera = CameraId{0}};
    set_pose(block, ImageId{0}, {});
    Settings settings;
    settings.photos = (folder_ / "").string();
    settings.densify.cloud = LasForm::kLas;
    auto project = create_project(folder_ / "project", settings, {});
    ASSERT_TRUE(project) << project.error().message;
    project_.emplace(*std::move(project));
    ASSERT_TRUE(project_->store.write_setup(block));
    ASSERT_TRUE(project_->store.write_orientation(block));
    std::filesystem::create_directories(folder_ / "project/products");
    auto writer = LasWriter::create(folder_ / "project/products/cloud.las", {{0, 0, 0}, {100, 100, 20}});
    ASSERT_TRUE(writer);
    Random random(5);
    std::vector<CloudPoint> points(20'000);
    for (CloudPoint& point : points) {
      point.position = {100 * random.uniform(), 100 * random.uniform(), 20 * random.uniform()};
      point.sigma_m = 0.02f;
      point.classification = std::uint8_t(random.below(3));
    }
    ASSERT_TRUE(writer->write(points));
    ASSERT_TRUE(writer->finish());
  }
  void edit(const std::vector<std::string>& words) {
    Journal journal(project_->folder);
    const Edit edit = parse_edit(words).value();
    ASSERT_TRUE(make_edits(project_->folder, journal, {&edit, 1}));
  }
  std::vector<CloudPoint> exported(ExportFormat format = ExportFormat::kLas) {
    EXPECT_TRUE(export_block(*project_, folder_ / "out", {.format = format}));
    const LasForm form = format == ExportFormat::kCopc ? LasForm::kCopc : LasForm::kLas;
    return LasReader::open(folder_ / "out" / las_file_name("cloud", form))->read(1'000'000).value();
  }
  std::string bytes(const std::string& name = "cloud.las") { return read_file(folder_ / "out" / name).value(); }

  const TestFolder folder_;
  std::optional<Project> project_;
};

const std::vector<std::string> kSquare = {"20", "30", "60", "30", "60", "80", "20", "80"};
bool is_in_square(const Eigen::Vector3d& p, double low, double high) {
  return p.x() > 20 && p.x() < 60 && p.y() > 30 && p.y() < 80 && p.z() >= low && p.z() <= high;
}
std::vector<std::string> on_square(std::vector<std::string> words) {
  words.insert(words.end(), kSquare.begin(), kSquare.end());
  return words;
}

TEST_F(EditedCloud, GivesClassesInsideAndLeavesAllElse) {
  const std::vector<CloudPoint> before = exported();
  edit(on_square({"classify", "6", "5", "-"}));
  const std::vector<CloudPoint> after = exported();
  ASSERT_EQ(after.size(), before.size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].position, before[i].position);
    EXPECT_EQ(after[i].sigma_m, before[i].sigma_m);
    const bool is_inside = is_in_square(before[i].position, 5, 100);
    inside += is_inside;
    EXPECT_EQ(after[i].classification, is_inside ? 6 : before[i].classification);
  }
  EXPECT_GT(inside, 2000u);
}

TEST_F(EditedCloud, LosesWhatIsCutAndWhatLiesOutsideACrop) {
  const std::vector<CloudPoint> before = exported();
  edit(on_square({"crop", "-", "15"}));
  edit({"cut", "10", "12", "0", "0", "100", "0", "100", "100", "0", "100"});
  const std::vector<CloudPoint> after = exported();
  std::size_t next = 0;
  for (const CloudPoint& point : before) {
    const double height = point.position.z();
    if (!is_in_square(point.position, 0, 15) || (height >= 10 && height <= 12)) continue;
    ASSERT_LT(next, after.size());
    EXPECT_EQ(after[next++].position, point.position);
  }
  EXPECT_EQ(next, after.size());
  EXPECT_EQ(exported(ExportFormat::kCopc).size(), after.size());
}

TEST_F(EditedCloud, IsThinnedAndCutToAnAreaInEveryForm) {
  const std::vector<CloudPoint> before = exported();
  ASSERT_TRUE(write_file(folder_ / "area.txt", "# corners\n20 30\n60,30\n60 80\n20 80\n"));
  ExportOptions options{.format = ExportFormat::kLas, .spacing_m = 5, .area = folder_ / "area.txt"};
  ASSERT_TRUE(export_block(*project_, folder_ / "thin", options));
  const auto thin = LasReader::open(folder_ / "thin/cloud.las")->read(1'000'000).value();
  std::set<std::array<int, 3>> cubes, all;
  const auto cube_of = [](const CloudPoint& p) {
    return std::array{int(std::floor(p.position.x() / 5)), int(std::floor(p.position.y() / 5)),
                      int(std::floor(p.position.z() / 5))};
  };
  for (const CloudPoint& point : thin) {
    EXPECT_TRUE(is_in_square(point.position, 0, 20));
    EXPECT_TRUE(cubes.insert(cube_of(point)).second);
  }
  for (const CloudPoint& point : before)
    if (is_in_square(point.position, 0, 20)) all.insert(cube_of(point));
  EXPECT_EQ(cubes, all);

  options.format = ExportFormat::kPly;
  ASSERT_TRUE(export_block(*project_, folder_ / "thin", options));
  const auto ply = read_ply(folder_ / "thin/cloud.ply").value();
  options.format = ExportFormat::kXyz;
  ASSERT_TRUE(export_block(*project_, folder_ / "thin", options));
  std::istringstream text(read_file(folder_ / "thin/cloud.xyz").value());
  std::string line;
  std::getline(text, line);
  EXPECT_TRUE(line.starts_with("#"));
  ASSERT_EQ(ply.size(), thin.size());
  for (std::size_t i = 0; i < thin.size(); ++i) {
    EXPECT_EQ(ply[i].position, thin[i].position);  // no map: the local frame is the cloud's
    ASSERT_TRUE(std::getline(text, line));
    std::istringstream fields(line);
    Eigen::Vector3d position;
    fields >> position.x() >> position.y() >> position.z();
    EXPECT_LT((position - thin[i].position).norm(), 1e-3);
  }
  EXPECT_FALSE(std::getline(text, line));

  ASSERT_TRUE(write_file(folder_ / "area.txt", "20 30\n60 30\n"));
  const auto refused = export_block(*project_, folder_ / "thin", options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("area.txt"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(export_block(*project_, folder_ / "thin", {.format = ExportFormat::kOpk, .spacing_m = 5}));
}

// What is removed is gone for the edits behind it, and comes back with undo, bit by bit.
TEST_F(EditedCloud, UndoGivesTheSameBytes) {
  exported();
  const std::string before = bytes();
  edit(on_square({"cut", "-", "-"}));
  edit(on_square({"classify", "6", "-", "-"}));
  for (const CloudPoint& point : exported()) EXPECT_NE(point.classification, 6);
  const std::string edited = bytes();
  edit({"undo"});
  edit({"undo"});
  exported();
  EXPECT_TRUE(bytes() == before);
  edit({"redo"});
  edit({"redo"});
  exported();
  EXPECT_TRUE(bytes() == edited);
}

}  // namespace
}  // namespace collinea
