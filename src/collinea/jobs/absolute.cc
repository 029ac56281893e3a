// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/absolute.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "collinea/base/file.h"
#include "collinea/geometry/absolute_orientation.h"
#include "collinea/geometry/closed_similarity.h"
#include "collinea/geometry/plane_similarity.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/control_fit.h"
#include "collinea/jobs/internal/ground_table.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kAssumedGroundSigma_m = 0.01;

struct ModelTable {
  std::vector<std::string> names;
  std::vector<Vector3d> points;
  std::vector<Matrix3d> covariances;
  std::optional<MatrixXd> full;  // of all
  bool states_sigmas = false;
};

Result<std::vector<Vector3d>> columns(const TextTable& table, const std::array<const char*, 3>& names,
                                      std::optional<double> fallback, std::string_view unit) {
  std::vector<Vector3d> out(table.rows.size());
  for (int axis = 0; axis < 3; ++axis) {
    const char* name = names[static_cast<std::size_t>(axis)];
    COLLINEA_TRY(const auto values, fallback ? table.numbers_or(name, unit, *fallback) : table.numbers(name, unit));
    for (std::size_t i = 0; i < out.size(); ++i) out[i][axis] = values[i];
  }
  return out;
}

Result<ModelTable> read_model(const std::filesystem::path& path, const OrientAbsoluteOptions& options) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  ModelTable model;
  COLLINEA_TRY(model.names, table.words("point").map_error(in_file));
  std::set<std::string> seen;
  for (const std::string& name : model.names)
    if (!seen.insert(name).second)
      return fail(Errc::kBadFormat, fmt::format("{}: point {} is there twice", path.string(), name));
  const bool is_plane = options.method == AbsoluteMethod::kPlane;
  COLLINEA_TRY(model.points,
               columns(table, {"U", "V", "W"}, is_plane ? std::optional(0.0) : std::nullopt, "m").map_error(in_file));
  model.states_sigmas = table.has("sigma_U") || options.sigma_model.value_or(0) > 0;
  COLLINEA_TRY(
      const auto sigmas,
      columns(table, {"sigma_U", "sigma_V", "sigma_W"}, options.sigma_model.value_or(0), "m").map_error(in_file));
  COLLINEA_TRY(const auto correlations,
               columns(table, {"correlation_UV", "correlation_UW", "correlation_VW"}, 0.0, "1").map_error(in_file));
  for (std::size_t i = 0; i < sigmas.size(); ++i) {
    const Vector3d &s = sigmas[i], &r = correlations[i];
    Matrix3d c;
    c << s[0] * s[0], r[0] * s[0] * s[1], r[1] * s[0] * s[2],  //
        r[0] * s[0] * s[1], s[1] * s[1], r[2] * s[1] * s[2],   //
        r[1] * s[0] * s[2], r[2] * s[1] * s[2], s[2] * s[2];
    model.covariances.push_back(c);
  }
  return model;
}

Result<MatrixXd> read_covariance(const std::filesystem::path& path, const ModelTable& model) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  std::array<std::vector<std::string>, 4> keys;
  const std::array<const char*, 4> names{"point_1", "axis_1", "point_2", "axis_2"};
  for (std::size_t k = 0; k < 4; ++k) {
    COLLINEA_TRY(keys[k], table.words(names[k]).map_error(in_file));
  }
  COLLINEA_TRY(const auto values, table.numbers("covariance", "1").map_error(in_file));
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < model.names.size(); ++i) index[model.names[i]] = static_cast<int>(3 * i);
  const auto size = static_cast<Eigen::Index>(3 * model.names.size());
  MatrixXd full = MatrixXd::Zero(size, size);
  for (std::size_t row = 0; row < values.size(); ++row) {
    std::array<int, 2> at{};
    for (std::size_t side = 0; side < 2; ++side) {
      const std::string &point = keys[2 * side][row], &axis = keys[2 * side + 1][row];
      const auto found = index.find(point);
      const auto number = std::string("UVW").find(axis);
      if (found == index.end() || axis.size() != 1 || number == std::string::npos)
        return fail(Errc::kBadFormat, fmt::format("{}: row {}: {} {} is no coordinate of the model", path.string(),
                                                  row + 1, point, axis));
      at[side] = found->second + static_cast<int>(number);
    }
    full(at[0], at[1]) = full(at[1], at[0]) = values[row];
  }
  return full;
}

Result<GroundTable> read_ground(const std::filesystem::path& path, const OrientAbsoluteOptions& options) {
  COLLINEA_TRY(GroundTable ground, read_ground_table(path, options.sigma_ground.value_or(0), false));
  ground.states_sigmas |= options.sigma_ground.has_value();
  for (const GroundTablePoint& point : ground.points)
    if (!point.has_plan() && !point.position.head<2>().array().isNaN().all())
      return fail(Errc::kBadFormat, fmt::format("{}: point {} has one of X and Y only", path.string(), point.name));
  return ground;
}

