// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/cloud/cloud_edits.h"
#include "collinea/vector/drawing.h"

namespace collinea {

/// A part of a photograph that the work leaves out: a moving car, water, the leg of the aircraft.
struct ImageMask {
  std::string name;
  std::optional<ImageId> image;          ///< nothing: all photographs
  std::vector<Eigen::Vector2d> ring_px;  ///< closed by itself
};

/// A part of the map that the orthophoto takes from one photograph, wherever that sees it.
struct SeamPatch {
  std::string name;
  ImageId image{};
  std::vector<Eigen::Vector2d> ring_m;  ///< closed by itself, in the map
};

/// What edits make beside control. Each kind of edit changes one of the parts.
struct EditedWork {
  std::vector<ImageMask> masks;    ///< in the order of their edits
  std::vector<SeamPatch> patches;  ///< the same: where two overlap, the later one holds
  Drawing drawing;
  std::vector<CloudRegion> regions;  ///< of the cloud, in the order of their edits
};

/// A text that is equal only of equal patches; for fingerprints.
[[nodiscard]] std::string patches_text(const EditedWork& work);

}  // namespace collinea
