// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "collinea/base/words.h"
#include "collinea/camera/film_calibration.h"

namespace collinea {

/// Common film cameras of 23 cm, by where their marks are.
enum class FilmCameraType { kRc8, kRc10, kRc30, kRmkA };
inline constexpr Word<FilmCameraType> kFilmCameraTypeWords[] = {
    {FilmCameraType::kRc8, "rc8", "early Wild RC8: four crosses in the corners, 106 mm from the axes"},
    {FilmCameraType::kRc10, "rc10", "Wild RC10, later RC8: the same, and four at the sides at 110 mm"},
    {FilmCameraType::kRc30, "rc30", "Leica RC30: corners at 106 mm, sides at 112 mm"},
    {FilmCameraType::kRmkA, "rmk_a", "Zeiss RMK A: four dots at the sides, at 113 mm"}};
[[nodiscard]] constexpr std::span<const Word<FilmCameraType>> words(FilmCameraType) { return kFilmCameraTypeWords; }

/// The nominal marks of a type, from certificates (RC30) and from the patterns that spymicmac's documentation has
/// gathered from images and calibration reports of the USGS (the others, given there to whole millimetres): those in
/// corners are 1 to 4 (lower left, upper right, upper left, lower right), those at sides 5 to 8 (left, right, top,
/// bottom), as the certificates of the RC30 number them. A camera differs from them by some hundredths of a millimetre,
/// so each coordinate has a standard deviation of 0.02 mm: enough to find the marks and for an orientation to a pixel
/// or two, no stand-in for a certificate. The principal distance is zero: it is not of the type.
[[nodiscard]] FilmCalibration nominal_calibration(FilmCameraType type);

}  // namespace collinea
