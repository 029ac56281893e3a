// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

namespace collinea {

/// Null for what is not known.
inline nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

inline nlohmann::ordered_json vector(const Eigen::Vector3d& v) { return {number(v.x()), number(v.y()), number(v.z())}; }

}  // namespace collinea
