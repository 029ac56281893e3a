// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/dtm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/memory.h"
#include "collinea/base/parallel.h"
#include "collinea/math/median.h"
#include "collinea/raster/raster_spool.h"
#include "collinea/surface/ground_filter.h"
#include "collinea/surface/pull_push.h"
#include "collinea/vector/contours.h"

namespace collinea {
namespace {

constexpr double kCoarseCells = 80;   // over the largest object
constexpr double kMostCoarse = 64e6;  // cells: 256 MB a raster
// Of the surface model at a time: a few megabytes, the same for any width. Rasters are compressed in squares of 512
// cells, of which whole ones are written.
constexpr int kSquare = 512;
constexpr int kPieceColumns = 4096, kPieceRows = 128;  // read; about
constexpr int kLeastCoarseRows = 4;                    // of a piece: threads share them
constexpr int kWrittenColumns = 1024, kWrittenRows = kSquare;
static_assert(kWrittenColumns % kSquare == 0);
constexpr double kLowQuantile = 0.1;     // of the heights in a coarse cell: below leaves, above wrong matches
constexpr double kLeastMeasured = 0.1;   // of a coarse cell, for it to count
constexpr double kToleranceCells = 0.5;  // of heights over the ground, in coarse cells
constexpr double kContoursOverRelief = 20;
constexpr double kContourBlurCells = 2;  // coarse: contours are to show the land, not the grass
constexpr int kBlurRows = 64;            // blurred together
constexpr double kShortestContour = 20;  // coarse cells around
constexpr double kStrayShare = 0.01;     // of the ground, at either end, says nothing of the relief
constexpr double kContourSigmas = 3;     // of a cell; blurred heights err less: closer lines would cross by chance

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// A piece of the surface model. What the orientation adds to the errors of neighbours is the same for all: it does not
// take part in what is ground.
struct Piece {
  int column = 0, row = 0;  // of its upper-left cell
  FloatImage height_m;
  FloatImage sigma_m;  // relative; not read for low heights
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

  Result<Piece> read_heights(int column, int row, int width, int rows) const {
    Piece piece{column, row, {}, {}, {}};
    COLLINEA_TRY(piece.height_m, height_->read_float(column, row, width, rows));
    COLLINEA_TRY(piece.state, state_->read_byte(column, row, width, rows));
    return piece;
  }

  Result<> read_sigmas(Piece& piece) const {
    COLLINEA_TRY(piece.sigma_m,
                 sigma_relative_->read_float(piece.column, piece.row, piece.state.width, piece.state.height));
    return {};
  }

  // What the orientation adds to the sigmas of a piece as it was read.
  Result<FloatImage> read_added_variance(const Piece& piece) const {
    COLLINEA_TRY(FloatImage added, sigma_->read_float(piece.column, piece.row, piece.state.width, piece.state.height));
    for (std::size_t i = 0; i < added.data.size(); ++i) {
      const float sigma_m = added.data[i], relative_m = piece.sigma_m.data[i];
      added.data[i] = std::max(0.0f, sigma_m * sigma_m - relative_m * relative_m);
    }
    return added;
  }

  // Columns of pieces of whole coarse cells: of whole squares, too, where that is possible, so that none is unpacked
  // for two of them.
  [[nodiscard]] int piece_columns() const {
    const int both = std::lcm(each_, kSquare), unit = both <= kPieceColumns ? both : each_;
    return std::max(1, kPieceColumns / unit) * unit;
  }

