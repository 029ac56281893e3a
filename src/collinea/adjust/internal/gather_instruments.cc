// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/gather_instruments.h"

#include <cmath>
#include <map>

#include "collinea/adjust/internal/candidates.h"
#include "collinea/block/subject_label.h"

namespace collinea::bundle {
namespace {

/// Positions, verticals and attitudes of the free images.
class InstrumentLayout {
 public:
  InstrumentLayout(const Block& block, const AdjustScope& scope, ProblemAndStart& out)
      : block_(block), scope_(scope), problem_(out.problem), start_(out.start) {}

  Result<> lay_out() {
    if (Result<> taken = take_positions(); !taken) return taken;
    if (Result<> taken = take_time_offsets(); !taken) return taken;
    if (Result<> taken = take_verticals(); !taken) return taken;
    return take_attitudes();
  }

 private:
  Result<> take_positions() {
    if (!scope_.use_positions) return {};
    for (int i = 0; i < problem_.poses; ++i) {
      const Image& image = block_.images.at(problem_.images[i].id);
      if (!image.position) continue;
      if (!(image.position->sigma_m.minCoeff() > 0))
        return fail(Errc::kBadInput, "the position of " + image.file + " has no positive standard deviation");
      const Eigen::Vector3d &position = image.position->position_in_world, &sigma_m = image.position->sigma_m;
      for (int axis = 0; axis < 3; ++axis)
        if (!is_known(position[axis], sigma_m[axis]))
          return fail(Errc::kBadInput, "the position of " + image.file + " has no finite coordinates");
      const Eigen::Vector3d inverse_sigma = sigma_m.cwiseInverse();
      problem_.positions.push_back(
          {static_cast<std::uint32_t>(i), (inverse_sigma.array() > 0).select(position, 0.0), inverse_sigma});
      if (Result<> placed = locate_antenna(problem_.positions.back(), image.camera); !placed) return placed;
    }
    return {};
  }

  // Three unknowns, made when they are first asked for; -1 when all sigmas are 0: there are none.
  Result<int> three_auxiliaries(UnknownKind kind, std::uint32_t owner, const Eigen::Vector3d& given,
                                const Eigen::Vector3d& sigma) {
    if ((sigma.array() == 0).all()) return -1;
    if (!(sigma.minCoeff() > 0) || !given.allFinite())
      return fail(Errc::kBadInput, label_of(subject_of(kind, owner, 0), block_) +
                                       " needs finite values with standard deviations that are all zero or all "
                                       "positive (infinite: not known)");
    auto& auxiliaries = problem_.auxiliaries;
    for (std::size_t i = 0; i < auxiliaries.size(); ++i)
      if (auxiliaries[i].kind == kind && auxiliaries[i].owner == owner) return static_cast<int>(i);
    const auto first = static_cast<int>(auxiliaries.size());
    for (int axis = 0; axis < 3; ++axis) {
      auxiliaries.push_back({kind, owner, axis, given[axis], 1 / sigma[axis]});
      start_.auxiliaries.push_back(given[axis]);
    }
    return first;
  }

  Result<> locate_antenna(GivenPosition& position, CameraId camera) {
    const ImageId id = problem_.images[position.image].id;
    if (const auto its = scope_.lever_arms.find(camera); its != scope_.lever_arms.end()) {
      const LeverArm& arm = its->second;
      COLLINEA_TRY(position.lever_arm,
                   three_auxiliaries(UnknownKind::kLeverArm, camera.value, arm.antenna_in_cam_m, arm.sigma_m));
      if (position.lever_arm < 0) position.arm = arm.antenna_in_cam_m;
      if (!position.arm.allFinite()) return fail(Errc::kBadInput, "the lever arm is no vector of finite numbers");
    }
    for (std::uint32_t t = 0; t < scope_.position_tracks.size(); ++t) {
      const PositionTrack& track = scope_.position_tracks[t];
      const auto time = track.time.find(id);
      if (time == track.time.end()) continue;
      position.time = time->second;
      if (!std::isfinite(position.time)) return fail(Errc::kBadInput, "a time of a track of positions is not finite");
      const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
      COLLINEA_TRY(position.shift, three_auxiliaries(UnknownKind::kShift, t, zero, track.shift_sigma_m));
      COLLINEA_TRY(position.drift, three_auxiliaries(UnknownKind::kDrift, t, zero, track.drift_sigma_m));
      break;
    }
    return {};
  }

