// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure_ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/math/random.h"
#include "collinea/project/settings.h"
#include "collinea/restitution/test_stereo.h"
#include "collinea/store/project_store.h"
#include "collinea/synthetic/survey.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Three photographs of 900 x 600 pixels over rocks, 10 cm on the ground, with their true poses and tie points, which
/// say about how high the ground is: there is no surface.
class MeasureGround : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "images");
    const auto written = write_images(truth_, folder_ / "images", {.threads = 2});
    ASSERT_TRUE(written) << written.error().message;
    Settings settings;
    settings.photos = (folder_ / "images").string();
    std::filesystem::create_directories(folder_ / "project");
    ASSERT_TRUE(write_settings(folder_ / "project", settings));
    auto store = ProjectStore::open(folder_ / "project");
    ASSERT_TRUE(store);
    const auto block = observations_only(truth_, {}, {});
    ASSERT_TRUE(block) << block.error().message;
    ASSERT_TRUE(store->write_setup(*block));
    ASSERT_TRUE(store->write_orientation(*block));
    BlockCovariances covariances;
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << 1e-5, 1e-5, 1e-5, 1e-3, 1e-3, 1e-3;
    for (const OrientedImage& one : oriented_images(truth_.block))
      covariances.poses[one.image] = sigma.cwiseAbs2().asDiagonal();
    ASSERT_TRUE(store->write_adjustment(*block, covariances));
  }
  Result<GroundReport> measure(const Vector2d& on_map, const GroundOptions& options = {}) {
    COLLINEA_TRY(const Project project, open_project(folder_ / "project", {}));
    return measure_ground(project, on_map, options);
  }

  TestFolder folder_;
  Truth truth_ = *make_survey(testing::strip_of_three());
};

// Measured places of the map: what the left photograph truly shows where the mark stands. Heights miss it within three
// standard deviations but for one position in ten at most; the mark moves along the ray of the left photograph.
TEST_F(MeasureGround, FindsTheGroundWithinItsStandardDeviations) {
  const LocalFrame frame = *world_frame(*truth_.block.georeference);
  Random random(5, 1);
  int measured = 0, missed = 0;
  for (int i = 0; i < 60 && measured < 15; ++i) {
    const auto images = oriented_images(truth_.block);
    const OrientedImage& middle = images[1];
    const auto hit = shown_at(truth_, middle.image, {200 + 500 * random.uniform(), 150 + 300 * random.uniform()});
    if (!hit) continue;
    const Vector3d on_map = frame.map_from_local(hit->point);
    const auto report = measure(on_map.head<2>());
    if (!report) continue;  // too little texture, or hidden
    ++measured;
    ASSERT_TRUE(report->sigma_m);
    EXPECT_GT(report->sigma_m->z(), 0);
    EXPECT_LT(report->sigma_m->z(), 1);
    EXPECT_FALSE(report->others.empty());
    EXPECT_NE(report->files[0], report->files[1]);
    const auto left = report->pair.images[0];
    const auto truth = shown_at(truth_, left, report->match.pixels[0]);
    ASSERT_TRUE(truth);
    const Vector3d off = report->position - frame.map_from_local(truth->point);
    missed += std::abs(off.z()) > 3 * report->sigma_m->z();
  }
  EXPECT_EQ(measured, 15);
  EXPECT_LE(missed, 1);
}

TEST_F(MeasureGround, ThePhotographsMayBeNamed) {
  const LocalFrame frame = *world_frame(*truth_.block.georeference);
  const auto images = oriented_images(truth_.block);
  const Vector3d middle = 0.5 * (centre_of(images[0].cam_from_world) + centre_of(images[1].cam_from_world));
  const Vector2d position = frame.map_from_local({middle.x(), middle.y(), 0}).head<2>();
  const auto file = [&](std::size_t i) { return truth_.block.images.at(images[i].image).file; };
  const auto report = measure(position, {.images = file(1) + "," + file(0)});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ((std::set<std::string>{report->files[0], report->files[1]}), (std::set<std::string>{file(0), file(1)}));
  for (const std::string& names : {std::string("none.jpg"), file(0), file(0) + ",none.jpg"}) {
    const auto refused = measure(position, {.images = names});
    ASSERT_FALSE(refused) << names;
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
    EXPECT_NE(refused.error().message.find("there is no image"), std::string::npos) << refused.error().message;
  }
  EXPECT_FALSE(measure(position, {.images = file(0) + "," + file(0)}));
  EXPECT_FALSE(measure(position + Vector2d(1e5, 0)));
  EXPECT_FALSE(measure({std::nan(""), 0}));
  EXPECT_FALSE(measure(position, {.images = {}, .match = {.window_px = 20'000}}));
  std::filesystem::remove(folder_ / "images" / file(0));
  EXPECT_FALSE(measure(position, {.images = file(0) + "," + file(1)}));
}

TEST_F(MeasureGround, ABlockThatIsNotOrientedHasNoGround) {
  Block setup = truth_.block;
  for (const OrientedImage& one : oriented_images(setup)) remove_pose(setup, one.image);
  std::filesystem::create_directories(folder_ / "other");
  ASSERT_TRUE(write_settings(folder_ / "other", {}));
  {
    auto store = ProjectStore::open(folder_ / "other");
    ASSERT_TRUE(store && store->write_setup(setup));
  }
  const auto project = open_project(folder_ / "other", {});
  ASSERT_TRUE(project);
  const auto refused = measure_ground(*project, {0, 0}, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
