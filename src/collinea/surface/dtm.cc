// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/dtm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "collinea/base/median.h"
#include "collinea/base/parallel.h"
#include "collinea/image/contours.h"
#include "collinea/io/file.h"
#include "collinea/surface/ground_filter.h"
#include "collinea/surface/pull_push.h"

namespace collinea {
namespace {

constexpr double kCoarseCells = 80;      // over the largest object
constexpr double kMostCoarse = 64e6;     // cells: 256 MB a raster
constexpr int kStripRows = 512;          // of the surface model at a time
constexpr double kLowQuantile = 0.1;     // of the heights in a coarse cell: below leaves, above wrong matches
constexpr double kLeastMeasured = 0.1;   // of a coarse cell, for it to count
constexpr double kToleranceCells = 0.5;  // of heights over the ground, in coarse cells
constexpr double kContoursOverRelief = 20;
constexpr double kContourBlurCells = 2;  // coarse: contours are to show the land, not the grass
constexpr double kShortestContour = 20;  // coarse cells around
constexpr double kStrayShare = 0.01;     // of the ground, at either end, says nothing of the relief
constexpr double kContourSigmas = 4;     // lines closer than that would cross by chance

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// A strip of the surface model. What the orientation adds to the errors of neighbours is the same for all: it does not
// take part in what is ground.
struct Strip {
  FloatImage height_m, sigma_m;  // relative
  Raster<std::uint8_t> state;
};

class Terrain {
 public:
  Terrain(const DsmFiles& dsm, const DtmFiles& files, const DtmOptions& options, const Run& run)
      : dsm_(dsm), files_(files), options_(options), run_(run) {}

  Result<Dtm> make() {
    COLLINEA_TRY(auto height, GeoTiffReader::open(dsm_.height));
    COLLINEA_TRY(auto sigma, GeoTiffReader::open(dsm_.sigma));
    COLLINEA_TRY(auto sigma_relative, GeoTiffReader::open(dsm_.sigma_relative));
    COLLINEA_TRY(auto state, GeoTiffReader::open(dsm_.state));
    height_ = &height, sigma_ = &sigma, sigma_relative_ = &sigma_relative, state_ = &state;
    summary_.grid = height.grid();
    choose_grid();
    auto made = find_low().and_then([&] { return find_ground(); }).and_then([&] { return average(); });
    if (made) made = write();
    if (made) made = draw_contours();
    if (!made) return tl::unexpected(std::move(made).error());
    return Dtm{summary_, std::move(ground_)};
  }

 private:
  // Coarse cells of whole cells of the surface model.
  void choose_grid() {
    const MapGrid& grid = summary_.grid;
    each_ = std::max(1, int(std::lround(options_.largest_object_m / kCoarseCells / grid.cell_m)));
    const auto cells = [&](int n) { return (n + each_ - 1) / each_; };
    while (double(cells(grid.width)) * double(cells(grid.height)) > kMostCoarse) ++each_;
    coarse_width_ = cells(grid.width), coarse_height_ = cells(grid.height);
    cell_m_ = each_ * grid.cell_m;
    summary_.coarse_cell_m = cell_m_;
  }

  [[nodiscard]] MapGrid coarse_grid() const {
    MapGrid grid = summary_.grid;
    grid.cell_m = cell_m_;
    grid.width = coarse_width_, grid.height = coarse_height_;
    return grid;
  }

  Result<Strip> read_strip(int row, int rows) const {
    const int width = summary_.grid.width;
    Strip strip;
    COLLINEA_TRY(strip.height_m, height_->read_float(0, row, width, rows));
    COLLINEA_TRY(strip.sigma_m, sigma_relative_->read_float(0, row, width, rows));
    COLLINEA_TRY(strip.state, state_->read_byte(0, row, width, rows));
    return strip;
  }

