// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/exterior_table.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <array>
#include <vector>

#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/pose_estimates.h"

namespace collinea {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kRounding = 1e-3;  // of correlations written with three decimals
constexpr std::array<const char*, 6> kNames{"X", "Y", "Z", "omega", "phi", "kappa"};

// Correlations of the six elements of each row: columns correlation_X_Y and so on, 0 where there are none. What
// rounding leaves of a singular matrix is made positive semi-definite again; what is none at all is refused.
Result<std::vector<Matrix6>> read_correlations(const TextTable& table) {
  std::vector<Matrix6> out(table.rows.size(), Matrix6::Identity());
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k) {
      if (i == k) continue;
      const std::string name = fmt::format("correlation_{}_{}", kNames[k], kNames[i]);
      if (!table.has(name)) continue;
      COLLINEA_TRY(const auto column, table.numbers_or(name, "", 0));
      for (std::size_t row = 0; row < column.size(); ++row)
        out[row](Eigen::Index(i), Eigen::Index(k)) = out[row](Eigen::Index(k), Eigen::Index(i)) = column[row];
    }
  for (std::size_t row = 0; row < out.size(); ++row) {
    const Eigen::SelfAdjointEigenSolver<Matrix6> solver(out[row]);
    if (!(solver.eigenvalues()(0) > -kRounding))
      return fail(Errc::kBadFormat, fmt::format("row {}: its correlations contradict each other", row + 1));
    out[row] =
        solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() * solver.eigenvectors().transpose();
  }
  return out;
}

}  // namespace

const UncertainPose* ExteriorTable::find(std::span<const std::string> names) const {
  for (const std::string& name : names) {
    const auto found = images.find(name);
    if (found != images.end()) return &found->second;
  }
  const auto stem_of = [](const std::string& name) { return std::filesystem::path(name).stem(); };
  for (const std::string& name : names)
    for (const auto& [image, pose] : images)
      if (stem_of(image) == stem_of(name)) return &pose;
  return nullptr;
}

Result<ExteriorTable> read_exterior_table(const std::filesystem::path& path) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  COLLINEA_TRY(const auto names, table.words("image").map_error(in_file));
  COLLINEA_TRY(const auto correlations, read_correlations(table).map_error(in_file));
  ExteriorTable out;
  out.is_metric = !table.unit_of("X").empty();
  std::vector<Vector6> values(names.size()), sigmas(names.size());
  for (std::size_t k = 0; k < 6; ++k) {
    const std::string_view unit = k < 3 ? "m" : "deg";
    COLLINEA_TRY(const auto column, table.numbers(kNames[k], unit).map_error(in_file));
    const std::string sigma_name = std::string("sigma_") + kNames[k];
    out.has_sigmas |= table.has(sigma_name);
    COLLINEA_TRY(const auto sigma, table.numbers_or(sigma_name, unit, 0).map_error(in_file));
    for (std::size_t i = 0; i < names.size(); ++i) {
      values[i][Eigen::Index(k)] = column[i];
      sigmas[i][Eigen::Index(k)] = sigma[i];
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Vector6& v = values[i];
    UncertainPose one;
    one.cam_from_world.rotation = cam_from_world({v[3], v[4], v[5]});
    one.cam_from_world.translation = -(one.cam_from_world.rotation * v.head<3>());
    const Matrix6 of_elements = sigmas[i].asDiagonal() * correlations[i] * sigmas[i].asDiagonal();
    one.covariance = covariance_of_pose(one.cam_from_world, of_elements);
    if (!one.covariance.allFinite()) one.covariance.setZero();
    if (!out.images.emplace(names[i], one).second)
      return fail(Errc::kBadFormat, fmt::format("{}: image {} is there twice", path.string(), names[i]));
  }
  return out;
}

}  // namespace collinea
