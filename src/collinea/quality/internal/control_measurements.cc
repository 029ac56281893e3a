// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/control_measurements.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/epipolar/intersect.h"

namespace collinea::bundle {
namespace {

constexpr double kSigmas = 6, kLeast_px = 3, kTimesTheRest = 4;

double largest_residual_px(const Intersection& met) {
  double largest = 0;
  for (const Eigen::Vector2d& residual : met.residuals_px) largest = std::max(largest, residual.norm());
  return largest;
}

struct Suspect {
  std::size_t line;
  double off_px = 0;   // from where the other rays see the point
  double rest_px = 0;  // largest residual of the others
};

// The ray without which the others agree best, and how far it is off then.
std::optional<Suspect> worst_of(const std::vector<SightLine>& lines) {
  std::optional<Suspect> worst;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<SightLine> others = lines;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const auto met = intersect(others);
    if (!met || met->sigma0 >= least) continue;
    least = met->sigma0;
    const auto pixel = project(*lines[i].camera, lines[i].cam_from_world * met->point_in_world);
    const double off = pixel ? (*pixel - lines[i].pixel).norm() : double(lines[i].camera->width_px);
    worst = Suspect{i, off, largest_residual_px(*met)};
  }
  return worst;
}

bool is_wrong(const Suspect& suspect, double sigma_px, std::size_t lines) {
  // Three rays leave pairs, and a pair agrees by chance more easily than three do: ask for more.
  const double times = lines == 3 ? 2 * kTimesTheRest : kTimesTheRest;
  return suspect.off_px > std::max({kSigmas * sigma_px, kLeast_px, times * suspect.rest_px});
}

}  // namespace

std::map<ControlId, Intersection> intersect_control(const Block& block, ControlDiagnosis& diagnosis) {
  std::map<ControlId, Intersection> points;
  for (const auto& [id, control] : block.control) {
    std::vector<std::size_t> indices;
    std::vector<SightLine> lines = sight_lines(block, id, &indices);
    while (lines.size() >= 3) {
      const auto suspect = worst_of(lines);
      if (!suspect || !is_wrong(*suspect, lines[suspect->line].sigma_px, lines.size())) break;
      const ImageId image = block.control_observations[indices[suspect->line]].image;
      diagnosis.findings.push_back(
          finding_of(FindingCode::kControlMeasurement, {id, image}, {{FigureName::kOffsetPx, suspect->off_px}}));
      diagnosis.excluded_observations.insert(indices[suspect->line]);
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(suspect->line));
      indices.erase(indices.begin() + static_cast<std::ptrdiff_t>(suspect->line));
    }
    const auto met = intersect(lines);
    if (!met) continue;
    const double largest = largest_residual_px(*met);
    // A bent block leaves some pixels; far more than that is a wrong measurement.
    if (lines.size() <= 3 && largest > std::max(2 * kSigmas * lines.front().sigma_px, 4 * kLeast_px)) {
      diagnosis.findings.push_back(
          finding_of(FindingCode::kControlMeasurementsDisagree, {id},
                     {{FigureName::kOffsetPx, 2 * largest}, {FigureName::kCount, static_cast<double>(lines.size())}}));
      diagnosis.excluded_points.insert(id);
      continue;
    }
    points.emplace(id, *met);
  }
  return points;
}

}  // namespace collinea::bundle
