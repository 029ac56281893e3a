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
#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/raster_spool.h"
#include "collinea/surface/internal/ground_filter.h"
#include "collinea/surface/internal/pull_push.h"
#include "collinea/surface/internal/surface_pieces.h"
#include "collinea/surface/internal/terrain_contours.h"

namespace collinea {
namespace {

constexpr double kCoarseCells = 80;   // over the largest object
constexpr double kMostCoarse = 64e6;  // cells: 256 MB a raster
constexpr int kSquare = SurfacePieces::kSquare;
constexpr int kWrittenColumns = 1024, kWrittenRows = kSquare;
static_assert(kWrittenColumns % kSquare == 0);
constexpr double kLowQuantile = 0.1;     // of the heights in a coarse cell: below leaves, above wrong matches
constexpr double kToleranceCells = 0.5;  // of heights over the ground, in coarse cells

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// The standard deviations with what the orientation adds.
FloatImage whole_sigmas(const SurfacePiece& piece, const FloatImage& added_variance) {
  FloatImage sigma_m = piece.sigma_m;
  for (std::size_t i = 0; i < sigma_m.data.size(); ++i)
    if (piece.state.data[i] != std::uint8_t(CellState::kEmpty))
      sigma_m.data[i] = std::sqrt(sigma_m.data[i] * sigma_m.data[i] + added_variance.data[i]);
  return sigma_m;
}

tl::unexpected<Error> no_ground() { return fail(Errc::kIllPosed, "nothing in the surface model is ground"); }

class Terrain {
 public:
  Terrain(SurfacePieces pieces, const DtmFiles& files, const DtmOptions& options, const GroundByHand& by_hand,
          const Run& run)
      : pieces_(std::move(pieces)), files_(files), options_(options), by_hand_(by_hand), run_(run) {}

  Result<Dtm> make() {
    summary_.grid = pieces_.grid();
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
    pieces_.set_coarse(each_);
  }

  [[nodiscard]] MapGrid coarse_grid() const {
    MapGrid grid = summary_.grid;
    grid.cell_m = cell_m_;
    grid.width = coarse_width_, grid.height = coarse_height_;
    return grid;
  }

  Result<> find_low() {
    low_m_ = FloatImage(coarse_width_, coarse_height_, 1, kNaN);
    given_ = Raster<std::uint8_t>(coarse_width_, coarse_height_);
    return pieces_.over_coarse_rows(run_, false, 0, 0.25, [&](int v, const SurfacePiece& piece) {
      std::vector<float> heights;
      pieces_.for_coarse_columns(piece, [&](int u) {
        heights.clear();
        std::size_t of_ground = 0;  // as people say
        pieces_.for_measured(piece, u, v, [&](int x, int y) {
          const auto said = said_of(piece, x, y);
          if (said != false) heights.push_back(piece.height_m.at(x, y));
          of_ground += said == true;
        });
        if (2 * of_ground > heights.size()) given_.at(u, v) = 1;
        if (heights.empty() || !pieces_.enough(heights.size())) return;
        const auto low = heights.begin() + std::ptrdiff_t(kLowQuantile * double(heights.size() - 1));
        std::nth_element(heights.begin(), low, heights.end());
        low_m_.at(u, v) = *low;
      });
    });
  }

