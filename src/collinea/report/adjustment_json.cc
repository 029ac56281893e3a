// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <numbers>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/details.h"
#include "collinea/report/internal/finding_json.h"
#include "collinea/report/json_values.h"
#include "collinea/report/value_words.h"
#include "collinea/report/write_adjustment.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

// Row by row; of a check point that of the block alone.
json covariance_of(const ControlDifference& one, double sigma0) {
  if (!one.covariance_m2) return nullptr;
  json rows = json::array();
  for (int row = 0; row < 3; ++row)
    rows.push_back(vector(Eigen::Vector3d(sigma0 * sigma0 * one.covariance_m2->row(row).transpose())));
  return rows;
}

json control(const AdjustmentReport& report) {
  json list = json::array();
  for (const ControlDifference& one : report.adjusted.control) {
    json row = json_of(one, report.block);
    row["covariance_m2"] = covariance_of(one, sigma_scale(report.adjusted));
    list.push_back(std::move(row));
  }
  return list;
}

std::vector<ImageDetail> image_details(const AdjustmentReport& report) {
  const Examined& adjusted = report.adjusted;
  std::map<ImageId, ImageDetail> details;
  for (const auto& [id, pose] : oriented_images(report.block)) {
    ImageDetail& one = details[id];
    one.image = id;
    one.centre_in_world = centre_of(pose);
    const auto known = adjusted.pose_covariance.find(id);
    if (known == adjusted.pose_covariance.end()) continue;
    const Eigen::Matrix<double, 6, 1> sigma = known->second.diagonal().cwiseSqrt() * sigma_scale(adjusted);
    one.rotation_sigma_deg = 180 / std::numbers::pi * sigma.head<3>();
    one.centre_sigma_m = sigma.tail<3>();
  }
  for (const PositionDifference& position : adjusted.positions)
    if (const auto its = details.find(position.image); its != details.end()) its->second.position = &position;
  for (std::size_t i = 0; i < adjusted.observations.size(); ++i) {
    const auto its = details.find(report.block.observations[adjusted.observations[i]].image);
    if (its == details.end() || !adjusted.residuals_px[i].allFinite()) continue;
    ++its->second.rays;
    its->second.rms_px += adjusted.residuals_px[i].squaredNorm();  // a sum of squares, until below
  }
  std::vector<ImageDetail> list;
  for (auto& [id, one] : details) {
    one.rms_px = one.rays > 0 ? std::sqrt(one.rms_px / double(one.rays)) : 0;
    list.push_back(one);
  }
  return list;
}

json images(const AdjustmentReport& report) {
  json list = json::array();
  for (const ImageDetail& one : image_details(report)) list.push_back(json_of(one, report.block));
  return list;
}

json geodetic_json(const AdjustmentReport& report) {
  json list = json::array();
  for (const GeodeticDifference& one : report.adjusted.geodetic) {
    const GeodeticObservation& measured = report.block.geodetic[one.observation];
    const double unit = measured.is_angle() ? 180 / std::numbers::pi : 1;
    list.push_back({{"measurement", words_of(measured, report.block)},
                    {"unit", measured.is_angle() ? "deg" : "m"},
                    {"role", one.used ? "control" : "check"},
                    {"given", unit * measured.value},
                    {"sigma_given", unit * measured.sigma},
                    {"adjusted", number(unit * one.adjusted)},
                    {"sigma_adjusted", number(unit * one.sigma * sigma_scale(report.adjusted))},
                    {"difference", number(unit * one.difference)},
                    {"sigma", number(unit * one.difference_sigma)}});
  }
  return list;
}

// Correlations of the parameters of a camera that are free.
json correlations_of(const Camera& camera, const MatrixPd& covariance) {
  json all;
  const std::vector<int> params = params_of(camera);
  for (const int k : params)
    for (const int other : params)
      if (other < k && covariance(k, k) > 0 && covariance(other, other) > 0)
        all[param_name(k)][param_name(other)] =
            number(covariance(k, other) / std::sqrt(covariance(k, k) * covariance(other, other)));
  return all;
}

