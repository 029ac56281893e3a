// SPDX-License-Identifier: Apache-2.0
#pragma once

// Flights with systematic errors of known size, for tests and benchmarks.

#include <cmath>
#include <utility>
#include <vector>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/examine.h"

namespace collinea::testing {

/// What is wrong with what was measured.
struct Wrong {
  double time_offset_s = 0;
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< of `strip`, or of all
  int strip = -1;
  Eigen::Vector3d drift_m = Eigen::Vector3d::Zero();  ///< over the whole flight
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  int assignment = 0;  ///< positions are those of so many images further
  double bowl_m = 0;   ///< at the rim of positions
  double b1_px = 0, b2_px = 0;
  double shutter_s = 0;
  double refraction = 0;  ///< share of the standard one
  AdditionalSet additional = AdditionalSet::kNone;
  double additional_px = 0;  ///< of its last parameter
};

struct FlightOptions {
  int strips = 4, images = 6;  ///< images of a strip
  int points = 150, control = 9;
  double sigma_px = 0.5, position_sigma_m = 0.02, control_sigma_m = 0.01;
  bool noise = true;
  bool attitudes = false;
  double rotation_rad = 3.1;  ///< of the camera in every second strip
};

struct Flown {
  Block block;
  AdjustScope scope;
  SystematicOptions systematics;
  Block truth;
};

/// The lens and the way of a camera as they truly are; answers where it sees a point.
class TrueImage {
 public:
  TrueImage(const Camera& camera, const Rigid3& pose, const Eigen::Vector3d& velocity, const Wrong& wrong,
            double raise_per_square_m)
      : camera_(camera), pose_(pose), velocity_(velocity), wrong_(wrong), raise_(raise_per_square_m) {
    camera_.params[Camera::kB1] += wrong.b1_px;
    camera_.params[Camera::kB2] += wrong.b2_px;
    if (wrong.additional == AdditionalSet::kNone) return;
    camera_.additional = wrong.additional;
    camera_.params[Camera::kParams + count_of(wrong.additional) - 1] = wrong.additional_px;
  }

  [[nodiscard]] std::optional<Eigen::Vector2d> see(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d centre = centre_of(pose_);
    const Eigen::Vector3d raised =
        point + Eigen::Vector3d(0, 0, wrong_.refraction * raise_ * (point - centre).squaredNorm());
    double row = camera_.height_px / 2.0;
    std::optional<Eigen::Vector2d> pixel;
    for (int round = 0; round < 4; ++round) {
      const Eigen::Vector3d there = centre + (row / camera_.height_px - 0.5) * wrong_.shutter_s * velocity_;
      pixel = project(camera_, pose_.rotation * (raised - there));
      if (!pixel) return pixel;
      row = pixel->y();
    }
    return pixel;
  }

