// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "collinea/report/relative_report.h"

namespace collinea::relative {

// Elements and residuals of a pair, in the units for people.

inline constexpr double kDegrees = 180 / std::numbers::pi;

// One element of the orientation, in the unit for people.
struct Element {
  std::string name;
  double value, sigma;
  std::string unit;
};

inline std::vector<Element> elements_of(const Vector5& values, const Matrix5& covariance,
                                        const std::array<const char*, 5>& names, int lengths) {
  std::vector<Element> out;
  for (int i = 0; i < 5; ++i) {
    const double factor = i < lengths ? 1 : kDegrees;
    out.push_back({names[static_cast<std::size_t>(i)], values(i) * factor,
                   std::sqrt(std::max(0.0, covariance(i, i))) * factor, i < lengths ? "1" : "deg"});
  }
  return out;
}

inline Matrix5 covariance_by(const Matrix5& by, const RelativeOrientation& orientation) {
  return by * orientation.stated_covariance() * by.transpose();
}

inline std::optional<DependentWithCovariance> dependent(const RelativeReport& report) {
  const Rigid3& motion = report.orientation.second_from_first;
  const auto elements = dependent_elements(motion);
  if (!elements) return std::nullopt;
  return DependentWithCovariance{*elements, covariance_by(dependent_by_change(motion), report.orientation)};
}

inline SymmetricWithCovariance symmetric(const RelativeReport& report) {
  const Rigid3& motion = report.orientation.second_from_first;
  return {symmetric_elements(motion), covariance_by(symmetric_by_change(motion), report.orientation)};
}

inline std::vector<Element> dependent_list(const DependentWithCovariance& d) {
  return elements_of(d.elements.values(), d.covariance, {"by", "bz", "omega", "phi", "kappa"}, 2);
}

inline std::vector<Element> symmetric_list(const SymmetricWithCovariance& s) {
  return elements_of(s.elements.values(), s.covariance, {"phi1", "kappa1", "omega2", "phi2", "kappa2"}, 0);
}

// Residuals in the unit and the axes of the table.
inline Eigen::Vector4d residual_of(const RelativeReport& report, std::size_t i) {
  const PairResidual& residual = report.orientation.residuals[i];
  const double f = report.frame.camera.focal_px();
  Eigen::Vector4d v;
  v << residual.first * f, residual.second * report.second_principal_distance.value_or(f);
  if (report.frame.y_up) {
    v(1) = -v(1);
    v(3) = -v(3);
  }
  return v;
}

inline double unit_weight(const RelativeReport& report) { return std::sqrt(report.orientation.variance_factor); }

inline std::string value(double v) { return fmt::format("{:.9g}", v); }

// 0 where one of the two is exact.
inline double correlation_of(const Matrix5& covariance, Eigen::Index row, Eigen::Index column) {
  const double product = covariance(row, row) * covariance(column, column);
  return product > 0 ? covariance(row, column) / std::sqrt(product) : 0;
}

}  // namespace collinea::relative
