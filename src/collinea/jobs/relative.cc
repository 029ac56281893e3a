// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/relative.h"

#include <algorithm>
#include <string>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/camera/camera.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/fundamental_file.h"
#include "collinea/jobs/internal/given_relative.h"
#include "collinea/jobs/internal/orientation_findings.h"
#include "collinea/jobs/internal/pair_points.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

Result<int> index_of(const RelativeReport& report, const std::string& name) {
  const auto found = std::find(report.names.begin(), report.names.end(), name);
  if (found == report.names.end()) return fail(Errc::kNotFound, "point " + name + " is not among those measured");
  return static_cast<int>(found - report.names.begin());
}

// Distances of a table; orientation, base and model become those that they leave.
Result<> scale_by(const TextTable& table, RelativeReport& report) {
  COLLINEA_TRY(const auto from, table.words("from"));
  COLLINEA_TRY(const auto to, table.words("to"));
  COLLINEA_TRY(const auto lengths, table.numbers("distance", "m"));
  COLLINEA_TRY(const auto sigmas, table.numbers("sigma", "m"));
  std::vector<PairDistance> distances;
  for (std::size_t k = 0; k < from.size(); ++k) {
    COLLINEA_TRY(const int first, index_of(report, from[k]));
    COLLINEA_TRY(const int second, index_of(report, to[k]));
    distances.push_back({first, second, lengths[k], sigmas[k]});
    report.distances.push_back({from[k], to[k], lengths[k], sigmas[k]});
  }
  report.scaled = scaled_pair(report.orientation, report.points, distances, true);
  if (!report.scaled)
    return fail(Errc::kBadInput,
                "the distances give no scale: each needs two points of the model, a length and a sigma");
  RelativeOrientation& orientation = report.orientation;
  orientation.second_from_first = report.scaled->second_from_first;
  orientation.covariance = report.scaled->covariance.topLeftCorner<5, 5>() / orientation.variance_factor;
  report.model = report.scaled->model;
  report.base = report.scaled->base;
  report.base_is_given = true;
  return {};
}

// Exterior orientation of the second image in the model, x right, y up, z backwards.
void set_pose(RelativeReport& report) {
  Eigen::Matrix<double, 6, 6> of_change = Eigen::Matrix<double, 6, 6>::Zero();
  of_change.topLeftCorner<5, 5>() = report.orientation.stated_covariance();
  if (report.scaled) of_change = report.scaled->covariance;
  set_right_pose(of_change, report);
}

// What there is to say of points that leave no orientation: behind the error, and as a picture in the folder.
Error described(Error error, RelativeReport& report, const RelativePairOptions& options) {
  if (error.code != Errc::kIllPosed) return error;
  const auto critical = critical_pair(report.points, report.options, options.seed);
  if (!critical) return error;
  report.orientation.second_from_first = critical->second_from_first;
  report.orientation.residuals.assign(report.points.size(), {});
  report.orientation.covariance.setZero();
  report.shape = critical->shape;
  report.model = model_points(report.orientation, report.points, report.base, true);
  const std::string text = pair_shape_text(report);
  if (options.out) {
    const auto written = write_file(*options.out / "geometry.txt", text).and_then([&] {
      return write_file(*options.out / "geometry.svg", pair_shape_svg(report));
    });
    if (!written) return written.error();
  }
  return std::move(error).advising("\n" + text);
}

// The other orientation of a plane and the simplified one, where the report is to have them.
void set_others(RelativeReport& report, const std::vector<PairPoint>& used) {
  const auto is_found = [&](PairWeakness weakness) {
    return report.shape && std::ranges::find(report.shape->weaknesses, weakness) != report.shape->weaknesses.end();
  };
  if (is_found(PairWeakness::kPlane) || is_found(PairWeakness::kNearPlane))
    report.second = second_orientation(report.orientation.second_from_first, *report.shape, used, report.options);
  if (report.options.start == PairStart::kLinear) report.linear = linear_orientation(used);
}

Result<> write_tables(const RelativeReport& report, const fs::path& folder) {
  COLLINEA_TRY(write_file(folder / "parameters.txt", text_of(relative_parameter_table(report))));
  COLLINEA_TRY(write_file(folder / "correlations.txt", text_of(relative_correlation_table(report))));
  COLLINEA_TRY(write_file(folder / "solutions.txt", text_of(relative_solutions_table(report))));
  if (report.orientation.search)
    COLLINEA_TRY(write_file(folder / "search.txt", text_of(relative_search_table(report))));
  if (report.linear) {
    COLLINEA_TRY(write_file(folder / "linear.txt", text_of(relative_linear_table(report))));
    COLLINEA_TRY(write_file(folder / "linear_parallaxes.txt", text_of(relative_linear_parallax_table(report))));
  }
  COLLINEA_TRY(write_file(folder / "residuals.txt", text_of(relative_residual_table(report))));
  COLLINEA_TRY(write_file(folder / "model.txt", text_of(relative_model_table(report))));
  COLLINEA_TRY(write_file(folder / "exterior.txt", text_of(relative_exterior_table(report))));
  COLLINEA_TRY(write_fundamental(report, folder));
  COLLINEA_TRY(write_file(folder / "findings.json", findings_json_text(report.findings)));
  return write_file(folder / "geometry.svg", pair_shape_svg(report));
}

}  // namespace

Result<RelativeReport> orient_pair(const fs::path& measurements, const RelativePairOptions& options) {
  if (options.given) return compare_with_given(measurements, options);
  if (measurements.empty())
    return fail(Errc::kBadInput, "a table of points is wanted, or elements that are given", {"given"_option});
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  RelativeReport report;
  COLLINEA_TRY(read_pair_points(table, options, report).map_error(in_file));
  report.options = options.adjustment;
  report.options.sigma_known = report.sigma_is_given && !options.estimate_sigma;
  if (options.base_m && options.distances)
    return fail(Errc::kBadInput, "the base is given, and by distances", {"base_m"_option, "distances"_option});
  report.base_is_given = options.base_m.has_value();
  report.base = options.base_m.value_or(1);
  COLLINEA_TRY(report.orientation,
               relative_orientation(report.points, report.options, options.seed).map_error([&](Error e) {
                 return in_file(described(std::move(e), report, options));
               }));
  std::vector<PairPoint> used;
  for (std::size_t i = 0; i < report.points.size(); ++i)
    if (report.orientation.residuals[i].used) used.push_back(report.points[i]);
  report.solutions = relative_solutions(report.orientation.second_from_first, used);
  report.shape = pair_shape(report.orientation.second_from_first, used, report.orientation.normal);
  set_others(report, used);
  report.model = model_points(report.orientation, report.points, report.base, true);
  if (options.distances) {
    const auto in_distances = [&](Error e) { return std::move(e).within(options.distances->string()); };
    COLLINEA_TRY(const TextTable distances, read_text_table(*options.distances));
    COLLINEA_TRY(scale_by(distances, report).map_error(in_distances));
  }
  set_pose(report);
  report.findings = relative_findings(report);
  if (options.out) COLLINEA_TRY(write_tables(report, *options.out));
  return report;
}

}  // namespace collinea
