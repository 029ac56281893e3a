// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/interest.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/feature/interest_covariance.h"
#include "collinea/jobs/internal/drawing.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kBorder_px = 16;  // of repeatability: what lies nearer to the border of one image is not counted

struct Change {
  ImageChange change;
  double amount;
};
constexpr std::array<Change, 19> kChanges = {{{ImageChange::kRotation, 0},
                                              {ImageChange::kRotation, 15},
                                              {ImageChange::kRotation, 30},
                                              {ImageChange::kRotation, 45},
                                              {ImageChange::kRotation, 60},
                                              {ImageChange::kRotation, 75},
                                              {ImageChange::kRotation, 90},
                                              {ImageChange::kScale, 0.5},
                                              {ImageChange::kScale, 0.7},
                                              {ImageChange::kScale, 0.85},
                                              {ImageChange::kScale, 1},
                                              {ImageChange::kScale, 1.2},
                                              {ImageChange::kScale, 1.5},
                                              {ImageChange::kScale, 2},
                                              {ImageChange::kNoise, 0},
                                              {ImageChange::kNoise, 2},
                                              {ImageChange::kNoise, 5},
                                              {ImageChange::kNoise, 10},
                                              {ImageChange::kNoise, 20}}};

// The map as it can be looked at: square roots, black to white.
GreyImage shown(const FloatImage& map) {
  GreyImage out(map.width, map.height);
  const float highest = map.empty() ? 0 : *std::ranges::max_element(map.data);
  if (!(highest > 0)) return out;
  for (std::size_t i = 0; i < map.data.size(); ++i)
    out.data[i] = static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::max(0.0f, map.data[i]) / highest)));
  return out;
}

Raster<std::uint8_t> marked(const GreyImage& image, const InterestPoints& found) {
  ColourImage drawing = to_draw_on(image);
  for (const InterestPoint& p : found.points) {
    if (p.is_circle)
      draw_circle(drawing, p.position_px, 5, kMarkBlue);
    else
      draw_cross(drawing, p.position_px, 5, kMarkRed);
  }
  return drawing;
}

std::vector<RepeatabilityRow> tried(const GreyImage& image, const InterestJobOptions& options, const Run& run) {
  std::vector<InterestOperator> operators = {options.points.method};
  if (*options.repeatability == RepeatabilityOf::kAll) {
    operators.clear();
    for (const auto& entry : words(InterestOperator{})) operators.push_back(entry.value);
  }
  const auto options_of = [&](std::size_t k) {
    InterestOptions its = options.points;
    its.method = operators[k];
    if (operators.size() > 1) its.threshold.reset();  // its unit is another with every operator
    return its;
  };
  std::vector<InterestPoints> original(operators.size());
  parallel_for(run, operators.size(), [&](std::size_t k) { original[k] = find_interest_points(image, options_of(k)); });
  std::vector<RepeatabilityRow> rows(operators.size() * kChanges.size());
  parallel_for(run, kChanges.size(), [&](std::size_t c) {
    const auto& [change, amount] = kChanges[c];
    const ChangedImage there = changed(image, change, amount, run.seed);
    const CommonPart part{image.width, image.height, there.image.width, there.image.height, kBorder_px};
    for (std::size_t k = 0; k < operators.size(); ++k) {
      const InterestPoints found = find_interest_points(there.image, options_of(k));
      rows[k * kChanges.size() + c] = {
          operators[k], change, amount,
          repeatability(original[k].points, found.points, there.from_original, part, options.tolerance_px)};
    }
    run.report("repeatability", static_cast<double>(c + 1) / kChanges.size());
  });
  return rows;
}

}  // namespace

Result<InterestReport> find_interest(const fs::path& file, const fs::path& folder, const InterestJobOptions& options,
                                     const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const GreyImage image, read_grey(file));
  InterestReport report{.image = file.filename().string(),
                        .width = image.width,
                        .height = image.height,
                        .options = options.points,
                        .tolerance_px = options.tolerance_px};
  const FloatImage map = interest_map(image, options.points);
  report.found = find_interest_points(image, map, options.points);
  add_paraboloid_covariances(image, options.points, report.found);
  if (options.repeatability) report.repeatability = tried(image, options, run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  COLLINEA_TRY(write_file(folder / "points.txt", text_of(points_table(report))));
  COLLINEA_TRY(write_png(folder / "points.png", marked(image, report.found)));
  COLLINEA_TRY(write_float_tiff(folder / "map.tif", map));
  COLLINEA_TRY(write_png(folder / "map.png", shown(map)));
  if (!report.repeatability.empty()) {
    COLLINEA_TRY(write_file(folder / "repeatability.txt", text_of(repeatability_table(report))));
    COLLINEA_TRY(write_file(folder / "repeatability.svg", repeatability_svg(report)));
  }
  return report;
}

}  // namespace collinea
