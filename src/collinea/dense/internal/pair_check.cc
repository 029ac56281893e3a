// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/pair_check.h"

#include <cstdint>
#include <string>

namespace collinea::dense {
namespace {

constexpr int kMostDisparities = 2000;

}  // namespace

Result<> check_pair(const GreyImage& left, const GreyImage& right, const DisparityRange& range) {
  if (left.empty() || right.empty()) return fail(Errc::kBadInput, "an image of the pair is empty");
  if (left.height != right.height)
    return fail(Errc::kBadInput, "the images of a rectified pair have the same height; these have " +
                                     std::to_string(left.height) + " and " + std::to_string(right.height) + " rows");
  if (range.high < range.low)
    return fail(Errc::kBadInput,
                "no disparity between " + std::to_string(range.low) + " and " + std::to_string(range.high));
  if (const std::int64_t count = std::int64_t(range.high) - range.low + 1; count > kMostDisparities)
    return fail(Errc::kBadInput, std::to_string(count) + " disparities are more than " +
                                     std::to_string(kMostDisparities) + ": use a lower resolution");
  if (range.low >= left.width || range.high <= -right.width)
    return fail(Errc::kBadInput, "disparities from " + std::to_string(range.low) + " to " + std::to_string(range.high) +
                                     " lead out of the images everywhere");
  return {};
}

}  // namespace collinea::dense
