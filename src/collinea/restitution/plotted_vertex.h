// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/marking/marking_block.h"
#include "collinea/restitution/measured_figure.h"
#include "collinea/restitution/plotting_surface.h"
#include "collinea/vector/drawing.h"

namespace collinea {

struct ImageMark {
  ImageId image;
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;
};

/// A vertex by its marks. Two and more: the rays are intersected. One: the ray meets the surface.
struct MarkedVertex {
  std::vector<ImageMark> marks;
};
/// A position in plan, on the surface. `sigma_m`: of each coordinate in plan; nothing: half a cell.
struct VertexOnSurface {
  Eigen::Vector2d on_map;
  std::optional<double> sigma_m = {};
};
/// Coordinates. Of a point of the cloud `sigma_m` is what matching gave, without the orientation; of others everything.
struct GivenVertex {
  Eigen::Vector3d position;
  std::optional<Eigen::Vector3d> sigma_m = {};
  VertexSource source = VertexSource::kTyped;
};
/// One that is drawn already, with those of its marks whose images there are. It stays where it is.
struct RepeatedVertex {
  DrawnVertex vertex;
  std::vector<ImageMark> marks = {};
};
using AskedVertex = std::variant<MarkedVertex, VertexOnSurface, GivenVertex, RepeatedVertex>;

/// How the errors of images move a position in the world: sum by_pose * pose error + sum by_camera * camera error. An
/// image, and a camera, stands once.
struct MovedByImages {
  using ByPose = Eigen::Matrix<double, 3, 6>;  ///< of [rotation (rad, in world), centre (m)], as JointPoses has them
  using ByCamera = Eigen::Matrix<double, 3, Camera::kAllParams>;  ///< of Camera::params
  std::vector<std::pair<ImageId, ByPose>> by_pose = {};
  std::vector<std::pair<CameraId, ByCamera>> by_camera = {};

  [[nodiscard]] bool empty() const { return by_pose.empty(); }
  void add(ImageId image, const ByPose& pose, CameraId camera, const ByCamera& params);
};

/// What the position of a vertex owes to whom, in the world: dX = own error + what the images move.
struct VertexErrors {
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of the own error, or of everything ...
  bool is_of_all = false;                                   ///< ... the own error is what the images leave of it then
  MovedByImages by_images = {};
};

struct PlottedVertex {
  Eigen::Vector3d position;           ///< in the map
  Eigen::Vector3d position_in_world;  ///< in the block
  VertexSource source = VertexSource::kTyped;
  std::optional<VertexErrors> errors;              ///< nothing: not known
  std::vector<Eigen::Vector2d> residuals_px = {};  ///< of the marks of several images: marked minus where these show it
};

/// Plots vertices in an oriented block (docs/theory/plotting.md).
///
/// Stereo: the point and the poses and cameras of its images adjusted together (marked_point()), as a tie point of the
/// block; of marks with the covariance Sigma and the gain G the own covariance is G Sigma G', and errors of the images
/// move the point by -G J. Where the covariance of the poses is not known they count as exact. Mono: see meeting().
/// What lies on the surface, or comes from the cloud, moves with the images as a point does that the (up to kNearest)
/// images nearest to it see with equal weights. Beside a wall the surface may be that of the other side
/// (moved_edges()): half the step counts as a standard deviation of the height.
///
/// The covariance of several vertices together is that of their own errors, each for itself, and J C J' of all images:
/// C is that of MarkingBlock::poses_together, or of local_poses() (of the images named, and of the nearest that see
/// each vertex, cameras exact).
class VertexPlotter {
 public:
  static constexpr std::size_t kNearest = 4;         ///< images by which the surface was made, of a vertex
  static constexpr std::size_t kMostImages = 60;     ///< that vertices are of together
  static constexpr std::size_t kMostVertices = 500;  ///< of a covariance: three rows each

