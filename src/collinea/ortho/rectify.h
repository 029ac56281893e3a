// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/pixel_cache.h"

namespace collinea {

/// An image that shows a plane: (x, y, 1) of the plane times cam_from_plane is a ray of the camera.
struct PlaneView {
  ImageId image;
  Camera camera;
  Eigen::Matrix3d cam_from_plane;
  std::optional<Eigen::Vector3d> centre_over_plane;  ///< of projection, in the frame of the plane; nothing: not known
  RayBend bend = {};
};

/// Where a point of the plane is seen; nothing behind the camera and beside the image.
[[nodiscard]] std::optional<Eigen::Vector2d> pixel_of(const PlaneView& view, const Eigen::Vector2d& on_plane_m);

/// The side of a pixel on the plane: the square root of its area [m]. Infinite where the view shows nothing.
[[nodiscard]] double pixel_size_m(const PlaneView& view, const Eigen::Vector2d& on_plane_m);

/// How far a point one metre in front of the plane is shown from its position [m]; nothing when the centre is not
/// known.
[[nodiscard]] std::optional<double> shift_per_depth(const PlaneView& view, const Eigen::Vector2d& on_plane_m);

/// A rectangle of the plane.
struct PlaneExtent {
  Eigen::Vector2d lowest, highest;
  [[nodiscard]] Eigen::Vector2d size() const { return highest - lowest; }
  /// The position at shares of its width and height.
  [[nodiscard]] Eigen::Vector2d at(double x, double y) const {
    return lowest + Eigen::Vector2d(x, y).cwiseProduct(size());
  }
};

/// The views that together show what can be seen of an extent, the best first: that with the smallest pixels, seen most
/// from the front, over the largest part; then what best fills the rest. At most one for each of 9 x 9 positions.
[[nodiscard]] std::vector<PlaneView> views_for(std::span<const PlaneView> views, const PlaneExtent& extent);

/// The grid over an extent; lower-left cell corner at its lowest corner. Errors: no cells, or more than 2^31.
[[nodiscard]] Result<MapGrid> plane_grid(const PlaneExtent& extent, double cell_m);

struct RectifiedSummary {
  std::uint64_t painted_cells = 0, empty_cells = 0;
  std::vector<std::uint64_t> cells_of;  ///< painted from each view
};

/// The image of a plane at a metric scale: every cell takes its colour (bicubic) from the first of `views` that shows
/// it; cells that none shows stay transparent. Images are read at the largest reduction whose pixels are no larger
/// than the cell. Written as GeoTIFF (cloud-optimised, coordinates of the plane in metres), or as PNG with a world file
/// when `path` ends so: then the whole image is held in memory. Same bits with any number of threads. Errors: a
/// image or the file, cancelled.
[[nodiscard]] Result<RectifiedSummary> write_rectified(const std::filesystem::path& path, const MapGrid& grid,
                                                       std::span<const PlaneView> views, const PixelSource& pixels,
                                                       const Run& run);

}  // namespace collinea