// What both tables have.
struct Control {
  ModelTable model;
  GroundTable ground;
  std::vector<std::size_t> common;  // indices of the model
  ControlFit fit;                   // of them
};

// The part of a covariance of all points of the model that belongs to some of them.
MatrixXd part_of(const MatrixXd& full, const std::vector<std::size_t>& points) {
  const auto size = static_cast<Eigen::Index>(3 * points.size());
  MatrixXd part(size, size);
  for (std::size_t a = 0; a < points.size(); ++a)
    for (std::size_t b = 0; b < points.size(); ++b)
      part.block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b)) =
          full.block<3, 3>(Eigen::Index(3 * points[a]), Eigen::Index(3 * points[b]));
  return part;
}

Result<Control> read_control(const std::filesystem::path& model, const std::filesystem::path& ground,
                             const OrientAbsoluteOptions& options) {
  Control control;
  COLLINEA_TRY(control.model, read_model(model, options));
  if (options.model_covariance) {
    COLLINEA_TRY(control.model.full, read_covariance(*options.model_covariance, control.model));
    control.model.states_sigmas = true;
  }
  COLLINEA_TRY(control.ground, read_ground(ground, options));
  control.fit.sigmas_are_stated = control.model.states_sigmas || control.ground.states_sigmas;
  std::set<std::string> checks;
  for (const std::string_view name : fields_of(options.check, ','))
    if (!name.empty()) checks.insert(std::string(name));
  for (std::size_t i = 0; i < control.model.names.size(); ++i) {
    const GroundTablePoint* found = control.ground.find(control.model.names[i]);
    if (!found) continue;
    AbsoluteControl pair{control.model.points[i], control.model.covariances[i], found->position, Matrix3d::Zero(),
                         found->has_plan(),       found->has_height()};
    if (control.model.full)
      pair.model_covariance = control.model.full->block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * i));
    Vector3d sigma = control.fit.sigmas_are_stated ? found->sigma : Vector3d::Constant(kAssumedGroundSigma_m);
    for (int axis = 0; axis < 3; ++axis)
      if (!std::isfinite(found->position[axis])) sigma[axis] = 0;  // not looked at
    pair.ground_covariance = sigma.cwiseAbs2().asDiagonal();
    control.common.push_back(i);
    control.fit.names.push_back(control.model.names[i]);
    control.fit.pairs.push_back(pair);
    control.fit.is_check.push_back(checks.erase(control.model.names[i]) > 0);
  }
  if (control.model.full) control.fit.model_covariance = part_of(*control.model.full, control.common);
  control.fit.is_rejected.assign(control.fit.pairs.size(), false);
  if (!checks.empty())
    return fail(Errc::kBadInput, fmt::format("check point {} is not in both tables", *checks.begin()),
                {"check"_option});
  if (control.common.empty())
    return fail(Errc::kIllPosed, fmt::format("no point of {} is in {}", model.string(), ground.string()));
  return control;
}

AbsoluteReport report_of(const Control& control, const AbsoluteOrientation& found, const VarianceTest& variance,
                         bool is_rigorous) {
  AbsoluteReport report = control_report(control.fit, found, variance, is_rigorous);
  for (std::size_t i = 0; i < control.model.names.size(); ++i) {
    const Matrix3d own = control.model.full
                             ? Matrix3d(control.model.full->block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * i)))
                             : control.model.covariances[i];
    const GroundPoint at = on_ground(found, control.model.points[i], own);
    report.ground.push_back(
        {control.model.names[i], at.position, variance.factor() * at.covariance.diagonal().cwiseSqrt()});
  }
  return report;
}

Result<AbsoluteReport> by_least_squares(Control& control, const OrientAbsoluteOptions& options) {
  if (options.least_median) {
    const std::vector<std::size_t> used = control.fit.used();
    const auto wrong = contradicting_control(control.fit.used_pairs(), options.seed);
    if (!wrong)
      return fail(Errc::kIllPosed,
                  "the least median of squares needs four full points, of which those that agree are not on a line",
                  {"least_median"_option});
    for (const std::size_t k : *wrong) control.fit.is_rejected[used[k]] = true;
  }
  COLLINEA_TRY(const AbsoluteOrientation found, fitted_with_rejection(control.fit, options.reject, options.alpha));
  AbsoluteReport report =
      report_of(control, found, {found.sigma0, found.redundancy, control.fit.sigmas_are_stated, options.alpha}, true);
  report.iterations = found.iterations;
  return report;
}

