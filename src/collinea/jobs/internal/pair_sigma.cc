// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_sigma.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace collinea {
namespace {

constexpr int kAcross = 17, kDisparities = 3;  // nodes along columns and rows; along disparities
constexpr double kLeastPoseStep = 1e-7;        // of a parameter of a pose [rad, bases]
constexpr double kBeyond = 0.2;                // of the range of disparities of the orientation, to either side

// A pair as it would be with another relative orientation, on the ground.
struct Oriented {
  EpipolarPair cameras;
  Similarity3 ground_from_model;

  // The point of two rays in the frames of the images, as the surface takes it: by the disparity, on the left ray.
  [[nodiscard]] Eigen::Vector3d point(const Eigen::Vector3d& left_ray, const Eigen::Vector3d& right_ray) const {
    const Eigen::Vector2d left = (cameras.left_from_image * left_ray).hnormalized();
    const Eigen::Vector2d right = (cameras.right_from_image * right_ray).hnormalized();
    const double depth = cameras.base_m / (left.x() - right.x());
    return ground_from_model * (inverse(cameras.left_from_world) * (depth * left.homogeneous()));
  }
};

Rigid3 with_base(Rigid3 right_from_left, double base) {
  right_from_left.translation *= base;
  return right_from_left;
}

Result<Oriented> oriented(const ModelOfPair& model, const Rigid3& second_from_first,
                          const std::optional<PairControl>& control) {
  const Rigid3 right_from_left = with_base(second_from_first, model.epipolar.base_m);
  Oriented made;
  COLLINEA_TRY(made.cameras, epipolar_pair(model.left_camera, Rigid3{}, model.right_camera, right_from_left));
  if (control) {
    COLLINEA_TRY(const AbsoluteOrientation absolute, oriented_absolutely(*control, model, right_from_left));
    made.ground_from_model = absolute.ground_from_model;
  }
  return made;
}

// The pair with each degree of freedom a step larger and smaller.
struct Changes {
  std::vector<std::array<Oriented, 2>> by;
  std::vector<double> step;

  [[nodiscard]] Eigen::Matrix3Xd derivative(const Eigen::Vector3d& left_ray, const Eigen::Vector3d& right_ray) const {
    Eigen::Matrix3Xd made(3, Eigen::Index(by.size()));
    for (std::size_t i = 0; i < by.size(); ++i)
      made.col(Eigen::Index(i)) =
          (by[i][0].point(left_ray, right_ray) - by[i][1].point(left_ray, right_ray)) / (2 * step[i]);
    return made;
  }
};

Result<Changes> changes_of(const ModelOfPair& model, const std::optional<PairControl>& control) {
  const RelativeOrientation& orientation = model.orientation;
  Changes changes;
  const Vector5 steps = difference_steps(orientation);
  for (int i = 0; i < 5; ++i) {
    std::array<Oriented, 2> both;
    for (std::size_t side = 0; side < 2; ++side) {
      const Vector5 change = (side == 0 ? 1 : -1) * steps[i] * Vector5::Unit(i);
      COLLINEA_TRY(both[side], oriented(model, changed(orientation.second_from_first, change), control));
    }
    changes.by.push_back(std::move(both));
    changes.step.push_back(steps[i]);
  }
  return changes;
}

Result<Changes> changes_of(const ModelOfPair& model, const std::array<UncertainPose, 2>& poses) {
  const double base = (centre_of(poses[1].cam_from_world) - centre_of(poses[0].cam_from_world)).norm();
  Changes changes;
  for (std::size_t k = 0; k < 2; ++k)
    for (int i = 0; i < 6; ++i) {
      const double least = (i < 3 ? 1 : base) * kLeastPoseStep;
      const double step = std::max(std::sqrt(std::max(poses[k].covariance(i, i), 0.0)), least);
      std::array<Oriented, 2> both;
      for (std::size_t side = 0; side < 2; ++side) {
        std::array<Rigid3, 2> moved{poses[0].cam_from_world, poses[1].cam_from_world};
        moved[k] = pose_after(moved[k], i, side == 0 ? step : -step);
        COLLINEA_TRY(both[side].cameras, epipolar_pair(model.left_camera, moved[0], model.right_camera, moved[1]));
      }
      changes.by.push_back(std::move(both));
      changes.step.push_back(step);
    }
  return changes;
}

}  // namespace

Vector5 difference_steps(const RelativeOrientation& orientation) {
  constexpr double kLeastStep = 1e-9;
  return orientation.stated_covariance().diagonal().cwiseMax(0).cwiseSqrt().cwiseMax(kLeastStep);
}

