// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr int kColumns = 12;       // of the grid; its cells are about square
constexpr int kLeastInCell = 10;   // fewer say nothing
constexpr double kLimit = 13.816;  // chi-squared with two degrees of freedom, 0.1 %
constexpr double kGross = 4;       // sigmas: gross errors are no system

struct Cell {
  double n = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double chi2 = 0;  // of the mean, two degrees of freedom
  [[nodiscard]] bool counts() const { return n >= kLeastInCell; }
};

// The mean residuals of one camera over its format.
struct Pattern {
  CameraId camera;
  int rows = 1;
  std::vector<Cell> cells;
  long significant = 0, counted = 0;
  double rms_px = 0;  // of the means, less what chance gives them
};

Pattern pattern_of(const AdjustmentReport& report, CameraId id) {
  const Camera& camera = report.block.cameras.at(id);
  Pattern pattern;
  pattern.camera = id;
  pattern.rows = std::max(1, static_cast<int>(std::lround(double(kColumns) * camera.height_px / camera.width_px)));
  pattern.cells.resize(static_cast<std::size_t>(kColumns * pattern.rows));
  std::vector<double> variance(pattern.cells.size(), 0);
  const double sigma0 = sigma_scale(report.adjusted);
  for (std::size_t i = 0; i < report.adjusted.observations.size(); ++i) {
    const Observation& seen = report.block.observations[report.adjusted.observations[i]];
    const Eigen::Vector2d& residual = report.adjusted.residuals_px[i];
    if (report.block.common_camera(report.block.images.at(seen.image).camera) != id || !residual.allFinite()) continue;
    if (residual.norm() > kGross * sigma0 * seen.sigma_px) continue;
    const int column = std::clamp(static_cast<int>(seen.pixel.x() * kColumns / camera.width_px), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(seen.pixel.y() * pattern.rows / camera.height_px), 0, pattern.rows - 1);
    const auto at = static_cast<std::size_t>(row * kColumns + column);
    pattern.cells[at].n += 1;
    pattern.cells[at].mean += residual;
    variance[at] += residual.squaredNorm() / 2;
  }
  double squares = 0;
  for (std::size_t i = 0; i < pattern.cells.size(); ++i) {
    Cell& cell = pattern.cells[i];
    if (cell.n > 0) cell.mean /= cell.n;
    if (!cell.counts()) continue;
    const double spread = std::max(variance[i] / cell.n - cell.mean.squaredNorm() / 2, 1e-300);
    cell.chi2 = cell.n * cell.mean.squaredNorm() / spread;
    squares += cell.mean.squaredNorm() - 2 * spread / cell.n;
    ++pattern.counted;
    pattern.significant += cell.chi2 > kLimit;
  }
  if (pattern.counted > 0) pattern.rms_px = std::sqrt(std::max(0.0, squares / double(pattern.counted)));
  return pattern;
}

std::vector<Pattern> patterns_of(const AdjustmentReport& report) {
  std::vector<Pattern> patterns;
  for (const auto& [id, camera] : report.block.cameras) {
    if (camera.width_px <= 0 || camera.height_px <= 0 || report.block.common_camera(id) != id) continue;
    patterns.push_back(pattern_of(report, id));
    if (patterns.back().counted == 0) patterns.pop_back();
  }
  return patterns;
}

// How far the residuals of tie points, in their own standard deviations, are from normal ones.
struct Normality {
  double n = 0, beyond_2 = 0, beyond_3 = 0, kurtosis = 0;  // shares; of normal residuals 4.55 %, 0.27 %, 3
};

Normality normality_of(const AdjustmentReport& report) {
  Normality found;
  const Examined& adjusted = report.adjusted;
  if (!adjusted.reliability) return found;
  double second = 0, fourth = 0;
  for (std::size_t i = 0; i < adjusted.observations.size(); ++i) {
    const Eigen::Vector2d sigmas =
        report.block.observations[adjusted.observations[i]].sigmas_px() * sigma_scale(adjusted);
    for (int axis = 0; axis < 2; ++axis) {
      const double r = adjusted.reliability->tie_redundancy[i][axis], v = adjusted.residuals_px[i][axis];
      if (!(r > 0.05) || !std::isfinite(v)) continue;
      const double t = v / (sigmas[axis] * std::sqrt(r)), t2 = t * t;
      found.n += 1;
      found.beyond_2 += t2 > 4;
      found.beyond_3 += t2 > 9;
      second += t2;
      fourth += t2 * t2;
    }
  }
  if (found.n == 0) return found;
  found.beyond_2 /= found.n;
  found.beyond_3 /= found.n;
  found.kurtosis = fourth * found.n / (second * second);
  return found;
}

