// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>

#include "collinea/block/instruments.h"
#include "collinea/io/internal/adjustment_line.h"

namespace collinea {

/// Reads the lines of an adjustment file that are of receivers and inertial systems: attitude, lever_arm, boresight,
/// track, on_track, time_offset, velocity. Each of a thing at most once.
class InstrumentLines {
 public:
  [[nodiscard]] Result<> take_attitude(const AdjustmentLine& line, ImageId image);
  [[nodiscard]] Result<> take_lever_arm(const AdjustmentLine& line, CameraId camera);
  [[nodiscard]] Result<> take_boresight(const AdjustmentLine& line, CameraId camera);
  [[nodiscard]] Result<> take_time_offset(const AdjustmentLine& line, CameraId camera);
  [[nodiscard]] Result<> take_velocity(const AdjustmentLine& line, ImageId image);
  [[nodiscard]] Result<> take_track(const AdjustmentLine& line);
  [[nodiscard]] Result<> take_on_track(const AdjustmentLine& line, ImageId image);

  [[nodiscard]] const Instruments& found() const { return found_; }

 private:
  Instruments found_;
  std::map<std::string, std::size_t> tracks_;  // indices in position_tracks
  std::set<ImageId> on_track_;
};

}  // namespace collinea
