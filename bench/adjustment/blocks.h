// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/math/random.h"
#include "collinea/quality/examine.h"

namespace collinea::bench {

enum class Layout {
  kCrossStrips,  ///< nadir strips and two across, positions and control
  kRing,         ///< two rings of images around an object, control
  kCorridor,     ///< two strips along a bending road, positions and control at the ends
};
inline constexpr const char* kLayoutNames[] = {"nadir and cross strips", "terrestrial ring", "corridor"};

struct BlockSize {
  int points = 300, control = 8;
};

[[nodiscard]] Eigen::Vector3d normal3(Random& random);

/// An exact block: poses, cameras, points, control, and measurements without errors that name their sigmas (0.5 px,
/// control 1 cm, positions 3 cm). Every seed is another world.
[[nodiscard]] Block exact_block(Layout layout, const BlockSize& size, std::uint64_t seed);

/// A nadir block of `rows` x `columns` images with that many points, each seen in up to 12 of them; no control.
[[nodiscard]] Block large_exact_block(int rows, int columns, int points);

struct Measured {
  Block block;
  AdjustScope scope;
};

/// The exact block with normal errors of its sigmas, a start that is a little off, and first values of the cameras with
/// the errors that their weak observations stand for.
[[nodiscard]] Measured measured(const Block& exact, std::uint64_t seed);

/// Options that iterate until nothing changes any more, without losses.
[[nodiscard]] ExamineOptions exact_options(Calibration calibration);

}  // namespace collinea::bench