  // Empties low heights that are not those of ground.
  Result<> keep_ground() {
    Raster<std::uint8_t> ground = ground_cells(low_m_, cell_m_, options_.largest_object_m, run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    for (std::size_t i = 0; i < ground.data.size(); ++i) ground.data[i] |= given_.data[i];
    given_ = {};
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

  // What people say of a cell.
  [[nodiscard]] std::optional<bool> said_of(const SurfacePiece& piece, int x, int y) const {
    if (!by_hand_) return std::nullopt;
    const MapGrid& grid = pieces_.grid();
    return by_hand_(
        {grid.east_of(piece.column + x + 0.5), grid.north_of(piece.row + y + 0.5), double(piece.height_m.at(x, y))});
  }

  [[nodiscard]] bool is_ground(const SurfacePiece& piece, int x, int y) const {
    if (const auto said = said_of(piece, x, y)) return *said;
    return ground_.shows_ground((piece.column + x + 0.5) / each_, (piece.row + y + 0.5) / each_,
                                double(piece.height_m.at(x, y)), double(piece.sigma_m.at(x, y)));
  }

  // Means of the ground in coarse cells, continued where there is none.
  Result<> average() {
    mean_ = HeightLevel(0, 0, coarse_width_, coarse_height_, cell_m_, 0);
    auto done = pieces_.over_coarse_rows(run_, true, 0.3, 0.6, [&](int v, const SurfacePiece& piece) {
      pieces_.for_coarse_columns(piece, [&](int u) { average_cell(piece, u, v); });
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
  Result<Means> read_means(const SurfacePiece& piece) const {
    const int left = std::max(0, piece.column / each_ - 1), top = std::max(0, piece.row / each_ - 1);
    const int right = std::min(coarse_width_, (piece.column + piece.state.width - 1) / each_ + 2);
    const int bottom = std::min(coarse_height_, (piece.row + piece.state.height - 1) / each_ + 2);
    Means means{left, top, {}, {}};
    COLLINEA_TRY(means.height_m, means_->read(0, left, top, right - left, bottom - top));
    COLLINEA_TRY(means.sigma_m, means_->read(1, left, top, right - left, bottom - top));
    return means;
  }

  // The median of the means before they are continued: some that are known badly do not change it.
  [[nodiscard]] std::optional<double> usual_sigma_m() const {
    std::vector<float> sigmas;
    sigmas.reserve(mean_.weight.data.size());
    for (std::size_t i = 0; i < mean_.weight.data.size(); ++i)
      if (mean_.weight.data[i] > 0) sigmas.push_back(mean_.sigma_m.data[i]);
    if (sigmas.empty()) return std::nullopt;
    return double(median(sigmas));
  }

  void average_cell(const SurfacePiece& piece, int u, int v) {
    double sum = 0, squares = 0;
    std::size_t count = 0;
    pieces_.for_measured(piece, u, v, [&](int x, int y) {
      if (!is_ground(piece, x, y)) return;
      sum += double(piece.height_m.at(x, y));
      squares += std::pow(double(piece.sigma_m.at(x, y)), 2);
      ++count;
    });
    if (count == 0 || !pieces_.enough(count)) return;
    mean_.height_m.at(u, v) = float(sum / double(count));
    mean_.sigma_m.at(u, v) = float(std::sqrt(squares / double(count)));
    mean_.weight.at(u, v) = float(count);
  }

  // Ground stays as measured; all else takes the means around.
  void make_terrain(const Means& means, SurfacePiece& piece, int y) const {
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

  void tally(const SurfacePiece& piece, const FloatImage& added_variance) {
    for (int y = 0; y < piece.state.height; ++y)
      for (int x = 0; x < piece.state.width; ++x) tally_cell(piece, x, y, double(added_variance.at(x, y)));
  }

  void tally_cell(const SurfacePiece& piece, int x, int y, double added_variance) {
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

  Result<> write() {
    const MapGrid& grid = summary_.grid;
    GeoTiffWriter<float>::Options of_height, of_sigma;
    of_height.nodata = of_sigma.nodata = double(kNoHeight);
    of_height.description = band::kTerrainHeight;
    of_sigma.description = band::kHeightSigma;
    GeoTiffWriter<float>::Options of_relative = of_sigma;
    of_relative.description = band::kRelativeHeightSigma;
    GeoTiffWriter<std::uint8_t>::Options of_state;
    of_state.description = band::kTerrainState;
    COLLINEA_TRY(auto height, GeoTiffWriter<float>::create(files_.height, grid, 1, of_height));
    COLLINEA_TRY(auto sigma, GeoTiffWriter<float>::create(files_.sigma, grid, 1, of_sigma));
    COLLINEA_TRY(auto relative, GeoTiffWriter<float>::create(files_.sigma_relative, grid, 1, of_relative));
    COLLINEA_TRY(auto state, GeoTiffWriter<std::uint8_t>::create(files_.state, grid, 1, of_state));
    const UnitList list{"terrain", tiles_over(grid.width, grid.height, kWrittenColumns, kWrittenRows), 0.6, 1};
    const auto write_tile = [&](const Unit& unit) -> Result<> {
      const int column = int(unit.first) * kWrittenColumns, row = int(unit.second) * kWrittenRows;
      COLLINEA_TRY(SurfacePiece piece, pieces_.read_heights(column, row, std::min(kWrittenColumns, grid.width - column),
                                                            std::min(kWrittenRows, grid.height - row)));
      COLLINEA_TRY(pieces_.read_sigmas(piece));
      COLLINEA_TRY(const FloatImage added_variance, pieces_.read_added_variance(piece));
      COLLINEA_TRY(const Means means, read_means(piece));
      parallel_for(run_, std::size_t(piece.state.height), [&](std::size_t y) { make_terrain(means, piece, int(y)); });
      tally(piece, added_variance);
      return height.write(column, row, piece.height_m)
          .and_then([&] { return relative.write(column, row, piece.sigma_m); })
          .and_then([&] { return sigma.write(column, row, whole_sigmas(piece, added_variance)); })
          .and_then([&] { return state.write(column, row, piece.state); });
    };
    COLLINEA_TRY(run_units_one_by_one(run_, list, write_tile));  // stopped: the last tile may be made in part
    if (summary_.ground_cells > 0)
      for (double* mean : {&summary_.mean_sigma_m, &summary_.mean_sigma_relative_m})
        *mean = std::sqrt(*mean / double(summary_.ground_cells));
    // The height comes last: where it is, all rasters are.
    return sigma.finish()
        .and_then([&] { return relative.finish(); })
        .and_then([&] { return state.finish(); })
        .and_then([&] { return height.finish(); });
  }

  Result<> draw_contours() {
    std::filesystem::path drawing = files_.contours;
    drawing.replace_extension(".dxf");
    CoarseTerrain terrain{coarse_grid(), {}, std::exchange(covered_, {}), usual_sigma_m_};
    COLLINEA_TRY(terrain.height_m, means_->read(0, 0, 0, coarse_width_, coarse_height_));
    means_.reset();
    summary_.contour_m = options_.contour_m ? *options_.contour_m : contour_interval_m(terrain);
    if (summary_.contour_m == 0) {
      for (const auto& file : {files_.contours, drawing}) COLLINEA_TRY(remove_file(file));
      return {};
    }
    COLLINEA_TRY(summary_.contours,
                 draw_terrain_contours(std::move(terrain), summary_.contour_m, files_.contours, drawing, run_));
    return {};
  }

  SurfacePieces pieces_;
  const DtmFiles& files_;
  const DtmOptions& options_;
  const GroundByHand& by_hand_;
  const Run& run_;
  DtmSummary summary_;
  int each_ = 1;  // cells of the surface model along a coarse one
  int coarse_width_ = 0, coarse_height_ = 0;
  double cell_m_ = 0;                 // of the coarse grid
  FloatImage low_m_;                  // low heights of coarse cells
  Raster<std::uint8_t> given_;        // whether people say that they are of the ground
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

Result<Dtm> build_dtm(const DsmFiles& dsm, const DtmFiles& files, const DtmOptions& options, const Run& run,
                      const GroundByHand& by_hand) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(SurfacePieces pieces, SurfacePieces::open(dsm));
  return Terrain(std::move(pieces), files, options, by_hand, run).make();
}

}  // namespace collinea
