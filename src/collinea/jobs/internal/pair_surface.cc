// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "collinea/base/memory.h"
#include "collinea/base/units.h"
#include "collinea/dense/stereo_parts.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kPartAround = 0.15;    // of the range of disparities, that semi-global matching looks at beyond it
constexpr double kLargestWhole = 20e6;  // pixels that are matched at once
constexpr std::size_t kBatch = 20'000;
constexpr int kBandRows = 16;

double median_disparity(const std::vector<LevelPoint>& points) {
  std::vector<double> values;
  for (const LevelPoint& point : points) values.push_back(point.disparity_px);
  return values.empty() ? 0 : median(values);
}

// What is measured in some rows of a part whose upper-left pixel is (column, row).
std::vector<LevelPoint> points_of(const DisparityMap& map, int column, int row, int begin, int end) {
  std::vector<LevelPoint> points;
  for (int y = begin; y < end; ++y)
    for (int x = 0; x < map.disparity.width; ++x)
      if (const float disparity = map.disparity.at(x, y); !std::isnan(disparity))
        points.push_back({{column + x + 0.5, row + y + 0.5}, double(disparity), 0, 1, double(map.sigma.at(x, y))});
  return points;
}

// Batches side by side.
template <class PointsOf>
Result<> add_batches(std::size_t count, const PointsOf& points, PairCloud& cloud, const Run& run) {
  return parallel_in_order(
      run, count, [&](std::size_t i) -> Result<PairCloud::Piece> { return cloud.piece_of(points(i)); },
      [&](std::size_t, const PairCloud::Piece& piece) -> Result<> {
        cloud.add(piece);
        return {};
      });
}

Result<> add_all(std::span<const LevelPoint> points, PairCloud& cloud, const Run& run) {
  const auto batch = [&](std::size_t i) {
    return points.subspan(i * kBatch, std::min(kBatch, points.size() - i * kBatch));
  };
  return add_batches((points.size() + kBatch - 1) / kBatch, batch, cloud, run);
}

Result<> add_all(const DisparityMap& map, PairCloud& cloud, const Run& run) {
  const int height = map.disparity.height;
  const auto band = [&](std::size_t i) {
    return points_of(map, 0, 0, int(i) * kBandRows, std::min(int(i + 1) * kBandRows, height));
  };
  return add_batches(std::size_t((height + kBandRows - 1) / kBandRows), band, cloud, run);
}

DisparityRange range_around(const std::vector<LevelPoint>& points) {
  double low = points.front().disparity_px, high = low;
  for (const LevelPoint& point : points) {
    low = std::min(low, point.disparity_px);
    high = std::max(high, point.disparity_px);
  }
  const double around = kPartAround * (high - low) + 3;
  return {int(std::floor(low - around)), int(std::ceil(high + around))};
}

// Parts side by side. How long it will take is known by the pair at reduced size.
Result<> match_in_parts(const EpipolarImages& images, const DisparityRange& range, const StereoOptions& options,
                        PairCloud& cloud, const Run& run) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  COLLINEA_TRY(const StereoParts parts, stereo_parts(images.left, images.right, range, options, run));
  const double spent_s = std::chrono::duration<double>(Clock::now() - start).count();
  run.say(fmt::format("semi-global matching of {} parts of {} x {} px: some {:.0f} s", parts.parts.size(),
                      images.left.width, images.left.height, spent_s * parts.work / std::max(parts.work_before, 1.0)));
  UnitList list{.stage = "surface"};
  for (std::size_t i = 0; i < parts.parts.size(); ++i) list.units.push_back(Unit::window(std::int64_t(i), 0));
  const Run alone{.stop = run.stop};
  const auto make = [&](const Unit& unit) -> Result<PairCloud::Piece> {
    const StereoPart& part = parts.parts[std::size_t(unit.first)];
    COLLINEA_TRY(const DisparityMap map, match_part(images.left, images.right, part, options, alone));
    return cloud.piece_of(points_of(map, part.column, part.row, 0, part.height));
  };
  return run_units_in_order(run, list, make, [&](const Unit&, const PairCloud::Piece& piece) -> Result<> {
    cloud.add(piece);
    return {};
  });
}

}  // namespace

EpipolarImages epipolar_images(PairImages images, const ModelOfPair& model, Interpolation resampling, const Run& run) {
  const EpipolarPair& cameras = model.epipolar;
  EpipolarImages made;
  made.left = resampled(images.left, model.left_camera, cameras.left_from_image, cameras.left, run, {}, resampling);
  images.left = {};
  made.right =
      resampled(images.right, model.right_camera, cameras.right_from_image, cameras.right, run, {}, resampling);
  return made;
}

Result<PairCloudSummary> write_surface(EpipolarImages images, const PairFiles& pair, const ModelOfPair& model,
                                       const PairOrientationSigma& by_orientation, const PairChainOptions& options,
                                       const fs::path& folder, PairReport& report, const Run& run) {
  const auto sigma = row_sigma(model.epipolar, model.orientation, median_disparity(model.in_epipolar));
  for (const LevelPoint& point : model.in_epipolar)
    report.row_sigma_px = std::max(report.row_sigma_px, sigma(point.left_px));
  const auto cloud_file = [&] { return PairCloud::create(folder, pair, model, report.absolute, by_orientation, run); };
  if (options.surface == PairSurface::kLevels) {
    COLLINEA_TRY(LevelSurface surface,
                 match_by_levels(images.left, images.right, model.in_epipolar, sigma, options.levels, run));
    images = {};
    give_back_freed_memory();
    report.levels = std::move(surface.levels);
    COLLINEA_TRY(PairCloud cloud, cloud_file());
    COLLINEA_TRY(add_all(surface.points, cloud, run));
    return cloud.finish();
  }
  COLLINEA_TRY(PairCloud cloud, cloud_file());
  const DisparityRange range = range_around(model.in_epipolar);
  if (double(images.left.width) * images.left.height > kLargestWhole) {
    COLLINEA_TRY(match_in_parts(images, range, options.stereo(), cloud, run));
    return cloud.finish();
  }
  COLLINEA_TRY(const DisparityMap map, match_pair(images.left, images.right, range, options.stereo(), run));
  COLLINEA_TRY(add_all(map, cloud, run));
  return cloud.finish();
}

}  // namespace collinea