  // What the orientation adds to the sigmas of a strip as it was read.
  Result<FloatImage> read_added_variance(const Strip& strip, int row) const {
    COLLINEA_TRY(FloatImage added, sigma_->read_float(0, row, strip.state.width, strip.state.height));
    for (std::size_t i = 0; i < added.data.size(); ++i) {
      const float sigma_m = added.data[i], relative_m = strip.sigma_m.data[i];
      added.data[i] = std::max(0.0f, sigma_m * sigma_m - relative_m * relative_m);
    }
    return added;
  }

  // Calls work(row of coarse cells, strip, first row of the strip) for every row of coarse cells, several at once.
  template <class Work>
  Result<> over_coarse_rows(double done_before, double done_after, Work&& work) {
    const int lines = std::max(1, kStripRows / each_), height = summary_.grid.height;
    for (int line = 0; line < coarse_height_; line += lines) {
      const int row = line * each_, rows = std::min(lines * each_, height - row);
      COLLINEA_TRY(const Strip strip, read_strip(row, rows));
      parallel_for(run_, std::size_t((rows + each_ - 1) / each_),
                   [&](std::size_t i) { work(line + int(i), strip, row); });
      if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
      run_.report("terrain", done_before + (done_after - done_before) * double(row + rows) / height);
    }
    return {};
  }

  // Calls visit(x, y in the strip) for every measured cell of a coarse cell.
  template <class Visit>
  void for_measured(const Strip& strip, int first_row, int u, int v, Visit&& visit) const {
    const int top = v * each_ - first_row, bottom = std::min(top + each_, strip.state.height);
    const int left = u * each_, right = std::min(left + each_, strip.state.width);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x)
        if (strip.state.at(x, y) == std::uint8_t(CellState::kMeasured)) visit(x, y);
  }

  [[nodiscard]] bool enough(std::size_t cells) const { return double(cells) >= kLeastMeasured * each_ * each_; }

  Result<> find_low() {
    low_m_ = FloatImage(coarse_width_, coarse_height_, 1, kNaN);
    return over_coarse_rows(0, 0.25, [&](int v, const Strip& strip, int first_row) {
      std::vector<float> heights;
      for (int u = 0; u < coarse_width_; ++u) {
        heights.clear();
        for_measured(strip, first_row, u, v, [&](int x, int y) { heights.push_back(strip.height_m.at(x, y)); });
        if (heights.empty() || !enough(heights.size())) continue;
        const auto low = heights.begin() + std::ptrdiff_t(kLowQuantile * double(heights.size() - 1));
        std::nth_element(heights.begin(), low, heights.end());
        low_m_.at(u, v) = *low;
      }
    });
  }

  // The ground as far as coarse cells tell it, and how much higher what belongs to it may be.
  Result<> find_ground() {
    const Raster<std::uint8_t> ground = ground_cells(low_m_, cell_m_, options_.largest_object_m, run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    if (std::none_of(ground.data.begin(), ground.data.end(), [](std::uint8_t g) { return g != 0; }))
      return fail(Errc::kIllPosed, "nothing in the surface model is ground");
    for (std::size_t i = 0; i < ground.data.size(); ++i)
      if (!ground.data[i]) low_m_.data[i] = kNaN;
    HeightLevel level = level_of(low_m_, cell_m_);
    fill_all(level);
    ground_ = GroundSurface(coarse_grid(), std::move(level.height_m));
    low_m_ = FloatImage();
    return {};
  }

  [[nodiscard]] bool is_ground(const Strip& strip, int first_row, int x, int y) const {
    return ground_.shows_ground((x + 0.5) / each_, (first_row + y + 0.5) / each_, double(strip.height_m.at(x, y)),
                                double(strip.sigma_m.at(x, y)));
  }

  // Means of the ground in coarse cells, continued where there is none.
  Result<> average() {
    mean_ = HeightLevel(0, 0, coarse_width_, coarse_height_, cell_m_, 0);
    covered_ = Raster<std::uint8_t>(coarse_width_, coarse_height_);
    auto done = over_coarse_rows(0.3, 0.6, [&](int v, const Strip& strip, int first_row) {
      for (int u = 0; u < coarse_width_; ++u) average_cell(strip, first_row, u, v);
    });
    if (!done) return done;
    if (std::none_of(mean_.weight.data.begin(), mean_.weight.data.end(), [](float w) { return w > 0; }))
      return fail(Errc::kIllPosed, "nothing in the surface model is ground");
    fill_all(mean_);
    return {};
  }

  void average_cell(const Strip& strip, int first_row, int u, int v) {
    double sum = 0, squares = 0;
    std::size_t count = 0;
    for_measured(strip, first_row, u, v, [&](int x, int y) {
      if (!is_ground(strip, first_row, x, y)) return;
      sum += double(strip.height_m.at(x, y));
      squares += std::pow(double(strip.sigma_m.at(x, y)), 2);
      ++count;
    });
    const int top = v * each_ - first_row, bottom = std::min(top + each_, strip.state.height);
    const int left = u * each_, right = std::min(left + each_, strip.state.width);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) covered_.at(u, v) |= strip.state.at(x, y) != std::uint8_t(CellState::kEmpty);
    if (count == 0 || !enough(count)) return;
    mean_.height_m.at(u, v) = float(sum / double(count));
    mean_.sigma_m.at(u, v) = float(std::sqrt(squares / double(count)));
    mean_.weight.at(u, v) = float(count);
  }

