// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/camera_poses.h"

#include <cmath>

#include "collinea/quality/internal/covariance.h"

namespace collinea {

using bundle::ProblemCamera;
using bundle::ProblemImage;

namespace {

constexpr int kOfPose = 6, kStated = 9;  // with omega, phi and kappa besides
using Stated = Eigen::Matrix<double, kStated, 1>;

// How an unknown that has these covariances with a pose goes with it. `sigma`: of that unknown.
Stated correlations_of(const Eigen::Matrix<double, kOfPose, 1>& with, double sigma, const Matrix6d& covariance,
                       const Eigen::Quaterniond& rotation) {
  const Matrix6d by_rotation = angles_by_rotation(rotation),
                 of_angles = by_rotation * covariance * by_rotation.transpose();
  Stated covariances, variances;
  covariances << with, (by_rotation * with).head<3>();
  variances << covariance.diagonal(), of_angles.diagonal().head<3>();
  return covariances.array() / (sigma * variances.array().sqrt());
}

}  // namespace

std::vector<CameraPoseCorrelation> correlate_cameras_and_poses(
    const Solved& solved, const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance,
    const bundle::FreeNetwork& free_network, bundle::TileCholesky& inverse) {
  const bundle::Problem& problem = solved.problem();
  const bundle::State& state = solved.state();
  std::vector<CameraPoseCorrelation> correlations;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    const ProblemCamera& camera = problem.cameras[static_cast<std::size_t>(c)];
    if (camera.is_of_film()) continue;  // of one image each
    for (std::size_t k = 0; k < camera.free.size(); ++k) {
      const int row = 6 * problem.poses + camera.first_global + static_cast<int>(k);
      const std::size_t first = correlations.size();
      for (int i = 0; i < kStated; ++i) correlations.push_back({camera.id, camera.free[k], i, {}, 0});
      for (int pose = 0; pose < problem.poses; ++pose) {
        const ProblemImage& image = problem.images[static_cast<std::size_t>(pose)];
        if (image.camera != c) continue;
        Eigen::Matrix<double, kOfPose, 1> with;
        for (int i = 0; i < kOfPose; ++i) with[i] = inverse.at(row, kOfPose * pose + i);
        with.head<3>() = state.rotations[static_cast<std::size_t>(pose)].conjugate() * Eigen::Vector3d(with.head<3>());
        with = free_network.with_pose(with, row, pose);
        const Stated stated = correlations_of(with, std::sqrt(inverse.at(row, row)), pose_covariance.at(image.id),
                                              state.rotations[static_cast<std::size_t>(pose)]);
        for (int i = 0; i < kStated; ++i) {
          const double correlation = stated[i];
          CameraPoseCorrelation& largest = correlations[first + static_cast<std::size_t>(i)];
          if (!largest.image.valid()) largest.image = image.id;
          if (!(std::abs(correlation) > std::abs(largest.correlation))) continue;  // an angle may have no bound
          largest.image = image.id;
          largest.correlation = correlation;
        }
      }
      if (!correlations.back().image.valid()) correlations.resize(first);
    }
  }
  return correlations;
}

}  // namespace collinea
