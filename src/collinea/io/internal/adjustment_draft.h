// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collinea/block/gnss_vector.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/internal/adjustment_instruments.h"
#include "collinea/io/internal/adjustment_line.h"

namespace collinea {

/// An adjustment file half read: what its lines gave so far, and what waits until all names are known.
struct AdjustmentDraft {
  /// An image measurement of control, which may stand above the line of its point.
  struct Measured {
    std::size_t line;
    ImageId image;
    std::string point;
    Eigen::Vector2d pixel;
    double sigma;
    PixelShape shape;
  };

  /// A geodetic observation between points that may be named later.
  struct GeodeticLine {
    std::size_t line;
    std::string from, to;
    GeodeticObservation measured;
    GnssVector vector;           ///< of kGnssVector
    bool is_geocentric = false;  ///< it is along the axes of the Earth
  };

  struct Tie {
    std::size_t line;
    Observation seen;
  };

  AdjustmentFile file;
  std::map<std::string, CameraId> cameras;
  std::map<std::string, ImageId> images;
  std::map<std::string, ControlId> control;
  std::set<std::pair<CameraId, std::size_t>> parameters;
  std::vector<Measured> measured;
  std::vector<GeodeticLine> geodetic;
  std::optional<std::pair<std::size_t, Eigen::Vector2d>> deflection_rad;  // line; north, east
  InstrumentLines instruments;
  std::map<GeodeticKind, std::map<std::string, std::uint32_t>> shapes;
  std::vector<std::pair<std::size_t, ControlId>> in_map;  // lines and points
  std::vector<Tie> ties;
};

/// Takes one line that begins with a keyword. An error names the line, and what was expected there.
[[nodiscard]] Result<> take_adjustment_line(const AdjustmentLine& line, AdjustmentDraft& draft);

}  // namespace collinea
