// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace collinea {

/// out[x] = rounded mean of upper and lower [2x], [2x + 1] for x in [0, count); `channels` interleaved, 1 or 3.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count, int channels);

}  // namespace collinea
