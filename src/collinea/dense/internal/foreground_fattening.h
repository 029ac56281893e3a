// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/run.h"
#include "collinea/raster/raster.h"

namespace collinea::dense {

/// Empties what a surface of inverse depths (NaN: none) shows beyond its edges. A matching window that reaches across
/// the edge of what lies in front sees mostly that edge: surfaces in front come out up to half a window too wide, from
/// all sides alike, so other images confirm it. Whether a pixel at such a border belongs to what lies in front, the
/// image tells: its grey is compared with the greys around of what lies surely in front, away from the border, and of
/// what lies behind, by more than `reach`. Only what breaks off by that and two `sigma` is a border. Pixels that are
/// more like what is behind are emptied; those that have too little of either around stay. Result is not to be used
/// when run.stopped().
void empty_foreground_fattening(const GreyImage& image, float reach, const FloatImage& sigma, FloatImage& surface,
                                const Run& run);

}  // namespace collinea::dense
