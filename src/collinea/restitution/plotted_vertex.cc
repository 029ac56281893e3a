// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/plotted_vertex.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "collinea/geometry/rotation.h"
#include "collinea/marking/marked_point.h"
#include "collinea/restitution/moved_edges.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

// Marks of one image count as one.
std::size_t count_images(std::span<const ImageMark> marks) {
  std::set<ImageId> images;
  for (const ImageMark& mark : marks) images.insert(mark.image);
  return images.size();
}

Result<> check(const Block& block, const ImageMark& mark) {
  if (!block.images.contains(mark.image)) return fail(Errc::kNotFound, "there is no such image");
  const std::string& file = block.images.at(mark.image).file;
  if (!is_oriented(block, mark.image)) return fail(Errc::kIllPosed, "image " + file + " is not oriented");
  if (!(mark.sigma_px > 0)) return fail(Errc::kBadInput, "sigma_px: a standard deviation is above 0");
  if (!mark.pixel.allFinite() || !inside(block.camera_of(mark.image), mark.pixel))
    return fail(Errc::kBadInput, "the mark is not inside of image " + file);
  return {};
}

SurfaceRay ray_of(const Block& block, const ImageMark& mark) {
  const Rigid3 pose = pose_of(block, mark.image);
  return {centre_of(pose),
          pose.rotation.conjugate() * normalized(block.camera_of(mark.image), mark.pixel).homogeneous()};
}

// What a ray and its pixel are to each other, at the point that it passes at t.
Matrix32 by_pixel(const Block& block, const ImageMark& mark, double t) {
  constexpr double kStep_px = 0.01;
  Matrix32 out;
  for (int k = 0; k < 2; ++k) {
    ImageMark ahead = mark, behind = mark;
    ahead.pixel[k] += kStep_px;
    behind.pixel[k] -= kStep_px;
    out.col(k) = (ray_of(block, ahead).direction - ray_of(block, behind).direction) * (t / (2 * kStep_px));
  }
  return out;
}

// Heights that a ray meets with edges where they may be as well, counted from where it does: the largest difference.
// `along`: what the ray falls towards the surface by t.
Result<double> step_under(const SurfaceRay& ray, double t, double along, const PlottingSurface& surface) {
  double step = 0;
  for (const bool outwards : {true, false}) {
    COLLINEA_TRY(const SurfaceMeeting met,
                 meeting(ray, moved_edges(surface.heights, outwards), surface.span, std::nullopt));
    if (met.outcome == MonoplotOutcome::kFound) step = std::max(step, std::abs(along * (met.t - t)));
  }
  return step;
}

// The same straight down, in the cell there.
Result<double> step_at(const Vector2d& on_map, const PlottingSurface& surface) {
  const MapGrid& grid = surface.heights.grid;
  const int column = std::clamp(int(std::floor(grid.column_of(on_map.x()))), 0, grid.width - 1),
            row = std::clamp(int(std::floor(grid.row_of(on_map.y()))), 0, grid.height - 1);
  COLLINEA_TRY(const FloatImage here, surface.heights.read(column, row, 1, 1));
  double step = 0;
  for (const bool outwards : {true, false}) {
    COLLINEA_TRY(const FloatImage moved, moved_edges(surface.heights, outwards).read(column, row, 1, 1));
    if (std::isfinite(moved.at(0, 0))) step = std::max(step, std::abs(double(moved.at(0, 0)) - here.at(0, 0)));
  }
  return step;
}

// Of a height whose neighbours beyond an edge may be meant: half the step, where there is one.
double squared_sigma(double sigma_m, double step_m) {
  constexpr double kNoise = 4;  // that is no step, in standard deviations
  return sigma_m * sigma_m + (step_m > kNoise * sigma_m ? step_m * step_m / 4 : 0);
}

std::string message_of(MonoplotOutcome outcome) {
  for (const auto& word : words(outcome))
    if (word.value == outcome) return std::string(word.meaning);
  return {};
}

template <class Key, class Value>
void add_to(std::vector<std::pair<Key, Value>>& all, Key key, const Value& value) {
  for (auto& [known, sum] : all)
    if (known == key) {
      sum += value;
      return;
    }
  all.emplace_back(key, value);
}

}  // namespace

void MovedByImages::add(ImageId image, const ByPose& pose, CameraId camera, const ByCamera& params) {
  add_to(by_pose, image, pose);
  add_to(by_camera, camera, params);
}