Result<AbsoluteReport> in_closed_form(const Control& control, const OrientAbsoluteOptions& options) {
  std::vector<Vector3d> model, ground;
  for (const std::size_t k : control.fit.used())
    if (control.fit.pairs[k].is_full()) {
      model.push_back(control.fit.pairs[k].in_model);
      ground.push_back(control.fit.pairs[k].in_ground);
    }
  std::optional<Similarity3> found;
  if (options.method == AbsoluteMethod::kUmeyama) found = align(model, ground);
  if (options.method == AbsoluteMethod::kQuaternion) found = align_by_quaternion(model, ground);
  if (options.method == AbsoluteMethod::kRodrigues)
    if (const auto linear = align_by_rodrigues(model, ground)) found = linear->b_from_a;
  if (!found)
    return fail(Errc::kIllPosed,
                fmt::format("a closed form needs three full points that do not lie on a line, there are {} full ones",
                            model.size()),
                {"method"_option});
  AbsoluteOrientation orientation;
  orientation.ground_from_model = *found;
  AbsoluteReport report = report_of(control, orientation, {}, false);
  report.closed_form = word_of(options.method);
  return report;
}

std::vector<Estimate> estimates_of(const PlaneSimilarity& p, double factor, const char* x, const char* y) {
  const auto sigma = [&](int i) { return factor * std::sqrt(p.covariance(i, i)); };
  return {{x, "m", p.shift.x(), sigma(0)},
          {y, "m", p.shift.y(), sigma(1)},
          {"scale", "", p.scale, sigma(2)},
          {"angle", "deg", p.angle_rad * kDegrees, sigma(3) * kDegrees}};
}

Result<AbsoluteReport> in_plane(const Control& control, const OrientAbsoluteOptions& options) {
  std::vector<PlanePair> pairs;
  std::vector<std::size_t> used;
  for (const std::size_t k : control.fit.used()) {
    const AbsoluteControl& pair = control.fit.pairs[k];
    if (!pair.has_plan) continue;
    pairs.push_back({pair.in_model.head<2>(), pair.in_ground.head<2>(), pair.model_covariance.topLeftCorner<2, 2>(),
                     pair.ground_covariance.topLeftCorner<2, 2>()});
    used.push_back(k);
  }
  const auto fit = fit_plane_similarity(pairs);
  if (!fit)
    return fail(Errc::kIllPosed,
                "a plane similarity needs two points apart that are known in plan, with sigmas above 0");
  AbsoluteReport report;
  report.is_plane = report.is_rigorous = true;
  report.variance = {fit->sigma0, fit->redundancy, control.fit.sigmas_are_stated, options.alpha};
  const double factor = report.variance.factor();
  report.parameters = estimates_of(fit->b_from_a, factor, "X0", "Y0");
  report.inverse_parameters = estimates_of(inverse(fit->b_from_a), factor, "U0", "V0");
  report.covariance = fit->b_from_a.covariance;
  report.full = static_cast<int>(pairs.size());
  const auto lifted = [](const Eigen::Vector2d& v) { return Vector3d(v.x(), v.y(), 0); };
  for (std::size_t k = 0; k < control.fit.pairs.size(); ++k) {
    const AbsoluteControl& pair = control.fit.pairs[k];
    AbsoluteReport::Point point{control.model.names[control.common[k]],
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                pair.has_plan,
                                false,
                                control.fit.is_check[k],
                                false};
    point.misfit = lifted(pair.in_ground.head<2>() - fit->b_from_a * pair.in_model.head<2>());
    const auto found = std::find(used.begin(), used.end(), k);
    if (found != used.end()) {
      const auto i = static_cast<std::size_t>(found - used.begin());
      point.sigma = factor * lifted(fit->sigmas[i]);
      point.redundancy = lifted(fit->redundancies[i]);
      point.w = lifted(fit->w[i]) / factor;
    }
    report.points.push_back(std::move(point));
  }
  for (std::size_t i = 0; i < control.model.names.size(); ++i) {
    const Eigen::Vector2d u = control.model.points[i].head<2>(), x = fit->b_from_a * u;
    const Eigen::Vector2d arm = fit->b_from_a.matrix() * u;
    Eigen::Matrix<double, 2, 4> by;
    by << 1, 0, arm.x() / fit->b_from_a.scale, -arm.y(), 0, 1, arm.y() / fit->b_from_a.scale, arm.x();
    const Eigen::Matrix2d own = fit->b_from_a.matrix() * control.model.covariances[i].topLeftCorner<2, 2>() *
                                fit->b_from_a.matrix().transpose();
    const Eigen::Matrix2d covariance = by * fit->b_from_a.covariance * by.transpose() + own;
    report.ground.push_back({control.model.names[i], lifted(x), lifted(factor * covariance.diagonal().cwiseSqrt())});
  }
  return report;
}

}  // namespace

Result<AbsoluteReport> orient_absolutely(const std::filesystem::path& model, const std::filesystem::path& ground,
                                         const OrientAbsoluteOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(Control control, read_control(model, ground, options));
  if (options.method == AbsoluteMethod::kLeastSquares) return by_least_squares(control, options);
  if (options.method == AbsoluteMethod::kPlane) return in_plane(control, options);
  return in_closed_form(control, options);
}

}  // namespace collinea
