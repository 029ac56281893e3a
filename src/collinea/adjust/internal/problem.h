// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "collinea/adjust/datum_sources.h"
#include "collinea/adjust/geodetic_model.h"
#include "collinea/adjust/internal/lens.h"
#include "collinea/adjust/unknowns.h"
#include "collinea/block/pixel_shape.h"
#include "collinea/math/robust.h"

namespace collinea::bundle {

/// Below this a problem is done before threads have started.
inline constexpr std::size_t kRaysWorthThreads = 3000;

/// What makes two correlated coordinates of an image point independent, besides 1 / sigma of the column: the row is
/// taken `of_row` times, less `of_column` times the column (PixelShape::whitening()).
struct Whitening {
  float of_column = 0, of_row = 1;

  [[nodiscard]] bool is_plain() const { return of_column == 0 && of_row == 1; }
  /// The second row of a 2 x count matrix, by rows.
  void apply(double* rows, int count) const {
    for (int c = 0; c < count; ++c) rows[count + c] = of_row * rows[count + c] - of_column * rows[c];
  }
};

[[nodiscard]] inline Whitening whitening_of(const PixelShape& shape) {
  if (shape.is_round()) return {};
  const Eigen::Matrix2d w = shape.whitening();
  return {static_cast<float>(-w(1, 0)), static_cast<float>(w(1, 1))};
}

/// One measured image point, whitened when used.
struct Ray {
  double pixel[2];
  double inverse_sigma;  ///< of the column, and mostly of the row
  std::uint32_t image;   ///< index in Problem::images
  std::uint32_t source;  ///< index in Block::observations or Block::control_observations
  Whitening whitening;
};

/// An image that takes part. Free images come first, in the order of elimination: image i is then pose i of the
/// unknowns.
struct ProblemImage {
  ImageId id;
  int camera;  ///< index in Problem::cameras
};

struct ProblemCamera {
  CameraId id;
  int first_global = 0;                                    ///< where its unknowns begin among all camera unknowns
  std::vector<int> free;                                   ///< Camera::Param of each unknown
  std::array<double, Camera::kAllParams> given{};          ///< pseudo-observations ...
  std::array<double, Camera::kAllParams> inverse_sigma{};  ///< ... and their weights^1/2
  /// Of a scan of film: L^-1 of the covariance L L' of the functions of its deformation; else empty. These are the last
  /// of `free`.
  Eigen::MatrixXd film_whitening = {};

  [[nodiscard]] bool is_of_film() const { return film_whitening.rows() > 0; }
  [[nodiscard]] std::size_t first_film_unknown() const {
    return free.size() - 2 * static_cast<std::size_t>(film_whitening.rows());
  }
};

/// A tie point or control point with its rays in [first_ray, next point's first_ray): first those of fixed images, then
/// from first_free on those of free images in ascending order.
struct ProblemPoint {
  std::uint32_t id = 0;  ///< of a PointId or a ControlId
  std::uint32_t first_ray, first_free;
  int control = -1;  ///< index in Problem::control, -1 for tie points
  bool is_fixed = false;
  int first_retained = -1;  ///< where its three unknowns begin among the global parameters; -1: the point is eliminated

  /// It has unknowns, and no observation that another point shares: it is eliminated before all others.
  [[nodiscard]] bool eliminated() const { return !is_fixed && first_retained < 0; }
};

/// An unknown beside poses, cameras and points. It is a global parameter, behind those of the cameras.
struct AuxiliaryUnknown {
  UnknownKind kind;
  std::uint32_t owner;  ///< of a CameraId, or a number in AdjustScope::position_tracks, of a set-up or of a shape
  int axis = 0;
  double given = 0, inverse_sigma = 0;  ///< its observation; 0: free
};

/// A measurement between two retained points, or of one that lies on a shape.
struct GeodeticLink {
  GeodeticObservation observation;
  std::uint32_t source;      ///< index in Block::geodetic
  std::uint32_t from, to;    ///< indices in Problem::points
  int auxiliary = -1;        ///< first of its own unknowns in Problem::auxiliaries; -1: none
  int shape = -1;            ///< index in Problem::shapes
  double inverse_sigma = 0;  ///< 0: only compared
};

struct ControlCoordinates {
  double given[3], inverse_sigma[3];   ///< 0 = not given; of a coordinate beside which the two others are exact
  double off_diagonal_weight[3] = {};  ///< weights off the diagonal: of 0 and 1, 0 and 2, 1 and 2