Vector3d VertexPlotter::in_world(const Vector3d& on_map) const {
  return frame_ ? frame_->local_from_map(on_map) : on_map;
}
Vector3d VertexPlotter::in_map(const Vector3d& in_world) const {
  return frame_ ? frame_->map_from_local(in_world) : in_world;
}

Matrix3d VertexPlotter::map_by_world(const Vector3d& position_in_world) const {
  if (!frame_) return Matrix3d::Identity();
  constexpr double kStep_m = 1;  // far above rounding of coordinates, far below what bends a map
  Matrix3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kStep_m * Vector3d::Unit(axis);
    out.col(axis) = (in_map(position_in_world + step) - in_map(position_in_world - step)) / (2 * kStep_m);
  }
  return out;
}

Result<PlottedVertex> VertexPlotter::plot(const AskedVertex& asked) {
  COLLINEA_TRY(PlottedVertex vertex, std::visit([&](const auto& one) { return plot_one(one); }, asked));
  if (!vertex.position.allFinite() || !vertex.position_in_world.allFinite())
    return fail(Errc::kBadInput, "the vertex lies outside of where the map is defined");
  return vertex;
}

Result<PlottedVertex> VertexPlotter::plot_one(const MarkedVertex& asked) {
  if (asked.marks.empty()) return fail(Errc::kBadInput, "a vertex has one mark or more");
  for (const ImageMark& mark : asked.marks) COLLINEA_TRY(check(marking_.block, mark));
  if (count_images(asked.marks) > 1) return stereo(asked.marks);
  if (asked.marks.size() > 1)
    return fail(Errc::kBadInput, "all marks are of one image: one of them, or one in another image");
  return mono(asked.marks.front());
}

Result<PlottedVertex> VertexPlotter::stereo(std::span<const ImageMark> marks) {
  const Block& block = marking_.block;
  const auto apart = [] {
    return fail(Errc::kIllPosed, "the rays of the marks do not meet: they are too parallel, or meet behind a camera");
  };
  const auto named = images_of(marks);
  if (!named) return apart();
  const std::optional<JointPoses>& known = poses_of(*named);
  const auto size = 6 * Index(named->size());
  const JointPoses images = known ? *known : JointPoses{.images = *named, .covariance = MatrixXd::Zero(size, size)};
  std::vector<PointMark> seen;
  for (const ImageMark& mark : marks)
    seen.push_back({std::size_t(std::ranges::find(images.images, mark.image) - images.images.begin()), mark.pixel,
                    mark.sigma_px * mark.sigma_px * Eigen::Matrix2d::Identity()});
  const auto found = marked_point(block, images, seen);
  if (!found) return apart();
  PlottedVertex vertex{.position = in_map(found->position_in_world),
                       .position_in_world = found->position_in_world,
                       .source = VertexSource::kStereo,
                       .errors = VertexErrors{}};
  for (std::size_t i = 0; i < marks.size(); ++i) {
    vertex.residuals_px.push_back(found->tests[i].residual_px);
    const Camera& camera = block.camera_of(marks[i].image);
    Matrix2P by_camera;
    const auto linear = linear_pixel(camera, pose_of(block, marks[i].image), found->position_in_world, &by_camera);
    if (!linear) return fail(Errc::kIllPosed, "the point lies behind a camera");
    const Matrix32 gain = found->gain.middleCols<2>(2 * Index(i));
    vertex.errors->covariance_m2 += gain * seen[i].covariance * gain.transpose();
    vertex.errors->by_images.add(marks[i].image, -gain * linear->by_pose, block.images.at(marks[i].image).camera,
                                 -gain * by_camera);
  }
  return vertex;
}

