// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/surface_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collinea/assess/internal/levelled.h"
#include "collinea/assess/internal/rough_cells.h"
#include "collinea/base/parallel.h"
#include "collinea/math/median.h"
#include "collinea/ortho/occluders.h"
#include "collinea/ortho/world_lattice.h"
#include "collinea/surface/surface_filter.h"

namespace collinea {
namespace {

constexpr int kStripRows = 256;
constexpr int kFarthest = 512;         // what may hide a point, and the margin of steps [cells of the truth]
constexpr double kSteepestRoof = 1.5;  // rise per run; what is steeper is a wall
constexpr double kRoof_m = 1;          // above the ground
constexpr int kStepMargin = 3;         // [cells of the model]
constexpr int kSeenStride = 4;         // every so many cells, both ways, it is looked at who sees them
constexpr std::size_t kEnough = 3;     // images
constexpr std::size_t kSome = 16;      // every so many errors, one is kept to be judged less the plane of all kept

// The rows of the truth under some rows of the model, with a margin.
struct TrueStrip {
  int first_row = 0;
  FloatImage heights_m;
  FloatImage terrain_m;         // empty: not known
  Raster<std::uint8_t> rough;   // steep, or near a step
  Raster<std::uint8_t> broken;  // a wall, or near one
};

class Assessor {
 public:
  Assessor(const HeightField& model, const StateReader& state, const HeightField& truth, std::span<const View> views,
           const LocalFrame* frame, const Run& run, const HeightField* terrain)
      : model_(model), state_(state), truth_(truth), views_(views), frame_(frame), run_(run), terrain_(terrain) {}

  Result<SurfaceErrors> all();

 private:
  Result<> add_strip(int row, int rows);
  void add_cell(const FloatImage& heights, const FloatImage& sigmas, const Raster<std::uint8_t>& states,
                const TrueStrip& strip, int x, int y, int row);
  void count_seen(const FloatImage& heights, const TrueStrip& strip, int row);
  [[nodiscard]] bool seen_by_enough(const Occluders& around, double x, double y, float z,
                                    const Eigen::Vector3d& world) const;
  [[nodiscard]] double truth_x(double column) const { return truth_.grid.column_of(model_.grid.east_of(column)); }
  [[nodiscard]] double truth_y(double row) const { return truth_.grid.row_of(model_.grid.north_of(row)); }

