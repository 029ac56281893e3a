// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/volume.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <system_error>

#include "collinea/base/parallel.h"
#include "collinea/geometry/polygon.h"
#include "collinea/io/text.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

constexpr double kMostCells = 1e8;
constexpr double kCorrelatedCells = 3;
constexpr int kLines = 16;    // across a cell, along each of which the border is met exactly
constexpr double kReach = 3;  // correlation lengths beyond which nothing is alike
// The least common part of the whole variance: a smaller one is rounding by more than a twentieth, since standard
// deviations are rounded to floats, in files and where they are made.
constexpr double kLeastCommon = 80 * std::numeric_limits<float>::epsilon();

/// The part of a raster that an area touches, with the part of every cell that is inside.
struct Window {
  MapGrid grid;
  int column = 0, row = 0;
  FloatImage inside, height_m, sigma_m;  // relative
  FloatImage common_m;  // standard deviation of what neighbours have in common, beside sigma_m; NaN: not known
};

// What heights are measured from.
struct Base {
  FloatImage height_m, sigma_m, common_m;
};

// The common part of a standard deviation, beyond the relative one; NaN where one is not known, or drowns it.
float common_part(double sigma_m, double relative_m) {
  const double variance = sigma_m * sigma_m - relative_m * relative_m;
  return variance > kLeastCommon * sigma_m * sigma_m ? float(std::sqrt(variance))
                                                     : std::numeric_limits<float>::quiet_NaN();
}

// The part of every cell that lies inside, by lines through it.
FloatImage parts_inside(const MapGrid& grid, const MapArea& area) {
  FloatImage inside(grid.width, grid.height);
  std::vector<double> crossings;
  for (int y = 0; y < grid.height; ++y)
    for (int line = 0; line < kLines; ++line) {
      const double north = grid.north_of(y + (line + 0.5) / kLines);
      crossings.clear();
      for (std::size_t i = 0; i < area.size(); ++i) {
        const auto east = crossing(area[i], area[(i + 1) % area.size()], north);
        if (east) crossings.push_back(grid.column_of(*east));
      }
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
        const double from = std::clamp(crossings[k], 0.0, double(grid.width)),
                     to = std::clamp(crossings[k + 1], 0.0, double(grid.width));
        for (int x = int(from); x < std::min(grid.width, int(std::ceil(to))); ++x)
          inside.at(x, y) += float((std::min(to, x + 1.0) - std::max(from, double(x))) / kLines);
      }
    }
  return inside;
}

Result<Window> window_of(const SurfaceFiles& surface, const std::optional<MapArea>& area,
                         const VolumeOptions& options) {
  COLLINEA_TRY(const HeightSamples heights, HeightSamples::open(surface, options.sigma_m));
  Window window;
  window.grid = heights.grid();
  if (area) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Eigen::Vector2d& corner : *area) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    const MapGrid& whole = heights.grid();
    const auto clamped = [](double value, int most) { return int(std::clamp(value, 0.0, double(most))); };
    window.column = clamped(std::floor(whole.column_of(low.x())), whole.width);
    window.row = clamped(std::floor(whole.row_of(high.y())), whole.height);
    window.grid.width = clamped(std::ceil(whole.column_of(high.x())), whole.width) - window.column;
    window.grid.height = clamped(std::ceil(whole.row_of(low.y())), whole.height) - window.row;
    window.grid.west_m = whole.east_of(window.column);
    window.grid.north_m = whole.north_of(window.row);
    if (window.grid.width <= 0 || window.grid.height <= 0)
      return fail(Errc::kBadInput, "the area lies beside " + surface.height.string() + ": coordinates in another CRS?");
  }
  if (double(window.grid.width) * window.grid.height > kMostCells)
    return fail(Errc::kUnsupported, "more than 100 million cells: give a smaller area");
  window.inside = area ? parts_inside(window.grid, *area) : FloatImage(window.grid.width, window.grid.height, 1, 1.0f);
  COLLINEA_TRY(window.height_m, heights.heights(window.column, window.row, window.grid.width, window.grid.height));
  COLLINEA_TRY(window.common_m, heights.sigmas(window.column, window.row, window.grid.width, window.grid.height));
  COLLINEA_TRY(window.sigma_m,
               heights.relative_sigmas(window.column, window.row, window.grid.width, window.grid.height));
  for (std::size_t i = 0; i < window.sigma_m.data.size(); ++i)
    window.common_m.data[i] = common_part(double(window.common_m.data[i]), double(window.sigma_m.data[i]));
  return window;
}