Result<PlottedVertex> VertexPlotter::mono(const ImageMark& mark) {
  if (!surface_)
    return fail(Errc::kIllPosed, "there is no surface that the ray could meet: run surface, or mark a second image");
  const SurfaceRay ray = ray_of(marking_.block, mark);
  if (!ray.direction.allFinite()) return fail(Errc::kIllPosed, "the mark has no ray");
  // The map is linear about a point: where the ray meets the surface, found by turns.
  Vector3d about = in_map(ray.centre);
  about.z() = 0.5 * (surface_->span.low + surface_->span.high);
  SurfaceMeeting met;
  Matrix3d linear;
  Vector3d on_map;
  SurfaceRay in_map_ray;
  constexpr int kMostTurns = 5;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const Vector3d origin = in_world(about);
    if (!origin.allFinite()) return fail(Errc::kIllPosed, "the ray leaves the map");
    linear = map_by_world(origin);
    in_map_ray = {about + linear * (ray.centre - origin), linear * ray.direction};
    COLLINEA_TRY(met, meeting(in_map_ray, surface_->heights, surface_->span, std::nullopt));
    if (met.outcome != MonoplotOutcome::kFound) return fail(Errc::kIllPosed, message_of(met.outcome));
    on_map = in_map_ray.at(met.t);
    if (!frame_ || (on_map - about).norm() < 1e-6) break;
    about = on_map;
  }
  PlottedVertex vertex{
      .position = on_map, .position_in_world = ray.at(met.t), .source = VertexSource::kMono, .errors = std::nullopt};
  const double falls = in_map_ray.direction.dot(Vector3d(-met.slope.x(), -met.slope.y(), 1));
  COLLINEA_TRY(const double step, step_under(in_map_ray, met.t, falls, *surface_));
  COLLINEA_TRY(VertexErrors errors, mono_errors(mark, ray, met, on_map, linear, step));
  if (errors.covariance_m2.allFinite()) vertex.errors = std::move(errors);
  return vertex;
}

Result<VertexErrors> VertexPlotter::mono_errors(const ImageMark& mark, const SurfaceRay& ray, const SurfaceMeeting& met,
                                                const Vector3d& on_map, const Matrix3d& map_by_world_axes,
                                                double step_m) {
  // n is the gradient of height above the surface, by the world; n . dX is what an error of the height adds.
  const Vector3d normal = map_by_world_axes.transpose() * Vector3d(-met.slope.x(), -met.slope.y(), 1);
  const Vector3d& d = ray.direction;
  const double along = normal.dot(d);
  if (!(std::asin(std::min(1.0, std::abs(along) / (normal.norm() * d.norm()))) > kLeastMeetingAngle_rad))
    return fail(Errc::kIllPosed, message_of(MonoplotOutcome::kGrazes));
  COLLINEA_TRY(const HeightSample height, surface_->samples.at(on_map.head<2>()));
  const double sigma = surface_->has_sigmas ? height.sigma_relative_m : std::nan("");
  const Matrix3d onto = Matrix3d::Identity() - d * normal.transpose() / along;
  const Matrix32 pixels = onto * by_pixel(marking_.block, mark, met.t);
  const Vector3d by_height = d / along;
  VertexErrors errors{mark.sigma_px * mark.sigma_px * pixels * pixels.transpose() +
                      squared_sigma(sigma, step_m) * by_height * by_height.transpose()};
  MovedByImages::ByPose by_pose;
  by_pose << met.t * skew(d), Matrix3d::Identity();
  const CameraId camera = marking_.block.images.at(mark.image).camera;
  Matrix2P by_camera;
  if (!linear_pixel(marking_.block.cameras.at(camera), pose_of(marking_.block, mark.image), ray.at(met.t), &by_camera))
    return fail(Errc::kIllPosed, "the point lies behind the camera");
  errors.by_images.add(mark.image, onto * by_pose, camera, -pixels * by_camera);
  // The surface moves with the images, too.
  const MovedByImages surface = moved_with_images(ray.at(met.t));
  const Matrix3d up = by_height * normal.transpose();
  for (const auto& [image, moved] : surface.by_pose) add_to(errors.by_images.by_pose, image, (up * moved).eval());
  for (const auto& [its, moved] : surface.by_camera) add_to(errors.by_images.by_camera, its, (up * moved).eval());
  return errors;
}

