// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>
#include <optional>

namespace collinea {

/// The surface of second degree through 3 x 3 responses, by least squares.
struct ResponseParaboloid {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  Eigen::Matrix2d curvature = Eigen::Matrix2d::Zero();  ///< second derivatives

  /// `response(x, y)` for x, y = -1, 0, 1.
  template <class Response>
  explicit ResponseParaboloid(const Response& response) {
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const double value = response(x, y);
        slope += Eigen::Vector2d(x, y) * value / 6;
        curvature += by_curvature(x, y) * value;
      }
  }
  /// How slope and second derivatives change with a response.
  [[nodiscard]] static Eigen::Vector2d by_slope(int x, int y) { return Eigen::Vector2d(x, y) / 6; }
  [[nodiscard]] static Eigen::Matrix2d by_curvature(int x, int y) {
    Eigen::Matrix2d out;
    out << x * x - 2.0 / 3, x * y / 4.0, x * y / 4.0, y * y - 2.0 / 3;
    return out;
  }
  /// Where its top lies from the middle; nothing where it has none within a pixel.
  [[nodiscard]] std::optional<Eigen::Vector2d> top() const {
    if (!(curvature.determinant() > 0 && curvature.trace() < 0)) return std::nullopt;
    const Eigen::Vector2d shift = -(curvature.inverse() * slope);
    if (!(shift.cwiseAbs().maxCoeff() <= 1)) return std::nullopt;
    return shift;
  }
  /// Whether it is a ridge: its two curvatures differ by more than the largest elongation of a blob (Lowe 2004).
  [[nodiscard]] bool is_ridge() const {
    constexpr double kElongation = 10, kMost = (kElongation + 1) * (kElongation + 1) / kElongation;
    const double det = curvature.determinant(), trace = curvature.trace();
    return !(det > 0) || trace * trace > kMost * det;
  }
};

}  // namespace collinea
