// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/report/report.h"

namespace collinea {

namespace test_flight {

inline double ground(double x, double y) { return 4 * std::sin(x / 60) + 0.02 * y; }

template <class Take>
void see(const Block& block, const Eigen::Vector3d& point, Take&& take) {
  for (const auto& [image, pose] : oriented_images(block)) {
    const auto pixel = project(block.cameras.at({0}), pose * point);
    if (pixel && inside(block.cameras.at({0}), *pixel)) take(image, *pixel);
  }
}

inline Eigen::Vector2d noisy(const Eigen::Vector2d& pixel, Random& random) {
  return pixel + 0.3 * Eigen::Vector2d(random.normal(), random.normal());
}

inline void add_camera(ReportInput& input) {
  Camera camera = ideal_camera(3650, 4000, 3000);
  camera.name = "DJI FC6310 0123";
  camera.prior.source = Provenance::kExif35mm;
  input.first_cameras[{0}] = camera;
  camera.params = {3661.4, 2004.1, 1490.7, -0.0123, 0.0061, -0.002, 0.0004, -0.0003, 0, 0};
  input.block.cameras[{0}] = camera;
  input.camera_sigma[{0}] = {0.41, 0.22, 0.25, 1e-4, 3e-4, 2e-4, 8e-6, 9e-6, 0, 0};
}

inline void add_images(int strips, int per_strip, Random& random, ReportInput& input) {
  std::uint32_t id = 0;
  for (int s = 0; s < strips; ++s)
    for (int i = 0; i < per_strip; ++i, ++id) {
      const Eigen::Vector3d centre(12.0 * i + random.normal(), 22.0 * s + random.normal(), 60 + 0.5 * random.normal());
      const Eigen::Quaterniond rotation =
          cam_from_world(OmegaPhiKappa{2 * random.normal(), 2 * random.normal(), s % 2 ? 180.0 : 0.0});
      Image image;
      image.file = "100MEDIA/DJI_" + std::to_string(1000 + id) + ".JPG";
      image.camera = {0};
      image.position = PositionPrior{centre, {2, 2, 4}, 45, 15, 160};
      input.block.images[{id}] = image;
      if (s == strips - 1 && i == per_strip - 1) continue;  // one image is lost
      set_pose(input.block, {id}, {rotation, -(rotation * centre)});
      input.centre_sigma_m[{id}] = Eigen::Vector3d(0.011, 0.012, 0.02);
      input.positions.push_back({{id}, Eigen::Vector3d(random.normal(), random.normal(), 3 * random.normal()), 1});
    }
}

inline void add_tie_points(int points, double width, double height, Random& random, Block& block) {
  for (std::uint32_t p = 0; p < std::uint32_t(points); ++p) {
    const double x = random.uniform(-20, width + 20), y = random.uniform(-15, height + 15);
    const Eigen::Vector3d position(x, y, ground(x, y));
    std::vector<Observation> seen;
    see(block, position, [&](ImageId image, const Eigen::Vector2d& pixel) {
      if (random.uniform() < 0.4) return;
      Observation o;
      o.image = image;
      o.point = {p};
      o.pixel = noisy(pixel, random);
      seen.push_back(o);
    });
    if (seen.size() < 2) continue;
    block.points[{p}] = {position, {}};
    block.observations.insert(block.observations.end(), seen.begin(), seen.end());
  }
}

inline void add_control(double width, double height, Random& random, ReportInput& input) {
  for (std::uint32_t c = 0; c < 9; ++c) {
    const double x = width * (c % 3) / 2.0, y = height * (c / 3) / 2.0;
    const bool check = c % 2 == 1;
    ControlPoint point{(check ? "K" : "P") + std::to_string(c + 1),
                       check ? ControlRole::kCheck : ControlRole::kControl,
                       {500000 + x, 4.98e6 + y, 100 + ground(x, y)},
                       {x, y, ground(x, y)},
                       {0.01, 0.01, 0.015}};
    input.block.control[{c}] = point;
    ControlDifference result;
    result.point = {c};
    result.used = !check;
    result.difference_m =
        (check ? 0.03 : 0.02) * Eigen::Vector3d(random.normal(), random.normal(), 1.5 * random.normal());
    result.difference_sigma_m = Eigen::Vector3d(0.02, 0.02, 0.03);
    see(input.block, point.position_in_world, [&](ImageId image, const Eigen::Vector2d& pixel) {
      input.block.control_observations.push_back({{c}, image, noisy(pixel, random), 0.5});
      ++result.rays;
    });
    input.control.push_back(result);
  }
}

inline void add_words(ReportInput& input) {
  input.skipped = {finding_of(FindingCode::kImageUnreadable, {Subject::file("100MEDIA/DJI_0999.JPG")}, {}, {},
                              "truncated: ends after 12 % of its rows"),
                   finding_of(FindingCode::kImageTooSmall, {Subject::file("icon.png")}, {{FigureName::kLimit, 64}})};
  input.findings = {finding_of(FindingCode::kCheckPoint, {ControlId{0}}, {{FigureName::kOffset, 0.4}})};
  input.steps = {{"a", "b", 0.8, 1.2, 9e7, ImportRecord{.images = 40}},
                 {"b", "c", 31.2, 60.1, 8e8, DetectRecord{.images = 40, .features = 1000}},
                 {"c", "d", 12.5, 20.4, 6e8, OrientationRecord{.oriented = 39, .pixel_size = 0.5}},
                 {"d", "e", 1.5, 2.4, 1e8,
                  SurfaceRecord{.skipped_because = finding_of(FindingCode::kNotDownwards, {Product::kSurfaceModel})}}};
  input.products = {{ProductFile::kSurface, 12'345'678}, {ProductFile::kCloudLas, 1'412'345'678}};
  input.options = NamedValues{{"orient.calibration", "brown"}, {"seed", "1"}};
  input.versions = {{"collinea", "0.1.0"}, {"GDAL", "3.6.2"}};
}

}  // namespace test_flight

/// A small survey flight with everything a report can show, for tests: `strips` x `per_strip` nadir images 60 m above
/// gentle ground, residuals of 0.3 px, five control and four check points with differences of 2 and 3 cm.
inline ReportInput report_of_test_flight(int strips, int per_strip, int points) {
  Random random(21);
  ReportInput input;
  input.title = "Quarry north <1>";
  input.date = "2024-05-17";
  input.block.georeference = Georeference{"EPSG:32633", 45, 15, 100};
  input.georeferenced = input.metric = true;
  input.crs_name = "WGS 84 / UTM zone 33N";
  input.gauge = Gauge{.map = "EPSG:32633", .by_control = true, .positions = 40};
  const double width = 12.0 * (per_strip - 1), height = 22.0 * (strips - 1);
  test_flight::add_camera(input);
  test_flight::add_images(strips, per_strip, random, input);
  test_flight::add_tie_points(points, width, height, random, input.block);
  test_flight::add_control(width, height, random, input);
  test_flight::add_words(input);
  input.sigma0 = 1.04;
  input.redundancy = long(input.block.observations.size()) * 2 - long(input.block.points.size()) * 3;
  input.gsd_m = 0.0164;
  return input;
}

}  // namespace collinea