// A raster weighted by a Gaussian around each of its cells, not divided by the sum of weights.
FloatImage blurred(const FloatImage& values, double length_cells, const Run& run) {
  const int reach = int(std::min<double>(std::ceil(kReach * length_cells), std::max(values.width, values.height)));
  std::vector<float> weights(std::size_t(2 * reach + 1));
  for (int i = -reach; i <= reach; ++i)
    weights[std::size_t(i + reach)] =
        length_cells > 0 ? float(std::exp(-0.5 * i * i / (length_cells * length_cells))) : 1.0f;
  const auto along = [&](const FloatImage& from, int dx, int dy) {
    FloatImage to(from.width, from.height);
    parallel_for(run, std::size_t(from.height), [&](std::size_t line) {
      const int y = int(line);
      for (int x = 0; x < from.width; ++x) {
        float sum = 0;
        for (int i = -reach; i <= reach; ++i) {
          const int u = x + i * dx, v = y + i * dy;
          if (u >= 0 && v >= 0 && u < from.width && v < from.height)
            sum += weights[std::size_t(i + reach)] * from.at(u, v);
        }
        to.at(x, y) = sum;
      }
    });
    return to;
  };
  return along(along(values, 1, 0), 0, 1);
}

// The names of a surface model and of the terrain model under it, or one and the same.
bool of_one_survey(const std::filesystem::path& surface, const std::filesystem::path& base) {
  const auto folder_of = [](const std::filesystem::path& file) {
    std::error_code error;
    const auto whole = std::filesystem::absolute(file, error).parent_path();
    const auto folder = std::filesystem::weakly_canonical(whole, error);
    return error ? whole : folder;
  };
  const auto name_of = [](const std::filesystem::path& file) {
    std::string name = lower(file.filename().string());
    if (const auto at = name.find("dtm"); at != std::string::npos) name.replace(at, 3, "dsm");
    return name;
  };
  return name_of(surface) == name_of(base) && folder_of(surface) == folder_of(base);
}

// Whether two surfaces have in common what their orientation adds, over the area of which both tell it.
bool of_one_orientation(const Window& window, const Base& base) {
  double apart = 0, together = 0;
  for (std::size_t i = 0; i < window.common_m.data.size(); ++i) {
    if (!(window.inside.data[i] > 0)) continue;
    const double a = std::pow(double(window.common_m.data[i]), 2), b = std::pow(double(base.common_m.data[i]), 2);
    if (!std::isfinite(a + b)) continue;
    apart += std::abs(a - b);
    together += a + b;
  }
  return apart <= kSameOrientation * together;
}

// The sum of standard deviations that are in common; where one is not known it is the mean of the others.
class CommonSum {
 public:
  void add(float sigma_m, double part_m2) {
    if (!std::isfinite(sigma_m)) return;
    sum_m3_ += double(sigma_m) * part_m2;
    known_m2_ += part_m2;
  }
  [[nodiscard]] double over(double area_m2) const { return known_m2_ > 0 ? sum_m3_ / known_m2_ * area_m2 : 0; }

 private:
  double sum_m3_ = 0, known_m2_ = 0;
};

// Sums of differences and their standard deviation; what is not known has no part in either.
Result<Volume> summed(const Window& window, const Base& base, const VolumeOptions& options, const Run& run) {
  const double cell_m2 = window.grid.cell_m * window.grid.cell_m;
  Volume volume;
  FloatImage errors(window.grid.width, window.grid.height);
  CommonSum common, base_common;
  for (std::size_t i = 0; i < errors.data.size(); ++i) {
    const double part_m2 = double(window.inside.data[i]) * cell_m2;
    if (!(part_m2 > 0)) continue;
    const double difference = double(window.height_m.data[i]) - double(base.height_m.data[i]);
    if (!std::isfinite(difference)) {
      volume.missing_m2 += part_m2;
      continue;
    }
    volume.area_m2 += part_m2;
    (difference > 0 ? volume.above_m3 : volume.below_m3) += std::abs(difference) * part_m2;
    const double sigma_m = std::hypot(double(window.sigma_m.data[i]), double(base.sigma_m.data[i]));
    errors.data[i] = float((std::isfinite(sigma_m) ? sigma_m : options.sigma_m) * part_m2);
    common.add(window.common_m.data[i], part_m2);
    base_common.add(base.common_m.data[i], part_m2);
  }
  const double length_cells = options.correlation_m ? *options.correlation_m / window.grid.cell_m : kCorrelatedCells;
  const FloatImage alike = blurred(errors, length_cells, run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  double variance = 0;
  for (std::size_t i = 0; i < errors.data.size(); ++i) variance += double(errors.data[i]) * double(alike.data[i]);
  volume.sigma_heights_m3 = std::sqrt(variance);
  volume.sigma_shift_m3 =
      std::hypot(options.shift_sigma_m * volume.area_m2, common.over(volume.area_m2), base_common.over(volume.area_m2));
  return volume;
}

// Least squares over the cells along the border.
Result<> fit_rim(const Window& window, FloatImage& base_m, Volume& plane, Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  long count = 0;
  plane.middle = {window.grid.east_of(0.5 * window.grid.width), window.grid.north_of(0.5 * window.grid.height)};
  const auto row_of = [&](int x, int y) {
    return Eigen::Vector3d(1, window.grid.east_of(x + 0.5) - plane.middle.x(),
                           window.grid.north_of(y + 0.5) - plane.middle.y());
  };
  // Cells that the border crosses, and whole ones that touch what is outside.
  const auto is_out = [&](int x, int y) {
    return x < 0 || y < 0 || x >= window.grid.width || y >= window.grid.height || window.inside.at(x, y) < 1e-6f;
  };
  const auto is_rim = [&](int x, int y) {
    return !is_out(x, y) && (window.inside.at(x, y) < 1 - 1e-6f || is_out(x - 1, y) || is_out(x + 1, y) ||
                             is_out(x, y - 1) || is_out(x, y + 1));
  };
  const auto each_rim = [&](auto&& visit) {
    for (int y = 0; y < window.grid.height; ++y)
      for (int x = 0; x < window.grid.width; ++x)
        if (is_rim(x, y) && std::isfinite(window.height_m.at(x, y)))
          visit(row_of(x, y), double(window.height_m.at(x, y)));
  };
  each_rim([&](const Eigen::Vector3d& a, double height_m) {
    normal += a * a.transpose();
    right += a * height_m;
    ++count;
  });
  const Eigen::LDLT<Eigen::Matrix3d> solved(normal);
  if (count < 4 || !(solved.vectorD().minCoeff() > 1e-9 * solved.vectorD().maxCoeff()))
    return fail(Errc::kIllPosed, "too few heights along the border of the area for a plane");
  plane.plane = solved.solve(right);
  each_rim([&](const Eigen::Vector3d& a, double height_m) { squares += std::pow(height_m - a.dot(*plane.plane), 2); });
  plane.rim_rms_m = std::sqrt(squares / double(count));
  covariance = solved.solve(Eigen::Matrix3d::Identity()) * (squares / double(count - 3));
  for (int y = 0; y < window.grid.height; ++y)
    for (int x = 0; x < window.grid.width; ++x) base_m.at(x, y) = float(row_of(x, y).dot(*plane.plane));
  return {};
}

}  // namespace

