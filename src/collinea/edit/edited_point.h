// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/import/image_names.h"

namespace collinea {

/// A control point with its marks: what edits of it change. Its marks name it when it takes its place in a block.
struct EditedPoint {
  std::optional<ControlPoint> point;                         ///< nothing: there is none of the name
  std::map<ImageId, std::vector<ControlObservation>> marks;  ///< a control file may state several in one image
  bool is_measured_on_ground = false;                        ///< geodetic observations name it
};

/// What edits are read against: images, cameras and the map of a block. Refers to the block.
class EditContext {
 public:
  explicit EditContext(const Block& block) : block_(block), images_(block) {}

  [[nodiscard]] const Block& block() const { return block_; }
  /// By its path below the photo folder, or its name where only one image has it. Error: none, or several.
  [[nodiscard]] Result<ImageId> image(const std::string& name) const;
  /// The world frame; nothing where the block has no location on Earth. Made when first asked for.
  [[nodiscard]] Result<std::optional<LocalFrame>> frame() const;

 private:
  const Block& block_;
  ImageNames images_;
  mutable std::optional<Result<std::optional<LocalFrame>>> frame_;
};

/// What is taken where an edit states no standard deviation.
struct EditDefaults {
  double sigma_m = 0.02;  ///< of coordinates of control
  double sigma_px = 0.5;  ///< of marks
};

}  // namespace collinea
