// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
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