  const HeightField& model_;
  const StateReader& state_;
  const HeightField& truth_;
  std::span<const View> views_;
  const LocalFrame* frame_;
  const Run& run_;
  const HeightField* terrain_;
  std::vector<float> overall_, smooth_measured_, smooth_interpolated_, roofs_;
  std::size_t bounds_ = 0, within_ = 0, roof_bounds_ = 0, roofs_within_ = 0, found_ = 0, measured_ = 0, seen_ = 0,
              seen_found_ = 0;
  std::vector<LocatedError> some_bounded_;
};

// Heights that are no more than the nearest on a step, and exact on smooth ground.
float true_height(const FloatImage& heights_m, double x, double y, bool rough) {
  const int column = int(std::floor(x)), row = int(std::floor(y));
  if (column < 0 || row < 0 || column >= heights_m.width || row >= heights_m.height)
    return std::numeric_limits<float>::quiet_NaN();
  return rough ? heights_m.at(column, row) : bilinear(heights_m, x, y);
}

void Assessor::add_cell(const FloatImage& heights, const FloatImage& sigmas, const Raster<std::uint8_t>& states,
                        const TrueStrip& strip, int x, int y, int row) {
  const double u = truth_x(x + 0.5), v = truth_y(row + y + 0.5) - strip.first_row;
  if (!(u >= 0 && v >= 0 && u < strip.heights_m.width && v < strip.heights_m.height)) return;
  const bool rough = strip.rough.at(int(u), int(v)) != 0;
  const float truth = true_height(strip.heights_m, u, v, rough), z = heights.at(x, y);
  if (std::isnan(truth) || std::isnan(z)) return;
  ++found_;
  const bool measured = states.empty() || states.at(x, y) == std::uint8_t(CellState::kMeasured);
  measured_ += measured;
  overall_.push_back(z - truth);
  if (!rough) (measured ? smooth_measured_ : smooth_interpolated_).push_back(z - truth);
  if (!measured) return;
  bool counts = !rough, roof = false;
  float expected = truth;
  if (!strip.terrain_m.empty() && !strip.broken.at(int(u), int(v))) {
    expected = bilinear(strip.heights_m, u, v);
    if (expected - strip.terrain_m.at(int(u), int(v)) > kRoof_m) {
      roofs_.push_back(z - expected);
      counts = roof = true;
    }
  }
  if (!counts || sigmas.empty() || !(sigmas.at(x, y) > 0)) return;
  const bool within = std::abs(z - expected) <= kBoundSigmas * double(sigmas.at(x, y));
  if (bounds_++ % kSome == 0)
    some_bounded_.push_back(
        {model_.grid.east_of(x + 0.5), model_.grid.north_of(row + y + 0.5), z - expected, sigmas.at(x, y)});
  within_ += within;
  roof_bounds_ += roof;
  roofs_within_ += roof && within;
}

bool Assessor::seen_by_enough(const Occluders& around, double x, double y, float z,
                              const Eigen::Vector3d& world) const {
  std::size_t count = 0;
  for (const View& view : views_) {
    const auto pixel = pixel_of(view, world);
    if (!pixel || !inside(view.camera, *pixel)) continue;
    const double camera_x = truth_.grid.column_of(view.centre_in_map.x());
    const double camera_y = truth_.grid.row_of(view.centre_in_map.y()) - around.row();
    count += !around.hide(x, y, double(z), camera_x, camera_y, view.centre_in_map.z());
    if (count >= kEnough) return true;
  }
  return false;
}

void Assessor::count_seen(const FloatImage& heights, const TrueStrip& strip, int row) {
  const Occluders around(strip.heights_m, 0, strip.first_row, truth_.grid.cell_m);
  const WorldLattice lattice(frame_, model_.grid, 0, row, heights.width, heights.height, 0, 1000);
  const int lines = (heights.height + kSeenStride - 1) / kSeenStride;
  std::vector<std::size_t> seen(std::size_t(lines), 0), found = seen;
  parallel_for(run_, std::size_t(lines), [&](std::size_t line) {
    const int y = int(line) * kSeenStride;
    for (int x = 0; x < heights.width; x += kSeenStride) {
      const double u = truth_x(x + 0.5), v = truth_y(row + y + 0.5) - strip.first_row;
      const float z = true_height(strip.heights_m, u, v, true);
      if (std::isnan(z) || !seen_by_enough(around, u, v, z, lattice.at(x + 0.5, y + 0.5, double(z)))) continue;
      ++seen[line];
      found[line] += !std::isnan(heights.at(x, y));
    }
  });
  for (std::size_t line = 0; line < seen.size(); ++line) seen_ += seen[line], seen_found_ += found[line];
}

Result<> Assessor::add_strip(int row, int rows) {
  const int top = std::max(0, int(std::floor(truth_y(row))) - kFarthest);
  const int bottom = std::min(truth_.grid.height, int(std::ceil(truth_y(row + rows))) + kFarthest);
  if (bottom <= top) return {};
  TrueStrip strip;
  strip.first_row = top;
  COLLINEA_TRY(strip.heights_m, truth_.read(0, top, truth_.grid.width, bottom - top));
  const int margin = int(std::ceil(kStepMargin * model_.grid.cell_m / truth_.grid.cell_m));
  strip.rough = rough_cells(strip.heights_m, truth_.grid.cell_m, margin, kSteepestSmooth);
  if (terrain_) {
    COLLINEA_TRY(strip.terrain_m, terrain_->read(0, top, truth_.grid.width, bottom - top));
    strip.broken = rough_cells(strip.heights_m, truth_.grid.cell_m, margin, kSteepestRoof);
  }
  COLLINEA_TRY(const FloatImage heights, model_.read(0, row, model_.grid.width, rows));
  FloatImage sigmas;
  if (model_.read_sigma) {
    COLLINEA_TRY(sigmas, model_.read_sigma(0, row, model_.grid.width, rows));
  }
  Raster<std::uint8_t> states;
  if (state_) {
    COLLINEA_TRY(states, state_(0, row, model_.grid.width, rows));
  }
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < heights.width; ++x) add_cell(heights, sigmas, states, strip, x, y, row);
  if (!views_.empty()) count_seen(heights, strip, row);
  return {};
}

Result<SurfaceErrors> Assessor::all() {
  for (int row = 0; row < model_.grid.height; row += kStripRows) {
    if (run_.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(add_strip(row, std::min(kStripRows, model_.grid.height - row)));
  }
  std::size_t true_cells = 0;  // of the true surface, in cells of the truth
  for (int row = 0; row < truth_.grid.height; row += kStripRows) {
    COLLINEA_TRY(const FloatImage heights,
                 truth_.read(0, row, truth_.grid.width, std::min(kStripRows, truth_.grid.height - row)));
    for (const float z : heights.data) true_cells += !std::isnan(z);
  }
  if (overall_.empty()) return fail(Errc::kBadInput, "the surface model and the true one do not overlap: another CRS?");
  SurfaceErrors errors;
  errors.cell_m = model_.grid.cell_m;
  errors.overall = height_errors(overall_, 3 * errors.cell_m);
  std::vector<float> smooth = smooth_measured_;
  smooth.insert(smooth.end(), smooth_interpolated_.begin(), smooth_interpolated_.end());
  errors.smooth_ground = height_errors(smooth, 3 * errors.cell_m);
  if (state_) {
    errors.smooth_measured = height_errors(smooth_measured_, 3 * errors.cell_m);
    errors.smooth_interpolated = height_errors(smooth_interpolated_, 3 * errors.cell_m);
  }
  errors.roofs = height_errors(roofs_, 3 * errors.cell_m);
  errors.bounds = bounds_;
  errors.within_bounds = bounds_ > 0 ? double(within_) / double(bounds_) : 0;
  errors.roofs_within_bounds = roof_bounds_ > 0 ? double(roofs_within_) / double(roof_bounds_) : 0;
  if (take_off_plane(some_bounded_)) {
    const auto within = std::count_if(some_bounded_.begin(), some_bounded_.end(), [](const LocatedError& one) {
      return std::abs(one.error_m) <= kBoundSigmas * double(one.sigma_m);
    });
    errors.levelled_within_bounds = double(within) / double(some_bounded_.size());
  }
  const double cells = double(true_cells) * std::pow(truth_.grid.cell_m / model_.grid.cell_m, 2);
  errors.completeness = std::min(1.0, double(found_) / cells);
  errors.completeness_measured = std::min(1.0, double(measured_) / cells);
  errors.cells_seen = seen_;
  errors.completeness_seen = seen_ > 0 ? double(seen_found_) / double(seen_) : 0;
  return errors;
}

}  // namespace

Result<TerrainErrors> terrain_errors(const HeightField& model, const StateReader& state, const HeightField& terrain,
                                     const HeightField& surface, const Run& run) {
  constexpr double kObject_m = 1;
  const MapGrid &grid = model.grid, &truth = terrain.grid;
  const auto truth_x = [&](double column) { return truth.column_of(grid.east_of(column)); };
  const auto truth_y = [&](double row) { return truth.row_of(grid.north_of(row)); };
  std::vector<float> measured, interpolated;
  TerrainErrors errors;
  std::size_t removed = 0;
  for (int row = 0; row < grid.height; row += kStripRows) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const int rows = std::min(kStripRows, grid.height - row);
    const int top = std::max(0, int(std::floor(truth_y(row))) - 1);
    const int bottom = std::min(truth.height, int(std::ceil(truth_y(row + rows))) + 1);
    if (bottom <= top) continue;
    COLLINEA_TRY(const FloatImage heights, model.read(0, row, grid.width, rows));
    COLLINEA_TRY(const auto states, state(0, row, grid.width, rows));
    COLLINEA_TRY(const FloatImage ground, terrain.read(0, top, truth.width, bottom - top));
    COLLINEA_TRY(const FloatImage highest, surface.read(0, top, truth.width, bottom - top));
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < grid.width; ++x) {
        const double u = truth_x(x + 0.5), v = truth_y(row + y + 0.5) - top;
        const float z = heights.at(x, y), at_top = true_height(highest, u, v, true);
        if (std::isnan(z) || std::isnan(at_top)) continue;
        const float at_ground = bilinear(ground, u, v);
        if (std::isnan(at_ground)) continue;
        const bool seen = states.at(x, y) == std::uint8_t(CellState::kMeasured);
        (seen ? measured : interpolated).push_back(z - at_ground);
        if (at_top - at_ground <= kObject_m) continue;
        ++errors.object_cells;
        removed += z - at_ground < (at_top - at_ground) / 2;
      }
  }
  std::vector<float> all = measured;
  all.insert(all.end(), interpolated.begin(), interpolated.end());
  if (all.empty()) return fail(Errc::kBadInput, "the terrain model and the true one do not overlap: another CRS?");
  errors.cell_m = grid.cell_m;
  errors.overall = height_errors(all, 3 * grid.cell_m);
  errors.measured = height_errors(measured, 3 * grid.cell_m);
  errors.interpolated = height_errors(interpolated, 3 * grid.cell_m);
  errors.share_removed = errors.object_cells > 0 ? double(removed) / double(errors.object_cells) : 1;
  return errors;
}

HeightErrors height_errors(std::vector<float>& differences_m, double gross_m) {
  HeightErrors errors;
  errors.cells = differences_m.size();
  if (differences_m.empty()) return errors;
  double sum = 0, squares = 0;
  std::size_t gross = 0;
  for (const float d : differences_m) {
    sum += double(d), squares += double(d) * double(d);
    gross += std::abs(double(d)) > gross_m;
  }
  const auto n = double(differences_m.size());
  errors.mean_m = sum / n;
  errors.rmse_m = std::sqrt(squares / n);
  errors.share_gross = double(gross) / n;
  const float middle = median(differences_m);
  errors.median_m = double(middle);
  for (float& d : differences_m) d = std::abs(d - middle);
  errors.nmad_m = 1.4826 * double(median(differences_m));
  return errors;
}

Result<SurfaceErrors> surface_errors(const HeightField& model, const StateReader& state, const HeightField& truth,
                                     std::span<const View> views, const LocalFrame* frame, const Run& run,
                                     const HeightField* terrain) {
  return Assessor(model, state, truth, views, frame, run, terrain).all();
}

}  // namespace collinea
