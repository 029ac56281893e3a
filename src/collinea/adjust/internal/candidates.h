// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea::bundle {

// What may take part in an adjustment, before anything that is too weak to be determined goes.

/// An oriented image.
struct CandidateImage {
  ImageId id;
  bool is_free = false;  ///< it moves if it takes part
};

/// All oriented images, ascending.
struct CandidateImages {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::vector<CandidateImage> images;
  std::vector<std::uint32_t> index_of_id;  ///< by ImageId::value; kNone: not oriented

  [[nodiscard]] std::uint32_t index_of(ImageId id) const {
    return id.value < index_of_id.size() ? index_of_id[id.value] : kNone;
  }
};

/// A tie point or control point with an approximate position, and the rays to it in oriented images.
struct CandidatePoint {
  std::uint32_t id = 0;  ///< of a PointId or, of control, a ControlId
  std::uint32_t first_ray = 0, end_ray = 0;
  int control = -1;  ///< index in CandidatePoints::control; -1: tie point
  bool is_fixed = false;
  bool is_linked = false;         ///< a geodetic observation is of it
  bool is_geodetic_only = false;  ///< it takes part only because of these
  int given = 0;                  ///< coordinates
  int least_rays = 2;             ///< that determine it without geodetic observations
  double position[3] = {};        ///< approximate, in the world [m]
};

/// Points with their rays, tie points first. Ray::image is an index in CandidateImages::images; the rays of a point are
/// of ascending images, one of each.
struct CandidatePoints {
  std::vector<CandidatePoint> points;
  std::vector<Ray> rays;
  std::vector<ControlCoordinates> control;
  std::vector<std::uint32_t> geodetic;  ///< indices in Block::geodetic
};

[[nodiscard]] CandidateImages candidate_images(const Block& block, const AdjustScope& scope);

/// In a local adjustment (AdjustScope::free_images) only points that a free image shows. Errors: measurements, control
/// coordinates and geodetic observations that are no numbers or have no positive standard deviations, as adjust() says.
[[nodiscard]] Result<CandidatePoints> candidate_points(const Block& block, const AdjustScope& scope,
                                                       const CandidateImages& images);

/// A coordinate that counts must be a number; one that was not given (its sigma is infinite) need not.
[[nodiscard]] bool is_known(double coordinate, double sigma);

}  // namespace collinea::bundle
