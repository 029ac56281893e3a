// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/adjust_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "collinea/adjust/control_check.h"
#include "collinea/adjust/flight_strips.h"
#include "collinea/block/picture_axes.h"
#include "collinea/io/text.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {
namespace {

using nlohmann::json;

Result<json> orient_report(const Project& project) {
  COLLINEA_TRY(const std::vector<StepRecord> steps, project.store.read_steps());
  for (const StepRecord& step : steps)
    if (step.name == "orient") return json::parse(step.report_json, nullptr, false);
  return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + project.folder.string());
}

// The least set that holds every parameter that had a standard deviation after orientation.
std::string calibration_of(const json& orientation) {
  std::string calibration = "none";
  const auto free = [](const json& sigma, int param) {
    const json& value = sigma.at(static_cast<std::size_t>(param));
    return value.is_number() && value.get<double>() > 0;
  };
  const std::pair<const char*, int> steps[] = {
      {"focal", Camera::kF}, {"focal_radial", Camera::kK1}, {"brown", Camera::kCx}, {"brown_affinity", Camera::kB1}};
  std::size_t most = 0;
  for (const auto& [camera, sigma] : orientation.at("details").at("camera_sigma").items())
    for (std::size_t i = 0; i < std::size(steps); ++i)
      if (i + 1 > most && free(sigma, steps[i].second)) {
        most = i + 1;
        calibration = steps[i].first;
      }
  return calibration;
}

// What orientation did without, or shall be done without, is compared all the same.
void choose_ground(Block& block, const json& orientation, bool use_ground) {
  std::set<std::size_t> used;
  for (const json& row : orientation.at("details").value("ground", json::array()))
    if (row.at("used").get<bool>()) used.insert(row.at("observation").get<std::size_t>());
  for (std::size_t i = 0; i < block.ground.size(); ++i)
    if (!use_ground || !used.contains(i)) block.ground[i].role = ControlRole::kCheck;
}

const Eigen::Vector3d kNotKnown = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());

Result<LeverArm> lever_arm_of(const std::string& text) {
  if (text == "estimate") return LeverArm{Eigen::Vector3d::Zero(), kNotKnown};
  const auto fields = fields_of(text, ',');
  LeverArm arm;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = fields.size() == 3 ? number(fields[i]) : std::nullopt;
    if (!value || !std::isfinite(*value))
      return fail(Errc::kBadInput, "lever_arm = \"" + text +
                                       "\": give x,y,z in metres (right, down, forward in the "
                                       "camera), or estimate");
    arm.antenna_in_cam_m[static_cast<Eigen::Index>(i)] = *value;
  }
  return arm;
}

// What receivers and inertial systems measure, and what of their mounting is not known.
Result<> add_instruments(const Block& block, const AdjustProjectOptions& asked, AdjustScope& scope) {
  if (asked.lever_arm) {
    COLLINEA_TRY(const LeverArm arm, lever_arm_of(*asked.lever_arm));
    for (const auto& [id, camera] : block.cameras) scope.lever_arms[id] = arm;
  }
  if (asked.position_shift != "none" && asked.position_shift != "block" && asked.position_shift != "strips")
    return fail(Errc::kBadInput, "position_shift = \"" + asked.position_shift + "\": choose none, block or strips");
  if (asked.position_drift && asked.position_shift == "none")
    return fail(Errc::kBadInput, "position_drift needs a position_shift: block or strips");
  if (asked.position_shift != "none")
    for (FlightStrip& strip : asked.position_shift == "block" ? one_strip(block) : flight_strips(block))
      scope.position_tracks.push_back(
          {std::move(strip), kNotKnown, asked.position_drift ? kNotKnown : Eigen::Vector3d(0, 0, 0)});
  if (!asked.use_attitudes) return {};
  const double level = asked.attitude_sigma_deg * std::numbers::pi / 180,
               heading = asked.heading_sigma_deg * std::numbers::pi / 180;
  for (const auto& [id, image] : block.images) {
    if (!image.attitude) continue;
    scope.attitudes[id] = {cam_from_world(*image.attitude), {level, level, heading}};
    scope.boresight_sigma_rad[image.camera] = kNotKnown;
  }
  if (scope.attitudes.empty()) return fail(Errc::kBadInput, "no photograph says how its camera was turned");
  return {};
}

AdjustOptions options_of(const AdjustProjectOptions& asked, const json& orientation) {
  AdjustOptions options;
  options.calibration = asked.calibration == "auto" ? calibration_of(orientation) : asked.calibration;
  options.loss = options.position_loss = asked.loss;
  options.loss_scale_sigmas = asked.loss_scale_sigmas;
  options.reliability = options.covariances = options.point_covariances = true;
  options.false_alarm = asked.false_alarm;
  options.power = asked.power;
  options.sigma0_known = asked.sigma0_known;
  return options;
}

// One line for the user.
std::string outcome_text(const Adjusted& adjusted, const std::filesystem::path& folder) {
  std::string text =
      fmt::format("sigma0 {:.3f}, redundancy {}, datum: {}", adjusted.sigma0, adjusted.redundancy, adjusted.datum);
  if (adjusted.reliability)
    text +=
        fmt::format("; {} of {} observations suspected", adjusted.reliability->rejected, adjusted.reliability->tested);
  else
    text += "; no standard deviations: " + adjusted.undetermined;
  for (const std::string& pair : adjusted.inseparable) text += "; " + pair;
  return text + "; " + (folder / "adjustment.html").string();
}

}  // namespace

Result<std::string> adjust_project(const Project& project, const AdjustProjectOptions& asked) {
  if (Result<> valid = validate(asked); !valid) return tl::unexpected(std::move(valid).error().within("adjust"));
  COLLINEA_TRY(const json orientation, orient_report(project));
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  AdjustmentReport report;
  COLLINEA_TRY(report.block, project.store.read_block());
  choose_ground(report.block, orientation, asked.use_ground);
  AdjustScope scope{.first_cameras = setup.cameras,
                    .use_positions = asked.use_positions && !orientation.at("position_rms_m").is_null(),
                    .use_control = asked.use_control && !orientation.at("control_rmse_m").is_null()};
  if (scope.use_positions && scope.use_control) apply(check_control(report.block, project.settings.seed), report.block);
  if (Result<> known = add_instruments(report.block, asked, scope); !known) return tl::unexpected(known.error());
  const AdjustOptions options = options_of(asked, orientation);
  if (asked.variance_components) {
    COLLINEA_TRY(report.components, estimate_variance_components(report.block, scope, options, project.run));
    if (!report.components->converged)
      project.run.say("note: the variance components have not settled; the last ones are used");
    report.adjusted = report.components->adjusted;
    report.block = with_sigmas(report.block, report.components->factors);
  } else {
    COLLINEA_TRY(report.adjusted, adjust(report.block, scope, options, project.run));
  }
  apply(report.adjusted, report.block);
  std::error_code error;
  report.title = std::filesystem::absolute(project.folder, error).lexically_normal().filename().string();
  const auto folder = project.folder / "adjustment";
  if (auto written = write_adjustment(report, folder); !written) return tl::unexpected(written.error());
  return outcome_text(report.adjusted, folder);
}

}  // namespace collinea
