// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/camera_poses.h"

#include <cmath>

namespace collinea {

using bundle::ProblemCamera;
using bundle::ProblemImage;

std::vector<CameraPoseCorrelation> correlate_cameras_and_poses(
    const Solved& solved, const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance,
    bundle::TileCholesky& inverse) {
  const bundle::Problem& problem = solved.problem();
  const bundle::State& state = solved.state();
  std::vector<CameraPoseCorrelation> correlations;
  if (problem.rank_defect > 0) return correlations;
  constexpr int kOfPose = 6;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    const ProblemCamera& camera = problem.cameras[static_cast<std::size_t>(c)];
    for (std::size_t k = 0; k < camera.free.size(); ++k) {
      const int row = 6 * problem.poses + camera.first_global + static_cast<int>(k);
      const std::size_t first = correlations.size();
      for (int i = 0; i < kOfPose; ++i) correlations.push_back({camera.id, camera.free[k], i, {}, 0});
      for (int pose = 0; pose < problem.poses; ++pose) {
        const ProblemImage& image = problem.images[static_cast<std::size_t>(pose)];
        if (image.camera != c) continue;
        Eigen::Matrix<double, kOfPose, 1> with;
        for (int i = 0; i < kOfPose; ++i) with[i] = inverse.at(row, kOfPose * pose + i);
        with.head<3>() = state.rotations[static_cast<std::size_t>(pose)].conjugate() * Eigen::Vector3d(with.head<3>());
        const Eigen::Matrix<double, kOfPose, 1> variances = pose_covariance.at(image.id).diagonal();
        for (int i = 0; i < kOfPose; ++i) {
          const double correlation = with[i] / std::sqrt(inverse.at(row, row) * variances[i]);
          CameraPoseCorrelation& largest = correlations[first + static_cast<std::size_t>(i)];
          if (largest.image.valid() && !(std::abs(correlation) > std::abs(largest.correlation))) continue;
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
