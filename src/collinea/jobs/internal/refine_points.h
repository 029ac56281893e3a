// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/intersection_report.h"

namespace collinea {

/// A point to be matched: the pixel of its reference and where it is about.
struct PointToRefine {
  std::string name, reference;
  Eigen::Vector2d pixel;
  Eigen::Vector3d start_in_world;
};

/// Matches points in all images of the poses whose files lie in the folder, under the name of the image with or without
/// its ending. Memory: all these images, a byte a pixel. Errors: no such folder or image, images that cannot be read,
/// stopped.
[[nodiscard]] Result<std::vector<IntersectionReport::Refined>> refine_points(
    const std::vector<PointToRefine>& points, const std::map<std::string, Rigid3>& cam_from_world, const Camera& camera,
    const std::filesystem::path& folder, const MultiImageOptions& options, const Run& run);

}  // namespace collinea
