// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace collinea {

/// Value and derivative between the pixels of a row.
struct RowSample {
  float value = 0, slope = 0;
};

/// By Catmull and Rom's cubic at a column (middles of pixels at halves); nothing where one of the four pixels leaves
/// the row or is 0 (shows nothing).
inline std::optional<RowSample> row_sample(const std::uint8_t* row, int width, double column) {
  const double at = column - 0.5;
  if (!(at >= 1 && at < width - 2)) return std::nullopt;
  const int i = int(at);
  const float a = row[i - 1], b = row[i], c = row[i + 1], d = row[i + 2];
  if (a == 0 || b == 0 || c == 0 || d == 0) return std::nullopt;
  const float t = float(at - i);
  const float k1 = 0.5F * (c - a), k2 = a - 2.5F * b + 2 * c - 0.5F * d, k3 = 0.5F * (d - a) + 1.5F * (b - c);
  return RowSample{b + t * (k1 + t * (k2 + t * k3)), k1 + t * (2 * k2 + t * 3 * k3)};
}

}  // namespace collinea
