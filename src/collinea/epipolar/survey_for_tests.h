// SPDX-License-Identifier: Apache-2.0
// A close-range survey with one camera of known calibration; for tests of this module and of jobs only.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/image_bundles.h"
#include "collinea/epipolar/projective_factorisation.h"
#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {

struct SelfCalibrationScene {
  std::size_t images = 5;
  Eigen::Index points = 30;
  double sigma = 0;
  std::uint64_t seed = 1;
  bool is_flat = false, has_one_centre = false;
  bool is_turned = true;  ///< otherwise all images look the same way
};
struct SelfCalibrationTruth {
  ImageBundles bundles;  ///< first camera at the origin; base of the second one: 1
  std::vector<ProjectionMatrix> matrices;
  ImageCoordinates measured;
};

/// Images around an object at 4 units from a first one, rolled about their axes, of a camera with principal distances
/// 3000 and 2950 px, principal point (1510, 990) px.
inline SelfCalibrationTruth self_calibration_truth(const SelfCalibrationScene& scene) {
  SelfCalibrationTruth out;
  Random random(scene.seed);
  out.bundles.calibration << 3000, 0, 1510, 0, 2950, 990, 0, 0, 1;
  const Eigen::Vector3d middle(0, 0, 4);
  for (std::size_t i = 0; i < scene.images; ++i) {
    Rigid3 pose;
    if (i > 0) {
      const double angle = (i % 2 ? 1 : -1) * (0.25 + 0.12 * double(i)) + random.uniform(-0.05, 0.05),
                   up = random.uniform(-0.5, 0.5);
      const Eigen::Vector3d centre =
          middle + random.uniform(3.4, 4.6) *
                       Eigen::Vector3d(std::sin(angle) * std::cos(up), std::sin(up), -std::cos(angle) * std::cos(up));
      Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
      if (scene.is_turned)
        rotation = rotation_by({0, 0, random.uniform(-1.6, 1.6)}) *
                   Eigen::Quaterniond::FromTwoVectors(middle + scene::random_vector(random, 0.2) - centre,
                                                      Eigen::Vector3d::UnitZ());
      pose = {rotation, scene.has_one_centre ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(-(rotation * centre))};
    }
    out.bundles.cam_from_model.push_back(pose);
  }
  const double base = scene.images > 1 ? centre_of(out.bundles.cam_from_model[1]).norm() : 1;
  const double unit = base > 0 ? base : 1;
  for (Rigid3& pose : out.bundles.cam_from_model) pose.translation /= unit;
  for (Eigen::Index p = 0; p < scene.points; ++p) {
    Eigen::Vector3d point = scene::random_vector(random, 0.8);
    if (scene.is_flat) point.z() = 0.3 * point.x() - 0.2 * point.y();
    out.bundles.points.push_back((middle + point) / unit);
  }
  for (const Rigid3& pose : out.bundles.cam_from_model) {
    ProjectionMatrix matrix;
    matrix << pose.rotation.toRotationMatrix(), pose.translation;
    out.matrices.push_back(out.bundles.calibration * matrix);
    Eigen::Matrix2Xd xy(2, scene.points);
    for (Eigen::Index p = 0; p < scene.points; ++p) {
      const Eigen::Vector3d& point = out.bundles.points[static_cast<std::size_t>(p)];
      xy.col(p) = (out.matrices.back() * point.homogeneous()).hnormalized() + scene::noise(random, scene.sigma);
    }
    out.measured.xy.push_back(xy);
    out.measured.sigma.push_back(Eigen::RowVectorXd::Constant(scene.points, scene.sigma > 0 ? scene.sigma : 1));
  }
  return out;
}

}  // namespace collinea