  // Ground stays as measured; all else takes the means around.
  void make_terrain(Strip& strip, int first_row, int y) const {
    for (int x = 0; x < strip.state.width; ++x) {
      std::uint8_t& state = strip.state.at(x, y);
      if (state == std::uint8_t(CellState::kEmpty)) continue;
      if (state == std::uint8_t(CellState::kMeasured) && is_ground(strip, first_row, x, y)) continue;
      state = std::uint8_t(CellState::kInterpolated);
      const double u = (x + 0.5) / each_, v = (first_row + y + 0.5) / each_;
      strip.height_m.at(x, y) = bilinear(mean_.height_m, u, v);
      strip.sigma_m.at(x, y) = bilinear(mean_.sigma_m, u, v);
    }
  }

  void tally(const Strip& strip, const FloatImage& added_variance) {
    for (std::size_t i = 0; i < strip.state.data.size(); ++i) {
      const auto state = CellState(strip.state.data[i]);
      const double height_m = strip.height_m.data[i];
      if (state == CellState::kEmpty) {
        ++summary_.empty_cells;
        continue;
      }
      const bool first = summary_.ground_cells + summary_.interpolated_cells == 0;
      summary_.lowest_m = first ? height_m : std::min(summary_.lowest_m, height_m);
      summary_.highest_m = first ? height_m : std::max(summary_.highest_m, height_m);
      if (state == CellState::kInterpolated) {
        ++summary_.interpolated_cells;
        continue;
      }
      ++summary_.ground_cells;
      const double squared = std::pow(double(strip.sigma_m.data[i]), 2);
      summary_.mean_sigma_relative_m += squared;
      summary_.mean_sigma_m += squared + double(added_variance.data[i]);
    }
  }

  // The standard deviations with what the orientation adds.
  [[nodiscard]] static FloatImage whole_sigmas(const Strip& strip, const FloatImage& added_variance) {
    FloatImage sigma_m = strip.sigma_m;
    for (std::size_t i = 0; i < sigma_m.data.size(); ++i)
      if (strip.state.data[i] != std::uint8_t(CellState::kEmpty))
        sigma_m.data[i] = std::sqrt(sigma_m.data[i] * sigma_m.data[i] + added_variance.data[i]);
    return sigma_m;
  }

