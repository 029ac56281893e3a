// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace collinea {

/// How the standard deviations of the two coordinates of an image point differ, and how these are correlated. With the
/// standard deviation s of the column the covariance of column and row is
///
///     s^2 ( 1,    q rho )
///         ( q rho, q^2  )      q = row_over_column, rho = correlation
///
/// Almost all measurements are round: one standard deviation for both, no correlation.
struct PixelShape {
  float row_over_column = 1;  ///< standard deviation of the row over that of the column, above 0
  float correlation = 0;      ///< of column and row, between -1 and 1 but neither

  bool operator==(const PixelShape&) const = default;
  [[nodiscard]] bool is_round() const { return row_over_column == 1 && correlation == 0; }
  /// It is that of a covariance.
  [[nodiscard]] bool is_valid() const {
    return std::isfinite(row_over_column) && row_over_column > 0 && std::abs(correlation) < 1;
  }

  /// The covariance over s^2.
  [[nodiscard]] Eigen::Matrix2d covariance() const {
    const double q = row_over_column, mixed = q * double(correlation);
    return (Eigen::Matrix2d() << 1, mixed, mixed, q * q).finished();
  }
  /// W with W covariance() W' = I and W' W = covariance()^-1, lower triangular: W (column, row)' / s are two
  /// independent observations of unit weight.
  [[nodiscard]] Eigen::Matrix2d whitening() const {
    const double root = std::sqrt((1 - double(correlation)) * (1 + double(correlation)));
    return (Eigen::Matrix2d() << 1, 0, -double(correlation) / root, 1 / (row_over_column * root)).finished();
  }
};

}  // namespace collinea
