// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/camera/film_calibration.h"

namespace collinea {

/// A calibration of a film camera as text: a word and its values a line, # begins a remark, the order is free.
///     camera                  text
///     principal_distance_mm   C
///     principal_point_mm      X Y          of autocollimation; missing: 0 0
///     symmetry_point_mm       X Y          centre of the distortion; missing: the principal point
///     radial_correction       K0 [K1 [K2 [K3]]]   added to measured coordinates, with lengths in mm
///     radial_distortion       K0 [K1 [K2 [K3]]]   the same with the other sign: where the lens puts points outwards
///     radial_distortion_um    R D          a line of a table: at the radius R mm points lie D um too far outwards
///     decentring_correction   P1 P2        (or decentring_distortion)
///     mark                    NAME X Y [KIND]     mm, x right, y up; cross, dot, ring, corner, notch
///     mark_sigma_mm           S            of the coordinates of the marks that follow
///     mark_size_mm            SIZE [LINE]  what their drawing is wide, and its lines
///     film_size_mm            WIDTH HEIGHT
///     image_size_mm         WIDTH HEIGHT    of the part that shows nothing but the scene; missing: found from the
///     marks
/// Only the distance is required. Errors name the line: an unknown word, one twice, values that are none, a mark twice,
/// both polynomial and table.
[[nodiscard]] Result<FilmCalibration> parse_film_calibration(std::string_view text);
/// The calibration as such a text: parsed again it is the same, to 1e-9 of each value.
[[nodiscard]] std::string text_of(const FilmCalibration& calibration);
[[nodiscard]] Result<FilmCalibration> read_film_calibration(const std::filesystem::path& path);

}  // namespace collinea