  // Behind all shifts, so that where they cannot be parted the offset is what is reported as not determined.
  Result<> take_time_offsets() {
    std::map<CameraId, int> number;
    for (GivenPosition& position : problem_.positions) {
      const ImageId id = problem_.images[position.image].id;
      const CameraId camera = block_.images.at(id).camera;
      const auto sigma = scope_.time_offset_sigma_s.find(camera);
      const auto velocity = scope_.velocity_m_s.find(id);
      if (sigma == scope_.time_offset_sigma_s.end() || sigma->second == 0 || velocity == scope_.velocity_m_s.end())
        continue;
      if (!(sigma->second > 0) || !velocity->second.allFinite())
        return fail(Errc::kBadInput, label_of(subject_of(UnknownKind::kTimeOffset, camera.value, 0), block_) +
                                         " needs a standard deviation from 0 (infinite: not known) and finite "
                                         "velocities");
      const auto [its, is_new] = number.emplace(camera, static_cast<int>(problem_.auxiliaries.size()));
      if (is_new) {
        problem_.auxiliaries.push_back({UnknownKind::kTimeOffset, camera.value, 0, 0, 1 / sigma->second});
        start_.auxiliaries.push_back(0);
      }
      position.time_offset = its->second;
      position.velocity = velocity->second;
    }
    return {};
  }

  Result<> take_attitudes() {
    for (int i = 0; i < problem_.poses; ++i) {
      const ImageId id = problem_.images[i].id;
      const auto its = scope_.attitudes.find(id);
      if (its == scope_.attitudes.end()) continue;
      const auto& [cam_from_world, sigma_rad] = its->second;
      if (!(sigma_rad.minCoeff() > 0) || !(std::abs(cam_from_world.norm() - 1) < 1e-6))
        return fail(Errc::kBadInput, "the attitude of " + block_.images.at(id).file +
                                         " is no rotation with positive standard deviations");
      GivenRotation given{static_cast<std::uint32_t>(i), cam_from_world, sigma_rad.cwiseInverse()};
      const CameraId camera = block_.images.at(id).camera;
      if (const auto sigma = scope_.boresight_sigma_rad.find(camera); sigma != scope_.boresight_sigma_rad.end()) {
        COLLINEA_TRY(given.boresight,
                     three_auxiliaries(UnknownKind::kBoresight, camera.value, Eigen::Vector3d::Zero(), sigma->second));
      }
      problem_.attitudes.push_back(given);
    }
    return {};
  }

  Result<> take_verticals() {
    for (int i = 0; i < problem_.poses; ++i) {
      const auto given = scope_.verticals.find(problem_.images[i].id);
      if (given == scope_.verticals.end()) continue;
      const auto& [up_in_cam, sigma_rad] = given->second;
      if (!(sigma_rad > 0) || !(std::abs(up_in_cam.norm() - 1) < 1e-6))
        return fail(Errc::kBadInput, "the vertical of " + block_.images.at(given->first).file +
                                         " is no direction with a positive standard deviation");
      problem_.verticals.push_back({static_cast<std::uint32_t>(i), up_in_cam, 1 / sigma_rad});
    }
    return {};
  }

  const Block& block_;
  const AdjustScope& scope_;
  Problem& problem_;
  State& start_;
};

}  // namespace

Result<> lay_out_instruments(const Block& block, const AdjustScope& scope, ProblemAndStart& out) {
  return InstrumentLayout(block, scope, out).lay_out();
}

}  // namespace collinea::bundle
