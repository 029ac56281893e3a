// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "collinea/base/words.h"

namespace collinea {

/// Functions of the position in the image that are added to the pixel on top of any camera model, for what a lens
/// polynomial does not say: film, mirrors, the support of a sensor, images put together from several.
enum class AdditionalSet : std::uint8_t {
  kNone,
  kPolynomial,  ///< complete polynomials of the third degree: 14
  kEbner,       ///< Ebner (1976), products of polynomials orthogonal on 3 x 3 positions: 12
  kGruen,       ///< Gruen (1978), the same on 5 x 5 positions: 44
  kFourier,     ///< Tang, Fritsch and Cramer (2012), first degree: 16
};
inline constexpr Word<AdditionalSet> kAdditionalWords[] = {{AdditionalSet::kNone, "none"},
                                                           {AdditionalSet::kPolynomial, "polynomial"},
                                                           {AdditionalSet::kEbner, "ebner"},
                                                           {AdditionalSet::kGruen, "gruen"},
                                                           {AdditionalSet::kFourier, "fourier"}};
[[nodiscard]] constexpr std::span<const Word<AdditionalSet>> words(AdditionalSet) { return kAdditionalWords; }
inline constexpr auto kAdditionalNames = only_words(kAdditionalWords);  ///< by the values
inline constexpr std::size_t kMostAdditional = 44;

[[nodiscard]] std::size_t count_of(AdditionalSet set);

/// What one parameter of size 1 px adds to column and row [px].
struct AdditionalEffect {
  std::array<double, kMostAdditional> column{}, row{};
};

/// What the whole set adds to a pixel [px], and its derivatives by that pixel.
struct AdditionalShift {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Zero();
};

/// The image over which the functions are normalised: from its middle, in halves of its sides, -1 to 1.
struct ImageExtent {
  double width_px = 1, height_px = 1;
};

[[nodiscard]] AdditionalShift additional_shift(AdditionalSet set, const double* values, ImageExtent size,
                                               const Eigen::Vector2d& pixel);
void additional_effect(AdditionalSet set, ImageExtent size, const Eigen::Vector2d& pixel, AdditionalEffect& effect);

}  // namespace collinea
