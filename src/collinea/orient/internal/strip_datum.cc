// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/strip_datum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace collinea {
namespace {

constexpr double kAgreement = 0.95;                       // mean length of the unit vectors "up": 18 degrees of scatter
constexpr double kReach = 10;                             // of the positions, in standard deviations
constexpr double kSteepest = 0.7;                         // height of the line over its length
constexpr double kAttitude_rad = std::numbers::pi / 180;  // common to all images: mounting, gimbal

// Roll turns the camera clockwise about its axis, as seen from behind.
Eigen::Vector3d up_in_cam(const AttitudePrior& attitude) {
  const double pitch = attitude.pitch_deg * std::numbers::pi / 180, roll = attitude.roll_deg * std::numbers::pi / 180;
  return {-std::cos(pitch) * std::sin(roll), -std::cos(pitch) * std::cos(roll), std::sin(pitch)};
}

std::optional<Eigen::Vector3d> up_in_block(const Block& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& attitude = block.images.at(id).attitude) {
      sum += pose.rotation.conjugate() * up_in_cam(*attitude);
      ++count;
    }
  if (2 * count < count_oriented(block) || sum.norm() < kAgreement * static_cast<double>(count)) return std::nullopt;
  return sum.normalized();
}

struct Stations {
  std::vector<Eigen::Vector3d> in_block, in_world;
  std::vector<double> weights;  ///< 1 / sigma^2 of each, its worst axis [1/m^2]
};

// Weighted products of the distances from the weighted middle.
Eigen::Matrix3d scatter(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& weights) {
  double sum = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += weights[i];
    middle += weights[i] * points[i];
  }
  middle /= sum;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i)
    products += weights[i] * (points[i] - middle) * (points[i] - middle).transpose();
  return products;
}

Stations stations_of(const Block& block) {
  Stations stations;
  for (const auto& [id, pose] : oriented_images(block)) {
    const auto& position = block.images.at(id).position;
    if (!position || !position->sigma_m.allFinite()) continue;
    stations.in_block.push_back(centre_of(pose));
    stations.in_world.push_back(position->position_in_world);
    const double sigma_m = position->sigma_m.maxCoeff();
    stations.weights.push_back(1 / (sigma_m * sigma_m));
  }
  return stations;
}

}  // namespace

std::map<ImageId, GivenVertical> verticals_by_attitude(const Block& block) {
  std::map<ImageId, GivenVertical> verticals;
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& attitude = block.images.at(id).attitude) verticals[id] = {up_in_cam(*attitude), kAttitude_rad};
  for (auto& [id, vertical] : verticals) vertical.sigma_rad *= std::sqrt(static_cast<double>(verticals.size()));
  return verticals;
}

double rotation_sigma_rad(const Block& block, double world_per_block) {
  const Stations stations = stations_of(block);
  if (stations.in_block.size() < 3) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter(stations.in_block, stations.weights)).eigenvalues();
  return 1 / (world_per_block * std::sqrt(std::max(0.0, axes[0]) + std::max(0.0, axes[1])));
}

std::optional<Similarity3> strip_datum(const Block& block) {
  auto [in_block, in_world, weights] = stations_of(block);
  const auto up = up_in_block(block);
  if (!up || in_world.size() < 2) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter(in_world, weights));
  const Eigen::Vector3d line = axes.eigenvectors().col(2);
  const double reach = std::sqrt(axes.eigenvalues().sum() / static_cast<double>(in_world.size()));  // in sigmas
  if (!(reach > kReach) || std::abs(line.z()) > kSteepest) return std::nullopt;
  double weight = 0;
  for (const double one : weights) weight += one;
  const double length_m = std::sqrt(axes.eigenvalues().sum() / weight);
  const double length = std::sqrt(scatter(in_block, weights).trace() / weight);
  if (!(length > 0)) return std::nullopt;
  // A mast on every camera, as high as the line is long, keeps the fit from turning about the line.
  for (std::size_t i = 0, count = in_world.size(); i < count; ++i) {
    in_block.emplace_back(in_block[i] + length * *up);
    in_world.emplace_back(in_world[i] + length_m * Eigen::Vector3d::UnitZ());
    weights.push_back(weights[i]);
  }
  return align(in_block, in_world, weights);
}

}  // namespace collinea
