// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// What a correction did.
struct Refracted {
  std::size_t corrected = 0;
  std::size_t left = 0;  ///< measurements of points not below the camera, or too near the horizon for flat layers
  double largest_px = 0;
};

/// By how much the standard atmosphere moves the corner of an image at most [px]; 0 where the block has no location on
/// Earth, so that heights are not known, or no tie points.
[[nodiscard]] double largest_refraction_px(const Block& block);

/// Moves the measurements of tie and control points in oriented images to where they would be without an atmosphere:
/// each ray is turned towards the nadir by refraction_rad() times the tangent of its angle from it, with the heights of
/// the camera and of the point, as the block has them now (a pose better by metres changes nothing to speak of). What
/// reads the photographs later bends rays by Image::bend, for the mean height of the tie points: 100 m of relief below
/// a flight at 3 km change that by 3 %. Errors: the block has no location on Earth, so that heights are not known.
[[nodiscard]] Result<Refracted> correct_refraction(Block& block);

}  // namespace collinea
