// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/statistics.h"

#include <algorithm>
#include <cmath>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr int kBins = 41;  // odd: one bin is centred on zero
constexpr std::size_t kMostRays = 10;
constexpr int kLongSideCells = 16;  // of a residual grid

ResidualGrid empty_grid(CameraId id, const Camera& camera) {
  const double cell = std::max(1.0, std::max(camera.width_px, camera.height_px) / double(kLongSideCells));
  ResidualGrid grid{id,
                    std::max(1, int(std::lround(camera.width_px / cell))),
                    std::max(1, int(std::lround(camera.height_px / cell))),
                    {},
                    {}};
  grid.mean_px.assign(std::size_t(grid.columns * grid.rows), Eigen::Vector2d::Zero());
  grid.count.assign(grid.mean_px.size(), 0);
  return grid;
}

void add_to_grid(ResidualGrid& grid, const Camera& camera, const Eigen::Vector2d& pixel,
                 const Eigen::Vector2d& residual) {
  const int column = std::clamp(int(pixel.x() / camera.width_px * grid.columns), 0, grid.columns - 1);
  const int row = std::clamp(int(pixel.y() / camera.height_px * grid.rows), 0, grid.rows - 1);
  const auto cell = std::size_t(row * grid.columns + column);
  grid.mean_px[cell] += residual;
  ++grid.count[cell];
}

// A histogram that reaches to about four standard deviations, whatever the blunders are.
void fill_histogram(const std::vector<float>& coordinates, ResidualStatistics& statistics) {
  if (coordinates.empty()) return;
  std::vector<float> lengths(coordinates.size());
  std::transform(coordinates.begin(), coordinates.end(), lengths.begin(), [](float v) { return std::abs(v); });
  const double robust_sigma = std::max(1.4826 * double(median(lengths)), 1e-6);
  statistics.bin_px = 8 * robust_sigma / kBins;
  statistics.histogram.assign(kBins, 0);
  for (const float value : coordinates) {
    const double bin = std::floor(double(value) / statistics.bin_px + kBins / 2.0);
    ++statistics.histogram[std::size_t(std::clamp(bin, 0.0, kBins - 1.0))];
  }
}

std::vector<std::size_t> rays_of_points(const Block& block) {
  std::vector<std::size_t> rays(kMostRays + 1, 0);
  for (std::size_t i = 0; i < block.observations.size();) {
    std::size_t next = i;
    while (next < block.observations.size() && block.observations[next].point == block.observations[i].point) ++next;
    ++rays[std::min(next - i, kMostRays)];
    i = next;
  }
  return rays;
}

}  // namespace

AxisRms rms_of(std::span<const Eigen::Vector3d> differences_m) {
  AxisRms rms;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  std::array<int, 3> counts{};
  double spatial = 0;
  int complete = 0;
  for (const Eigen::Vector3d& difference : differences_m) {
    rms.points += difference.array().isFinite().any();
    for (int i = 0; i < 3; ++i)
      if (std::isfinite(difference[i])) {
        squares[i] += difference[i] * difference[i];
        ++counts[std::size_t(i)];
      }
    if (difference.allFinite()) {
      spatial += difference.squaredNorm();
      ++complete;
    }
  }
  for (std::size_t i = 0; i < 3; ++i)
    if (counts[i]) rms.axis_m[i] = std::sqrt(squares[Eigen::Index(i)] / counts[i]);
  if (complete) rms.spatial_m = std::sqrt(spatial / complete);
  return rms;
}

AxisRms control_rms(const ReportInput& input, bool used) {
  std::vector<Eigen::Vector3d> differences;
  for (const ControlDifference& control : input.control) {
    if (control.used != used || control.excluded) continue;
    differences.push_back(control.difference_m);  // NaN on axes that were not surveyed
  }
  return rms_of(differences);
}

AxisRms position_rms(const ReportInput& input) {
  std::vector<Eigen::Vector3d> differences;
  for (const PositionDifference& position : input.positions) differences.push_back(position.difference_m);
  return rms_of(differences);
}

double mean_length_px(std::span<const Eigen::Vector2d> residuals_px) {
  double sum = 0;
  std::size_t count = 0;
  for (const Eigen::Vector2d& residual : residuals_px)
    if (residual.allFinite()) {
      sum += residual.norm();
      ++count;
    }
  return count ? sum / double(count) : 0;
}

ResidualStatistics residual_statistics(const Block& block) {
  ResidualStatistics statistics;
  std::map<ImageId, ImageResiduals> images;
  std::map<CameraId, ResidualGrid> grids;
  for (const auto& [id, pose] : oriented_images(block)) {
    images[id].image = id;
    const CameraId camera = block.common_camera(block.images.at(id).camera);
    if (!grids.contains(camera)) grids.emplace(camera, empty_grid(camera, block.cameras.at(camera)));
  }
  std::vector<float> coordinates;
  coordinates.reserve(2 * block.observations.size());
  double lengths = 0, squares = 0;
  for (const Observation& o : block.observations) {
    const std::optional<Rigid3> pose = find_pose(block, o.image);
    const auto point = block.points.find(o.point);
    if (!pose || point == block.points.end()) continue;
    const Camera& camera = block.camera_of(o.image);
    const auto pixel = project(camera, *pose * point->second.position_in_world);
    if (!pixel) continue;
    const Eigen::Vector2d residual = o.pixel - *pixel;
    for (int i = 0; i < 2; ++i) coordinates.push_back(float(residual[i]));
    lengths += residual.norm();
    squares += residual.squaredNorm();
    statistics.largest_px = std::max(statistics.largest_px, residual.norm());
    ImageResiduals& image = images.at(o.image);
    ++image.observations;
    image.rms_px += residual.squaredNorm();
    add_to_grid(grids.at(block.common_camera(block.images.at(o.image).camera)), camera, o.pixel, residual);
  }
  statistics.observations = coordinates.size() / 2;
  if (statistics.observations) {
    statistics.mean_px = lengths / double(statistics.observations);
    statistics.rms_px = std::sqrt(squares / double(2 * statistics.observations));
  }
  fill_histogram(coordinates, statistics);
  for (auto& [id, image] : images) {
    if (image.observations) image.rms_px = std::sqrt(image.rms_px / image.observations);
    statistics.images.push_back(image);
  }
  for (auto& [id, grid] : grids) {
    for (std::size_t i = 0; i < grid.count.size(); ++i)
      if (grid.count[i]) grid.mean_px[i] /= grid.count[i];
    statistics.grids.push_back(std::move(grid));
  }
  statistics.rays = rays_of_points(block);
  return statistics;
}

double control_rms_px(const Block& block, const ControlDifference& control) {
  if (!control.difference_m.allFinite()) return std::nan("");
  const Eigen::Vector3d estimated = block.control.at(control.point).position_in_world + control.difference_m;
  double squares = 0;
  int count = 0;
  for (const ControlObservation& o : block.control_observations) {
    const std::optional<Rigid3> pose = find_pose(block, o.image);
    if (o.point != control.point || !pose) continue;
    const auto pixel = project(block.camera_of(o.image), *pose * estimated);
    if (!pixel) continue;
    squares += (*pixel - o.pixel).squaredNorm();
    ++count;
  }
  return count ? std::sqrt(squares / count) : std::nan("");
}

}  // namespace collinea
