// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/write_adjustment.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/adjustment_products.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/precision_layers.h"
#include "collinea/report/internal/tie_residuals.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::string csv_field(double value) { return std::isfinite(value) ? fmt::format(",{:.12g}", value) : ","; }

std::string cameras_csv(const AdjustmentReport& report) {
  std::string text = "camera,parameter,unit,value,sigma\n";
  for (const auto& [id, camera] : report.block.cameras) {
    const auto covariance = report.adjusted.camera_covariance.find(id);
    const bool known = covariance != report.adjusted.camera_covariance.end();
    const double unknown = report.adjusted.cameras.contains(id) ? std::nan("") : 0;  // 0: the camera was fixed
    for (const int k : params_of(camera))
      text += in_quotes(camera.name) + fmt::format(",{},{}", param_name(k), param_unit(k)) +
              csv_field(camera.params[k]) +
              csv_field(known ? std::sqrt(covariance->second(k, k)) * sigma_scale(report.adjusted) : unknown) + "\n";
  }
  return text;
}

std::string geodetic_csv(const AdjustmentReport& report) {
  std::string text =
      "from,to,name,kind,unit,role,given,sigma_given,adjusted,sigma_adjusted,difference,sigma_difference\n";
  for (const GeodeticDifference& one : report.adjusted.geodetic) {
    const GeodeticObservation& measured = report.block.geodetic[one.observation];
    const double unit = measured.is_angle() ? kDegrees : 1;
    text += in_quotes(report.block.control.at(measured.from).name) + "," +
            (measured.is_of_shape() ? "" : in_quotes(report.block.control.at(measured.to).name)) + "," +
            in_quotes(measured.name) + "," + in_quotes(kGeodeticKindNames[static_cast<std::size_t>(measured.kind)]) +
            (measured.is_angle() ? ",deg" : ",m") + (one.used ? ",control" : ",check");
    for (const double value : {measured.value, measured.sigma, one.adjusted, one.sigma * sigma_scale(report.adjusted),
                               one.difference, one.difference_sigma})
      text += csv_field(unit * value);
    text += "\n";
  }
  return text;
}

std::string unknowns_csv(const AdjustmentReport& report) {
  std::string text = "unknown,unit,value,sigma\n";
  for (const EstimatedUnknown& one : shown_unknowns(report.adjusted))
    text += in_quotes(words_of(subject_of(one.kind, one.owner, one.axis), report.block)) + "," + unit_of(one.kind) +
            csv_field(in_unit(one.kind, one.value)) +
            csv_field(in_unit(one.kind, one.sigma) * sigma_scale(report.adjusted)) + "\n";
  return text;
}

std::string observations_csv(const AdjustmentReport& report, const std::vector<TestedObservation>& observations) {
  std::string text =
      "observation,group,unit,residual,sigma,redundancy,w,gross_error,minimal_detectable_bias,its_effect,"
      "its_effect_in_sigmas\n";
  for (const TestedObservation& tested : observations) {
    const TestedObservation one = in_unit(tested);
    text += in_quotes(name_of(one, report.block)) + "," + in_quotes(words_of(one.group)) + "," + unit_of(one);
    for (const double value : {one.residual, one.sigma, one.redundancy, one.w, one.gross_error,
                               one.minimal_detectable_bias, one.effect, one.effect_in_sigmas})
      text += csv_field(value);
    text += "\n";
  }
  return text;
}

Result<> write_texts(const AdjustmentReport& report, const AdjustmentProducts& products,
                     const std::filesystem::path& folder) {
  static const Reliability kNone;
  const Reliability& tests = report.adjusted.reliability ? *report.adjusted.reliability : kNone;
  const std::pair<const char*, std::string> files[] = {{"poses.csv", poses_csv(report, products)},
                                                       {"cameras.csv", cameras_csv(report)},
                                                       {"points.csv", points_csv(products)},
                                                       {"control.csv", control_csv(report, products)},
                                                       {"geodetic.csv", geodetic_csv(report)},
                                                       {"unknowns.csv", unknowns_csv(report)},
                                                       {"observations.csv", observations_csv(report, tests.others)},
                                                       {"suspects.csv", observations_csv(report, tests.suspects)},
                                                       {"products.json", products_json(report, products)},
                                                       {"adjustment.json", adjustment_json(report)},
                                                       {"adjustment.html", adjustment_page(report, products)}};
  for (const auto& [name, text] : files) COLLINEA_TRY(write_file(folder / name, text));
  if (report.snooped) return write_file(folder / "rejected.csv", rejected_csv(*report.snooped));
  return remove_file(folder / "rejected.csv");  // of an earlier adjustment
}

}  // namespace

Result<> write_adjustment(const AdjustmentReport& report, const std::filesystem::path& folder, const Run& run) {
  COLLINEA_TRY(const AdjustmentProducts products, products_of(report));
  std::error_code error;
  std::filesystem::create_directories(folder, error);  // what is wrong with it shows below
  // The GeoPackage is a database, and takes as long as all texts.
  std::array<Result<>, 3> written;
  parallel_for(run, written.size(), [&](std::size_t i) {
    const auto residuals = folder / "tie_residuals.csv";
    if (i == 0)
      written[i] = write_products(report, products, precision_layers(report, products), folder / "adjustment.gpkg");
    else if (i == 1)
      written[i] = write_texts(report, products, folder);
    else  // that of an earlier adjustment goes
      written[i] = report.measured_ties.empty() ? remove_file(residuals) : write_tie_residuals(report, residuals);
  });
  for (Result<>& one : written)
    if (!one) return std::move(one);
  return {};
}

}  // namespace collinea
