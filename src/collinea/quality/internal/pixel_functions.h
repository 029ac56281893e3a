// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/camera/additional.h"

namespace collinea::bundle {

/// Functions of the position in the image that every set of additional parameters consists of, for the columns and for
/// the rows of the camera alike: monomials and waves of normalised coordinates.
class PixelFunctions {
 public:
  static constexpr int kMost = 33;
  /// `with_gruen`: monomials up to the fourth degree in either coordinate instead of those of the smaller sets.
  explicit PixelFunctions(bool with_gruen);
  [[nodiscard]] int count() const { return count_; }
  /// The number of the monomial x^a y^b, which is there.
  [[nodiscard]] int number_of(int a, int b) const;
  /// Their values at a pixel; out has count() elements.
  void at(const ImageExtent& size, const double* pixel, double* out) const;
  /// The parameters of a set by the functions (2 count(), first those of columns, then of rows). Nothing when they do
  /// not span the set.
  [[nodiscard]] std::optional<Eigen::MatrixXd> combination_of(AdditionalSet set, const ImageExtent& size) const;

 private:
  std::vector<std::array<int, 2>> powers_;
  int count_;
};

}  // namespace collinea::bundle
