// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_tables.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "collinea/base/nearest_names.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kShareOfExtent = 1e-4;

// Three columns, whose names end in those letters.
Result<std::vector<Vector3d>> columns(const TextTable& table, const std::string& prefix, const std::string& letters,
                                      std::string_view unit, double fallback, bool needed) {
  std::vector<Vector3d> rows(table.rows.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = prefix + letters[axis];
    COLLINEA_TRY(const auto values, needed ? table.numbers(name, unit) : table.numbers_or(name, unit, fallback));
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i][static_cast<Index>(axis)] = values[i];
  }
  return rows;
}

// Standard deviations of three axes, of columns of their own or of one for all; `fallback` where none is given.
Result<std::vector<Vector3d>> sigmas(const TextTable& table, const std::string& letters, std::string_view unit,
                                     double fallback) {
  COLLINEA_TRY(const auto common, table.numbers_or("sigma", unit, fallback));
  std::vector<Vector3d> rows(table.rows.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    COLLINEA_TRY(const auto values, table.numbers_or(std::string("sigma_") + letters[axis], unit, kNaN));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double value = std::isnan(values[i]) ? common[i] : values[i];
      if (value < 0) return fail(Errc::kBadInput, fmt::format("row {} of the table: a sigma is below 0", i + 1));
      rows[i][static_cast<Index>(axis)] = value;
    }
  }
  return rows;
}

double extent_of(const StereoModel& model) {
  Vector3d centre = Vector3d::Zero();
  double squares = 0;
  for (const NamedPoint& point : model.points) centre += point.position / double(model.points.size());
  for (const NamedPoint& point : model.points) squares += (point.position - centre).squaredNorm();
  return std::sqrt(squares / double(model.points.size()));
}

// What no row states: that of --sigma, or a guess.
void guess(GivenModels& given, std::optional<double> sigma) {
  double extent = 0;
  for (const StereoModel& model : given.models) extent += extent_of(model) / double(given.models.size());
  given.sigma = sigma.value_or(kShareOfExtent * (extent > 0 ? extent : 1));
  for (StereoModel& model : given.models)
    for (NamedPoint& point : model.points) point.covariance = Matrix3d::Identity() * given.sigma * given.sigma;
}

// Index of a point in a model; an error names both.
Result<Index> index_in(const StereoModel& model, const std::map<std::string, Index>& indices,
                       const std::string& point) {
  const auto found = indices.find(point);
  if (found == indices.end())
    return fail(Errc::kNotFound, fmt::format("covariances: model {} has no point {}", model.name, point));
  return found->second;
}

}  // namespace

Result<GivenModels> models_of(const TextTable& table, std::optional<double> sigma) {
  GivenModels given;
  if (!table.unit_of("U").empty()) given.unit = table.unit_of("U");
  COLLINEA_TRY(const auto names, table.words("model"));
  COLLINEA_TRY(const auto points, table.words("point"));
  COLLINEA_TRY(const auto positions, columns(table, "", "UVW", given.unit, kNaN, true));
  COLLINEA_TRY(const auto stated, sigmas(table, "UVW", given.unit, kNaN));
  std::map<std::string, std::size_t> index;
  std::size_t without = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [found, is_new] = index.try_emplace(names[i], given.models.size());
    if (is_new) given.models.push_back({names[i], {}, {}});
    without += stated[i].array().isNaN().any() ? 1 : 0;
    given.models[found->second].points.push_back(
        {points[i], positions[i], stated[i].cwiseAbs2().asDiagonal().toDenseMatrix()});
  }
  if (without > 0 && without < names.size())
    return fail(Errc::kBadInput,
                fmt::format("{} of {} rows of the models state no standard deviation; state all or none", without,
                            names.size()));
  given.sigmas_given = without == 0 || sigma.has_value();
  if (without > 0) guess(given, sigma);
  return given;
}

