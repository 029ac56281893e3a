// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/field_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/parallel.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

// What is stated of exact values: tables and headers are written with so many digits, and an adjustment needs a weight.
constexpr double kLeastSigma_m = 1e-4, kLeastSigma_px = 1e-3, kLeastPositionSigma_m = 1e-3;

// Streams of random numbers, one for each kind of error.
enum Stream : std::uint64_t {
  kExposure = 1000,
  kPosition = 2000,
  kAttitude = 3000,
  kSurvey = 4000,
  kMeasurement = 5000
};

Random stream(const Truth& truth, Stream kind, std::uint64_t item) {
  return Random(truth.seed, (std::uint64_t{kind} << 32) + item);
}

std::string time_of(int exposure) {
  const int seconds = 10 * 3600 + 5 * 60 + 3 * exposure;
  return fmt::format("2024:06:15 {:02}:{:02}:{:02}.000", seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
}

// The whole board is on the image and nothing hides a corner of it.
std::optional<Eigen::Vector2d> whole_mark(const Truth& truth, ImageId image, const Mark& mark, double margin_px) {
  const auto centre = seen_at(truth, image, mark.centre, margin_px);
  if (!centre) return std::nullopt;
  for (int i = 0; i < 4; ++i) {
    const double u = (i & 1 ? 1.2 : -1.2) * mark.half_size_m, v = (i & 2 ? 1.2 : -1.2) * mark.half_size_m;
    Eigen::Vector3d corner = mark.centre + u * mark.right + v * mark.up;
    const bool lies = std::abs(mark.right.z()) + std::abs(mark.up.z()) < 1e-9;
    if (lies) corner.z() = truth.scene.terrain_height(corner.x(), corner.y());
    if (!seen_at(truth, image, corner)) return std::nullopt;
  }
  return centre;
}

struct Sighting {
  ImageId image;
  Eigen::Vector2d pixel;
};

std::vector<Sighting> sightings(const Truth& truth, const Mark& mark, double margin_px) {
  std::vector<Sighting> list;
  for (const auto& [id, image] : truth.block.images)
    if (const auto pixel = whole_mark(truth, id, mark, margin_px)) list.push_back({id, *pixel});
  return list;
}

// Farthest-point sampling: starts at the position farthest from the middle, goes on with the position farthest from all
// chosen.
std::vector<std::size_t> spread(const std::vector<Eigen::Vector3d>& positions, std::size_t count) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& position : positions) middle += position / double(positions.size());
  std::vector<double> room(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) room[i] = (positions[i] - middle).norm();
  std::vector<std::size_t> chosen;
  while (chosen.size() < std::min(count, positions.size())) {
    const std::size_t next = std::size_t(std::max_element(room.begin(), room.end()) - room.begin());
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double distance = (positions[i] - positions[next]).norm();
      room[i] = chosen.empty() ? distance : std::min(room[i], distance);
    }
    chosen.push_back(next);
  }
  return chosen;
}

void survey_mark(Truth& truth, const Mark& mark, const std::vector<Sighting>& seen, std::string name, ControlRole role,
                 const MarkOptions& options) {
  const ControlId id{std::uint32_t(truth.block.control.size())};
  Random random = stream(truth, kSurvey, id.value);
  ControlPoint point;
  point.name = std::move(name);
  point.role = role;
  point.sigma_m = options.sigma_m.cwiseMax(kLeastSigma_m);
  const Eigen::Vector3d error(random.normal(), random.normal(), random.normal());
  point.position_in_map = truth.frame.map_from_local(mark.centre) + error.cwiseProduct(options.sigma_m);
  point.position_in_world = truth.frame.local_from_map(point.position_in_map);
  truth.block.control.emplace(id, point);
  truth.marks_in_world.emplace(id, mark.centre);
  truth.scene.add(mark);
  Random measuring = stream(truth, kMeasurement, id.value);
  const double sigma_px = options.measurement_sigma_px;
  for (const Sighting& sighting : seen) {
    const Eigen::Vector2d noise(measuring.normal(), measuring.normal());
    truth.block.control_observations.push_back({id, sighting.image, sighting.pixel + sigma_px * noise,
                                                sigma_px > 0 ? std::max(sigma_px, kLeastSigma_px) : 0.1});
  }
}

}  // namespace

double bounded_normal(Random& random) { return std::clamp(random.normal(), -2.5, 2.5); }