  // Calls work(row of coarse cells, piece) for every row of coarse cells in every piece, several at once. Pieces come
  // column by column: the squares in which one ends and the next begins are still in the cache.
  template <class Work>
  Result<> over_coarse_rows(bool sigmas, double done_before, double done_after, Work&& work) {
    const int rows = std::max(kLeastCoarseRows, kPieceRows / each_) * each_, columns = piece_columns();
    const auto [width, height] = std::pair(summary_.grid.width, summary_.grid.height);
    for (int column = 0; column < width; column += columns)
      for (int row = 0; row < height; row += rows) {
        COLLINEA_TRY(Piece piece,
                     read_heights(column, row, std::min(columns, width - column), std::min(rows, height - row)));
        if (sigmas)
          COLLINEA_TRY(read_sigmas(piece));
        parallel_for(run_, std::size_t((piece.state.height + each_ - 1) / each_),
                     [&](std::size_t i) { work(row / each_ + int(i), std::as_const(piece)); });
        if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
        const double done = (column + double(piece.state.width) * double(row + piece.state.height) / height) / width;
        run_.report("terrain", done_before + (done_after - done_before) * done);
      }
    return {};
  }

  // Calls visit(column of coarse cells) for all of a piece.
  template <class Visit>
  void for_coarse_columns(const Piece& piece, Visit&& visit) const {
    const int end = (piece.column + piece.state.width + each_ - 1) / each_;
    for (int u = piece.column / each_; u < end; ++u) visit(u);
  }

  // The cells of a coarse cell in a piece.
  struct Cells {
    int left, top, right, bottom;
  };
  [[nodiscard]] Cells cells_of(const Piece& piece, int u, int v) const {
    const int left = u * each_ - piece.column, top = v * each_ - piece.row;
    return {left, top, std::min(left + each_, piece.state.width), std::min(top + each_, piece.state.height)};
  }

  // Calls visit(x, y in the piece) for every measured cell of a coarse cell.
  template <class Visit>
  void for_measured(const Piece& piece, int u, int v, Visit&& visit) const {
    const Cells cells = cells_of(piece, u, v);
    for (int y = cells.top; y < cells.bottom; ++y)
      for (int x = cells.left; x < cells.right; ++x)
        if (piece.state.at(x, y) == std::uint8_t(CellState::kMeasured)) visit(x, y);
  }

  [[nodiscard]] bool enough(std::size_t cells) const { return double(cells) >= kLeastMeasured * each_ * each_; }

  Result<> find_low() {
    low_m_ = FloatImage(coarse_width_, coarse_height_, 1, kNaN);
    return over_coarse_rows(false, 0, 0.25, [&](int v, const Piece& piece) {
      std::vector<float> heights;
      for_coarse_columns(piece, [&](int u) {
        heights.clear();
        for_measured(piece, u, v, [&](int x, int y) { heights.push_back(piece.height_m.at(x, y)); });
        if (heights.empty() || !enough(heights.size())) return;
        const auto low = heights.begin() + std::ptrdiff_t(kLowQuantile * double(heights.size() - 1));
        std::nth_element(heights.begin(), low, heights.end());
        low_m_.at(u, v) = *low;
      });
    });
  }

