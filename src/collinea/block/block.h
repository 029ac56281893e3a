// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/block/geodetic.h"
#include "collinea/block/pixel_shape.h"
#include "collinea/block/ray_bend.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// How the world frame of a block (local, metric, right-handed, z up) lies on the Earth: x east, y north, z up on the
/// WGS84 ellipsoid at the origin; maps and control are in `crs`. geodesy::LocalFrame converts.
struct Georeference {
  std::string crs;  ///< what PROJ understands: "EPSG:32633", "EPSG:32633+5773", WKT
  double origin_latitude_deg = 0, origin_longitude_deg = 0, origin_height_m = 0;  ///< ellipsoidal
  /// Deflection of the vertical, the same over all of the block: by how much the plumb line points north (xi) and east
  /// (eta) of the ellipsoid's normal. Of levelled instruments alone; projects do not keep it.
  double deflection_north_rad = 0, deflection_east_rad = 0;
};

/// Where a camera says it was (GNSS), with standard deviations along x, y, z of the world frame.
struct PositionPrior {
  Eigen::Vector3d position_in_world;  ///< [m]
  Eigen::Vector3d sigma_m;
  double latitude_deg = 0, longitude_deg = 0, height_m = 0;  ///< as the device wrote them; height ellipsoidal
  std::optional<double> height_above_start_m;  ///< over the position of take-off, where the device says so
};

/// How a camera says it was turned: Tait-Bryan angles of the optical axis as drones write them. Heading clockwise from
/// north, pitch -90 = straight down, roll about the optical axis.
struct AttitudePrior {
  double heading_deg = 0, pitch_deg = 0, roll_deg = 0;
  /// Standard deviations of rotations about east, north and the plumb line; 0: not stated.
  Eigen::Vector3d sigma_deg = Eigen::Vector3d::Zero();
};

/// One exposure. Where it was taken is answered by pose_of(), and by that alone.
struct Image {
  std::string file;  ///< relative to the photo folder
  CameraId camera;
  std::string taken;  ///< EXIF date and time with sub-seconds as it sorts; empty when unknown
  std::optional<PositionPrior> position;
  std::optional<AttitudePrior> attitude;
  int orientation = 1;  ///< EXIF orientation tag: for display only, pixels are used as stored
  RayBend bend;  ///< of measurements that were corrected for refraction: straight rays where the photograph has them
};

/// A tie point: one point of the object seen in two or more images.
struct TiePoint {
  Eigen::Vector3d position_in_world;     ///< [m]
  std::array<std::uint8_t, 3> colour{};  ///< red, green, blue
};

/// One measured image point of one tie point.
struct Observation {
  ImageId image;
  PointId point;
  std::uint32_t feature = 0;  ///< its index in the image's Features
  Eigen::Vector2d pixel;      ///< [px]
  double sigma_px = 1;        ///< standard deviation of each coordinate; of the column where `shape` is not round
  PixelShape shape;

  /// Of column and row.
  [[nodiscard]] Eigen::Vector2d sigmas_px() const { return {sigma_px, sigma_px * shape.row_over_column}; }
};

/// A surveyed point. Heights-only or plan-only control has an infinite sigma on the other axes.
struct ControlPoint {
  std::string name;
  ControlRole role = ControlRole::kControl;
  Eigen::Vector3d position_in_map;                        ///< easting, northing, height in Georeference::crs [m]
  Eigen::Vector3d position_in_world;                      ///< [m]
  Eigen::Vector3d sigma_m;                                ///< east, north, height
  Eigen::Vector3d correlation = Eigen::Vector3d::Zero();  ///< east with north, east with height, north with height
};

struct ControlObservation {
  ControlId point;
  ImageId image;
  Eigen::Vector2d pixel;
  double sigma_px = 1;  ///< as Observation::sigma_px
  PixelShape shape;

  [[nodiscard]] Eigen::Vector2d sigmas_px() const { return {sigma_px, sigma_px * shape.row_over_column}; }
};

struct Block;

/// An image whose pose is known: its camera frame from the world frame.
struct OrientedImage {
  ImageId image;
  Rigid3 cam_from_world;
};

/// The table of poses of a block. It is read and written by the functions at the end of this header alone, so that a
/// pose may one day come from a rig, or differ from line to line of an image, without a change in those who ask for it.
class PoseTable {
 private:
  friend std::optional<Rigid3> find_pose(const Block& block, ImageId image);
  friend bool is_oriented(const Block& block, ImageId image);
  friend std::size_t count_oriented(const Block& block);
  friend std::vector<OrientedImage> oriented_images(const Block& block);
  friend void set_pose(Block& block, ImageId image, const Rigid3& cam_from_world);
  friend void set_poses(Block& block, std::map<ImageId, Rigid3> cam_from_world);
  friend void remove_pose(Block& block, ImageId image);
  std::map<ImageId, Rigid3> cam_from_world_;  // oriented images only
};

/// All that is known of a set of overlapping images. Plain data: no pointers, no files, no hidden caches.
struct Block {
  std::optional<Georeference> georeference;  ///< nothing: the world frame is a gauge without position or scale on Earth
  std::map<CameraId, Camera> cameras;
  std::map<ImageId, Image> images;
  PoseTable poses;
  std::map<PointId, TiePoint> points;
  std::vector<Observation> observations;  ///< of tie points; sorted by (point, image)
  std::map<ControlId, ControlPoint> control;
  std::vector<ControlObservation> control_observations;
  std::vector<GeodeticObservation> geodetic;  ///< measured between control points, or known of them

  [[nodiscard]] const Camera& camera_of(ImageId image) const { return cameras.at(images.at(image).camera); }
  /// The camera that stands for all scans of film, which have one each; of other images their own. What images have in
  /// common is looked for in those of one.
  [[nodiscard]] CameraId common_camera(CameraId camera) const {
    if (!cameras.at(camera).prior.film) return camera;
    for (const auto& [id, one] : cameras)
      if (one.prior.film) return id;
    return camera;
  }
};

/// The pose of an image: point_in_cam = pose * point_in_world. Of an image that is not oriented nobody may ask.
[[nodiscard]] Rigid3 pose_of(const Block& block, ImageId image);
/// The same; nothing when the image is not oriented.
[[nodiscard]] std::optional<Rigid3> find_pose(const Block& block, ImageId image);
[[nodiscard]] bool is_oriented(const Block& block, ImageId image);
[[nodiscard]] std::size_t count_oriented(const Block& block);
/// The oriented images with their poses, by ascending id. A copy: the block may be changed while it is walked.
[[nodiscard]] std::vector<OrientedImage> oriented_images(const Block& block);

/// Orients the image, or orients it anew.
void set_pose(Block& block, ImageId image, const Rigid3& cam_from_world);
/// Orients these images and no others.
void set_poses(Block& block, std::map<ImageId, Rigid3> cam_from_world);
/// The image is not oriented any more.
void remove_pose(Block& block, ImageId image);
/// No image is oriented any more.
void clear_poses(Block& block);

}  // namespace collinea
