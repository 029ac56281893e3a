// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/geometry/polygon.h"

namespace collinea {

/// The masked parts of an image: outlines, each closed by itself [px]. Inside is behind an odd number of sides.
class MaskRings {
 public:
  void add(std::vector<Eigen::Vector2d> ring_px);
  [[nodiscard]] bool hides(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] bool empty() const { return rings_.empty(); }
  /// A text that is equal only of equal rings; for fingerprints.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<BoundedRing> rings_;
};

/// What of the images of a block is left out by all work: a moving car, water, the leg of the aircraft.
class ImageMasks {
 public:
  /// `image`: nothing: of all images.
  void add(std::optional<ImageId> image, const std::vector<Eigen::Vector2d>& ring_px);
  [[nodiscard]] bool empty() const { return of_all_.empty() && of_image_.empty(); }
  /// Those of an image, with those of all; null: none.
  [[nodiscard]] const MaskRings* of(ImageId image) const;
  /// As MaskRings::text(), of all.
  [[nodiscard]] std::string text() const;

 private:
  MaskRings of_all_;
  std::map<ImageId, MaskRings> of_image_;  // with those of all
};

}  // namespace collinea
