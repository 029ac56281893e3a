// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/block/image_masks.h"
#include "collinea/geodesy/local_frame.h"

namespace collinea {

/// An oriented image as a source of an orthophoto.
struct View {
  ImageId image;
  CameraId camera_id;
  Camera camera;
  Rigid3 cam_from_world;
  RayBend bend;
  Eigen::Matrix3d rotation;  ///< of cam_from_world: millions of points are turned by it
  Eigen::Vector3d centre_in_world, centre_in_map;
  const MaskRings* masks = nullptr;  ///< parts of the image that show nothing; null: none
  /// How far the flattest line of sight of the image runs per rise, or more; infinite where one does not rise.
  double most_run_per_rise = std::numeric_limits<double>::infinity();
};

/// The oriented images in the order of their ids. `frame`: null when the map is the plane x, y of the world.
[[nodiscard]] std::vector<View> views_of(const Block& block, const LocalFrame* frame);

/// Where a point is seen, also beside the image; nothing when it cannot be.
[[nodiscard]] inline std::optional<Eigen::Vector2d> pixel_of(const View& view, const Eigen::Vector3d& point_in_world) {
  return project(view.camera, view.bend.bent(view.rotation * point_in_world + view.cam_from_world.translation));
}

/// True when the pixel and its neighbours lie on the image.
[[nodiscard]] inline bool well_inside(const View& view, const Eigen::Vector2d& pixel) {
  constexpr double kRim = 2.5;  // what an interpolation by 4 x 4 pixels needs, and the JPEG's last row
  return pixel.x() >= kRim && pixel.y() >= kRim && pixel.x() <= view.camera.width_px - kRim &&
         pixel.y() <= view.camera.height_px - kRim;
}

/// The same, and no mask hides the pixel.
[[nodiscard]] inline bool shows(const View& view, const Eigen::Vector2d& pixel) {
  return well_inside(view, pixel) && !(view.masks && view.masks->hides(pixel));
}

/// How well a view serves for a point: 0 straight from above in the middle of the image; grows with the square of the
/// tangent of the nadir distance, towards the border of the image and with pixels larger than the wanted cell. A
/// smooth function of the point. Huge where the view shows nothing.
[[nodiscard]] float cost_of(const View& view, const Eigen::Vector3d& point_in_world, double cell_m);
constexpr float kUseless = 1000;

/// True when orthophoto and surface model make sense for a block: at least half of its oriented images look down
/// (optical axis within 60 degrees of straight down). False without oriented images.
[[nodiscard]] bool looks_down(const Block& block);

}  // namespace collinea
