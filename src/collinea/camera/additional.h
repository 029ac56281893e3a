// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <ranges>
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
  kFilm,        ///< of one scan of film: Legendre's polynomials up to the sixth degree (camera/film_prior.h): 56
};
/// Those that can be chosen; the set of film comes with its scans.
inline constexpr Word<AdditionalSet> kAdditionalWords[] = {{AdditionalSet::kNone, "none"},
                                                           {AdditionalSet::kPolynomial, "polynomial"},
                                                           {AdditionalSet::kEbner, "ebner"},
                                                           {AdditionalSet::kGruen, "gruen"},
                                                           {AdditionalSet::kFourier, "fourier"}};
[[nodiscard]] constexpr std::span<const Word<AdditionalSet>> words(AdditionalSet) { return kAdditionalWords; }
/// Of all, by the values.
inline constexpr std::array<std::string_view, 6> kAdditionalNames = {"none",  "polynomial", "ebner",
                                                                     "gruen", "fourier",    "film"};
static_assert(std::ranges::equal(only_words(kAdditionalWords), kAdditionalNames | std::views::take(5)));
inline constexpr std::size_t kFilmFunctions = 28;  ///< products of Legendre's polynomials up to a degree of six
inline constexpr std::size_t kMostAdditional = 2 * kFilmFunctions;

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
/// The functions of kFilm at a pixel: of them, the parameter 2 k adds function k to the column, 2 k + 1 to the row.
/// They are in the order of their degree, and beyond the image as at its border.
[[nodiscard]] Eigen::Matrix<double, kFilmFunctions, 1> film_functions(ImageExtent size, const Eigen::Vector2d& pixel);

void additional_effect(AdditionalSet set, ImageExtent size, const Eigen::Vector2d& pixel, AdditionalEffect& effect);

}  // namespace collinea
