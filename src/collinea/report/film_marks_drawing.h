// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/camera/film_calibration.h"

namespace collinea {

/// The fiducial marks of cameras as they are looked for in scans, an SVG: of each camera the film, emulsion down, x
/// right and y up, with its marks enlarged where they are and their names; below them the kinds that the cameras have.
/// A mark without a kind is drawn as `kind`. At most one panel a camera; no cameras give an empty drawing.
[[nodiscard]] std::string film_marks_svg(std::span<const FilmCalibration> cameras, MarkKind kind);

}  // namespace collinea
