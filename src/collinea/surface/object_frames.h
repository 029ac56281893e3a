// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/geometry/plane.h"

namespace collinea {

/// A plane of an object on which products are made as on the ground: x to the right and y up as its images see it from
/// the front, z towards them, the origin at the lower left of what lies on it.
struct ObjectFrame {
  std::string name;
  FramedPlane plane;
  Eigen::Vector2d extent_m{0, 0};  ///< of what lies on it: from the origin to the upper right
  double depth_m = 0;              ///< what lies so far before or behind the plane belongs to it
  double area_m2 = 0;              ///< of the cells that hold points of the plane
  double rms_m = 0;                ///< of the distances of its points
  std::size_t points = 0;          ///< on the plane, of those looked at
  std::vector<ImageId> images;     ///< that see it from the front

  /// Whether a point in the coordinates of the frame belongs to its products.
  [[nodiscard]] bool holds(const Eigen::Vector3d& in_frame) const {
    return in_frame.x() >= 0 && in_frame.y() >= 0 && in_frame.x() <= extent_m.x() && in_frame.y() <= extent_m.y() &&
           std::abs(in_frame.z()) <= depth_m;
  }
};

/// How planes are looked for.
struct FrameSearch {
  double tolerance_m = 0;   ///< largest distance of a plane's points from it
  double least_part = 0.1;  ///< of the largest plane's area that others have at least
  std::size_t most = 12;    ///< planes
};

/// The tolerance where none is given: three median sigmas of the points, or where that is less a two-hundredth of what
/// nine tenths of the points extend over. 0 of fewer than three points.
[[nodiscard]] double frame_tolerance_m(std::span<const Eigen::Vector3d> points, std::span<const double> sigmas_m);

/// The direction of up: z where the block has a location on Earth; else the mean of the images' upward axes, as those
/// who photograph mostly hold the camera level. The cameras cannot tell it to better than some degrees.
[[nodiscard]] Eigen::Vector3d up_in_world(const Block& block);

/// The same made better by the walls of the scene: normals of planes within 20 degrees of level directions are taken as
/// level, weighted by area. Two walls that are not parallel fix it; one fixes it in one direction; without walls, and
/// where the block has a location on Earth, it stays.
[[nodiscard]] Eigen::Vector3d up_by_walls(const Block& block, std::span<const ObjectFrame> frames);

/// What is shown before and behind a plane where nothing else is asked for: five tolerances, or where that is more 15 %
/// of the smaller extent.
[[nodiscard]] double default_depth_m(const ObjectFrame& frame, double tolerance_m);

/// The frame of a plane. The extent holds all `points` but one in two hundred on each side. The front is the side from
/// which the images show what lies within the extent larger (nothing tells what hides it: those behind a wall look
/// through it). `normal_in_world`: to either side. `images` are those that see some of the extent within 65 degrees of
/// the normal; none where that is a single one.
[[nodiscard]] ObjectFrame frame_of_plane(const Block& block, std::span<const Eigen::Vector3d> points,
                                         const Eigen::Vector3d& middle, const Eigen::Vector3d& normal_in_world,
                                         const Eigen::Vector3d& up);

/// The planes that dominate a cloud, by area, named plane1, plane2, ... Points are gathered in voxels, of 1/64 of what
/// they extend over; the plane through a voxel that most others bear out (their middles lie on it, their normals agree
/// within 25 degrees) is fitted to its points, in one piece: voxels that touch each other. Its voxels are taken away,
/// and the next is looked for. Left out are planes within 20 degrees of level (pavements: the map shows those), those
/// that no two images see from the front, and those that face as a larger one does and stand within its depth
/// (windows).
/// Deterministic; the order of the points changes nothing but rounding. Error: stopped.
[[nodiscard]] Result<std::vector<ObjectFrame>> find_object_frames(const Block& block,
                                                                  std::span<const Eigen::Vector3d> points,
                                                                  const FrameSearch& search, const Run& run);

/// The block in the coordinates of a frame, without location on Earth: its images alone are oriented, and nothing but
/// images, cameras and poses is there.
[[nodiscard]] Block block_in_frame(const Block& block, const ObjectFrame& frame);

/// WKT1 of the engineering CRS of a frame, for GeoTIFF and GeoPackage: x to the right, y up, in metres where the block
/// has a scale.
[[nodiscard]] std::string frame_wkt(const ObjectFrame& frame, bool is_metric);

}  // namespace collinea
