// SPDX-License-Identifier: Apache-2.0
#include "collinea/plan/planned_block.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// What a stabilised camera and an autopilot leave over.
constexpr double kRotation_rad = std::numbers::pi / 180, kMove_m = 0.3;
constexpr double kHeightOverPlan = 1.5;  // of GNSS
constexpr double kCells = 500;
enum Stream : std::uint64_t { kPoses = 1, kPoints, kFound, kErrors };

Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

/// Waves as long as an image is wide.
struct Ground {
  double relief_m, length_m;
  [[nodiscard]] Vector3d at(const Vector2d& position) const {
    const double radians_per_m = 2 * std::numbers::pi / length_m;
    return {position.x(), position.y(),
            relief_m / 4 * (std::sin(radians_per_m * position.x()) + std::sin(radians_per_m * position.y()))};
  }
};

Rigid3 pose_of(const PlannedImage& image, double tilt_rad, const Vector2d& origin, Random random) {
  const double sine = std::sin(image.heading_rad), cosine = std::cos(image.heading_rad);
  const Vector3d along(sine, cosine, 0), right(cosine, -sine, 0), down(0, 0, -1);
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = std::sin(tilt_rad) * down - std::cos(tilt_rad) * along;
  rotation.row(2) = std::cos(tilt_rad) * down + std::sin(tilt_rad) * along;
  const Eigen::Quaterniond cam_from_world =
      (rotation_by(kRotation_rad * normal3(random)) * Eigen::Quaterniond(rotation)).normalized();
  const Vector3d centre = image.centre - Vector3d(origin.x(), origin.y(), 0) + kMove_m * normal3(random);
  return {cam_from_world, -(cam_from_world * centre)};
}

