// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/covariance.h"

#include <algorithm>
#include <cmath>

#include "collinea/adjust/kind_geodetic.h"
#include "collinea/base/parallel.h"
#include "collinea/geometry/rotation.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea {
namespace bundle {

Eigen::MatrixXd block_of(TileCholesky& inverse, int row, int rows, int column, int columns) {
  Eigen::MatrixXd block(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      block(r, c) = inverse.at(std::max(row + r, column + c), std::min(row + r, column + c));
  return block;
}

double variance_of(const Row& row, TileCholesky& inverse) {
  double sum = 0;
  for (const RowPart& a : row)
    for (const RowPart& b : row)
      sum += a.derivative * b.derivative * inverse.at(std::max(a.row, b.row), std::min(a.row, b.row));
  return sum;
}

}  // namespace bundle

using bundle::GeodeticLink;
using bundle::Problem;
using bundle::ProblemCamera;
using bundle::Row;
using bundle::State;
using bundle::TileCholesky;

std::map<ImageId, Matrix6d> pose_covariances(const Solved& solved, const bundle::FreeNetwork& free_network,
                                             TileCholesky& inverse) {
  const Problem& problem = solved.problem();
  std::map<ImageId, Matrix6d> covariances;
  for (int i = 0; i < problem.poses; ++i) {
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = solved.state().rotations[i].conjugate().toRotationMatrix();
    const Eigen::MatrixXd in_cam = bundle::block_of(inverse, 6 * i, 6, 6 * i, 6);
    covariances[problem.images[i].id] = free_network.of_pose(to_world * in_cam * to_world.transpose(), i, to_world);
  }
  return covariances;
}

Matrix6d angles_by_rotation(const Eigen::Quaterniond& cam_from_world) {
  Matrix6d by_rotation = Matrix6d::Identity();
  by_rotation.topLeftCorner<3, 3>() = -angles_by_rotation_of_camera(omega_phi_kappa(cam_from_world));
  return by_rotation;
}

std::map<CameraId, MatrixPd> camera_covariances(const Solved& solved, TileCholesky& inverse) {
  const Problem& problem = solved.problem();
  std::map<CameraId, MatrixPd> covariances;
  for (const ProblemCamera& camera : problem.cameras) {
    if (camera.free.empty()) continue;
    const int size = Camera::kParams + static_cast<int>(count_of(solved.block().cameras.at(camera.id).additional));
    MatrixPd covariance = MatrixPd::Zero(size, size);
    const int first = 6 * problem.poses + camera.first_global;
    for (std::size_t a = 0; a < camera.free.size(); ++a)
      for (std::size_t b = 0; b < camera.free.size(); ++b) {
        const int i = first + static_cast<int>(a), k = first + static_cast<int>(b);
        covariance(camera.free[a], camera.free[b]) = inverse.at(std::max(i, k), std::min(i, k));
      }
    covariances[camera.id] = covariance;
  }
  return covariances;
}

std::vector<Eigen::Matrix3d> point_covariances(const Solved& solved,
                                               const std::vector<std::pair<PointId, Eigen::Vector3d>>& points,
                                               const bundle::FreeNetwork& free_network, TileCholesky& inverse,
                                               const Run& run) {
  const Problem& problem = solved.problem();
  std::map<PointId, std::size_t> index;
  for (std::size_t i = 0; i < points.size(); ++i) index[points[i].first] = i;
  std::vector<Eigen::Matrix3d> covariances(points.size());
  parallel_for(run, problem.point_count(), [&](std::size_t p) {
    if (problem.point(p).is_fixed || problem.point(p).control >= 0) return;
    const bundle::PointSystem system(problem, solved.state(), p);
    covariances[index.at(PointId{problem.point(p).id})] = free_network.of_point(system.covariance(inverse), system, p);
  });
  return covariances;
}

void predict_others(const Solved& solved, const bundle::FreeNetwork& free_network, TileCholesky& inverse,
                    Adjusted& adjusted) {
  const Problem& problem = solved.problem();
  const State& state = solved.state();
  const int globals_begin = 6 * problem.poses;
  for (std::size_t i = 0; i < problem.auxiliaries.size(); ++i) {
    const int row = globals_begin + problem.first_auxiliary + static_cast<int>(i);
    adjusted.auxiliaries[i].sigma = std::sqrt(inverse.at(row, row));
  }
  for (std::size_t i = 0; i < problem.geodetic.size(); ++i) {
    const GeodeticLink& link = problem.geodetic[i];
    GeodeticDifference& difference = adjusted.geodetic[i];
    const GeodeticModel model = model_of(problem, link, state);
    const Row row = row_of(problem, link, model);
    const double variance = free_network.of_link(variance_of(row, inverse), link, model, row);
    const double sigma = link.observation.sigma, scaled = std::pow(sigma_scale(adjusted), 2) * variance;
    difference.sigma = std::sqrt(std::max(variance, 0.0));
    // The sigma of a residual is what is left of that of the measurement; see predict_control_points.
    const double h = variance / (sigma * sigma);
    difference.difference_sigma =
        std::sqrt(std::max(0.0, difference.used ? scaled * (1 - h) + sigma * sigma - 2 * variance + h * variance
                                                : scaled + sigma * sigma));
  }
}

}  // namespace collinea
