// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace collinea {

/// out[x] = rounded mean of upper and lower [2x], [2x + 1] for x in [0, count); `channels` interleaved, 1 or 3.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count, int channels);

/// out[x] = sum over i of weights[i] * rows[i][x] for x in [0, count), added in the order of i: one pass of a blur
/// along columns (rows = lines of the picture) or along a line (rows = the line shifted).
void weighted_sum(const float* const* rows, const float* weights, int taps, float* out, int count);

}  // namespace collinea