Eigen::Quaterniond shaken(Random& random, double sigma_deg) {
  const double x = bounded_normal(random), y = bounded_normal(random), z = bounded_normal(random);
  return rotation_by(sigma_deg / kDegreesPerRadian * Eigen::Vector3d(x, y, z));
}

void add_images(Truth& truth, const Camera& camera, const std::vector<Rigid3>& cam_from_world, double exposure_sigma,
                double white_balance_sigma) {
  const CameraId camera_id{0};
  truth.block.cameras.emplace(camera_id, camera);
  for (std::size_t i = 0; i < cam_from_world.size(); ++i) {
    const ImageId id{std::uint32_t(i)};
    Image image;
    image.file = fmt::format("IMG_{:04}.jpg", i + 1);
    image.camera = camera_id;
    image.taken = time_of(int(i));
    truth.block.images.emplace(id, image);
    set_pose(truth.block, id, cam_from_world[i]);
    Random random = stream(truth, kExposure, i);
    truth.exposure.emplace(id, std::exp(exposure_sigma * bounded_normal(random)));
    if (white_balance_sigma == 0) continue;
    const double red = bounded_normal(random), blue = bounded_normal(random);
    truth.white[id] = {std::exp(white_balance_sigma * red), 1, std::exp(white_balance_sigma * blue)};
  }
}

void add_positions(Truth& truth, double sigma_plan_m, double sigma_height_m) {
  const Eigen::Vector3d sigma(sigma_plan_m, sigma_plan_m, sigma_height_m);
  for (auto& [id, image] : truth.block.images) {
    Random random = stream(truth, kPosition, id.value);
    const Eigen::Vector3d error(random.normal(), random.normal(), random.normal());
    PositionPrior prior;
    prior.position_in_world = centre_of(pose_of(truth.block, id)) + error.cwiseProduct(sigma);
    prior.sigma_m = sigma.cwiseMax(kLeastPositionSigma_m);
    const Eigen::Vector3d written = truth.frame.geographic_from_local(prior.position_in_world);
    prior.latitude_deg = written.x();
    prior.longitude_deg = written.y();
    prior.height_m = written.z();
    image.position = prior;
  }
}

void add_attitudes(Truth& truth, double sigma_deg) {
  for (auto& [id, image] : truth.block.images) {
    Random random = stream(truth, kAttitude, id.value);
    const Eigen::Matrix3d rotation = pose_of(truth.block, id).rotation.toRotationMatrix();
    const Eigen::Vector3d up = -rotation.row(1), axis = rotation.row(2);
    const double heading = std::atan2(up.x(), up.y());
    const double ahead = axis.x() * std::sin(heading) + axis.y() * std::cos(heading);
    AttitudePrior prior;
    prior.heading_deg = heading * kDegreesPerRadian + sigma_deg * random.normal();
    prior.pitch_deg = -std::atan2(-axis.z(), ahead) * kDegreesPerRadian + sigma_deg * random.normal();
    image.attitude = prior;
  }
}

Result<> add_marks(Truth& truth, const std::vector<Mark>& candidates, const MarkOptions& options, const Run& run) {
  const int wanted = options.control_points + options.check_points;
  if (wanted == 0) return {};
  std::vector<std::vector<Sighting>> seen(candidates.size());
  parallel_for(run, candidates.size(),
               [&](std::size_t i) { seen[i] = sightings(truth, candidates[i], options.margin_px); });
  if (run.stopped()) return fail(Errc::kCancelled, "choosing positions for survey marks was stopped");
  std::vector<std::size_t> usable;
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (int(seen[i].size()) >= options.least_images) {
      usable.push_back(i);
      positions.push_back(candidates[i].centre);
    }
  if (int(usable.size()) < wanted)
    return fail(Errc::kBadInput,
                fmt::format("{} survey marks are wanted, but only {} open positions are seen in {} images", wanted,
                            usable.size(), options.least_images));
  int number = 0;
  for (std::size_t index : spread(positions, std::size_t(wanted))) {
    const bool control = number < options.control_points;
    const std::string name =
        control ? fmt::format("C{:02}", number + 1) : fmt::format("K{:02}", number + 1 - options.control_points);
    survey_mark(truth, candidates[usable[index]], seen[usable[index]], name,
                control ? ControlRole::kControl : ControlRole::kCheck, options);
    ++number;
  }
  return {};
}

}  // namespace collinea