 private:
  Camera camera_;
  Rigid3 pose_;
  Eigen::Vector3d velocity_;
  const Wrong& wrong_;
  double raise_;
};

/// Images in the order flown: strips there and back.
inline std::vector<std::vector<ImageId>> flown_order(const FlightOptions& o) {
  std::vector<std::vector<ImageId>> strips;
  for (int strip = 0; strip < o.strips; ++strip) {
    std::vector<ImageId>& images = strips.emplace_back();
    for (int k = 0; k < o.images; ++k)
      images.push_back({static_cast<std::uint32_t>(10 + strip * o.images + (strip % 2 ? o.images - 1 - k : k))});
  }
  return strips;
}

/// Positions of images, as the receiver states them.
inline void give_positions(Flown& made, const FlightOptions& o, const Wrong& wrong, Random& random) {
  std::vector<ImageId> sequence;
  for (const auto& strip : flown_order(o)) sequence.insert(sequence.end(), strip.begin(), strip.end());
  Eigen::Vector2d middle(0, 0);
  for (const ImageId id : sequence)
    middle += centre_of(pose_of(made.truth, id)).head<2>() / static_cast<double>(sequence.size());
  double radius = 0;
  for (const ImageId id : sequence)
    radius = std::max(radius, (centre_of(pose_of(made.truth, id)).head<2>() - middle).norm());
  const auto count = static_cast<int>(sequence.size());
  for (int k = 0; k < count; ++k) {
    const ImageId id = sequence[static_cast<std::size_t>(k)];
    const Rigid3& pose = pose_of(made.truth, id);
    const ImageId whose = sequence[static_cast<std::size_t>(std::clamp(k + wrong.assignment, 0, count - 1))];
    Eigen::Vector3d position = centre_of(pose_of(made.truth, whose)) + pose.rotation.conjugate() * wrong.lever_arm_m +
                               wrong.time_offset_s * made.systematics.velocity_m_s.at(id) +
                               (double(k) / (count - 1) - 0.5) * wrong.drift_m;
    if (wrong.strip < 0 || wrong.strip == k / o.images) position += wrong.shift_m;
    position.z() += wrong.bowl_m * (centre_of(pose).head<2>() - middle).squaredNorm() / (radius * radius);
    if (o.noise) position += o.position_sigma_m * normal3(random);
    made.block.images[id].position = PositionPrior{position, Eigen::Vector3d::Constant(o.position_sigma_m)};
  }
}

/// A nadir block with control and positions, flown at 8 m/s with some wind.
inline Flown flown(std::uint64_t seed, const Wrong& wrong = {}, const FlightOptions& o = {}) {
  const TestBlockOptions options{.rows = o.strips,
                                 .columns = o.images,
                                 .points = o.points,
                                 .control = o.control,
                                 .control_sigma_m = o.control_sigma_m,
                                 .tilt_rad = 0.05,
                                 .rotation_rad = o.rotation_rad,
                                 .seed = seed};
  Flown made{test_block(options), {}, {}, {}};
  made.block.georeference = {"EPSG:32633", 48.2, 15.63, 300};
  made.truth = made.block;
  Random random(seed, 71);
  made.systematics.test = true;
  for (const auto& strip : flown_order(o)) {
    std::map<ImageId, double>& times = made.systematics.strips.emplace_back();
    const double sign = made.systematics.strips.size() % 2 ? 1 : -1;
    for (const ImageId id : strip) {
      times[id] = static_cast<double>(times.size()) * 15 / 8;
      made.systematics.velocity_m_s[id] = Eigen::Vector3d(8 * sign, 0, 0) + 0.8 * normal3(random);
    }
  }
  give_positions(made, o, wrong, random);
  const double raise = 2e-8;  // about that of the standard atmosphere near the ground
  const auto measure = [&](ImageId image, const Eigen::Vector3d& point, auto& seen) {
    const TrueImage true_image(made.truth.camera_of(image), pose_of(made.truth, image),
                               made.systematics.velocity_m_s.at(image), wrong, raise);
    seen.pixel = *true_image.see(point);
    const double du = random.normal(), dv = random.normal();
    if (o.noise) seen.pixel += o.sigma_px * Eigen::Vector2d(du, dv);
    seen.sigma_px = o.sigma_px;
  };
  for (Observation& seen : made.block.observations)
    measure(seen.image, made.truth.points.at(seen.point).position_in_world, seen);
  for (ControlObservation& seen : made.block.control_observations)
    measure(seen.image, made.truth.control.at(seen.point).position_in_world, seen);
  for (auto& [id, control] : made.block.control)
    if (o.noise) control.position_in_world += o.control_sigma_m * normal3(random);
  for (const auto& [id, image] : made.block.images) {
    if (!o.attitudes) break;
    const Rigid3& pose = pose_of(made.truth, id);
    const double sigma = 0.001;
    made.scope.attitudes[id] = {(rotation_by(wrong.boresight_rad).conjugate() * pose.rotation *
                                 rotation_by((o.noise ? sigma : 0) * normal3(random)))
                                    .normalized(),
                                Eigen::Vector3d::Constant(sigma)};
  }
  return made;
}

/// Nothing is robust, everything to the last step, sigmas are true.
inline ExamineOptions looking_for_systematics(const Flown& made, Calibration calibration = Calibration::kNone) {
  ExamineOptions options{.adjust = plain(calibration)};
  options.systematics = made.systematics;
  options.systematics.sigma0_known = true;
  return options;
}

}  // namespace collinea::testing