  Result<> write() {
    const MapGrid& grid = summary_.grid;
    GeoTiffWriter<float>::Options of_height, of_sigma;
    of_height.nodata = of_sigma.nodata = double(kNoHeight);
    of_height.description = "digital terrain model: height of the ground [m]";
    of_sigma.description = "standard deviation of the height [m]";
    GeoTiffWriter<float>::Options of_relative = of_sigma;
    of_relative.description = "standard deviation of the height against those around it [m]";
    GeoTiffWriter<std::uint8_t>::Options of_state;
    of_state.description = "0 nothing, 1 ground as measured, 2 interpolated";
    COLLINEA_TRY(auto height, GeoTiffWriter<float>::create(files_.height, grid, 1, of_height));
    COLLINEA_TRY(auto sigma, GeoTiffWriter<float>::create(files_.sigma, grid, 1, of_sigma));
    COLLINEA_TRY(auto relative, GeoTiffWriter<float>::create(files_.sigma_relative, grid, 1, of_relative));
    COLLINEA_TRY(auto state, GeoTiffWriter<std::uint8_t>::create(files_.state, grid, 1, of_state));
    for (int row = 0; row < grid.height; row += kStripRows) {
      COLLINEA_TRY(Strip strip, read_strip(row, std::min(kStripRows, grid.height - row)));
      COLLINEA_TRY(const FloatImage added_variance, read_added_variance(strip, row));
      parallel_for(run_, std::size_t(strip.state.height), [&](std::size_t y) { make_terrain(strip, row, int(y)); });
      if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
      tally(strip, added_variance);
      auto written = height.write(0, row, strip.height_m)
                         .and_then([&] { return relative.write(0, row, strip.sigma_m); })
                         .and_then([&] { return sigma.write(0, row, whole_sigmas(strip, added_variance)); })
                         .and_then([&] { return state.write(0, row, strip.state); });
      if (!written) return written;
      run_.report("terrain", 0.6 + 0.4 * double(row + strip.state.height) / grid.height);
    }
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    if (summary_.ground_cells > 0)
      for (double* mean : {&summary_.mean_sigma_m, &summary_.mean_sigma_relative_m})
        *mean = std::sqrt(*mean / double(summary_.ground_cells));
    // The height comes last: where it is, all rasters are.
    return sigma.finish()
        .and_then([&] { return relative.finish(); })
        .and_then([&] { return state.finish(); })
        .and_then([&] { return height.finish(); });
  }

  [[nodiscard]] double contour_interval_m() const {
    if (options_.contour_m) return *options_.contour_m;
    std::vector<float> heights;
    for (std::size_t i = 0; i < covered_.data.size(); ++i)
      if (covered_.data[i]) heights.push_back(mean_.height_m.data[i]);
    if (heights.empty()) return 0;
    const double highest_m = double(quantile(heights, 1 - kStrayShare)),
                 relief_m = highest_m - double(quantile(heights, kStrayShare));
    const double least_m = std::max(relief_m / kContoursOverRelief, kContourSigmas * summary_.mean_sigma_relative_m);
    if (!(least_m > 0)) return 0;
    const double unit_m = std::pow(10.0, std::floor(std::log10(least_m)));
    for (const double times : {1, 2, 5})
      if (times * unit_m >= least_m) return times * unit_m;
    return 10 * unit_m;
  }

  // The means where the surface model has anything, NaN elsewhere, blurred by a Gaussian over their like.
  [[nodiscard]] FloatImage blurred_means() const {
    constexpr int kRadius = int(3 * kContourBlurCells);
    std::array<float, 2 * kRadius + 1> weights;
    for (int i = -kRadius; i <= kRadius; ++i)
      weights[std::size_t(i + kRadius)] = float(std::exp(-0.5 * i * i / (kContourBlurCells * kContourBlurCells)));
    const auto sums_along = [&](const FloatImage& from, int dx, int dy) {
      FloatImage to(from.width, from.height);
      parallel_for(run_, std::size_t(from.height), [&](std::size_t line) {
        const int y = int(line);
        for (int x = 0; x < from.width; ++x)
          for (int i = -kRadius; i <= kRadius; ++i)
            to.at(x, y) += weights[std::size_t(i + kRadius)] * from.at(std::clamp(x + i * dx, 0, from.width - 1),
                                                                       std::clamp(y + i * dy, 0, from.height - 1));
      });
      return to;
    };
    FloatImage sums(coarse_width_, coarse_height_), counts = sums;
    for (std::size_t i = 0; i < covered_.data.size(); ++i)
      if (covered_.data[i]) sums.data[i] = mean_.height_m.data[i], counts.data[i] = 1;
    sums = sums_along(sums_along(sums, 1, 0), 0, 1);
    counts = sums_along(sums_along(counts, 1, 0), 0, 1);
    for (std::size_t i = 0; i < covered_.data.size(); ++i)
      sums.data[i] = covered_.data[i] ? sums.data[i] / counts.data[i] : kNaN;
    return sums;
  }