std::string image(const Pattern& pattern, const Camera& camera) {
  constexpr double kWidth = 560, kMargin = 10;
  const double scale = (kWidth - 2 * kMargin) / camera.width_px, height = camera.height_px * scale + 2 * kMargin;
  double longest = 1e-9;
  for (const Cell& cell : pattern.cells)
    if (cell.counts()) longest = std::max(longest, cell.mean.norm());
  const double length_px = round_below(longest), cell_width = (kWidth - 2 * kMargin) / kColumns;
  const double stretch = cell_width / longest;
  Svg svg(kWidth, height + 24, "mean residuals over the format of " + camera.name);
  svg.rectangle(kMargin, kMargin, kWidth - 2 * kMargin, height - 2 * kMargin, "frame");
  for (std::size_t i = 0; i < pattern.cells.size(); ++i) {
    const Cell& cell = pattern.cells[i];
    if (!cell.counts()) continue;
    const double column = static_cast<double>(i % kColumns) + 0.5, row = static_cast<double>(i / kColumns) + 0.5;
    const Eigen::Vector2d at(kMargin + column * cell_width, kMargin + row * (height - 2 * kMargin) / pattern.rows);
    if (cell.chi2 > kLimit)
      svg.arrow(at, at + stretch * cell.mean, "pattern_arrow");
    else
      svg.line(at, at + stretch * cell.mean, "unused");
    svg.circle(at, 1.5, "dot");
  }
  const Eigen::Vector2d from(kMargin, height + 10);
  svg.line(from, from + Eigen::Vector2d(stretch * length_px, 0), "scale");
  svg.text(from + Eigen::Vector2d(stretch * length_px + 8, 4), fmt::format("{:g} px", length_px));
  return svg.finish();
}

}  // namespace

std::string residual_section(const AdjustmentReport& report) {
  const std::vector<Pattern> patterns = patterns_of(report);
  if (patterns.empty()) return "";
  std::string html =
      "<section><h2>Systematic residuals</h2>\n<p>Mean residuals of tie points over the format; arrows where they are "
      "significant (level 0.1 %), grey where chance explains them. What remains in all images alike is what the "
      "camera model leaves over.</p>\n";
  for (const Pattern& pattern : patterns) {
    const Camera& camera = report.block.cameras.at(pattern.camera);
    html += fmt::format(
                "<p>{}: {} of {} cells are significant, {:.2g} by chance; the means are {:.3f} px (root mean "
                "square, chance taken off).</p>\n",
                escaped(camera.name), pattern.significant, pattern.counted, 0.001 * double(pattern.counted),
                pattern.rms_px) +
            image(pattern, camera);
  }
  if (const Normality normal = normality_of(report); normal.n > 0)
    html += fmt::format(
        "<p>Of {:.0f} residuals, in their own standard deviations, {:.2f} % are beyond 2 and {:.2f} % beyond 3 (of "
        "normal "
        "ones 4.55 and 0.27 %); their kurtosis is {:.2f} (3).</p>\n",
        normal.n, 100 * normal.beyond_2, 100 * normal.beyond_3, normal.kurtosis);
  return html + "</section>\n";
}

json residual_json(const AdjustmentReport& report) {
  json cameras = json::array();
  for (const Pattern& pattern : patterns_of(report)) {
    json cells = json::array();
    for (std::size_t i = 0; i < pattern.cells.size(); ++i)
      if (const Cell& cell = pattern.cells[i]; cell.counts())
        cells.push_back({{"column", i % kColumns},
                         {"row", i / kColumns},
                         {"residuals", cell.n},
                         {"mean_px", {cell.mean.x(), cell.mean.y()}},
                         {"chi_squared", cell.chi2}});
    cameras.push_back({{"camera", report.block.cameras.at(pattern.camera).name},
                       {"columns", kColumns},
                       {"rows", pattern.rows},
                       {"cells_counted", pattern.counted},
                       {"cells_significant", pattern.significant},
                       {"systematic_rms_px", pattern.rms_px},
                       {"cells", cells}});
  }
  json all = {{"cameras", cameras}};
  if (const Normality normal = normality_of(report); normal.n > 0)
    all["normality"] = {{"residuals", normal.n},
                        {"share_beyond_2_sigmas", normal.beyond_2},
                        {"share_beyond_3_sigmas", normal.beyond_3},
                        {"kurtosis", normal.kurtosis}};
  return all;
}

}  // namespace collinea
