// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How shades are shown with few grey values.
enum class Dither : std::uint8_t { kNone, kFloydSteinberg, kOrdered };
inline constexpr Word<Dither> kDitherWords[] = {
    {Dither::kNone, "none"},
    {Dither::kFloydSteinberg, "floyd-steinberg", "the error of each pixel goes on to its neighbours"},
    {Dither::kOrdered, "ordered", "cells of N x N pixels, of which as many are brighter as the shade asks for"}};
[[nodiscard]] constexpr std::span<const Word<Dither>> words(Dither) { return kDitherWords; }

/// Shades that cells of `cell` x `cell` pixels show with `levels` grey values: (levels - 1) cell^2 + 1 (Mussio 6.13).
[[nodiscard]] constexpr int shades_of(int levels, int cell) { return (levels - 1) * cell * cell + 1; }

/// Floyd and Steinberg (1976), rows from left to right: 7/16 of the error to the right, 3/16, 5/16 and 1/16 below. The
/// result has the grey values 255 i / (levels - 1), each channel by itself; the error that leaves the image is lost.
/// Pixels where the mask `known` is 0 are empty: they stay 0, and errors that go there are lost.
[[nodiscard]] Raster<std::uint8_t> dithered_by_diffusion(const Raster<std::uint8_t>& image, int levels,
                                                         const GreyImage* known = nullptr);

/// Ordered dithering: a shade between the grey values i and i + 1 lights k of the cell^2 pixels of a cell by i + 1, k
/// the nearest whole number (Mussio 6.13). `cell` is 2 to 8; ranks within the cell by Bayer (1973) where it is a power
/// of two, otherwise in steps that keep neighbours apart.
[[nodiscard]] Raster<std::uint8_t> dithered_by_cells(const Raster<std::uint8_t>& image, int levels, int cell);

}  // namespace collinea
