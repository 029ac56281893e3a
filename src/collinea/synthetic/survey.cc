// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/survey.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/field_work.h"
#include "collinea/synthetic/internal/rocks.h"
#include "collinea/synthetic/internal/town.h"
#include "collinea/synthetic/internal/village.h"

namespace collinea {
namespace {

constexpr double kCrossHeight = 1.15;  // flying height of cross strips over that of the others
constexpr double kGimbalSigma_deg = 1.2;
constexpr double kFocalError = 1.011;  // the true focal length over what the header of an image says

// What follows from the options: sizes of the block on the ground.
struct Plan {
  Camera camera;
  double height_m = 0, gsd_m = 0;
  double across_m = 0, along_m = 0;  // an image on the ground
  double base_m = 0, spacing_m = 0;
  int strips = 0, per_strip = 0, dropped = 0;  // images left out at the end of the last strip
  int cross_strips = 0, per_cross = 0;
};

// Two cross strips of a quarter of the images; in large blocks of fewer, as soon as they reach from side to side.
void choose_strips(Plan& plan, int images) {
  plan.cross_strips = images >= 12 ? 2 : 0;
  const auto across = [&](int rest) { return std::max(1, int(std::lround(std::sqrt(rest / 2.0)))); };
  const int reach = 2 + int(across(images) * plan.spacing_m / (kCrossHeight * plan.base_m));
  plan.per_cross = plan.cross_strips ? std::max(2, std::min(images / 8, reach)) : 0;
  const int rest = images - plan.cross_strips * plan.per_cross;
  plan.strips = across(rest);
  plan.per_strip = (rest + plan.strips - 1) / plan.strips;
  plan.dropped = plan.strips * plan.per_strip - rest;
}

Plan plan_of(const SurveyOptions& o, const Camera& camera) {
  Plan plan;
  plan.camera = camera;
  const double focal = plan.camera.focal_px();
  plan.height_m = o.height_m.value_or(o.gsd_m * focal);
  plan.gsd_m = plan.height_m / focal;
  plan.across_m = camera.width_px * plan.gsd_m;
  plan.along_m = camera.height_px * plan.gsd_m;
  plan.base_m = (1 - o.forward_overlap.value_or(0.75)) * plan.along_m;
  plan.spacing_m = (1 - o.side_overlap.value_or(0.65)) * plan.across_m;
  plan.strips = o.strips;
  plan.per_strip = o.images_per_strip;
  plan.cross_strips = o.cross_strips.value_or(2);
  plan.per_cross = o.images_per_cross_strip;
  if (o.images) choose_strips(plan, *o.images);
  return plan;
}

struct Station {
  double x, y, z, heading;  // heading clockwise from north: where the upper edge of the image points
};

// Strips run north and south in turn, the cross strips east and west; the block's middle is the origin.
std::vector<Station> stations_of(const Plan& plan) {
  std::vector<Station> stations;
  for (int strip = 0; strip < plan.strips; ++strip) {
    const int count = plan.per_strip - (strip + 1 == plan.strips ? plan.dropped : 0);
    const double x = (strip - 0.5 * (plan.strips - 1)) * plan.spacing_m, sign = strip % 2 ? -1 : 1;
    for (int i = 0; i < count; ++i)
      stations.push_back(
          {x, sign * (i - 0.5 * (plan.per_strip - 1)) * plan.base_m, plan.height_m, strip % 2 ? std::numbers::pi : 0});
  }
  const double length_m = (plan.per_strip - 1) * plan.base_m;
  for (int strip = 0; strip < plan.cross_strips; ++strip) {
    const double y = length_m * ((strip + 0.5) / plan.cross_strips - 0.5), sign = strip % 2 ? -1 : 1;
    const double step_m =
        std::max(kCrossHeight * plan.base_m, plan.strips * plan.spacing_m / std::max(1, plan.per_cross));
    for (int i = 0; i < plan.per_cross; ++i)
      stations.push_back({sign * (i - 0.5 * (plan.per_cross - 1)) * step_m, y, kCrossHeight * plan.height_m,
                          sign * std::numbers::pi / 2});
  }
  return stations;
}

Rigid3 looking_down(const Station& station, const SurveyOptions& o, Random random) {
  const double sine = std::sin(station.heading), cosine = std::cos(station.heading);
  Eigen::Matrix3d rotation;  // rows: right, down, forward of the camera
  rotation << cosine, -sine, 0, -sine, -cosine, 0, 0, 0, -1;
  const Eigen::Quaterniond cam_from_world =
      (shaken(random, o.attitude_jitter_deg) * Eigen::Quaterniond(rotation)).normalized();
  const double dx = bounded_normal(random), dy = bounded_normal(random), dz = bounded_normal(random);
  const Eigen::Vector3d centre =
      Eigen::Vector3d(station.x, station.y, station.z) + o.position_jitter_m * Eigen::Vector3d(dx, dy, dz);
  return {cam_from_world, -(cam_from_world * centre)};
}

struct Area {
  Eigen::Vector2d low{1e30, 1e30}, high{-1e30, -1e30};

