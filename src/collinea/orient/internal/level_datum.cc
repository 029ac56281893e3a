// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/level_datum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "collinea/block/image_axes.h"
#include "collinea/math/median.h"
#include "collinea/orient/internal/strip_datum.h"

namespace collinea {
namespace {

constexpr double kHeld_rad = 2 * std::numbers::pi / 180;  // how level people and gimbals hold a camera on the average
constexpr double kWorstScale = 0.5;                       // relative
// Reach of the stations across their longest line, in sigmas of all positions: that of a ring with the worst scale.
constexpr double kAcross = 1 / (kWorstScale * std::numbers::sqrt2);
constexpr double kClearlyBetter = 0.8;  // of the residuals: below that the fit decides between two levels
constexpr int kRounds = 5;
constexpr double kOutlier = 3;  // sigmas

struct Level {
  Eigen::Vector3d up_in_block;
  double sigma_rad;
  LevelSource by;
};

std::optional<Level> by_attitudes(const Block& block) {
  const auto verticals = verticals_by_attitude(block);
  if (2 * verticals.size() < count_oriented(block)) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [id, vertical] : verticals) sum += pose_of(block, id).rotation.conjugate() * vertical.up_in_cam;
  const auto count = static_cast<double>(verticals.size());
  if (sum.norm() < 0.95 * count) return std::nullopt;  // they contradict each other
  return Level{sum.normalized(), verticals.begin()->second.sigma_rad / std::sqrt(count), LevelSource::kAttitudes};
}

// Mean and mean products of the images' axes in the block.
struct Views {
  Eigen::Vector3d down = Eigen::Vector3d::Zero(), forward = Eigen::Vector3d::Zero();
  Eigen::Matrix3d right = Eigen::Matrix3d::Zero();
};

Views views_of(const Block& block) {
  Views views;
  const double share = 1 / static_cast<double>(count_oriented(block));
  for (const auto& [id, pose] : oriented_images(block)) {
    const int orientation = block.images.at(id).orientation;
    const Eigen::Quaterniond block_from_cam = pose.rotation.conjugate();
    views.down += share * (block_from_cam * down_in_cam(orientation));
    views.forward += share * (block_from_cam * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d right = block_from_cam * right_in_cam(orientation);
    views.right += share * right * right.transpose();
  }
  return views;
}

std::vector<Level> levels_of(const Block& block) {
  std::vector<Level> levels;
  if (const auto level = by_attitudes(block)) levels.push_back(*level);
  const Views views = views_of(block);
  const double share = 1 / static_cast<double>(count_oriented(block));
  const auto add = [&](const Eigen::Vector3d& up, double scatter_rad, LevelSource by) {
    if (up.norm() > 0.1) levels.push_back({up.normalized(), std::hypot(kHeld_rad, scatter_rad * std::sqrt(share)), by});
  };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(views.right);
  const Eigen::Vector3d square = axes.eigenvectors().col(0), held = views.down + views.forward;
  if (axes.eigenvalues()[1] > 4 * axes.eigenvalues()[0] + 1e-3)
    add(square.dot(held) > 0 ? Eigen::Vector3d(-square) : square, std::sqrt(std::max(0.0, axes.eigenvalues()[0])),
        LevelSource::kEdges);
  const auto scatter = [](const Eigen::Vector3d& mean) { return std::acos(std::clamp(mean.norm(), 0.0, 1.0)); };
  add(-views.forward, scatter(views.forward), LevelSource::kView);
  add(-views.down, scatter(views.down), LevelSource::kLowerEdges);
  return levels;
}

// One station: its position in a level block and what its receiver measured.
struct Station {
  std::complex<double> in_block, in_world;
  double sigma_m;
};

struct PlanFit {
  std::complex<double> world_from_block = 1, shift;  // turn and scale; where the zero of the block comes to lie
  double chi = 0;                                    // root mean square residual in sigmas, of those that count
  double rotation_sigma_rad = 0, across = 0;         // across: reach off their line, in sigmas of all
};

// Weighted least squares of a turn, a scale and a shift, with the outliers of the round before left out.
std::optional<PlanFit> plan_fit(const std::vector<Station>& stations) {
  PlanFit fit;
  std::vector<double> weights(stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i) weights[i] = 1 / (stations[i].sigma_m * stations[i].sigma_m);
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0, reach = 0;
    std::complex<double> block = 0, world = 0, product = 0, along = 0;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      sum += weights[i];
      block += weights[i] * stations[i].in_block;
      world += weights[i] * stations[i].in_world;
    }
    block /= sum, world /= sum;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const std::complex<double> a = stations[i].in_block - block;
      product += weights[i] * std::conj(a) * (stations[i].in_world - world);
      reach += weights[i] * std::norm(a);
      along += weights[i] * a * a;
    }
    if (!(reach > 0) || !(std::abs(product) > 0)) return std::nullopt;
    fit.world_from_block = product / reach;
    fit.shift = world - fit.world_from_block * block;
    const double scale = std::abs(fit.world_from_block);
    fit.rotation_sigma_rad = 1 / (scale * std::sqrt(reach));
    fit.across = scale * std::sqrt(std::max(0.0, (reach - std::abs(along)) / 2));
    std::vector<double> distances;
    for (const Station& s : stations)
      distances.push_back(std::abs(s.in_world - fit.world_from_block * s.in_block - fit.shift) / s.sigma_m);
    const double shown =
        std::max(1.0, median(std::vector(distances)) / 1.1774);  // median of a normal 2-vector's length
    double squares = 0, count = 0;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const bool counts = distances[i] < kOutlier * shown * std::numbers::sqrt2;
      weights[i] = counts ? 1 / (stations[i].sigma_m * stations[i].sigma_m) : 0;
      squares += counts ? distances[i] * distances[i] : 0;
      count += counts;
    }
    if (count < 3) return std::nullopt;
    fit.chi = std::sqrt(squares / (2 * count));
  }
  return fit;
}

