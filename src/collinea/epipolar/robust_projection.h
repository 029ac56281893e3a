// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/projection_matrix.h"

namespace collinea {

/// What the least median of squares says of points for a direct linear transformation.
struct RobustProjection {
  std::vector<std::size_t> contradicting;  ///< ascending
  double scale = 0;                        ///< robust standard deviation of an image coordinate, in its unit
};

/// Points that contradict the least median of squares over minimal samples (six points in space, four of a plane; see
/// StartSearch): their error is beyond 3.04 times the scale and their own sigma, as one of 100 right ones is. Of n
/// points n - [n/2] - 3 may be wrong (of a plane n - [n/2] - 2), whatever their errors are. Same seed, same result.
/// Nothing with fewer than eight points (six of a plane), or when no sample of them gives a matrix.
[[nodiscard]] std::optional<RobustProjection> robust_projection(std::span<const ProjectedPoint> points, bool is_plane,
                                                                std::uint64_t seed);

}  // namespace collinea
