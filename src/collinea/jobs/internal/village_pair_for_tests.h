// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/raster/geotiff.h"
#include "collinea/synthetic/write.h"

namespace collinea::testing {

inline constexpr double kVillageFocal_px = 600;

// Two images of a made-up village by a camera without distortion, with the truth.
struct VillagePair {
  TestFolder folder;
  Block truth;
  std::optional<Scene> scene;
  std::filesystem::path left, right;

  struct Lens {
    double k1 = 0;
  };

  VillagePair() : VillagePair(Lens{}) {}
  explicit VillagePair(const Lens& lens) {
    SurveyOptions options;
    options.strips = 1;
    options.images_per_strip = 2;
    options.cross_strips = 0;
    options.forward_overlap = 0.65;
    options.gsd_m = 0.1;
    options.camera.width_px = 800;
    options.camera.height_px = 600;
    options.camera.focal_px = kVillageFocal_px;
    options.camera.k1 = lens.k1;
    options.camera.k2 = options.camera.k3 = options.camera.p1 = options.camera.p2 = 0;
    options.camera.principal_x_px = options.camera.principal_y_px = 0;
    const auto survey = make_survey(options);
    EXPECT_TRUE(survey);
    truth = survey->block;
    scene = survey->scene;
    std::filesystem::create_directories(folder / "images");
    EXPECT_TRUE(write_images(*survey, folder / "images", {.threads = 2}));
    auto image = truth.images.begin();
    left = folder / "images" / image->second.file;
    right = folder / "images" / (++image)->second.file;
  }

  [[nodiscard]] Rigid3 pose(int i) const { return pose_of(truth, std::next(truth.images.begin(), i)->first); }
  [[nodiscard]] Rigid3 right_from_left() const { return pose(1) * inverse(pose(0)); }

  // Heights of a surface model less those of the scene: known cells within 12 m of the middle between the cameras.
  [[nodiscard]] std::vector<double> height_errors(const std::filesystem::path& dsm) const {
    const auto raster = GeoTiffReader::open(dsm);
    if (!raster) return {};
    const MapGrid& grid = raster->grid();
    const auto heights = raster->read_known(0, 0, grid.width, grid.height);
    if (!heights) return {};
    const Eigen::Vector3d middle = (centre_of(pose(0)) + centre_of(pose(1))) / 2;
    std::vector<double> errors;
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        const double x = grid.east_of(column + 0.5), y = grid.north_of(row + 0.5);
        if (std::hypot(x - middle.x(), y - middle.y()) > 12 || std::isnan(heights->at(column, row))) continue;
        errors.push_back(heights->at(column, row) - scene->surface_height(x, y));
      }
    return errors;
  }

  // Points in the air and on the ground that both cameras see, as control with exact measurements.
  [[nodiscard]] std::string control_table() const {
    std::string text =
        "point X[m] Y[m] Z[m] sigma_X[m] sigma_Y[m] sigma_Z[m] x_left[px] y_left[px] x_right[px] y_right[px]\n";
    const Camera& camera = truth.cameras.begin()->second;
    const Eigen::Vector3d middle = (centre_of(pose(0)) + centre_of(pose(1))) / 2;
    int n = 0;
    for (int y = -2; y <= 2; ++y)
      for (int x = -1; x <= 1; ++x) {
        const Eigen::Vector3d at(middle.x() + 9 * x, middle.y() + 9 * y, (n * 7) % 5);
        const auto a = project(camera, pose(0) * at), b = project(camera, pose(1) * at);
        if (!a || !b) continue;
        text += fmt::format("P{} {} {} {} 0.01 0.01 0.01 {} {} {} {}\n", ++n, at.x(), at.y(), at.z(), a->x(), a->y(),
                            b->x(), b->y());
      }
    return text;
  }
};

}  // namespace collinea::testing
