// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/position_averaging.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/sparse_normals.h"

namespace collinea {
namespace {

constexpr double kBaseOfSigmas = 3;   // bases that count reach over so many standard deviations of a difference
constexpr double kLeastAcross = 0.1;  // of a frame of directions: second singular value over the first

bool known(const ReceivedPosition& position) { return position.sigma_m.allFinite(); }

// Weight of an observation that is off by so many of its standard deviations (Cauchy's loss, scale 2).
double weight_of(double sigmas) { return 1 / (1 + sigmas * sigmas / 4); }

}  // namespace

std::optional<Eigen::Quaterniond> world_from_directions(std::span<const RelativeDirection> directions,
                                                        std::span<const ReceivedPosition> received) {
  struct Base {
    Eigen::Vector3d in_world, in_frame;
    double sigma_rad;
  };
  std::vector<Base> bases;
  for (const RelativeDirection& pair : directions) {
    const ReceivedPosition &first = received[pair.first], &second = received[pair.second];
    if (!known(first) || !known(second)) continue;
    const Eigen::Vector3d base = second.position_in_world - first.position_in_world;
    const double sigma_m = std::sqrt((first.sigma_m.squaredNorm() + second.sigma_m.squaredNorm()) / 3);
    if (base.norm() < kBaseOfSigmas * sigma_m) continue;
    bases.push_back({base.normalized(), pair.direction, std::hypot(sigma_m / base.norm(), kDirectionSigma_rad)});
  }
  if (bases.size() < 3) return std::nullopt;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Base& base : bases) {
      const double off = round == 0 ? 0 : (base.in_world - rotation * base.in_frame).norm() / base.sigma_rad;
      sum += weight_of(off) / (base.sigma_rad * base.sigma_rad) * base.in_world * base.in_frame.transpose();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (!(svd.singularValues()[1] > kLeastAcross * svd.singularValues()[0])) return std::nullopt;
    const Eigen::Vector3d signs(1, 1, svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1);
    rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  return Eigen::Quaterniond(rotation).normalized();
}

std::vector<Eigen::Vector3d> average_positions(std::span<const RelativeDirection> directions,
                                               std::span<const ReceivedPosition> received, const Run& run) {
  constexpr int kRounds = 6, kMostIterations = 2000;
  constexpr double kTolerance = 1e-4;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double positions = 0;
  for (const ReceivedPosition& position : received)
    if (known(position)) {
      mean += position.position_in_world;
      positions += 1;
    }
  if (positions > 0) mean /= positions;
  std::vector<Eigen::Vector3d> centres;
  for (const ReceivedPosition& position : received)
    centres.push_back(known(position) ? position.position_in_world : mean);

  for (int round = 0; round < kRounds && !run.stopped(); ++round) {
    SparseNormals normals(centres.size());
    for (std::size_t i = 0; i < received.size(); ++i) {
      if (!known(received[i])) continue;
      const Eigen::Vector3d inverse_sigma = received[i].sigma_m.cwiseInverse();
      const double off = (centres[i] - received[i].position_in_world).cwiseProduct(inverse_sigma).norm() / std::sqrt(3);
      const Eigen::Matrix3d weight = inverse_sigma.cwiseAbs2().asDiagonal();
      normals.add_value(i, weight_of(round == 0 ? 0 : off) * weight, received[i].position_in_world);
    }
    for (const RelativeDirection& pair : directions) {
      const Eigen::Vector3d base = centres[pair.second] - centres[pair.first];
      const double sigma_m = kDirectionSigma_rad * std::max(base.norm(), 1e-3);
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - pair.direction * pair.direction.transpose();
      const double off = (across * base).norm() / sigma_m;
      normals.add_difference(pair.first, pair.second, (round == 0 ? 1 : weight_of(off)) / (sigma_m * sigma_m) * across,
                             Eigen::Vector3d::Zero());
    }
    normals.solve(centres, kTolerance, kMostIterations);
  }
  return centres;
}

}  // namespace collinea