struct Box {
  Vector2d low{1e300, 1e300}, high{-1e300, -1e300};
  void add(const Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  [[nodiscard]] Box grown(double by) const { return {low.array() - by, high.array() + by}; }
  [[nodiscard]] bool has(const Vector2d& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

/// One image, ready to be asked what it shows.
class Viewer {
 public:
  Viewer(ImageId id, const Camera& camera, const Rigid3& pose, double lowest_m)
      : id_(id), camera_(camera), pose_(pose) {
    const double w = camera.width_px, h = camera.height_px;
    const Vector3d centre = centre_of(pose);
    for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(w, 0), Vector2d(0, h), Vector2d(w, h)}) {
      const Vector3d ray = pose.rotation.conjugate() * ray_in_cam(camera, corner);
      shown_.add((centre + ray * ((lowest_m - centre.z()) / std::min(ray.z(), -0.1))).head<2>());
    }
    shown_.add(centre.head<2>());
  }
  [[nodiscard]] ImageId id() const { return id_; }
  [[nodiscard]] std::optional<Vector2d> see(const Vector3d& point) const {
    if (!shown_.has(point.head<2>())) return std::nullopt;
    const auto pixel = project(camera_, pose_ * point);
    return pixel && inside(camera_, *pixel) ? pixel : std::nullopt;
  }

 private:
  ImageId id_;
  const Camera& camera_;
  Rigid3 pose_;
  Box shown_;
};

void add_images(const FlightPlan& plan, const MeasurementOptions& o, PlannedBlock& planned) {
  const CameraId camera{0};
  planned.block.cameras[camera] = plan.camera;
  planned.block.cameras[camera].prior.sigma_f_px = o.focal_sigma * plan.camera.focal_px();
  PositionTrack track;
  track.shift_sigma_m = Vector3d::Constant(o.position_shift_m);
  for (std::size_t i = 0; i < plan.images.size(); ++i) {
    const ImageId id{static_cast<std::uint32_t>(i)};
    const Rigid3 pose = pose_of(plan.images[i], plan.tilt_rad, planned.origin, Random(kPoses, i));
    Image image{"image " + std::to_string(i + 1), camera, "", {}, {}, 1};
    if (o.position_sigma_plan_m) {
      const double plan_m = *o.position_sigma_plan_m;
      const double height_m = o.position_sigma_height_m.value_or(kHeightOverPlan * plan_m);
      image.position = PositionPrior{centre_of(pose), {plan_m, plan_m, height_m}};
      track.time[id] = 0;
    }
    planned.block.images[id] = image;
    set_pose(planned.block, id, pose);
  }
  if (!track.time.empty() && o.position_shift_m > 0) planned.scope.position_tracks.push_back(track);
}

// Evenly spread over all that the images may show, so many that an image holds those that are wanted. Whether an
// image finds a point does not depend on what other images there are.
void add_tie_points(const FlightPlan& plan, const MeasurementOptions& o, const Ground& ground,
                    const std::vector<Viewer>& viewers, PlannedBlock& planned) {
  const double radius_m = 0.5 * std::hypot(plan.across_m, plan.along_m);
  Box box;
  for (const Vector2d& corner : plan.area) box.add(corner - planned.origin);
  box = box.grown(1.5 * radius_m + plan.spacing_m + plan.height_m * std::tan(plan.tilt_rad));
  const Vector2d size = box.high - box.low;
  const double density = o.points_per_image / (o.found_share * plan.across_m * plan.along_m);
  const auto count = static_cast<std::uint32_t>(std::min(5e7, density * size.x() * size.y()));
  for (std::uint32_t i = 0; i < count; ++i) {
    Random random(kPoints, i);
    const double x = random.uniform(box.low.x(), box.high.x()), y = random.uniform(box.low.y(), box.high.y());
    const Vector3d point = ground.at({x, y});
    const std::size_t first = planned.block.observations.size();
    for (const Viewer& viewer : viewers)
      if (const auto pixel = viewer.see(point))
        if (Random(kFound, (std::uint64_t{i} << 20) + viewer.id().value).uniform() < o.found_share)
          planned.block.observations.push_back({viewer.id(), PointId{i}, 0, *pixel, o.sigma_px});
    if (planned.block.observations.size() < first + 2)
      planned.block.observations.resize(first);
    else
      planned.block.points.emplace_hint(planned.block.points.end(), PointId{i}, TiePoint{point});
  }
}

// A surveyed point or a point of the map; measured in every image that shows it. Answers how many these are.
int add_surveyed(const PlannedPoint& point, ControlId id, const Ground& ground, const std::vector<Viewer>& viewers,
                 double sigma_px, PlannedBlock& planned) {
  ControlPoint control;
  control.name = point.name;
  control.role = point.role;
  control.position_in_world = ground.at(point.position - planned.origin);
  control.position_in_map = {point.position.x(), point.position.y(), control.position_in_world.z()};
  control.sigma_m = point.sigma_m;
  int seen = 0;
  for (const Viewer& viewer : viewers)
    if (const auto pixel = viewer.see(control.position_in_world)) {
      planned.block.control_observations.push_back({id, viewer.id(), *pixel, sigma_px});
      ++seen;
    }
  planned.block.control[id] = control;
  return seen;
}

void add_cells(const MapArea& area, const MeasurementOptions& o, const Ground& ground,
               const std::vector<Viewer>& viewers, PlannedBlock& planned) {
  const Vector3d not_surveyed = Vector3d::Constant(std::numeric_limits<double>::infinity());
  auto next = static_cast<std::uint32_t>(planned.block.control.size());
  for (std::size_t cell = 0; cell < planned.grid.size(); ++cell) {
    const Vector2d position = planned.grid.centre(cell);
    if (!is_inside(area, position)) continue;
    const ControlId id{next++};
    add_surveyed({"cell", ControlRole::kCheck, position, not_surveyed}, id, ground, viewers, o.control_sigma_px,
                 planned);
    planned.cells[id] = cell;
  }
}

double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  return (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1) * power;
}

}  // namespace

Vector2d PrecisionGrid::centre(std::size_t cell) const {
  const auto column = double(cell % std::size_t(width)), row = double(cell / std::size_t(width));
  return {west_m + (column + 0.5) * cell_m, north_m - (row + 0.5) * cell_m};
}