Result<PlottedVertex> VertexPlotter::plot_one(const VertexOnSurface& asked) {
  if (!surface_) return fail(Errc::kIllPosed, "there is no surface: run surface");
  COLLINEA_TRY(const HeightSample height, surface_->samples.at(asked.on_map));
  if (!std::isfinite(height.height_m)) return fail(Errc::kIllPosed, "the surface has no height there");
  PlottedVertex vertex{.position = {asked.on_map.x(), asked.on_map.y(), height.height_m},
                       .position_in_world = {},
                       .source = VertexSource::kSurface,
                       .errors = std::nullopt};
  vertex.position_in_world = in_world(vertex.position);
  if (!surface_->has_sigmas || !std::isfinite(height.sigma_relative_m)) return vertex;
  // An error in plan is one of the height as well, where the surface slopes.
  const double cell = surface_->heights.grid.cell_m, plan = asked.sigma_m.value_or(cell / 2);
  Matrix3d on_map = Matrix3d::Zero();
  COLLINEA_TRY(const double step, step_at(asked.on_map, *surface_));
  on_map(2, 2) = squared_sigma(height.sigma_relative_m, step);
  for (int axis = 0; axis < 2; ++axis) {
    const Vector2d aside = cell * Vector2d::Unit(axis);
    COLLINEA_TRY(const HeightSample ahead, surface_->samples.at(asked.on_map + aside));
    COLLINEA_TRY(const HeightSample behind, surface_->samples.at(asked.on_map - aside));
    const double rise = (ahead.height_m - behind.height_m) / (2 * cell);
    Vector3d moved = Vector3d::Unit(axis);
    moved.z() = std::isfinite(rise) ? rise : 0;
    on_map += plan * plan * moved * moved.transpose();
  }
  const Matrix3d world_by_map = map_by_world(vertex.position_in_world).inverse();
  vertex.errors = VertexErrors{world_by_map * on_map * world_by_map.transpose(), false,
                               moved_with_images(vertex.position_in_world)};
  if (vertex.errors->by_images.empty()) vertex.errors.reset();
  return vertex;
}

Result<PlottedVertex> VertexPlotter::plot_one(const GivenVertex& asked) {
  PlottedVertex vertex{.position = asked.position,
                       .position_in_world = in_world(asked.position),
                       .source = asked.source,
                       .errors = std::nullopt};
  if (!asked.sigma_m || !vertex.position_in_world.allFinite()) return vertex;
  const Matrix3d world_by_map = map_by_world(vertex.position_in_world).inverse();
  vertex.errors =
      VertexErrors{world_by_map * asked.sigma_m->cwiseAbs2().asDiagonal() * world_by_map.transpose(), false, {}};
  if (asked.source == VertexSource::kCloud) vertex.errors->by_images = moved_with_images(vertex.position_in_world);
  return vertex;
}

// As good as its marks are now, but where it was drawn; without marks as good as it was then.
Result<PlottedVertex> VertexPlotter::plot_one(const RepeatedVertex& asked) {
  PlottedVertex vertex{.position = asked.vertex.position,
                       .position_in_world = in_world(asked.vertex.position),
                       .source = asked.vertex.source,
                       .errors = std::nullopt};
  if (vertex.position_in_world.allFinite()) vertex.errors = as_drawn(asked, vertex.position_in_world);
  return vertex;
}

std::optional<VertexErrors> VertexPlotter::as_drawn(const RepeatedVertex& asked, const Vector3d& position_in_world) {
  const DrawnVertex& drawn = asked.vertex;
  if (!drawn.covariance_m2) return std::nullopt;
  const Matrix3d world_by_map = map_by_world(position_in_world).inverse();
  VertexErrors errors{world_by_map * *drawn.covariance_m2 * world_by_map.transpose(), true, {}};
  const bool is_marked = drawn.source == VertexSource::kStereo || drawn.source == VertexSource::kMono;
  if (is_marked && asked.marks.size() == drawn.marks.size() && !asked.marks.empty()) {
    const auto again = plot_one(MarkedVertex{asked.marks});
    if (again && again->errors) return again->errors;
  } else if (drawn.source == VertexSource::kSurface || drawn.source == VertexSource::kCloud) {
    errors.by_images = moved_with_images(position_in_world);
  }
  return errors;
}

VertexFigures::VertexFigures(VertexPlotter& plotter, std::vector<PlottedVertex> vertices) {
  for (const PlottedVertex& vertex : vertices) {
    points_.positions.push_back(vertex.position_in_world);
    points_.heights.push_back(vertex.position.z());
  }
  auto covariance = plotter.covariance(vertices);
  has_sigma_ = covariance.has_value();
  if (covariance) points_.covariance = *std::move(covariance);
}

Result<FigureOfVertices> VertexFigures::measure(FigureKind kind) const {
  std::vector<std::size_t> numbers(points_.positions.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return measure(kind, numbers);
}

Result<FigureOfVertices> VertexFigures::measure(FigureKind kind, std::span<const std::size_t> numbers) const {
  COLLINEA_TRY(const MeasuredFigure figure, measure_figure(kind, numbers, points_));
  return FigureOfVertices{figure.value, has_sigma_ ? std::optional(figure.sigma) : std::nullopt};
}

}  // namespace collinea
