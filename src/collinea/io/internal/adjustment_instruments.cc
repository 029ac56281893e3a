// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/adjustment_instruments.h"

#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/adjustment_words.h"

namespace collinea {
namespace {

tl::unexpected<Error> twice(const AdjustmentLine& line) {
  return bad_line(line.number, "a second " + line.words[0] + " of " + shown(line.words[1]));
}

}  // namespace

Result<> InstrumentLines::take_attitude(const AdjustmentLine& line, ImageId image) {
  COLLINEA_TRY(const Eigen::Vector3d angles, finite3(line, 2, "an angle"));
  COLLINEA_TRY(const Eigen::Vector3d sigma_deg, deviation3(line, 5));
  if (!(sigma_deg.minCoeff() > 0)) return bad_line(line.number, "a measured attitude has standard deviations above 0");
  const GivenAttitude given{cam_from_world(OmegaPhiKappa{angles[0], angles[1], angles[2]}), sigma_deg * kDegree};
  if (!found_.attitudes.emplace(image, given).second) return twice(line);
  return {};
}

Result<> InstrumentLines::take_lever_arm(const AdjustmentLine& line, CameraId camera) {
  LeverArm arm;
  COLLINEA_TRY(arm.antenna_in_cam_m, finite3(line, 2, "a coordinate"));
  COLLINEA_TRY(arm.sigma_m, deviation3(line, 5));
  if (!found_.lever_arms.emplace(camera, arm).second) return twice(line);
  return {};
}

Result<> InstrumentLines::take_boresight(const AdjustmentLine& line, CameraId camera) {
  COLLINEA_TRY(const Eigen::Vector3d sigma_deg, deviation3(line, 2));
  if (!found_.boresight_sigma_rad.emplace(camera, sigma_deg * kDegree).second) return twice(line);
  return {};
}

Result<> InstrumentLines::take_time_offset(const AdjustmentLine& line, CameraId camera) {
  COLLINEA_TRY(const double sigma_s, deviation(line, 2));
  if (!found_.time_offset_sigma_s.emplace(camera, sigma_s).second) return twice(line);
  return {};
}

Result<> InstrumentLines::take_velocity(const AdjustmentLine& line, ImageId image) {
  COLLINEA_TRY(const Eigen::Vector3d velocity, finite3(line, 2, "a velocity"));
  if (!found_.velocity_m_s.emplace(image, velocity).second) return twice(line);
  return {};
}

Result<> InstrumentLines::take_track(const AdjustmentLine& line) {
  if (!tracks_.emplace(line.words[1], found_.position_tracks.size()).second) return twice(line);
  PositionTrack track;
  COLLINEA_TRY(track.shift_sigma_m, deviation3(line, 2));
  COLLINEA_TRY(track.drift_sigma_m, deviation3(line, 5));
  found_.position_tracks.push_back(std::move(track));
  return {};
}

Result<> InstrumentLines::take_on_track(const AdjustmentLine& line, ImageId image) {
  const auto track = tracks_.find(line.words[2]);
  if (track == tracks_.end())
    return bad_line(line.number, "there is no track " + shown(line.words[2]) + " above: add a line track " +
                                     line.words[2] + " SX SY SZ DX DY DZ");
  COLLINEA_TRY(const double time, finite(line, 3, "a time"));
  if (!on_track_.insert(image).second) return bad_line(line.number, shown(line.words[1]) + " is on a track already");
  found_.position_tracks[track->second].time[image] = time;
  return {};
}

}  // namespace collinea