Result<> add_covariances(GivenModels& given, const TextTable& table) {
  static constexpr std::array<const char*, 9> kElements = {"UU", "UV", "UW", "VU", "VV", "VW", "WU", "WV", "WW"};
  COLLINEA_TRY(const auto names, table.words("model"));
  COLLINEA_TRY(const auto firsts, table.words("point"));
  COLLINEA_TRY(const auto seconds, table.words("other"));
  std::array<std::vector<double>, 9> values;
  for (std::size_t e = 0; e < 9; ++e) {
    COLLINEA_TRY(values[e], table.numbers(kElements[e], ""));
  }
  std::map<std::string, StereoModel*> models;
  std::map<std::string, std::map<std::string, Index>> indices;
  for (StereoModel& model : given.models) {
    models[model.name] = &model;
    for (std::size_t i = 0; i < model.points.size(); ++i)
      indices[model.name][model.points[i].name] = static_cast<Index>(i);
  }
  std::map<std::string, std::set<std::pair<Index, Index>>> seen;
  for (std::size_t row = 0; row < names.size(); ++row) {
    if (!models.contains(names[row]))
      return fail(Errc::kNotFound, fmt::format("covariances: there is no model {}", names[row]));
    StereoModel& model = *models[names[row]];
    COLLINEA_TRY(const Index i, index_in(model, indices[model.name], firsts[row]));
    COLLINEA_TRY(const Index k, index_in(model, indices[model.name], seconds[row]));
    const auto n = static_cast<Index>(model.points.size());
    if (model.covariance.size() == 0) model.covariance.setZero(3 * n, 3 * n);
    if (!seen[model.name].insert(std::minmax(i, k)).second)
      return fail(Errc::kBadInput, fmt::format("covariances: model {} has points {} and {} twice", model.name,
                                               firsts[row], seconds[row]));
    Matrix3d block;
    for (int e = 0; e < 9; ++e) block(e / 3, e % 3) = values[static_cast<std::size_t>(e)][row];
    if (i == k && (block - block.transpose()).norm() > 1e-9 * block.norm())
      return fail(Errc::kBadInput,
                  fmt::format("covariances: that of point {} in model {} is not symmetric", firsts[row], model.name));
    model.covariance.block<3, 3>(3 * i, 3 * k) = block;
    model.covariance.block<3, 3>(3 * k, 3 * i) = block.transpose();
    if (i == k) model.points[static_cast<std::size_t>(i)].covariance = block;
  }
  given.sigmas_given |= !seen.empty();
  return {};
}

Result<std::vector<SurveyedPoint>> surveyed_points_of(const TextTable& table, double sigma_m) {
  COLLINEA_TRY(const auto names, table.words("point"));
  COLLINEA_TRY(const auto positions, columns(table, "", "XYZ", "m", kNaN, false));
  COLLINEA_TRY(const auto stated, sigmas(table, "XYZ", "m", sigma_m));
  std::vector<std::string> roles(names.size());
  if (table.has("role")) {
    COLLINEA_TRY(roles, table.words("role"));
  }
  std::vector<SurveyedPoint> points;
  for (std::size_t i = 0; i < names.size(); ++i) {
    SurveyedPoint point{names[i], positions[i], stated[i], roles[i] == "check"};
    if (!roles[i].empty() && roles[i] != "-" && roles[i] != "check" && roles[i] != "control")
      return fail(Errc::kBadInput,
                  fmt::format("point {}: \"{}\" is no role; it is control or check", names[i], roles[i]));
    if (std::isnan(point.position.x()) != std::isnan(point.position.y()))
      return fail(Errc::kBadInput, fmt::format("point {}: X and Y are given together or not at all", names[i]));
    if (point.position.array().isNaN().all())
      return fail(Errc::kBadInput, fmt::format("point {} has no coordinates", names[i]));
    for (int axis = 0; axis < 3; ++axis)
      if (std::isnan(point.position[axis])) {
        point.position[axis] = 0;
        point.sigma[axis] = std::numeric_limits<double>::infinity();
      }
    points.push_back(point);
  }
  return points;
}

}  // namespace collinea