  void include(const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  [[nodiscard]] Area grown(double x_m, double y_m) const {
    return {low - Eigen::Vector2d(x_m, y_m), high + Eigen::Vector2d(x_m, y_m)};
  }
};

// All ground that any image may show: its corners traced down to a level below all terrain.
Result<Area> ground_in_view(const Camera& camera, const std::vector<Rigid3>& poses, double level_m, double margin_m) {
  Area area;
  const double w = camera.width_px, h = camera.height_px;
  for (const Rigid3& pose : poses)
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(0, 0), {w, 0}, {0, h}, {w, h}, {w / 2, 0}, {w / 2, h}, {0, h / 2}, {w, h / 2}}) {
      const Eigen::Vector3d ray = pose.rotation.conjugate() * ray_in_cam(camera, pixel), centre = centre_of(pose);
      if (ray.z() > -0.3)
        return fail(Errc::kBadInput,
                    "the images show the horizon: longer focal length or smaller attitude_jitter_deg needed");
      area.include((centre + ray * ((level_m - centre.z()) / ray.z())).head<2>());
    }
  return area.grown(2 + margin_m, 2 + margin_m);
}

// Open ground in the sun, as a surveyor would choose it.
std::vector<Mark> open_positions(const Scene& scene, const Area& area, double half_size_m, int count, Random random) {
  std::vector<Mark> marks;
  for (int trial = 0; trial < 20 * count && int(marks.size()) < count; ++trial) {
    const double x = random.uniform(area.low.x(), area.high.x()), y = random.uniform(area.low.y(), area.high.y());
    const double heading = random.uniform(0, std::numbers::pi / 2), z = scene.terrain_height(x, y);
    bool open = true;
    for (int i = 0; i < 9 && open; ++i) {
      const double u = x + (i % 3 - 1) * (1.5 + half_size_m), v = y + (i / 3 - 1) * (1.5 + half_size_m);
      const double ground = scene.terrain_height(u, v);
      open = scene.surface_height(u, v) == ground && scene.in_sun({u, v, ground}, scene.terrain().normal(u, v));
    }
    if (open)
      marks.push_back({{x, y, z},
                       {std::cos(heading), std::sin(heading), 0},
                       {-std::sin(heading), std::cos(heading), 0},
                       half_size_m});
  }
  return marks;
}

// What differs between the kinds of country, unless it is given.
struct CountryDefaults {
  double relief_m, building_area_m2;
  double cell_m, cell_gsds;  // of the terrain, the larger of the two
};

CountryDefaults defaults_of(Country country) {
  switch (country) {
    case Country::kTown:
      return {12, 600, 0.5, 2};
    case Country::kRocks:
      return {250, 60000, 0.5, 2};
    default:
      return {8, 1400, 0.25, 5};
  }
}

CountryOptions country_of(const SurveyOptions& o, const Plan& plan, const Area& shown, const Area& mapped) {
  const CountryDefaults defaults = defaults_of(o.country);
  const Area built = o.country == Country::kVillage ? mapped.grown(10, 10) : shown;
  CountryOptions country;
  country.low = shown.low;
  country.high = shown.high;
  country.built_low = built.low;
  country.built_high = built.high;
  country.cell_m = std::max(defaults.cell_m, defaults.cell_gsds * plan.gsd_m);
  country.relief_m = o.relief_m.value_or(defaults.relief_m);
  country.building_area_m2 = o.building_area_m2.value_or(defaults.building_area_m2);
  country.seed = std::uint64_t(o.seed);
  return country;
}

Scene scene_of(Country country, const CountryOptions& options) {
  switch (country) {
    case Country::kTown:
      return make_town(options);
    case Country::kRocks:
      return make_rocks(options);
    default:
      return make_village(options);
  }
}

// The land that products are made of. In one strip all that two images show.
Area mapped_area(const Plan& plan, const Area& flown) {
  if (plan.strips > 1 || plan.cross_strips > 0) return flown.grown(0.3 * plan.across_m, 0.3 * plan.along_m);
  constexpr double kWithin = 0.47;  // of the size of an image, from its middle: tilts move its sides
  return flown.grown(kWithin * plan.across_m, std::max(kWithin * plan.along_m - plan.base_m, 0.05 * plan.along_m));
}

Result<> mark_control(Truth& truth, const SurveyOptions& o, const Area& mapped, const Run& run) {
  MarkOptions marks;
  marks.control_points = o.control_points;
  marks.check_points = o.check_points;
  marks.sigma_m = {o.control_sigma_plan_m, o.control_sigma_plan_m, o.control_sigma_height_m};
  marks.measurement_sigma_px = o.measurement_sigma_px;
  marks.least_images = std::min(3, int(truth.block.images.size()));
  const int candidates = 20 * (o.control_points + o.check_points) + 100;
  const double half_size_m = 4.5 * truth.gsd_m;
  return add_marks(truth, open_positions(truth.scene, mapped, half_size_m, candidates, Random(truth.seed, 7)), marks,
                   run);
}

}  // namespace