  Result<> draw_contours() {
    std::filesystem::path drawing = files_.contours;
    drawing.replace_extension(".dxf");
    summary_.contour_m = contour_interval_m();
    if (summary_.contour_m == 0) {
      for (const auto& file : {files_.contours, drawing})
        if (auto removed = remove_file(file); !removed) return removed;
      return {};
    }
    const FloatImage means = blurred_means();
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(summary_.contours, write_contours(means, coarse_grid(), summary_.contour_m, kShortestContour * cell_m_,
                                                   files_.contours, drawing));
    return {};
  }

  const DsmFiles& dsm_;
  const DtmFiles& files_;
  const DtmOptions& options_;
  const Run& run_;
  const GeoTiffReader *height_ = nullptr, *sigma_ = nullptr, *sigma_relative_ = nullptr, *state_ = nullptr;
  DtmSummary summary_;
  int each_ = 1;  // cells of the surface model along a coarse one
  int coarse_width_ = 0, coarse_height_ = 0;
  double cell_m_ = 0;             // of the coarse grid
  FloatImage low_m_;              // low heights of coarse cells
  GroundSurface ground_;          // that they tell, everywhere
  HeightLevel mean_;              // of the ground
  Raster<std::uint8_t> covered_;  // by the surface model
};

}  // namespace

GroundSurface::GroundSurface(MapGrid grid, FloatImage low_m)
    : grid_(std::move(grid)), low_m_(std::move(low_m)), tolerance_m_(low_m_.width, low_m_.height) {
  const auto at = [&](int x, int y) {
    return double(low_m_.at(std::clamp(x, 0, low_m_.width - 1), std::clamp(y, 0, low_m_.height - 1)));
  };
  for (int v = 0; v < low_m_.height; ++v)
    for (int u = 0; u < low_m_.width; ++u) {
      const double rise_m = std::hypot(at(u + 1, v) - at(u - 1, v), at(u, v + 1) - at(u, v - 1)) / 2;
      tolerance_m_.at(u, v) = float(kToleranceCells * grid_.cell_m + rise_m);
    }
}

bool GroundSurface::shows_ground(double column, double row, double height_m, double sigma_m) const {
  const int u = std::clamp(int(column), 0, low_m_.width - 1), v = std::clamp(int(row), 0, low_m_.height - 1);
  return std::abs(height_m - double(bilinear(low_m_, column, row))) <= double(tolerance_m_.at(u, v)) + 3 * sigma_m;
}

bool GroundSurface::shows_ground(const Eigen::Vector3d& on_map, double sigma_m) const {
  const double column = grid_.column_of(on_map.x()), row = grid_.row_of(on_map.y());
  if (!(column >= 0 && row >= 0 && column < grid_.width && row < grid_.height)) return false;
  return shows_ground(column, row, on_map.z(), sigma_m);
}

Result<Dtm> build_dtm(const DsmFiles& dsm, const DtmFiles& files, const DtmOptions& options, const Run& run) {
  if (auto valid = validate(options); !valid) return tl::unexpected(std::move(valid).error());
  return Terrain(dsm, files, options, run).make();
}

}  // namespace collinea
