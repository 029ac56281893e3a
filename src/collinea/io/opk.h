// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/geometry/rotation.h"

namespace collinea {

/// One row of a table of exterior orientations.
struct ExteriorOrientation {
  std::string file;
  Eigen::Vector3d
      centre_in_map;     ///< easting, northing, height [m]; world coordinates when the block has no georeference
  OmegaPhiKappa angles;  ///< to the axes of the map at this position: grid east, grid north, up
};

/// The exterior orientations of all oriented images, in the order of the ids. With a georeference the angles refer to
/// the map grid at each projection centre, so that meridian convergence and the curvature of the Earth are in them; the
/// scale of the projection is not. Errors: a CRS that PROJ does not know.
[[nodiscard]] Result<std::vector<ExteriorOrientation>> exterior_orientations(const Block& block);

/// Writes them as text, one image a line: image X Y Z omega phi kappa [m, deg], ground = Rx(omega) Ry(phi) Rz(kappa)
/// image with the image frame x right, y up, z backward. Lines that start with # explain it. Errors: a name that does
/// not fit into a line (check_image_names).
[[nodiscard]] Result<> write_opk(const std::filesystem::path& path, const Block& block);

/// Reads such a table, from here or elsewhere: fields parted by blanks or tabs, lines that start with # left out.
/// Errors name file and line: not a number, an image twice, nothing at all.
[[nodiscard]] Result<std::vector<ExteriorOrientation>> read_opk(const std::filesystem::path& path);

/// The inverse of exterior_orientations: the poses of those images of `block` that the table names (by the file as in
/// the block), in its world frame. Errors: a CRS that PROJ does not know, a position outside of it.
[[nodiscard]] Result<std::map<ImageId, Rigid3>> poses_of(const std::vector<ExteriorOrientation>& rows,
                                                         const Block& block);

}  // namespace collinea