Result<Truth> make_survey(const SurveyOptions& o, const Run& run) {
  COLLINEA_TRY(validate(o));
  COLLINEA_TRY(const Camera camera, true_camera(o.camera, 0.67));
  return make_survey(o, camera, 0, run);
}

Result<Truth> make_survey(const SurveyOptions& o, const Camera& camera, double margin_px, const Run& run) {
  COLLINEA_TRY(validate(o));
  COLLINEA_TRY(LocalFrame frame,
               LocalFrame::create(o.site.crs, o.site.latitude_deg, o.site.longitude_deg, o.site.ground_height_m));
  const Plan plan = plan_of(o, camera);
  const auto seed = std::uint64_t(o.seed);
  const std::vector<Station> stations = stations_of(plan);
  std::vector<Rigid3> poses;
  Area flown;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    poses.push_back(looking_down(stations[i], o, Random(seed, 100 + i)));
    flown.include({stations[i].x, stations[i].y});
  }
  COLLINEA_TRY(const Area shown,
               ground_in_view(plan.camera, poses, -1.2 * o.relief_m.value_or(defaults_of(o.country).relief_m),
                              1.2 * margin_px * plan.gsd_m));
  const Area mapped = mapped_area(plan, flown);

  Truth truth{.scene = scene_of(o.country, country_of(o, plan, shown, mapped)),
              .frame = frame,
              .block = {},
              .marks_in_world = {},
              .exposure = {},
              .optics = optics_of(o.light),
              .mapped = std::pair(mapped.low, mapped.high)};
  truth.block.georeference =
      Georeference{o.site.crs, o.site.latitude_deg, o.site.longitude_deg, o.site.ground_height_m};
  truth.gsd_m = plan.gsd_m;
  truth.nominal_focal_px = plan.camera.focal_px() / kFocalError;
  truth.seed = seed;
  add_images(truth, plan.camera, poses, o.light.exposure_sigma, o.white_balance_sigma);
  if (o.receiver.gps) {
    add_positions(truth, o.receiver.gps_sigma_plan_m, o.receiver.gps_sigma_height_m);
    add_attitudes(truth, kGimbalSigma_deg);
  }
  COLLINEA_TRY(mark_control(truth, o, mapped, run));
  return truth;
}

}  // namespace collinea