json cameras(const AdjustmentReport& report) {
  std::map<CameraId, CameraDetail> details = by_camera(image_details(report), report.block);
  json list = json::array();
  for (const auto& [id, camera] : report.block.cameras) {
    CameraDetail& detail = details[id];
    detail.camera = id;
    const auto covariance = report.adjusted.camera_covariance.find(id);
    const bool known = covariance != report.adjusted.camera_covariance.end();
    const double unknown = report.adjusted.cameras.contains(id) ? std::nan("") : 0;  // 0: the camera was fixed
    for (int k = 0; k < Camera::kAllParams; ++k)
      detail.sigma.push_back(!known ? unknown
                             : k >= covariance->second.rows()
                                 ? 0
                                 : std::sqrt(covariance->second(k, k)) * sigma_scale(report.adjusted));
    json one = json_of(detail, report.block);
    if (known && !camera.prior.film)
      if (const json all = correlations_of(camera, covariance->second); !all.is_null()) one["correlations"] = all;
    list.push_back(one);
  }
  return list;
}

json unknowns(const AdjustmentReport& report) {
  json list = json::array();
  for (const EstimatedUnknown& one : shown_unknowns(report.adjusted))
    list.push_back({{"unknown", words_of(subject_of(one.kind, one.owner, one.axis), report.block)},
                    {"unit", unit_of(one.kind)},
                    {"value", number(in_unit(one.kind, one.value))},
                    {"sigma", number(in_unit(one.kind, one.sigma) * sigma_scale(report.adjusted))}});
  return list;
}

json tested(const std::vector<TestedObservation>& observations, const Block& block) {
  json list = json::array();
  for (const TestedObservation& in_rad : observations) {
    const TestedObservation one = in_unit(in_rad);
    list.push_back({{"observation", name_of(one, block)},
                    {"unit", unit_of(one)},
                    {"residual", number(one.residual)},
                    {"sigma", number(one.sigma)},
                    {"redundancy", number(one.redundancy)},
                    {"w", number(one.w)},
                    {"gross_error", number(one.gross_error)},
                    {"minimal_detectable_bias", number(one.minimal_detectable_bias)},
                    {"effect", number(one.effect)},
                    {"effect_in_sigmas", number(one.effect_in_sigmas)}});
  }
  return list;
}

json groups(const AdjustmentReport& report, const Reliability& tests) {
  json list = json::array();
  for (std::size_t g = 0; g < kObservationGroups; ++g) {
    const GroupSums& sums = tests.groups[g];
    if (sums.observations == 0) continue;
    json one = {{"group", words_of(ObservationGroup(g))},
                {"observations", sums.observations},
                {"redundancy", number(sums.redundancy)},
                {"sigma_factor", number(shown_factor(sums))}};
    if (report.components) {
      one["applied_factor"] = number(report.components->factors[g]);
      one["applied_factor_sigma"] = number(report.components->sigma[g]);
    }
    list.push_back(one);
  }
  return list;
}

json tie_errors(const Reliability& tests) {
  json list = json::array();
  for (std::size_t i = 0; i < tests.tie_errors.classes.size(); ++i) {
    const TieErrors::Class& one = tests.tie_errors.classes[i];
    list.push_back({{"least_rays", one.least_rays},
                    {"errors", one.errors},
                    {"scale", number(one.distribution.scale)},
                    {"degrees_of_freedom", number(one.distribution.degrees_of_freedom)},
                    {"gross_share", number(one.distribution.gross_share)},
                    {"limit", number(tests.tie_limits[i])}});
  }
  return list;
}

json left_out_point(const AdjustmentReport& report, const LeftOutPoint& one) {
  return {{"name", report.block.control.at(one.point).name},
          {"difference_m", vector(one.difference_m)},
          {"sigma_m", vector(one.difference_sigma_m)}};
}

json rms_json(const std::vector<LeftOutPoint>& points) {
  json all;
  for (const bool height : {false, true})
    if (const LeftOutRms rms = rms_of(points, height); rms.points > 0)
      all[height ? "height" : "plan"] = {
          {"points", rms.points}, {"rms_m", number(rms.difference_m)}, {"predicted_m", number(rms.predicted_m)}};
  return all;
}