  /// All must outlive it. `frame`: null where the map is the world. `surface`: null where there is none.
  VertexPlotter(const MarkingBlock& marking, const LocalFrame* frame, PlottingSurface* surface)
      : marking_(marking), frame_(frame), surface_(surface) {}

  /// Errors: images that are not oriented; rays that do not meet; no surface, or none there; a ray that grazes it.
  [[nodiscard]] Result<PlottedVertex> plot(const AskedVertex& asked);

  /// Of all positions together, 3 rows each [m^2], in the world. Errors: kIllPosed, the errors of a vertex or of the
  /// block are not known; kUnsupported, more than kMostImages or kMostVertices.
  [[nodiscard]] Result<Eigen::MatrixXd> covariance(std::span<const PlottedVertex> vertices);
  /// That of one, in the axes of the map; nothing: not known.
  [[nodiscard]] std::optional<Eigen::Matrix3d> covariance_in_map(const PlottedVertex& vertex);

  /// From a displacement in the world to that in the map.
  [[nodiscard]] Eigen::Matrix3d map_by_world(const Eigen::Vector3d& position_in_world) const;

 private:
  Result<PlottedVertex> plot_one(const MarkedVertex& asked);
  Result<PlottedVertex> plot_one(const VertexOnSurface& asked);
  Result<PlottedVertex> plot_one(const GivenVertex& asked);
  Result<PlottedVertex> plot_one(const RepeatedVertex& asked);
  Result<PlottedVertex> stereo(std::span<const ImageMark> marks);
  Result<PlottedVertex> mono(const ImageMark& mark);
  Result<VertexErrors> mono_errors(const ImageMark& mark, const SurfaceRay& ray, const SurfaceMeeting& met,
                                   const Eigen::Vector3d& on_map, const Eigen::Matrix3d& map_by_world, double step_m);
  std::optional<VertexErrors> as_drawn(const RepeatedVertex& asked, const Eigen::Vector3d& position_in_world);
  [[nodiscard]] std::vector<ImageId> nearest(const Eigen::Vector3d& position_in_world, std::size_t most) const;
  [[nodiscard]] MovedByImages moved_with_images(const Eigen::Vector3d& position_in_world) const;
  [[nodiscard]] std::optional<std::vector<ImageId>> images_of(std::span<const ImageMark> marks) const;
  [[nodiscard]] std::vector<ImageId> images_of(std::span<const PlottedVertex> vertices) const;
  void add_neighbours(const Eigen::Vector3d& position_in_world, std::vector<ImageId>& images) const;
  [[nodiscard]] Eigen::Vector3d in_world(const Eigen::Vector3d& on_map) const;
  [[nodiscard]] Eigen::Vector3d in_map(const Eigen::Vector3d& in_world) const;
  const std::optional<JointPoses>& poses_of(const std::vector<ImageId>& images);

  MarkingBlock marking_;
  const LocalFrame* frame_;
  PlottingSurface* surface_;
  static constexpr std::size_t kMostKept = 256;                      // sets of images
  std::map<std::vector<ImageId>, std::optional<JointPoses>> poses_;  // made so far
};

/// A figure of vertices in their order; `sigma`: nothing where VertexPlotter::covariance() has none: where the errors
/// of a vertex are not known, and of more vertices or images than it takes. Errors: as measure_figure().
struct FigureOfVertices {
  double value = 0;
  std::optional<double> sigma;
};
class VertexFigures {
 public:
  /// The plotter is asked for the covariance once.
  VertexFigures(VertexPlotter& plotter, std::vector<PlottedVertex> vertices);
  [[nodiscard]] Result<FigureOfVertices> measure(FigureKind kind) const;
  /// Of some of them, by their numbers.
  [[nodiscard]] Result<FigureOfVertices> measure(FigureKind kind, std::span<const std::size_t> numbers) const;

 private:
  FigurePoints points_;
  bool has_sigma_ = false;
};

}  // namespace collinea
