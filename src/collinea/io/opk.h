// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/geometry/rotation.h"

namespace collinea {

/// Covariance of a pose in the world, as adjustments give it: of [rotation e (rad, in world), centre (m, in world)],
/// true cam_from_world = cam_from_world * rotation_by(e).
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// One row of a table of exterior orientations.
struct ExteriorOrientation {
  std::string file;
  Eigen::Vector3d
      centre_in_map;     ///< easting, northing, height [m]; world coordinates when the block has no georeference
  OmegaPhiKappa angles;  ///< to the axes of the map at this position: grid east, grid north, up
  /// Of [centre in map (m), omega, phi, kappa (rad)]; nothing: not known.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance = std::nullopt;
};

/// The derivative of (omega, phi, kappa) [rad] by the rotation e [rad, in world] of PoseCovariance. With
/// m = Rx(omega) Ry(phi) Rz(kappa) the rotation takes m to rotation_by(-e) m, and
///     -e = (omega' + kappa' sin phi, phi' cos omega - kappa' sin omega cos phi, phi' sin omega + kappa' cos omega cos
///     phi)
/// which is solved for the angles (Kraus, Photogrammetry 1, B 3.4). Grows without bound towards phi = +-90 degrees,
/// where omega and kappa are not defined apart.
[[nodiscard]] Eigen::Matrix3d angles_by_rotation(const OmegaPhiKappa& angles);

/// The exterior orientations of all oriented images, in the order of the ids. With a georeference the angles refer to
/// the map grid at each projection centre, so that meridian convergence and the curvature of the Earth are in them; the
/// scale of the projection is not. Covariances of the poses become those of positions in the map and angles to its
/// axes; the axes themselves are taken as exact. Errors: a CRS that PROJ does not know.
[[nodiscard]] Result<std::vector<ExteriorOrientation>> exterior_orientations(
    const Block& block, const std::map<ImageId, PoseCovariance>& pose_covariance = {});

/// Writes them as text, one image a line: image X Y Z omega phi kappa [m, deg], ground = Rx(omega) Ry(phi) Rz(kappa)
/// image with the image frame x right, y up, z backward. Lines that start with # explain it. Where covariances are
/// given, the standard deviations of the six numbers stand behind them [m, deg]; nan where an image has none. Errors: a
/// name that does not fit into a line (check_image_names).
[[nodiscard]] Result<> write_opk(const std::filesystem::path& path, const Block& block,
                                 const std::map<ImageId, PoseCovariance>& pose_covariance = {});

/// Reads such a table, from here or elsewhere: fields parted by blanks or tabs, lines that start with # left out.
/// Standard deviations are read where a line of titles names them (sigma_x_m), as a diagonal covariance.
/// Errors name file and line: not a number, an image twice, nothing at all.
[[nodiscard]] Result<std::vector<ExteriorOrientation>> read_opk(const std::filesystem::path& path);

/// The inverse of exterior_orientations: the poses of those images of `block` that the table names (by the file as in
/// the block), in its world frame. Errors: a CRS that PROJ does not know, a position outside of it.
[[nodiscard]] Result<std::map<ImageId, Rigid3>> poses_of(const std::vector<ExteriorOrientation>& rows,
                                                         const Block& block);

}  // namespace collinea