json reliability(const AdjustmentReport& report, const Reliability& tests) {
  json left_out = json::array(), folded = json::array();
  for (const LeftOutPoint& one : tests.left_out) left_out.push_back(left_out_point(report, one));
  for (std::size_t i = 0; i < tests.folded.points.size(); ++i) {
    folded.push_back(left_out_point(report, tests.folded.points[i]));
    folded.back()["part"] = tests.folded.part[i];
  }
  return {{"false_alarm", tests.false_alarm},
          {"power", tests.power},
          {"test", tests.sigma0_known ? "w" : "tau"},
          {"limit", tests.limit},
          {"tie_errors", tie_errors(tests)},
          {"tested", tests.tested},
          {"rejected", tests.rejected},
          {"unseen", tests.unseen},
          {"groups", groups(report, tests)},
          {"suspects", tested(tests.suspects, report.block)},
          {"control_and_positions", tested(tests.others, report.block)},
          {"left_out", left_out},
          {"left_out_rms", rms_json(tests.left_out)},
          {"left_out_in_parts",
           {{"parts", tests.folded.folds}, {"rms", rms_json(tests.folded.points)}, {"points", folded}}}};
}

}  // namespace

std::string adjustment_json(const AdjustmentReport& report) {
  const Examined& adjusted = report.adjusted;
  json j = {
      {"sigma0", adjusted.sigma0},
      {"redundancy", adjusted.redundancy},
      {"observations", adjusted.observation_count},
      {"unknowns", adjusted.unknown_count},
      {"rank_defect", adjusted.rank_defect},
      {"datum", words_of(adjusted.datum, adjusted.rank_defect)},
      {"converged", adjusted.converged},
      {"iterations", adjusted.iterations},
      {"initial_cost", number(adjusted.initial_cost)},
      {"final_cost", number(adjusted.final_cost)},
      {"last_step_sigmas", number(adjusted.last_step_sigmas)},
      {"conditioning",
       {{"inflation", number(adjusted.conditioning.inflation)},
        {"mostly", words_of(adjusted.conditioning, report.block)}}},
      {"undetermined", adjusted.undetermined ? finding_json(*adjusted.undetermined, report.block) : json(nullptr)},
      {"cameras", cameras(report)},
      {"image_list", images(report)},
      {"control_points", control(report)},
      {"accuracy", accuracy_json(report)}};
  if (report.film)
    j["film_deformation"] = {
        {"sigma_px", report.film->process.sigma_px},         {"correlation_px", report.film->process.correlation_px},
        {"sigma_by_marks_px", report.film->before.sigma_px}, {"rms_px", report.film->rms_px},
        {"adjustments", report.film->iterations + 1},        {"converged", report.film->converged}};
  if (!report.datum_points.empty())
    j["datum_points"] = {{"names", datum_point_names(report)}, {"have_effect", adjusted.rank_defect > 0}};
  if (!report.adjusted.geodetic.empty()) j["geodetic"] = geodetic_json(report);
  if (!adjusted.auxiliaries.empty()) j["auxiliary_unknowns"] = unknowns(report);
  if (!report.additional.empty()) j["additional"] = additional_json(report);
  if (!adjusted.inseparable.empty()) j["inseparable"] = findings_json(adjusted.inseparable, report.block);
  if (adjusted.reliability) j["reliability"] = reliability(report, *adjusted.reliability);
  if (!adjusted.pose_covariance.empty()) {
    j["pose_correlations"] = pose_correlation_json(report);
    j["camera_pose_correlations"] = camera_pose_correlation_json(report);
    j["weakest"] = weak_json(report);
  }
  j["network"] = network_json(report);
  j["residuals"] = residual_json(report);
  if (!report.residual_tests.empty()) j["residual_tests"] = residual_tests_json(report);
  j["weaknesses"] = findings_json(adjusted.weaknesses, report.block);
  if (!report.taken_up.empty() || !adjusted.systematics.empty()) j["systematics"] = systematic_json(report);
  if (report.mismatches)
    j["mismatches"] = {{"tested", report.mismatches->tested},
                       {"wrong", report.mismatches->wrong.size()},
                       {"with_them", report.mismatches->with_them.size()},
                       {"expected_good", number(report.mismatches->expected_good)}};
  if (const auto& weights = report.tie_weights)
    j["tie_weights"] = {{"scale_sigmas", weights->scale}, {"degrees_of_freedom", number(weights->degrees_of_freedom)},
                        {"least", weights->least},        {"lower_quartile", weights->lower_quartile},
                        {"adjustments", weights->rounds}, {"converged", weights->converged}};
  if (report.snooped) j["snooping"] = snooping_json(report);
  return j.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace collinea
