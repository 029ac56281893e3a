// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/monoplot.h"

#include <fmt/format.h>

#include "collinea/base/file.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/exterior_table.h"

namespace collinea {
namespace {

// The rays whose images are oriented, and a row of the report each measurement.
Result<std::vector<UncertainSightLine>> read_lines(const TextTable& table, const PhotoFrame& frame, double sigma,
                                                   const ExteriorTable& exterior, MonoplotReport& report) {
  COLLINEA_TRY(const auto images, table.words("image"));
  COLLINEA_TRY(const auto points, table.words("point"));
  COLLINEA_TRY(const auto x, table.numbers("x", frame.unit()));
  COLLINEA_TRY(const auto y, table.numbers("y", frame.unit()));
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", frame.unit(), sigma));
  std::vector<UncertainSightLine> lines;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(sigmas[i] > 0)) return fail(Errc::kBadFormat, fmt::format("row {}: sigma is not above 0", i + 1));
    const UncertainPose* pose = exterior.find(std::span(&images[i], 1));
    report.points.push_back({points[i], images[i], pose != nullptr, {}});
    if (!pose) continue;
    UncertainSightLine line;
    line.line = {&frame.camera, pose->cam_from_world, frame.pixel({x[i], y[i]}), sigmas[i], {}};
    line.pose_covariance = pose->covariance;
    lines.push_back(line);
  }
  if (points.empty()) return fail(Errc::kBadInput, "there are no measurements");
  return lines;
}

}  // namespace

Result<MonoplotReport> monoplot_from_tables(const std::filesystem::path& measurements,
                                            const std::filesystem::path& orientation,
                                            const std::filesystem::path& surface, const MonoplotTableOptions& options,
                                            const Run& run) {
  COLLINEA_TRY(validate(options));
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, table.unit_of("x")).map_error(in_file));
  COLLINEA_TRY(const ExteriorTable exterior, read_exterior_table(orientation));
  if (options.surface_sigma && !is_there(*options.surface_sigma))
    return fail(Errc::kNotFound, options.surface_sigma->string() + " is not there", {"surface_sigma"_option});
  COLLINEA_TRY(const HeightField heights, open_height_field(surface, options.surface_sigma.value_or("")));
  MonoplotReport report;
  report.orientations_have_sigmas = exterior.has_sigmas;
  report.heights_have_sigmas = options.surface_sigma.has_value() || options.sigma_height_m.has_value();
  const double given = options.sigma.value_or(frame.y_up ? 0.01 : 1);
  const double sigma = options.sigma && frame.y_up ? given * unit_factor(table.unit_of("x"), "mm").value_or(1) : given;
  COLLINEA_TRY(const auto lines, read_lines(table, frame, sigma, exterior, report).map_error(in_file));
  COLLINEA_TRY(const auto found, monoplot(lines, heights, options.sigma_height_m, run));
  std::size_t next = 0;
  for (MonoplotReport::Point& point : report.points)
    if (point.is_oriented) point.found = found[next++];
  return report;
}

}  // namespace collinea
