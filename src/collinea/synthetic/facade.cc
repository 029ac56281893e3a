// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/facade_scene.h"
#include "collinea/synthetic/internal/field_work.h"
#include "collinea/synthetic/survey.h"

namespace collinea {
namespace {

constexpr double kFocalError = 1.011;  // the true focal length over what the header of an image says

// A camera held level but for a tilt towards its target.
Rigid3 looking_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& target, const Eigen::Quaterniond& shake) {
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  const Eigen::Quaterniond cam_from_world = (shake * Eigen::Quaterniond(rotation)).normalized();
  return {cam_from_world, -(cam_from_world * centre)};
}

// Two images at each station of an arc about the middle of the wall, low ones first; each looks at the part of the wall
// in front of it rather than at one point, so that the ends of the wall are covered too.
std::vector<Rigid3> walk(const FacadeOptions& o, const FacadeScene& scene) {
  std::vector<Rigid3> poses;
  for (int level = 0; level < 2; ++level)
    for (int i = 0; i < o.stations; ++i) {
      Random random(std::uint64_t(o.seed), 300 + poses.size());
      const double share = o.stations > 1 ? double(i) / (o.stations - 1) - 0.5 : 0;
      const double angle = share * o.arc_deg * std::numbers::pi / 180;
      const double dx = bounded_normal(random), dy = bounded_normal(random), dz = bounded_normal(random);
      const Eigen::Vector3d centre = Eigen::Vector3d(1.15 * o.distance_m * std::sin(angle),
                                                     -o.distance_m * std::cos(angle), level ? o.high_m : o.low_m) +
                                     o.position_jitter_m * Eigen::Vector3d(dx, dy, dz);
      const Eigen::Vector3d target(0.62 * scene.width_m * share, 0, 0.48 * scene.storeys * scene.storey_m);
      poses.push_back(looking_at(centre, target, shaken(random, o.attitude_jitter_deg)));
    }
  return poses;
}

// Positions on the wall's front where a whole board sticks to one face.
std::vector<Mark> points_on_wall(const Scene& scene, const FacadeScene& wall, double half_size_m, int count,
                                 Random random) {
  std::vector<Mark> marks;
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitY();
  for (int trial = 0; trial < 200 * count && int(marks.size()) < count; ++trial) {
    const double x = random.uniform(-0.49, 0.49) * wall.width_m,
                 z = random.uniform(0.4, wall.storeys * wall.storey_m - 0.4);
    const auto middle = scene.cast({x, -5, z}, ahead);
    bool flat = middle && middle->solid >= 0 &&
                scene.solids()[std::size_t(middle->solid)].shape == Solid::Shape::kBox &&
                scene.solids()[std::size_t(middle->solid)].wall != Finish::kWindow &&
                scene.in_sun(middle->point, middle->normal);
    for (int i = 0; i < 4 && flat; ++i) {
      const double dx = (i & 1 ? 1.3 : -1.3) * half_size_m, dz = (i & 2 ? 1.3 : -1.3) * half_size_m;
      const auto corner = scene.cast({x + dx, -5, z + dz}, ahead);
      flat = corner && std::abs(corner->point.y() - middle->point.y()) < 1e-6 && corner->normal.y() < -0.999;
    }
    if (flat) marks.push_back({middle->point, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), half_size_m});
  }
  return marks;
}

}  // namespace

Result<Truth> make_facade(const FacadeOptions& o, const Run& run) {
  COLLINEA_TRY(validate(o));
  COLLINEA_TRY(LocalFrame frame,
               LocalFrame::create(o.site.crs, o.site.latitude_deg, o.site.longitude_deg, o.site.ground_height_m));
  COLLINEA_TRY(const Camera camera, true_camera(o.camera, 0.78));
  FacadeScene wall;
  wall.seed = std::uint64_t(o.seed);
  wall.yard_m = std::max(30.0, 1.6 * o.distance_m);
  Truth truth{.scene = make_facade_scene(wall),
              .frame = frame,
              .block = {},
              .marks_in_world = {},
              .exposure = {},
              .optics = optics_of(o.light),
              .mapped = {}};
  truth.block.georeference =
      Georeference{o.site.crs, o.site.latitude_deg, o.site.longitude_deg, o.site.ground_height_m};
  truth.gsd_m = o.distance_m / camera.focal_px();
  truth.nominal_focal_px = camera.focal_px() / kFocalError;
  truth.lens_mm = 4.9;
  truth.seed = wall.seed;
  const std::vector<Rigid3> poses = walk(o, wall);
  add_images(truth, camera, poses, o.light.exposure_sigma);
  if (o.receiver.gps) add_positions(truth, o.receiver.gps_sigma_plan_m, o.receiver.gps_sigma_height_m);
  MarkOptions marks;
  marks.control_points = o.control_points;
  marks.check_points = o.check_points;
  marks.sigma_m = Eigen::Vector3d::Constant(o.control_sigma_m);
  marks.measurement_sigma_px = o.measurement_sigma_px;
  marks.least_images = std::min(3, int(poses.size()));
  const int candidates = 10 * (o.control_points + o.check_points) + 50;
  if (auto done = add_marks(
          truth, points_on_wall(truth.scene, wall, 4.5 * truth.gsd_m, candidates, Random(wall.seed, 8)), marks, run);
      !done)
    return tl::unexpected(std::move(done).error());
  return truth;
}

}  // namespace collinea
