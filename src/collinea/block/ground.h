// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include "collinea/base/id.h"

namespace collinea {

/// What is measured on the ground between two points.
enum class GroundKind : std::uint8_t {
  kDistance,          ///< in space, tape, scale bar or total station [m]
  kHeightDifference,  ///< height of `to` minus that of `from` [m]; 0 for equal heights
  kDirection,         ///< reading of the horizontal circle at `from`, clockwise [rad]
  kZenithAngle,       ///< at `from`, 0 upwards [rad]
};
inline constexpr std::size_t kGroundKinds = 4;
inline constexpr std::array<const char*, kGroundKinds> kGroundKindNames = {"distance", "height difference", "direction",
                                                                           "zenith angle"};

enum class ControlRole { kControl, kCheck };

/// One measurement between two control points, which need no coordinates of their own.
struct GroundObservation {
  static constexpr std::uint32_t kNoSetup = ~std::uint32_t{0};

  GroundKind kind = GroundKind::kDistance;
  std::string name;  ///< as its file calls it; may be empty
  ControlId from, to;
  double value = 0, sigma = 0;               ///< [m], or [rad] for angles
  ControlRole role = ControlRole::kControl;  ///< kCheck: only compared
  std::uint32_t setup = kNoSetup;            ///< directions of one set-up of the instrument share its orientation
  double instrument_height_m = 0, target_height_m = 0;  ///< above the marks

  [[nodiscard]] bool is_angle() const { return kind == GroundKind::kDirection || kind == GroundKind::kZenithAngle; }
};

}  // namespace collinea
