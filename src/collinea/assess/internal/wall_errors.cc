// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/wall_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kWall_m = 2;
constexpr double kSteepest = 1.5;  // rise per run of what is no step
constexpr int kReach = 10;         // [cells]
constexpr int kAround = 3;         // cells on either side that tell the direction of a wall
constexpr int kMargin = kReach + kAround;
constexpr int kStripRows = 256;
constexpr double kNear = 2;  // [pixels of the ground]

// Rows of the model with a margin above and below, and the true height at the middle of each cell.
struct Strip {
  FloatImage model_m, truth_m;
};

Result<FloatImage> true_heights(const HeightField& model, const HeightField& truth, int row, int rows) {
  const auto column_of = [&](int x) { return int(std::floor(truth.grid.column_of(model.grid.east_of(x + 0.5)))); };
  const auto row_of = [&](int y) { return int(std::floor(truth.grid.row_of(model.grid.north_of(y + 0.5)))); };
  FloatImage result(model.grid.width, rows, 1, std::numeric_limits<float>::quiet_NaN());
  const int top = std::max(0, row_of(row)), bottom = std::min(truth.grid.height, row_of(row + rows - 1) + 1);
  if (bottom <= top) return result;
  COLLINEA_TRY(const FloatImage heights, truth.read(0, top, truth.grid.width, bottom - top));
  for (int y = 0; y < rows; ++y) {
    const int v = row_of(row + y) - top;
    if (v < 0 || v >= heights.height) continue;
    for (int x = 0; x < result.width; ++x)
      if (const int u = column_of(x); u >= 0 && u < heights.width) result.at(x, y) = heights.at(u, v);
  }
  return result;
}

// The samples of one strip, along rows (dx = 1, dy = 0) or columns.
class Crossing {
 public:
  Crossing(const Strip& strip, double cell_m, int dx, int dy) : strip_(strip), cell_m_(cell_m), dx_(dx), dy_(dy) {}

  // The error [m] of the wall between a cell and the next one; nothing when there is none to be measured.
  [[nodiscard]] std::optional<double> error(int x, int y) const {
    if (!is_wall(x, y)) return std::nullopt;
    const double across = share_across(x, y);
    if (!(across >= std::sqrt(0.5))) return std::nullopt;  // seen better along the other axis, or nothing known around
    const float middle = (truth(x, y, 0) + truth(x, y, 1)) / 2;
    int above = 0, truly_above = 0;
    for (int k = 1 - kReach; k <= kReach; ++k) {
      const float z = strip_.model_m.at(x + k * dx_, y + k * dy_);
      if (std::isnan(z)) return std::nullopt;
      above += z > middle;
      truly_above += truth(x, y, k) > middle;
    }
    return (above - truly_above) * cell_m_ * across;
  }

 private:
  [[nodiscard]] float truth(int x, int y, int k) const { return strip_.truth_m.at(x + k * dx_, y + k * dy_); }

  [[nodiscard]] bool is_wall(int x, int y) const {
    if (!(std::abs(truth(x, y, 1) - truth(x, y, 0)) >= float(kWall_m))) return false;
    for (int k = 1 - kReach; k < kReach; ++k)
      if (k != 0 && !(std::abs(truth(x, y, k + 1) - truth(x, y, k)) <= float(kSteepest * cell_m_))) return false;
    return true;
  }

  // The cosine between the wall's normal and the axis, by the steps around.
  [[nodiscard]] double share_across(int x, int y) const {
    double along_x = 0, along_y = 0;
    for (int j = -kAround; j < kAround; ++j)
      for (int i = -kAround; i < kAround; ++i) {
        const float here = strip_.truth_m.at(x + i, y + j);
        along_x += double(strip_.truth_m.at(x + i + 1, y + j) - here);
        along_y += double(strip_.truth_m.at(x + i, y + j + 1) - here);
      }
    return std::abs(dx_ ? along_x : along_y) / std::hypot(along_x, along_y);
  }

  const Strip& strip_;
  double cell_m_;
  int dx_, dy_;
};

}  // namespace

Result<WallErrors> wall_errors(const HeightField& model, const HeightField& truth, double gsd_m, const Run& run) {
  const MapGrid& grid = model.grid;
  std::vector<double> errors_m;
  for (int row = kMargin; row + kMargin < grid.height; row += kStripRows) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const int rows = std::min(kStripRows, grid.height - kMargin - row);
    Strip strip;
    COLLINEA_TRY(strip.model_m, model.read(0, row - kMargin, grid.width, rows + 2 * kMargin));
    COLLINEA_TRY(strip.truth_m, true_heights(model, truth, row - kMargin, rows + 2 * kMargin));
    const Crossing rightwards(strip, grid.cell_m, 1, 0), downwards(strip, grid.cell_m, 0, 1);
    for (int y = kMargin; y < kMargin + rows; ++y)
      for (int x = kMargin; x + kMargin < grid.width; ++x)
        for (const Crossing* crossing : {&rightwards, &downwards})
          if (const auto error = crossing->error(x, y)) errors_m.push_back(*error);
  }
  WallErrors result;
  result.samples = errors_m.size();
  if (errors_m.empty()) return result;
  double sum = 0, squares = 0;
  std::size_t near = 0;
  for (double& error : errors_m) {
    sum += error, squares += error * error;
    error = std::abs(error);
    near += error <= kNear * gsd_m;
  }
  const auto n = double(errors_m.size());
  result.mean_m = sum / n;
  result.rms_m = std::sqrt(squares / n);
  result.median_m = median(errors_m);
  result.share_within = double(near) / n;
  return result;
}

}  // namespace collinea
