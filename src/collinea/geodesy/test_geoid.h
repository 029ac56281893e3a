// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>

namespace collinea {

/// The height of the test's geoid over the ellipsoid [m]: linear, so that a grid holds it exactly.
inline double test_geoid_m(double latitude_deg, double longitude_deg) {
  return 45 + 2 * (latitude_deg - 48) - 4 * (longitude_deg - 15);
}

/// Writes it as a grid in GTX (NOAA): south-western node, steps, rows and columns, then heights from the south, all
/// big-endian. It reaches from 47 to 49 degrees north and from 14 to 17 degrees east.
inline void write_test_geoid(const std::filesystem::path& path) {
  constexpr int kRows = 21, kColumns = 31;
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](auto bits) {
    for (int shift = 8 * int(sizeof bits) - 8; shift >= 0; shift -= 8) file.put(char((bits >> shift) & 0xff));
  };
  for (const double value : {47.0, 14.0, 0.1, 0.1}) put(std::bit_cast<std::uint64_t>(value));
  for (const int count : {kRows, kColumns}) put(std::uint32_t(count));
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      put(std::bit_cast<std::uint32_t>(float(test_geoid_m(47 + 0.1 * row, 14 + 0.1 * column))));
}

}  // namespace collinea