double Volume::sigma_m3() const { return std::hypot(sigma_heights_m3, sigma_shift_m3, sigma_base_m3); }

Result<Volume> volume_over_level(const SurfaceFiles& surface, double base_m, const std::optional<MapArea>& area,
                                 const VolumeOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const Window window, window_of(surface, area, options));
  const FloatImage exact(window.grid.width, window.grid.height);
  return summed(window, {FloatImage(window.grid.width, window.grid.height, 1, float(base_m)), exact, exact}, options,
                run);
}

Result<Volume> volume_over_rim(const SurfaceFiles& surface, const MapArea& area, const VolumeOptions& options,
                               const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(Window window, window_of(surface, area, options));
  const FloatImage exact(window.grid.width, window.grid.height);
  window.common_m = exact;
  VolumeOptions without_shift = options;
  without_shift.shift_sigma_m = 0;
  Base base{exact, exact, exact};
  Volume plane;
  Eigen::Matrix3d covariance;
  COLLINEA_TRY(fit_rim(window, base.height_m, plane, covariance));
  COLLINEA_TRY(Volume volume, summed(window, base, without_shift, run));
  volume.plane = plane.plane;
  volume.middle = plane.middle;
  volume.rim_rms_m = plane.rim_rms_m;
  Eigen::Vector3d by_plane = Eigen::Vector3d::Zero();
  const double cell_m2 = window.grid.cell_m * window.grid.cell_m;
  for (int y = 0; y < window.grid.height; ++y)
    for (int x = 0; x < window.grid.width; ++x)
      if (window.inside.at(x, y) > 0 && std::isfinite(window.height_m.at(x, y)))
        by_plane += double(window.inside.at(x, y)) * cell_m2 *
                    Eigen::Vector3d(1, window.grid.east_of(x + 0.5) - plane.middle.x(),
                                    window.grid.north_of(y + 0.5) - plane.middle.y());
  volume.sigma_base_m3 = std::sqrt(by_plane.dot(covariance * by_plane));
  return volume;
}

Result<Volume> volume_over_surface(const SurfaceFiles& surface, const SurfaceFiles& base,
                                   const std::optional<MapArea>& area, const VolumeOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(Window window, window_of(surface, area, options));
  COLLINEA_TRY(HeightSamples below, HeightSamples::open(base, options.sigma_m));
  if (!below.grid().wkt.empty() && !window.grid.wkt.empty() && below.grid().wkt != window.grid.wkt)
    return fail(Errc::kBadInput, base.height.string() + " lies in another CRS than " + surface.height.string());
  const FloatImage none(window.grid.width, window.grid.height);
  Base read{none, none, none};
  for (int y = 0; y < window.grid.height; ++y) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    for (int x = 0; x < window.grid.width; ++x) {
      if (!(window.inside.at(x, y) > 0)) continue;
      COLLINEA_TRY(const HeightSample one, below.at({window.grid.east_of(x + 0.5), window.grid.north_of(y + 0.5)}));
      read.height_m.at(x, y) = float(one.height_m);
      read.sigma_m.at(x, y) = float(one.sigma_relative_m);
      read.common_m.at(x, y) = common_part(one.sigma_m, one.sigma_relative_m);
    }
  }
  VolumeOptions of_both = options;
  if (of_one_survey(surface.height, base.height) && of_one_orientation(window, read)) {
    window.common_m = read.common_m = none;
    of_both.shift_sigma_m = 0;
  }
  return summed(window, read, of_both, run);
}

}  // namespace collinea
