// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/absolute_tables.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "collinea/io/text.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
constexpr double kAssumedGroundSigma_m = 0.01;

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

}  // namespace

Result<AbsoluteTables> read_absolute_tables(const std::filesystem::path& model, const std::filesystem::path& ground,
                                            const OrientAbsoluteOptions& options) {
  AbsoluteTables control;
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

}  // namespace collinea