  // Empties low heights that are not those of ground.
  Result<> keep_ground() {
    const Raster<std::uint8_t> ground = ground_cells(low_m_, cell_m_, options_.largest_object_m, run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    if (std::none_of(ground.data.begin(), ground.data.end(), [](std::uint8_t g) { return g != 0; })) return no_ground();
    for (std::size_t i = 0; i < ground.data.size(); ++i)
      if (!ground.data[i]) low_m_.data[i] = kNaN;
    return {};
  }

  // The ground as far as coarse cells tell it, and how much higher what belongs to it may be.
  Result<> find_ground() {
    COLLINEA_TRY(keep_ground());
    ground_ = GroundSurface(coarse_grid(), filled(std::exchange(low_m_, {}), cell_m_));
    return {};
  }

  [[nodiscard]] bool is_ground(const Piece& piece, int x, int y) const {
    return ground_.shows_ground((piece.column + x + 0.5) / each_, (piece.row + y + 0.5) / each_,
                                double(piece.height_m.at(x, y)), double(piece.sigma_m.at(x, y)));
  }

  static tl::unexpected<Error> no_ground() { return fail(Errc::kIllPosed, "nothing in the surface model is ground"); }

  // Means of the ground in coarse cells, continued where there is none.
  Result<> average() {
    mean_ = HeightLevel(0, 0, coarse_width_, coarse_height_, cell_m_, 0);
    auto done = over_coarse_rows(true, 0.3, 0.6, [&](int v, const Piece& piece) {
      for_coarse_columns(piece, [&](int u) { average_cell(piece, u, v); });
    });
    if (!done) return done;
    const auto usual = usual_sigma_m();
    if (!usual) return no_ground();
    usual_sigma_m_ = *usual;
    fill_all(mean_);
    covered_ = Raster<std::uint8_t>(coarse_width_, coarse_height_);
    COLLINEA_TRY(means_, RasterSpool::create(files_.height, coarse_width_, coarse_height_));
    means_->append(mean_.height_m);
    means_->append(mean_.sigma_m);
    mean_ = HeightLevel();
    give_back_freed_memory();
    return {};
  }

  // The means under a piece and one cell around, within the raster.
  struct Means {
    int column = 0, row = 0;  // of the upper-left coarse cell
    FloatImage height_m, sigma_m;
  };
  Result<Means> read_means(const Piece& piece) const {
    const int left = std::max(0, piece.column / each_ - 1), top = std::max(0, piece.row / each_ - 1);
    const int right = std::min(coarse_width_, (piece.column + piece.state.width - 1) / each_ + 2);
    const int bottom = std::min(coarse_height_, (piece.row + piece.state.height - 1) / each_ + 2);
    Means means{left, top, {}, {}};
    COLLINEA_TRY(means.height_m, means_->read(0, left, top, right - left, bottom - top));
    COLLINEA_TRY(means.sigma_m, means_->read(1, left, top, right - left, bottom - top));
    return means;
  }

  // Of the means before they are continued, the median: some that are known badly do not change it.
  [[nodiscard]] std::optional<double> usual_sigma_m() const {
    std::vector<float> sigmas;
    sigmas.reserve(mean_.weight.data.size());
    for (std::size_t i = 0; i < mean_.weight.data.size(); ++i)
      if (mean_.weight.data[i] > 0) sigmas.push_back(mean_.sigma_m.data[i]);
    if (sigmas.empty()) return std::nullopt;
    return double(median(sigmas));
  }

  void average_cell(const Piece& piece, int u, int v) {
    double sum = 0, squares = 0;
    std::size_t count = 0;
    for_measured(piece, u, v, [&](int x, int y) {
      if (!is_ground(piece, x, y)) return;
      sum += double(piece.height_m.at(x, y));
      squares += std::pow(double(piece.sigma_m.at(x, y)), 2);
      ++count;
    });
    if (count == 0 || !enough(count)) return;
    mean_.height_m.at(u, v) = float(sum / double(count));
    mean_.sigma_m.at(u, v) = float(std::sqrt(squares / double(count)));
    mean_.weight.at(u, v) = float(count);
  }

  // Ground stays as measured; all else takes the means around.
  void make_terrain(const Means& means, Piece& piece, int y) const {
    for (int x = 0; x < piece.state.width; ++x) {
      std::uint8_t& state = piece.state.at(x, y);
      if (state == std::uint8_t(CellState::kEmpty)) continue;
      if (state == std::uint8_t(CellState::kMeasured) && is_ground(piece, x, y)) continue;
      state = std::uint8_t(CellState::kInterpolated);
      const double u = (piece.column + x + 0.5) / each_ - means.column, v = (piece.row + y + 0.5) / each_ - means.row;
      piece.height_m.at(x, y) = bilinear(means.height_m, u, v);
      piece.sigma_m.at(x, y) = bilinear(means.sigma_m, u, v);
    }
  }

  void tally(const Piece& piece, const FloatImage& added_variance) {
    for (int y = 0; y < piece.state.height; ++y)
      for (int x = 0; x < piece.state.width; ++x) tally_cell(piece, x, y, double(added_variance.at(x, y)));
  }

  void tally_cell(const Piece& piece, int x, int y, double added_variance) {
    const auto state = CellState(piece.state.at(x, y));
    if (state == CellState::kEmpty) {
      ++summary_.empty_cells;
      return;
    }
    covered_.at((piece.column + x) / each_, (piece.row + y) / each_) = 1;
    const double height_m = piece.height_m.at(x, y);
    const bool first = summary_.ground_cells + summary_.interpolated_cells == 0;
    summary_.lowest_m = first ? height_m : std::min(summary_.lowest_m, height_m);
    summary_.highest_m = first ? height_m : std::max(summary_.highest_m, height_m);
    if (state == CellState::kInterpolated) {
      ++summary_.interpolated_cells;
      return;
    }
    ++summary_.ground_cells;
    const double squared = std::pow(double(piece.sigma_m.at(x, y)), 2);
    summary_.mean_sigma_relative_m += squared;
    summary_.mean_sigma_m += squared + added_variance;
  }

  // The standard deviations with what the orientation adds.
  [[nodiscard]] static FloatImage whole_sigmas(const Piece& piece, const FloatImage& added_variance) {
    FloatImage sigma_m = piece.sigma_m;
    for (std::size_t i = 0; i < sigma_m.data.size(); ++i)
      if (piece.state.data[i] != std::uint8_t(CellState::kEmpty))
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
    for (int row = 0; row < grid.height; row += kWrittenRows)
      for (int column = 0; column < grid.width; column += kWrittenColumns) {
        COLLINEA_TRY(Piece piece, read_heights(column, row, std::min(kWrittenColumns, grid.width - column),
                                               std::min(kWrittenRows, grid.height - row)));
        COLLINEA_TRY(read_sigmas(piece));
        COLLINEA_TRY(const FloatImage added_variance, read_added_variance(piece));
        COLLINEA_TRY(const Means means, read_means(piece));
        parallel_for(run_, std::size_t(piece.state.height), [&](std::size_t y) { make_terrain(means, piece, int(y)); });
        tally(piece, added_variance);
        auto written = height.write(column, row, piece.height_m)
                           .and_then([&] { return relative.write(column, row, piece.sigma_m); })
                           .and_then([&] { return sigma.write(column, row, whole_sigmas(piece, added_variance)); })
                           .and_then([&] { return state.write(column, row, piece.state); });
        if (!written) return written;
        const double done = row + piece.state.height * double(column + piece.state.width) / grid.width;
        run_.report("terrain", 0.6 + 0.4 * done / grid.height);
        if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");  // the piece may be made in part
      }
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
    heights.reserve(std::size_t(std::count(covered_.data.begin(), covered_.data.end(), 1)));
    for (std::size_t i = 0; i < covered_.data.size(); ++i)
      if (covered_.data[i]) heights.push_back(mean_.height_m.data[i]);
    if (heights.empty()) return 0;
    const double highest_m = double(quantile(heights, 1 - kStrayShare)),
                 relief_m = highest_m - double(quantile(heights, kStrayShare));
    const double least_m = std::max(relief_m / kContoursOverRelief, kContourSigmas * usual_sigma_m_);
    if (!(least_m > 0)) return 0;
    const double unit_m = std::pow(10.0, std::floor(std::log10(least_m)));
    for (const double times : {1, 2, 5})
      if (times * unit_m >= least_m) return times * unit_m;
    return 10 * unit_m;
  }

  // The means where the surface model has anything, NaN elsewhere, blurred by a Gaussian over their like.
  [[nodiscard]] FloatImage blurred_means() const {
    FloatImage blurred(coarse_width_, coarse_height_);
    parallel_for(run_, std::size_t((coarse_height_ + kBlurRows - 1) / kBlurRows), [&](std::size_t band) {
      const int first = int(band) * kBlurRows, end = std::min(first + kBlurRows, coarse_height_);
      blur_rows(first, end, blurred);
    });
    return blurred;
  }

  // Rows [first, end): sums of heights and of cells along rows, then along columns.
  void blur_rows(int first, int end, FloatImage& blurred) const {
    constexpr int kRadius = int(3 * kContourBlurCells);
    std::array<float, 2 * kRadius + 1> weights;
    for (int i = -kRadius; i <= kRadius; ++i)
      weights[std::size_t(i + kRadius)] = float(std::exp(-0.5 * i * i / (kContourBlurCells * kContourBlurCells)));
    const int top = std::max(0, first - kRadius), bottom = std::min(coarse_height_, end + kRadius),
              width = coarse_width_;
    FloatImage sums(width, bottom - top), counts(width, bottom - top);
    for (int y = top; y < bottom; ++y)
      for (int x = 0; x < width; ++x)
        for (int i = -kRadius; i <= kRadius; ++i) {
          const int from = std::clamp(x + i, 0, width - 1);
          const bool there = covered_.at(from, y) != 0;
          sums.at(x, y - top) += weights[std::size_t(i + kRadius)] * (there ? mean_.height_m.at(from, y) : 0);
          counts.at(x, y - top) += weights[std::size_t(i + kRadius)] * (there ? 1 : 0);
        }
    for (int y = first; y < end; ++y)
      for (int x = 0; x < width; ++x) {
        float sum = 0, count = 0;
        for (int i = -kRadius; i <= kRadius; ++i) {
          const int from = std::clamp(y + i, 0, coarse_height_ - 1) - top;
          sum += weights[std::size_t(i + kRadius)] * sums.at(x, from);
          count += weights[std::size_t(i + kRadius)] * counts.at(x, from);
        }
        blurred.at(x, y) = covered_.at(x, y) ? sum / count : kNaN;
      }
  }

  Result<> draw_contours() {
    std::filesystem::path drawing = files_.contours;
    drawing.replace_extension(".dxf");
    COLLINEA_TRY(mean_.height_m, means_->read(0, 0, 0, coarse_width_, coarse_height_));
    means_.reset();
    summary_.contour_m = contour_interval_m();
    if (summary_.contour_m == 0) {
      for (const auto& file : {files_.contours, drawing})
        COLLINEA_TRY(remove_file(file));
      return {};
    }
    FloatImage means = blurred_means();
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    mean_ = HeightLevel();
    covered_ = Raster<std::uint8_t>();
    COLLINEA_TRY(summary_.contours, write_contours(std::move(means), coarse_grid(), summary_.contour_m,
                                                   kShortestContour * cell_m_, files_.contours, drawing));
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
  double cell_m_ = 0;                 // of the coarse grid
  FloatImage low_m_;                  // low heights of coarse cells
  GroundSurface ground_;              // that they tell, everywhere
  HeightLevel mean_;                  // of the ground
  std::optional<RasterSpool> means_;  // its heights and sigmas, once they are continued
  double usual_sigma_m_ = 0;          // of these, relative
  Raster<std::uint8_t> covered_;      // by the surface model
};

}  // namespace

double GroundSurface::tolerance_m(int u, int v) const {
  const auto at = [&](int x, int y) {
    return double(low_m_.at(std::clamp(x, 0, low_m_.width - 1), std::clamp(y, 0, low_m_.height - 1)));
  };
  const double east_m = at(u + 1, v) - at(u - 1, v), north_m = at(u, v + 1) - at(u, v - 1);
  return kToleranceCells * grid_.cell_m + std::sqrt(east_m * east_m + north_m * north_m) / 2;
}

bool GroundSurface::shows_ground(double column, double row, double height_m, double sigma_m) const {
  const int u = std::clamp(int(column), 0, low_m_.width - 1), v = std::clamp(int(row), 0, low_m_.height - 1);
  return std::abs(height_m - double(bilinear(low_m_, column, row))) <=
         tolerance_m(u, v) + std::min(3 * sigma_m, grid_.cell_m);
}

bool GroundSurface::shows_ground(const Eigen::Vector3d& on_map, double sigma_m) const {
  const double column = grid_.column_of(on_map.x()), row = grid_.row_of(on_map.y());
  if (!(column >= 0 && row >= 0 && column < grid_.width && row < grid_.height)) return false;
  return shows_ground(column, row, on_map.z(), sigma_m);
}

Result<Dtm> build_dtm(const DsmFiles& dsm, const DtmFiles& files, const DtmOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  return Terrain(dsm, files, options, run).make();
}

}  // namespace collinea