PrecisionGrid precision_grid(const MapArea& area, std::optional<double> cell_m) {
  Box box;
  for (const Vector2d& corner : area) box.add(corner);
  PrecisionGrid grid;
  grid.cell_m = cell_m.value_or(round_below(std::sqrt(2 * size_m2(area) / kCells)));
  const Vector2d size = (box.high - box.low) / grid.cell_m;
  grid.width = std::max(1, int(std::ceil(size.x() - 1e-6)));
  grid.height = std::max(1, int(std::ceil(size.y() - 1e-6)));
  const Vector2d over = Vector2d(grid.width, grid.height) - size;  // shared by both sides
  grid.west_m = box.low.x() - over.x() / 2 * grid.cell_m;
  grid.north_m = box.high.y() + over.y() / 2 * grid.cell_m;
  return grid;
}

Result<PlannedBlock> planned_block(const FlightPlan& plan, const std::vector<PlannedPoint>& points,
                                   const MeasurementOptions& o) {
  COLLINEA_TRY(validate(o));
  if (!o.position_sigma_plan_m && (o.position_sigma_height_m || o.position_shift_m > 0))
    return fail(
        Errc::kBadInput,
        "standard deviations of heights and of a shift are of measured projection centres: give that in plan too",
        {"position_sigma_plan_m"_option});
  PlannedBlock planned;
  Box box;
  for (const Vector2d& corner : plan.area) box.add(corner);
  planned.origin = (box.low + box.high) / 2;
  planned.grid = precision_grid(plan.area, o.map_cell_m);
  if (planned.grid.size() > 100'000)
    return fail(Errc::kBadInput, "the map would have more than 100000 cells; larger ones are needed",
                {"map_cell_m"_option});
  add_images(plan, o, planned);
  const Ground ground{plan.relief_m, std::max(plan.across_m, plan.along_m)};
  std::vector<Viewer> viewers;
  for (const auto& [id, pose] : oriented_images(planned.block))
    viewers.emplace_back(id, planned.block.camera_of(id), pose, -plan.relief_m / 2 - 1);
  add_tie_points(plan, o, ground, viewers, planned);
  for (const PlannedPoint& point : points) {
    const ControlId id{static_cast<std::uint32_t>(planned.block.control.size())};
    if (add_surveyed(point, id, ground, viewers, o.control_sigma_px, planned) == 0)
      return fail(Errc::kBadInput, "point " + point.name + " is seen in no image of the planned flight");
  }
  add_cells(plan.area, o, ground, viewers, planned);
  planned.scope.first_cameras = planned.block.cameras;
  planned.options.adjust.calibration = o.calibration;
  planned.options.adjust.loss = planned.options.adjust.position_loss = Loss::kNone;
  planned.options.point_covariances = true;
  return planned;
}

PlannedBlock with_errors(PlannedBlock planned, std::uint64_t seed) {
  Random random(seed, kErrors);
  const auto error2 = [&] {
    const double x = random.normal(), y = random.normal();
    return Vector2d(x, y);
  };
  for (Observation& seen : planned.block.observations) seen.pixel += seen.sigma_px * error2();
  for (ControlObservation& seen : planned.block.control_observations) seen.pixel += seen.sigma_px * error2();
  for (auto& [id, control] : planned.block.control) {
    const Vector3d error = normal3(random);
    for (int axis = 0; axis < 3; ++axis)
      if (std::isfinite(control.sigma_m[axis])) control.position_in_world[axis] += control.sigma_m[axis] * error[axis];
  }
  Vector3d shift = Vector3d::Zero();
  for (const PositionTrack& track : planned.scope.position_tracks)
    shift = track.shift_sigma_m.cwiseProduct(normal3(random));
  for (auto& [id, image] : planned.block.images)
    if (image.position)
      image.position->position_in_world += shift + image.position->sigma_m.cwiseProduct(normal3(random));
  for (auto& [id, camera] : planned.scope.first_cameras) {
    const CameraSigmas sigmas = calibration_sigmas(planned.options.adjust.calibration, camera);
    for (std::size_t k = 0; k < sigmas.size(); ++k)
      if (std::isfinite(sigmas[k])) camera.params[k] += sigmas[k] * random.normal();
  }
  return planned;
}

}  // namespace collinea
