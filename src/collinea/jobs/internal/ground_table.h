// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// A point of a table of ground coordinates: what it does not state is not a number, with an infinite sigma.
struct GroundTablePoint {
  std::string name;
  Eigen::Vector3d position, sigma;

  [[nodiscard]] bool has_plan() const { return position.head<2>().allFinite(); }
  [[nodiscard]] bool has_height() const { return std::isfinite(position.z()); }
};

struct GroundTable {
  TextTable table;  ///< for further columns of the same rows
  std::vector<GroundTablePoint> points;
  bool states_sigmas = false;

  /// Nothing where the table has no such point.
  [[nodiscard]] const GroundTablePoint* find(const std::string& name) const;

 private:
  friend Result<GroundTable> read_ground_table(const std::filesystem::path& path, double sigma_m, bool needs_height);
  std::map<std::string, std::size_t> index_;
};

/// Columns point, X, Y, Z [m], sigma_X, sigma_Y, sigma_Z; `sigma_m` where none is stated. Errors: columns (Z may be
/// missing where no height is needed), a point twice, a negative sigma.
[[nodiscard]] Result<GroundTable> read_ground_table(const std::filesystem::path& path, double sigma_m,
                                                    bool needs_height);

}  // namespace collinea