std::vector<Station> stations_of(const Block& block, const Eigen::Quaterniond& level_from_block) {
  std::vector<Station> stations;
  for (const auto& [id, pose] : oriented_images(block)) {
    const auto& position = block.images.at(id).position;
    if (!position || !position->sigma_m.head<2>().allFinite()) continue;
    const Eigen::Vector3d centre = level_from_block * centre_of(pose), &there = position->position_in_world;
    stations.push_back(
        {{centre.x(), centre.y()}, {there.x(), there.y()}, std::sqrt(position->sigma_m.head<2>().squaredNorm() / 2)});
  }
  return stations;
}

// By what the heights say; without any, the cameras are at the height of the frame's origin.
double height_shift_m(const Block& block, const Similarity3& plan, std::size_t& heights) {
  std::vector<double> shifts, all;
  for (const auto& [id, pose] : oriented_images(block)) {
    const auto& position = block.images.at(id).position;
    const double height_m = (plan * centre_of(pose)).z();
    all.push_back(-height_m);
    if (position && std::isfinite(position->sigma_m.z())) shifts.push_back(position->position_in_world.z() - height_m);
  }
  heights = shifts.size();
  if (shifts.empty()) shifts = all;
  return median(shifts);
}

}  // namespace

std::optional<LevelDatum> level_datum(const Block& block) {
  std::optional<PlanFit> best;
  Level level;
  Eigen::Quaterniond level_from_block;
  LevelDatum datum;
  for (const Level& candidate : levels_of(block)) {
    const auto rotation = Eigen::Quaterniond::FromTwoVectors(candidate.up_in_block, Eigen::Vector3d::UnitZ());
    const std::vector<Station> stations = stations_of(block, rotation);
    if (stations.size() < 3) return std::nullopt;
    const auto fit = plan_fit(stations);
    if (!fit || (best && fit->chi > kClearlyBetter * best->chi)) continue;
    best = fit;
    level = candidate;
    level_from_block = rotation;
    datum.positions = stations.size();
  }
  if (!best || best->across < kAcross || best->rotation_sigma_rad > kWorstScale) return std::nullopt;
  Similarity3& world_from_block = datum.world_from_block;
  world_from_block.scale = std::abs(best->world_from_block);
  const Eigen::AngleAxisd north(std::arg(best->world_from_block), Eigen::Vector3d::UnitZ());
  world_from_block.rotation = (north * level_from_block).normalized();
  world_from_block.translation = {best->shift.real(), best->shift.imag(), 0};
  world_from_block.translation.z() = height_shift_m(block, world_from_block, datum.heights);
  datum.level_by = level.by;
  datum.level_sigma_rad = level.sigma_rad;
  datum.rotation_sigma_rad = best->rotation_sigma_rad;
  const double of_each = level.sigma_rad * std::sqrt(static_cast<double>(count_oriented(block)));
  for (const auto& [id, pose] : oriented_images(block))
    datum.verticals[id] = {pose.rotation * level.up_in_block, of_each};
  return datum;
}

}  // namespace collinea
