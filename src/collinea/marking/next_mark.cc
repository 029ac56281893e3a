// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/next_mark.h"

#include <cmath>
#include <tuple>
#include <vector>

namespace collinea {
namespace {

std::size_t count_placed(const AdjustedMarks& marks) {
  std::size_t placed = 0;
  for (const AdjustedMark& one : marks.points) placed += one.position_in_world.has_value();
  return placed;
}

// Of points that `before` has positions of.
double rms_sigma(const AdjustedMarks& marks, const AdjustedMarks& before) {
  double variances = 0;
  int coordinates = 0;
  for (std::size_t i = 0; i < marks.points.size(); ++i) {
    if (!before.points[i].position_in_world || !marks.points[i].position_in_world) continue;
    variances += marks.points[i].covariance_m2.trace();
    coordinates += 3;
  }
  return coordinates > 0 ? std::sqrt(variances / coordinates) : 0;
}

}  // namespace

Result<std::optional<NextMark>> best_next_mark(MarkedBlock& block, std::span<const BlockPoint> points,
                                               std::span<const PossibleMark> possible,
                                               std::span<const PointLink> ground) {
  COLLINEA_TRY(const AdjustedMarks before, block.adjust(points, {}, ground));
  std::optional<NextMark> best;
  std::vector<BlockPoint> tried(points.begin(), points.end());
  for (const PossibleMark& one : possible) {
    COLLINEA_CHECK(one.point < points.size());
    tried[one.point].marks.push_back(one.mark);
    const auto after = block.adjust(tried, {}, ground);
    tried[one.point].marks.pop_back();
    if (!after || after->placed != before.placed) continue;
    const NextMark next{one, count_placed(before), count_placed(*after), rms_sigma(before, before),
                        rms_sigma(*after, before)};
    const auto better = [](const NextMark& a, const NextMark& b) {
      return std::tuple(b.placed_after, a.rms_sigma_after_m) < std::tuple(a.placed_after, b.rms_sigma_after_m);
    };
    if (!best || better(next, *best)) best = next;
  }
  return best;
}

}  // namespace collinea
