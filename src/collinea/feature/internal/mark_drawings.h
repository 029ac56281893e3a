// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "collinea/feature/mark_model.h"

namespace collinea {

/// A drawing at three widths of blur, from narrow to wide, or at one.
struct Drawings {
  std::array<const MarkTemplate*, 3> at{};
  std::size_t count = 1;

  [[nodiscard]] const MarkTemplate& middle() const { return *at[count / 2]; }
  [[nodiscard]] double blur_px2(std::size_t k) const { return at[k]->blur_px * at[k]->blur_px; }
};

/// Shares of the drawings at a blur, and their derivatives by it: Lagrange's parabola through the three in the square
/// of the width, in which blurred light is smooth (heat equation). A mixture of two has longer tails than any blur.
struct Mixture {
  std::array<double, 3> share{1, 0, 0}, by_blur{};
};
[[nodiscard]] Mixture mixture_at(const Drawings& drawings, double blur_px2);

/// The value of a drawing.
struct DrawnSample {
  double value = 0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  ///< by the position in pixels of the raster
  double by_blur = 0;
};

/// By Catmull and Rom's cubics. Nothing within a cell and a half of the border.
[[nodiscard]] std::optional<DrawnSample> sample(const Drawings& drawings, const Mixture& mixture,
                                                const Eigen::Vector2d& at);

}  // namespace collinea
