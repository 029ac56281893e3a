// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/base/words.h"

namespace collinea {

/// How an image is read between its samples.
enum class Interpolation : std::uint8_t { kBilinear, kBicubic };
inline constexpr Word<Interpolation> kInterpolationWords[] = {
    {Interpolation::kBilinear, "bilinear", "of the four samples around: smooths"},
    {Interpolation::kBicubic, "bicubic", "cubic convolution of the sixteen around"}};
[[nodiscard]] constexpr std::span<const Word<Interpolation>> words(Interpolation) { return kInterpolationWords; }

}  // namespace collinea