PairOrientationSigma::Lattice PairOrientationSigma::lattice_of(const ModelOfPair& model) {
  const EpipolarPair& cameras = model.epipolar;
  const std::vector<LevelPoint>& points = model.in_epipolar;
  double low = 1, high = 1;
  if (!points.empty()) {
    const auto [least, most] = std::minmax_element(
        points.begin(), points.end(), [](const auto& a, const auto& b) { return a.disparity_px < b.disparity_px; });
    const double beyond = kBeyond * (most->disparity_px - least->disparity_px);
    low = least->disparity_px - beyond, high = most->disparity_px + beyond;
  }
  return {double(cameras.left.width_px) / (kAcross - 1), double(cameras.left.height_px) / (kAcross - 1), low,
          std::max(high - low, 1e-6) / (kDisparities - 1)};
}

namespace {

// The rays of a node of the lattice, in the frames of the epipolar images.
struct NodeRays {
  double disparity;
  Eigen::Vector3d left, right;
};

// With the covariance that `covariance_of` makes of how the point of two rays changes and of these rays.
template <class Lattice, class CovarianceOf>
std::vector<Eigen::Matrix3d> nodes_of(const Lattice& lattice, const EpipolarPair& cameras, const Changes& changes,
                                      const CovarianceOf& covariance_of) {
  std::vector<Eigen::Matrix3d> nodes;
  for (int k = 0; k < kDisparities; ++k)
    for (int j = 0; j < kAcross; ++j)
      for (int i = 0; i < kAcross; ++i) {
        const double disparity = lattice.low + k * lattice.step_d;
        const Eigen::Vector2d at(i * lattice.step_x, j * lattice.step_y);
        const NodeRays rays{disparity, normalized(cameras.left, at).homogeneous(),
                            normalized(cameras.right, at - Eigen::Vector2d(disparity, 0)).homogeneous()};
        nodes.push_back(covariance_of(changes.derivative(cameras.left_from_image.conjugate() * rays.left,
                                                         cameras.right_from_image.conjugate() * rays.right),
                                      rays));
      }
  return nodes;
}

}  // namespace

Result<PairOrientationSigma> PairOrientationSigma::of(const ModelOfPair& model,
                                                      const std::optional<PairControl>& control,
                                                      const std::optional<AbsoluteOrientation>& absolute) {
  COLLINEA_TRY(const Changes changes, changes_of(model, control));
  const EpipolarPair& cameras = model.epipolar;
  const Matrix5 relative = model.orientation.stated_covariance();
  const Lattice lattice = lattice_of(model);
  return PairOrientationSigma(
      lattice, nodes_of(lattice, cameras, changes, [&](const Eigen::Matrix3Xd& by, const NodeRays& rays) {
        Eigen::Matrix3d covariance = by * relative * by.transpose();
        if (absolute) {
          const Eigen::Vector3d in_model =
              inverse(cameras.left_from_world) * (cameras.depth_at(rays.disparity) * rays.left);
          covariance += on_ground(*absolute, in_model).covariance;
        }
        return covariance;
      }));
}

Result<PairOrientationSigma> PairOrientationSigma::of(const ModelOfPair& model,
                                                      const std::array<UncertainPose, 2>& poses) {
  COLLINEA_TRY(const Changes changes, changes_of(model, poses));
  const EpipolarPair& cameras = model.epipolar;
  const Lattice lattice = lattice_of(model);
  return PairOrientationSigma(
      lattice, nodes_of(lattice, cameras, changes, [&](const Eigen::Matrix3Xd& by, const NodeRays&) {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (Eigen::Index k = 0; k < 2; ++k)
          covariance +=
              by.middleCols<6>(6 * k) * poses[std::size_t(k)].covariance * by.middleCols<6>(6 * k).transpose();
        return covariance;
      }));
}

Eigen::Matrix3d PairOrientationSigma::covariance(const Eigen::Vector2d& left_px, double disparity_px) const {
  const double at[] = {left_px.x() / lattice_.step_x, left_px.y() / lattice_.step_y,
                       (disparity_px - lattice_.low) / lattice_.step_d};
  const int count[] = {kAcross, kAcross, kDisparities};
  int first[3];
  double part[3];
  for (int k = 0; k < 3; ++k) {
    first[k] = std::clamp(int(at[k]), 0, count[k] - 2);
    part[k] = std::clamp(at[k] - first[k], 0.0, 1.0);
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const double weight = (i ? part[0] : 1 - part[0]) * (j ? part[1] : 1 - part[1]) * (k ? part[2] : 1 - part[2]);
    sum += weight * nodes_[std::size_t(((first[2] + k) * kAcross + first[1] + j) * kAcross + first[0] + i)];
  }
  return sum;
}

}  // namespace collinea
