// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/text.h"
#include "collinea/jobs/intersection.h"
#include "collinea/math/random.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/pyramid.h"
#include "collinea/synthetic/render.h"
#include "collinea/synthetic/survey.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// Photographs of a façade without distortion, and of points on it the exact position and measurements in two of them
// that are off by a pixel.
class RefinedFacade : public ::testing::Test {
 protected:
  void SetUp() override {
    FacadeOptions options;
    options.stations = 12;
    options.camera = {.width_px = 1280, .height_px = 960, .focal_px = 1800};
    options.camera.k1 = options.camera.k2 = options.camera.k3 = options.camera.p1 = options.camera.p2 = 0;
    auto made = make_facade(options);
    ASSERT_TRUE(made) << made.error().message;
    truth_ = std::make_unique<Truth>(std::move(*made));
    const Camera& camera = truth_->block.cameras.begin()->second;
    const RayTable rays(camera, {});
    std::string poses = "image X Y Z omega phi kappa\n";
    for (const auto& [id, pose] : oriented_images(truth_->block)) {
      const bool is_near = (id.value >= 4 && id.value <= 7) || id.value == 17;  // four in hand, one on the pole
      if (!is_near) continue;
      const auto image = render(*truth_, id, rays, {});
      ASSERT_TRUE(image);
      const std::string name = "I" + std::to_string(id.value);
      ASSERT_TRUE(write_png(folder_ / (name + ".png"), half(*image)));
      const Eigen::Vector3d centre = centre_of(pose);
      const OmegaPhiKappa angles = omega_phi_kappa(pose.rotation);
      poses += name;
      for (const double value :
           {centre.x(), centre.y(), centre.z(), angles.omega_deg, angles.phi_deg, angles.kappa_deg})
        poses += " " + exact(value);
      poses += "\n";
      ids_.push_back(id);
    }
    ASSERT_TRUE(write_file(folder_ / "poses.txt", poses));
    options_.photo.principal_distance = camera.focal_px() / 2;
    options_.photo.principal_point =
        exact(camera.params[Camera::kCx] / 2) + "," + exact(camera.params[Camera::kCy] / 2);
    options_.sigma = 1;
    options_.images = folder_ / "";
    measure();
  }
  void measure() {
    Random random(5);
    std::string text = "image point x[px] y[px]\n", ground = "point X[m] Y[m] Z[m]\n";
    for (int k = 0; k < 1500; ++k) {
      const Eigen::Vector2d pixel(random.uniform(30, 610), random.uniform(30, 450));
      const auto hit = shown_at(*truth_, ids_[1], 2 * pixel);
      if (!hit || hit->solid < 0) continue;
      const auto other = seen_at(*truth_, ids_[2], hit->point, 20);
      if (!other) continue;
      const std::string name = std::to_string(k);
      text += "I" + std::to_string(ids_[1].value) + " " + name + " " + exact(pixel.x()) + " " + exact(pixel.y()) + "\n";
      text += "I" + std::to_string(ids_[2].value) + " " + name + " " + exact(other->x() / 2 + random.normal()) + " " +
              exact(other->y() / 2 + random.normal()) + "\n";
      ground += name + " " + exact(hit->point.x()) + " " + exact(hit->point.y()) + " " + exact(hit->point.z()) + "\n";
    }
    ASSERT_TRUE(write_file(folder_ / "measured.txt", text));
    ASSERT_TRUE(write_file(folder_ / "ground.txt", ground));
    options_.ground = folder_ / "ground.txt";
  }
  // Whether all of the window shows one plane.
  [[nodiscard]] bool is_flat(const Eigen::Vector2d& pixel) const {
    const auto middle = shown_at(*truth_, ids_[1], 2 * pixel);
    for (int y = -12; y <= 12; y += 2)
      for (int x = -12; x <= 12; x += 2) {
        const auto there = shown_at(*truth_, ids_[1], 2 * (pixel + Eigen::Vector2d(x, y)));
        if (!there || std::abs(middle->normal.dot(there->point - middle->point)) > 1e-3) return false;
      }
    return true;
  }
  TestFolder folder_;
  std::unique_ptr<Truth> truth_;
  std::vector<ImageId> ids_;
  IntersectTableOptions options_;
};

struct Errors {
  std::vector<double> metres, ratios;
  double within = 0, missed = 0;

  void add(const IntersectionReport::Refined& point) {
    const double sigma = std::sqrt(point.match.covariance.trace());
    metres.push_back(point.off_ground.norm());
    ratios.push_back(metres.back() / sigma);
    within += metres.back() < 1.96 * sigma;
    missed += point.match.statistic > 16.3 + 5 * (point.match.redundancy - 3);
  }
  // Median of error / sigma; of a normal error it is 0.674.
  double median_ratio() {
    std::sort(ratios.begin(), ratios.end());
    return ratios[ratios.size() / 2];
  }
  double median_error() {
    std::sort(metres.begin(), metres.end());
    return metres[metres.size() / 2];
  }
};

TEST_F(RefinedFacade, ErrorsAreThoseThatTheSigmasState) {
  const auto report = intersect_from_tables(folder_ / "measured.txt", folder_ / "poses.txt", options_, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  Errors flat, stepped, before;
  std::size_t found = 0;
  for (const IntersectionReport::Refined& point : report->refined) {
    if (point.match.outcome != MultiImageOutcome::kFound) continue;
    ++found;
    (is_flat(point.match.views[2].pixel) ? flat : stepped).add(point);
    IntersectionReport::Refined as_it_was = point;
    as_it_was.off_ground += point.moved;
    before.add(as_it_was);
  }
  RecordProperty("flat",
                 std::to_string(flat.median_ratio()) + " " + std::to_string(flat.within / double(flat.ratios.size())));
  // Windows that show one plane; the texture is finer than the pixels here and there.
  EXPECT_GT(flat.median_ratio(), 0.6);
  EXPECT_LT(flat.median_ratio(), 0.78);
  EXPECT_GT(flat.within, 0.88 * double(flat.ratios.size()));
  EXPECT_LT(flat.median_error(), before.median_error() / 50);
  // Windows over an edge of depth show two surfaces: the sigmas do not know it, the test of the rays does at times.
  EXPECT_GT(stepped.missed, 5 * flat.missed);
  EXPECT_GT(found, report->refined.size() / 2);
  const auto tables = intersection_tables(*report);
  ASSERT_EQ(tables.size(), 4u);
  EXPECT_EQ(tables[2].table.rows.size(), found);
  EXPECT_NE(intersection_text(*report).find("matched in all images"), std::string::npos);
}

TEST_F(RefinedFacade, MissingImagesAndOtherUnitsAreNamed) {
  options_.images = folder_ / "none";
  const auto no_folder = intersect_from_tables(folder_ / "measured.txt", folder_ / "poses.txt", options_);
  ASSERT_FALSE(no_folder);
  EXPECT_NE(no_folder.error().message.find("none"), std::string::npos) << no_folder.error().message;
  options_.images = folder_ / "";
  ASSERT_TRUE(write_file(folder_ / "mm.txt", "image point x[mm] y[mm]\nI4 1 0 0\nI5 1 0.1 0\n"));
  const auto millimetres = intersect_from_tables(folder_ / "mm.txt", folder_ / "poses.txt", options_);
  ASSERT_FALSE(millimetres);
  EXPECT_NE(millimetres.error().message.find("measurements in px"), std::string::npos) << millimetres.error().message;
}

}  // namespace
}  // namespace collinea
