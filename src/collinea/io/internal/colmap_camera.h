// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/io/internal/colmap_model.h"

namespace collinea::colmap {

/// A camera as COLMAP can hold it, and what was lost on the way.
struct ExportedCamera {
  CameraRow row;
  Camera as_exported;  ///< where COLMAP will see points
  std::vector<Finding> findings;
};

/// FULL_OPENCV; of a fisheye OPENCV_FISHEYE, or THIN_PRISM_FISHEYE where it has decentring. An equisolid lens is
/// fitted. Additional parameters are left out. Errors: a lens that corrects measured coordinates.
[[nodiscard]] Result<ExportedCamera> exported(CameraId id, const Camera& camera);

/// Errors: models without a counterpart, no focal length.
[[nodiscard]] Result<Camera> imported(const CameraRow& row);

}  // namespace collinea::colmap
