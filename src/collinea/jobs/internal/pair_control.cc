// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_control.h"

#include <fmt/format.h>

#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/jobs/internal/ground_table.h"

namespace collinea {
namespace {

constexpr double kUsualSigma_m = 0.02;  // of the ground, where the table states none

AbsoluteControl on_ground_of(const GroundTablePoint& point) {
  AbsoluteControl made;
  made.has_plan = point.has_plan();
  made.has_height = point.has_height();
  for (int k = 0; k < 3; ++k) {
    const bool is_known = std::isfinite(point.position[k]);
    made.in_ground[k] = is_known ? point.position[k] : 0;
    made.ground_covariance(k, k) = is_known ? point.sigma[k] * point.sigma[k] : 0;
  }
  return made;
}

// Which points are only compared.
Result<std::vector<bool>> checks_of(const GroundTable& ground) {
  std::vector<bool> checks(ground.points.size(), false);
  if (!ground.table.has("role")) return checks;
  COLLINEA_TRY(const std::vector<std::string> roles, ground.table.words("role"));
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] != "check" && roles[i] != "control" && roles[i] != "-" && !roles[i].empty())
      return fail(Errc::kBadFormat,
                  fmt::format("point {}: the role {} is neither control nor check", ground.points[i].name, roles[i]));
    checks[i] = roles[i] == "check";
  }
  return checks;
}

// All points intersected in the model.
Result<ControlFit> in_model(const PairControl& control, const ModelOfPair& model, const Rigid3& right_from_left) {
  ControlFit fit = control.fit;
  for (std::size_t i = 0; i < fit.pairs.size(); ++i) {
    const std::array<SightLine, 2> lines = {
        SightLine{&model.left_camera, {}, control.pixels[i][0], control.sigma_px, {}},
        SightLine{&model.right_camera, right_from_left, control.pixels[i][1], control.sigma_px, {}}};
    const auto met = intersect(lines);
    if (!met)
      return fail(Errc::kIllPosed, fmt::format("{}: the rays of point {} do not meet in front of the cameras",
                                               control.file.string(), fit.names[i]));
    fit.pairs[i].in_model = met->point_in_world;
    fit.pairs[i].model_covariance = met->covariance;
  }
  return fit;
}

}  // namespace

Result<PairControl> read_pair_control(const std::filesystem::path& file, const PairFiles& pair, int shrink,
                                      double sigma_px) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const GroundTable ground, read_ground_table(file, kUsualSigma_m, false));
  PairControl control{.file = file, .pixels = {}, .sigma_px = sigma_px / shrink, .fit = {}};
  for (const GroundTablePoint& point : ground.points) {
    control.fit.names.push_back(point.name);
    control.fit.pairs.push_back(on_ground_of(point));
  }
  COLLINEA_TRY(control.fit.is_check, checks_of(ground).map_error(within));
  control.fit.is_rejected.assign(ground.points.size(), false);
  std::array<std::vector<double>, 4> pixels;
  const char* const columns[] = {"x_left", "y_left", "x_right", "y_right"};
  for (std::size_t i = 0; i < 4; ++i) {
    COLLINEA_TRY(pixels[i], ground.table.numbers(columns[i], "px").map_error(within));
  }
  for (std::size_t i = 0; i < ground.points.size(); ++i) {
    std::array<Eigen::Vector2d, 2> seen = {Eigen::Vector2d(pixels[0][i], pixels[1][i]), {pixels[2][i], pixels[3][i]}};
    if (pair.film) {
      const auto left = pair.film->in_left(seen[0]), right = pair.film->in_right(seen[1]);
      if (!left || !right)
        return fail(Errc::kBadInput,
                    fmt::format("{}: point {} lies beyond the film", file.string(), control.fit.names[i]));
      seen = {*left, *right};
    }
    control.pixels.push_back({seen[0] / shrink, seen[1] / shrink});
  }
  return control;
}

std::vector<Eigen::Vector2d> PairControl::used_left_px() const {
  std::vector<Eigen::Vector2d> out;
  for (const std::size_t k : fit.used()) out.push_back(pixels[k][0]);
  return out;
}

std::vector<std::string> PairControl::used_names() const {
  std::vector<std::string> out;
  for (const std::size_t k : fit.used()) out.push_back(fit.names[k]);
  return out;
}

Result<AbsoluteOrientation> oriented_absolutely(const PairControl& control, const ModelOfPair& model,
                                                const Rigid3& right_from_left) {
  COLLINEA_TRY(const ControlFit fit, in_model(control, model, right_from_left));
  return fitted(fit).map_error([&](Error error) { return std::move(error).within(control.file.string()); });
}

Result<AbsoluteOrientation> oriented_with_rejection(PairControl& control, const ModelOfPair& model,
                                                    const Rigid3& right_from_left, bool reject, double alpha) {
  COLLINEA_TRY(ControlFit fit, in_model(control, model, right_from_left));
  COLLINEA_TRY(AbsoluteOrientation found, fitted_with_rejection(fit, reject, alpha).map_error([&](Error error) {
    return std::move(error).within(control.file.string());
  }));
  control.fit.is_rejected = fit.is_rejected;
  return found;
}

Result<AbsoluteReport> pair_control_report(const PairControl& control, const ModelOfPair& model,
                                           const AbsoluteOrientation& found, double alpha) {
  COLLINEA_TRY(ControlFit fit, in_model(control, model, model.right_from_left()));
  const Eigen::Quaterniond half_turn(0, 1, 0, 0);
  const Eigen::Matrix3d turn = half_turn.toRotationMatrix();
  for (AbsoluteControl& pair : fit.pairs) {
    pair.in_model = turn * pair.in_model;
    pair.model_covariance = turn * pair.model_covariance * turn.transpose();
  }
  AbsoluteOrientation turned = found;
  turned.ground_from_model.rotation = (found.ground_from_model.rotation * half_turn).normalized();
  turned.centroid_in_model = turn * found.centroid_in_model;
  AbsoluteReport report =
      control_report(fit, turned, {found.sigma0, found.redundancy, fit.sigmas_are_stated, alpha});
  report.iterations = found.iterations;
  for (std::size_t i = 0; i < fit.pairs.size(); ++i) {
    const GroundPoint at = on_ground(turned, fit.pairs[i].in_model, fit.pairs[i].model_covariance);
    report.ground.push_back({fit.names[i], at.position, at.covariance.diagonal().cwiseSqrt()});
  }
  return report;
}

}  // namespace collinea
