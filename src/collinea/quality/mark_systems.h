// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "collinea/base/words.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// How image coordinates (u, v) of marks may have been counted by the program that measured them. The pixel (x, y) of
/// an image of w x h pixels follows from them; s is a factor that is the same for all marks.
enum class MarkSystem : std::uint8_t {
  kAsGiven,             ///< (u, v): columns to the right, rows down, from the upper-left corner
  kRowsUp,              ///< (u, h - v)
  kColumnsLeft,         ///< (w - u, v)
  kUpsideDown,          ///< (w - u, h - v): measured in images that were shown turned by 180 degrees
  kExchanged,           ///< (v, u): columns and rows exchanged
  kTurnedRight,         ///< (v, h - u): measured in images that were shown turned clockwise (EXIF orientation 6)
  kTurnedLeft,          ///< (w - v, u): shown turned counterclockwise (EXIF orientation 8)
  kCentre,              ///< (w / 2 + u, h / 2 + v): from the middle of the image
  kCentreRowsUp,        ///< (w / 2 + u, h / 2 - v)
  kResampled,           ///< s (u, v): measured in images of another size
  kResampledRowsUp,     ///< (s u, h - s v)
  kScaledCentre,        ///< (w / 2 + s u, h / 2 + s v): millimetres from the middle, or another unit
  kScaledCentreRowsUp,  ///< (w / 2 + s u, h / 2 - s v)
};

inline constexpr Word<MarkSystem> kMarkSystemWords[] = {
    {MarkSystem::kAsGiven, "as_given"},
    {MarkSystem::kRowsUp, "rows_up"},
    {MarkSystem::kColumnsLeft, "columns_left"},
    {MarkSystem::kUpsideDown, "upside_down"},
    {MarkSystem::kExchanged, "exchanged"},
    {MarkSystem::kTurnedRight, "turned_right"},
    {MarkSystem::kTurnedLeft, "turned_left"},
    {MarkSystem::kCentre, "centre"},
    {MarkSystem::kCentreRowsUp, "centre_rows_up"},
    {MarkSystem::kResampled, "resampled"},
    {MarkSystem::kResampledRowsUp, "resampled_rows_up"},
    {MarkSystem::kScaledCentre, "scaled_centre"},
    {MarkSystem::kScaledCentreRowsUp, "scaled_centre_rows_up"},
};
constexpr std::span<const Word<MarkSystem>> words(MarkSystem) { return kMarkSystemWords; }

[[nodiscard]] constexpr bool has_factor(MarkSystem system) { return system >= MarkSystem::kResampled; }

/// The same with the factor 1; of a system without a factor itself.
[[nodiscard]] constexpr MarkSystem without_factor(MarkSystem system) {
  switch (system) {
    case MarkSystem::kResampled:
      return MarkSystem::kAsGiven;
    case MarkSystem::kResampledRowsUp:
      return MarkSystem::kRowsUp;
    case MarkSystem::kScaledCentre:
      return MarkSystem::kCentre;
    case MarkSystem::kScaledCentreRowsUp:
      return MarkSystem::kCentreRowsUp;
    default:
      return system;
  }
}

/// A system with its factor (1 where it has none).
struct MarkHypothesis {
  MarkSystem system = MarkSystem::kAsGiven;
  double factor = 1;
};

/// pixel = linear * (u, v) + origin [px].
struct MarkMap {
  Eigen::Matrix2d linear;
  Eigen::Vector2d origin;
};

/// What the hypothesis says of marks in images of that size; (0.5, 0.5) is the centre of the upper-left pixel in all of
/// them, since half a pixel is too small to be told.
[[nodiscard]] MarkMap map_of(const MarkHypothesis& hypothesis, double width_px, double height_px);
[[nodiscard]] Eigen::Vector2d pixel_of(const MarkHypothesis& hypothesis, const Camera& camera,
                                       const Eigen::Vector2d& given);

}  // namespace collinea
