// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/grid_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/jobs/internal/point_rows.h"
#include "collinea/raster/band_descriptions.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kNoHeight = -9999;
constexpr int kStripRows = 512;
constexpr double kMostCells = 1e9;
constexpr std::size_t kLeftOut = 10;  // one in so many

struct Extent {
  Eigen::Vector2d low, high;

  explicit Extent(const std::vector<HeightPoint>& points)
      : low(points.front().position.head<2>()), high(points.front().position.head<2>()) {
    for (const HeightPoint& point : points) {
      low = low.cwiseMin(point.position.head<2>());
      high = high.cwiseMax(point.position.head<2>());
    }
  }
  [[nodiscard]] double mean_distance_m(std::size_t points) const {
    const Eigen::Vector2d size = high - low;
    return std::max(std::sqrt(size.x() * size.y() / double(points)), size.maxCoeff() / double(points));
  }
};

Result<MapGrid> grid_over(const Extent& extent, double cell_m) {
  MapGrid grid{.west_m = std::floor(extent.low.x() / cell_m) * cell_m,
               .north_m = std::ceil(extent.high.y() / cell_m) * cell_m,
               .cell_m = cell_m};
  const double width = std::ceil((extent.high.x() - grid.west_m) / cell_m),
               height = std::ceil((grid.north_m - extent.low.y()) / cell_m);
  if (!(width * height <= kMostCells) || !(width < 1e6) || !(height < 1e6))
    return fail(Errc::kBadInput, fmt::format("cells of {} m make {} x {}: too many", cell_m, width, height),
                {"cell_m"_option});
  grid.width = std::max(int(width), 1);
  grid.height = std::max(int(height), 1);
  return grid;
}

Result<std::unique_ptr<HeightInterpolation>> interpolation_of(const std::vector<HeightPoint>& points, double distance_m,
                                                              const GridPointsOptions& options,
                                                              const std::optional<FittedCovariance>& fitted) {
  switch (options.method) {
    case GridMethod::kSplines:
      return bicubic_splines(points, options.spacing_m.value_or(2 * distance_m));
    case GridMethod::kTriangles:
      return triangulated(points, options.longest_m.value_or(std::numeric_limits<double>::infinity()));
    case GridMethod::kPlanes:
      return local_planes(points, options.nearest);
    case GridMethod::kCollocation:
      break;
  }
  return collocation(points, *fitted, options.nearest);
}

// Every tenth point from the others.
Result<> leave_out(const std::vector<HeightPoint>& points, double distance_m, const GridPointsOptions& options,
                   GriddedPoints& gridded) {
  std::vector<HeightPoint> kept, left_out;
  for (std::size_t i = 0; i < points.size(); ++i) (i % kLeftOut == kLeftOut / 2 ? left_out : kept).push_back(points[i]);
  const auto surface = interpolation_of(kept, distance_m, options, gridded.covariance);
  if (!surface) return {};  // too few without them
  double squares = 0, ratios = 0;
  std::size_t with_sigma = 0;
  const double noise_m2 = gridded.covariance ? gridded.covariance->covariance.noise_m2 : 0;
  for (const HeightPoint& point : left_out) {
    const InterpolatedHeight there = (*surface)->at(point.position.head<2>());
    if (std::isnan(there.height_m)) continue;
    const double error = there.height_m - point.position.z();
    ++gridded.left_out;
    squares += error * error;
    const double variance = there.sigma_m * there.sigma_m + point.sigma_m * point.sigma_m + noise_m2;
    if (!(variance > 0)) continue;
    ratios += error * error / variance;
    ++with_sigma;
  }
  if (gridded.left_out > 0) gridded.left_out_rms_m = std::sqrt(squares / double(gridded.left_out));
  if (with_sigma > 0) gridded.left_out_variance_ratio = ratios / double(with_sigma);
  return {};
}

Result<> write_grid(const HeightInterpolation& surface, const fs::path& out, GriddedPoints& gridded, const Run& run) {
  const MapGrid& grid = gridded.grid;
  const fs::path sigma_path = out.parent_path() / (out.stem().string() + "_sigma" + out.extension().string());
  const auto create = [&](const fs::path& path, FileText description) {
    return GeoTiffWriter<float>::create(path, grid, 1, {.nodata = kNoHeight, .description = std::string(description)});
  };
  COLLINEA_TRY(auto heights, create(out, band::kSurfaceHeight));
  COLLINEA_TRY(auto sigmas, create(sigma_path, band::kHeightSigma));
  for (int row = 0; row < grid.height; row += kStripRows) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    const int rows = std::min(kStripRows, grid.height - row);
    FloatImage height(grid.width, rows, 1), sigma(grid.width, rows, 1);
    parallel_for(run, std::size_t(rows), [&](std::size_t at) {
      const int y = int(at);
      for (int x = 0; x < grid.width; ++x) {
        const InterpolatedHeight there = surface.at({grid.east_of(x + 0.5), grid.north_of(row + y + 0.5)});
        height.at(x, y) = float(std::isnan(there.height_m) ? kNoHeight : there.height_m);
        sigma.at(x, y) = float(std::isnan(there.sigma_m) ? kNoHeight : there.sigma_m);
      }
    });
    gridded.cells += std::size_t(
        std::count_if(height.data.begin(), height.data.end(), [](float value) { return value != float(kNoHeight); }));
    COLLINEA_TRY(heights.write(0, row, height));
    COLLINEA_TRY(sigmas.write(0, row, sigma));
    run.report("grid", double(row + rows) / grid.height);
  }
  COLLINEA_TRY(heights.finish());
  return sigmas.finish();
}

}  // namespace

namespace {

// Options of another method than the one asked for.
Result<> check_method(const GridPointsOptions& options) {
  if (options.covariance && options.method != GridMethod::kCollocation)
    return fail(Errc::kBadInput, "only collocation has a covariance", {"covariance"_option, "method"_option});
  if (options.spacing_m && options.method != GridMethod::kSplines)
    return fail(Errc::kBadInput, "only splines have squares of a side", {"spacing_m"_option, "method"_option});
  if (options.longest_m && options.method != GridMethod::kTriangles)
    return fail(Errc::kBadInput, "only triangles have a longest side", {"longest_m"_option, "method"_option});
  return {};
}

}  // namespace

Result<GriddedPoints> grid_points(const fs::path& points_path, const fs::path& out, const GridPointsOptions& options,
                                  const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_method(options));
  COLLINEA_TRY(const std::vector<HeightPoint> points, read_point_rows(points_path));
  if (points.size() < 3) return fail(Errc::kIllPosed, points_path.string() + ": a surface needs three points or more");
  const Extent extent(points);
  const double distance_m = extent.mean_distance_m(points.size());
  if (!(distance_m > 0)) return fail(Errc::kIllPosed, points_path.string() + ": all points lie on one position");
  GriddedPoints gridded{.method = options.method, .points = points.size()};
  COLLINEA_TRY(gridded.grid, grid_over(extent, options.cell_m.value_or(distance_m / 2)));
  if (options.method == GridMethod::kCollocation) {
    COLLINEA_TRY(gridded.covariance, fit_covariance(points, options.covariance));
  }
  COLLINEA_TRY(const auto surface, interpolation_of(points, distance_m, options, gridded.covariance));
  COLLINEA_TRY(leave_out(points, distance_m, options, gridded));
  COLLINEA_TRY(write_grid(*surface, out, gridded, run));
  return gridded;
}

}  // namespace collinea