  [[nodiscard]] Eigen::Matrix3d weight() const {
    Eigen::Matrix3d p;
    p << inverse_sigma[0] * inverse_sigma[0], off_diagonal_weight[0], off_diagonal_weight[1],  //
        off_diagonal_weight[0], inverse_sigma[1] * inverse_sigma[1], off_diagonal_weight[2],   //
        off_diagonal_weight[1], off_diagonal_weight[2], inverse_sigma[2] * inverse_sigma[2];
    return p;
  }
  [[nodiscard]] bool correlated() const {
    return off_diagonal_weight[0] != 0 || off_diagonal_weight[1] != 0 || off_diagonal_weight[2] != 0;
  }
};

/// The covariance of the given coordinates; 0 on axes that are not given.
[[nodiscard]] inline Eigen::Matrix3d inverse_weight(const ControlCoordinates& control) {
  Eigen::Matrix3d p = control.weight();
  Eigen::Vector3d scale;  // to one size before they are inverted
  for (int axis = 0; axis < 3; ++axis) {
    const bool given = p(axis, axis) > 0;
    scale[axis] = given ? 1 / std::sqrt(p(axis, axis)) : 0;
    if (!given) p(axis, axis) = 1;
  }
  const Eigen::Vector3d one = (scale.array() > 0).select(scale, 1.0);
  const Eigen::Matrix3d inverse = (one.asDiagonal() * p * one.asDiagonal()).inverse();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

struct GivenPosition {
  std::uint32_t image;
  Eigen::Vector3d given, inverse_sigma;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();  ///< exact part of the lever arm
  int lever_arm = -1, shift = -1, drift = -1;     ///< first of three indices in Problem::auxiliaries; -1: none
  int time_offset = -1;                           ///< index in Problem::auxiliaries
  double time = 0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();

  /// It is that of the projection centre.
  [[nodiscard]] bool plain() const {
    return lever_arm < 0 && shift < 0 && drift < 0 && time_offset < 0 && arm.isZero(0);
  }

  /// How many of its coordinates are given.
  [[nodiscard]] int axes() const { return static_cast<int>((inverse_sigma.array() > 0).count()); }
};

/// The direction of the world's z axis in the camera; a difference counts across it only (two observations).
struct GivenUp {
  std::uint32_t image;
  Eigen::Vector3d up_in_cam;
  double inverse_sigma;

  /// Given minus computed, in sigmas: the chord, along which nothing pulls for small angles.
  [[nodiscard]] Eigen::Vector3d residual(const Eigen::Vector3d& z_in_cam) const {
    return inverse_sigma * (up_in_cam - z_in_cam);
  }
};

/// A turn about x, y, z of the world.
struct GivenRotation {
  std::uint32_t image;
  Eigen::Quaterniond cam_from_world;
  Eigen::Vector3d inverse_sigma;
  int boresight = -1;  ///< first of three indices in Problem::auxiliaries; -1: none
};

/// Directions in which the poses of some images must not move together, because nothing observes that motion.
struct DatumConstraint {
  std::vector<int> poses;
  std::vector<std::array<double, 6>> direction;  ///< one for each pose: rotation in the camera frame, centre
  Eigen::Matrix<double, 7, 1> motion{};          ///< of the whole part, see motion_of
  Eigen::Vector3d centre{};
  double size = 1;
  int part = 0;
};

/// The structure of an adjustment: flat tables of numbers, nothing that changes with the iterations.
struct Problem {
  std::vector<ProblemImage> images;
  int poses = 0;  ///< free images
  std::vector<ProblemCamera> cameras;
  int global_count = 0;              ///< unknowns of all cameras, then `auxiliaries`, then the retained points
  std::vector<ProblemPoint> points;  ///< ordered by their first free image; one more at the end closes the last
  std::vector<Ray> rays;
  std::vector<ControlCoordinates> control;
  std::vector<GivenPosition> positions;
  std::vector<GivenUp> verticals;
  std::vector<GivenRotation> attitudes;
  std::vector<AuxiliaryUnknown> auxiliaries;
  int first_auxiliary = 0;                     ///< of the global parameters
  std::vector<std::uint32_t> retained_points;  ///< numbers of points, ascending
  std::vector<GeodeticLink> geodetic;
  std::vector<GeodeticShape> shapes;
  std::size_t geodetic_left_out = 0;  ///< of Block::geodetic, because of points that take no part or determine no shape
  Earth earth;                        ///< of geodetic observations
  std::vector<DatumConstraint> datum;
  std::vector<int> part_of_pose;   ///< images connected by points, as numbers of parts
  std::vector<int> part_of_point;  ///< those that no image shows are of the part they are measured from; -1: of none
  int rank_defect = 0;
  DatumSources datum_sources;
  std::vector<ImageId> images_left_out;
  bool moves_as_one = false;      ///< one connected part, nothing fixed: the block can be moved as a whole
  std::size_t first_control = 0;  ///< no point before this one is a control point
  double extent_m = 0;            ///< size of the block
  Loss tie_loss, position_loss;
  long observation_count = 0, unknown_count = 0;

  [[nodiscard]] long redundancy() const { return observation_count - unknown_count + rank_defect; }
  [[nodiscard]] Loss loss_of(const ProblemPoint& point) const { return point.control >= 0 ? Loss{} : tie_loss; }
  [[nodiscard]] std::size_t point_count() const { return points.size() - 1; }
  [[nodiscard]] const ProblemPoint& point(std::size_t i) const { return points[i]; }
  [[nodiscard]] std::uint32_t end_ray(std::size_t i) const { return points[i + 1].first_ray; }
  /// No image shows the point: geodetic observations alone determine it, and its unknowns are like those of set-ups.
  [[nodiscard]] bool is_unseen(std::size_t i) const { return points[i].first_ray == end_ray(i); }
};

/// Rotation cam_from_world by rows, then the projection centre in the world.
using Frame = std::array<double, 12>;

/// The unknowns and everything derived from them.
struct State {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Frame> frames;
  std::vector<std::array<double, Camera::kAllParams>> cameras;
  std::vector<Lens> lenses;
  std::vector<double> points;       ///< 3 of each point
  std::vector<double> auxiliaries;  ///< parallel to Problem::auxiliaries
};

/// The world's z axis in the camera.
[[nodiscard]] inline Eigen::Vector3d z_in_cam(const Frame& frame) { return {frame[2], frame[5], frame[8]}; }

/// The derivative of an observation by one of the reduced unknowns.
struct RowPart {
  int row;
  double derivative;
};
using Row = std::vector<RowPart>;

/// The rotation cam_from_world of an image.
[[nodiscard]] inline Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation_in(const State& state,
                                                                                                std::uint32_t image) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(state.frames[image].data());
}

/// Three unknowns of Problem::auxiliaries, and the derivatives of an observation by them.
[[nodiscard]] inline Eigen::Vector3d auxiliary3(const State& state, int first) {
  return Eigen::Map<const Eigen::Vector3d>(&state.auxiliaries[static_cast<std::size_t>(first)]);
}
inline void add_auxiliaries(const Problem& problem, int first, const Eigen::RowVector3d& derivative, Row& row) {
  for (int c = 0; c < 3; ++c) row.push_back({6 * problem.poses + problem.first_auxiliary + first + c, derivative[c]});
}

[[nodiscard]] Frame frame_of(const Eigen::Quaterniond& rotation, const double* centre);

/// The beginning of an adjustment.
struct ProblemAndStart {
  Problem problem;
  State start;
};

}  // namespace collinea::bundle
