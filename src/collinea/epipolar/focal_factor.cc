// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/focal_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "collinea/epipolar/essential.h"
#include "collinea/epipolar/relative.h"
#include "collinea/epipolar/two_view_criteria.h"

namespace collinea {

std::optional<FocalFactor> focal_factor(const Camera& camera_first, std::span<const Keypoint> first,
                                        const Camera& camera_second, std::span<const Keypoint> second,
                                        const ImagePair& pair) {
  const FocalDoubt doubt{camera_first.sigma_f_px > 0, camera_second.sigma_f_px > 0, 1};
  if (pair.geometry != PairGeometry::kGeneral || !(pair.second_from_first.translation.norm() > 0.5))
    return std::nullopt;
  if (!doubt.first && !doubt.second) return std::nullopt;
  PointPairs pairs;
  pairs.focal_first_px = camera_first.focal_px();
  pairs.focal_second_px = camera_second.focal_px();
  for (const auto& [i, j] : pair.matches)
    pairs.add(normalized(camera_first, {first[i].x, first[i].y}),
              normalized(camera_second, {second[j].x, second[j].y}));
  std::vector<int> all(pair.matches.size());
  std::iota(all.begin(), all.end(), 0);
  constexpr double kLoss_px = 3;
  std::optional<RelativeFocalFit> best;
  double rms_px = std::numeric_limits<double>::infinity();
  for (const double start : {1.0, 0.7, 1.4}) {  // the factor is found from a start within a third or so
    const PointPairs moved = with_focal_factor(pairs, doubt.first ? start : 1, doubt.second ? start : 1);
    auto fit = refine_relative_and_focal(pair.second_from_first, moved, all, kLoss_px, doubt);
    if (!fit) continue;
    fit->focal_factor *= start;
    const PointPairs corrected =
        with_focal_factor(pairs, doubt.first ? fit->focal_factor : 1, doubt.second ? fit->focal_factor : 1);
    const auto errors = errors_of(essential_matrix(fit->second_from_first), corrected, false);
    const double rms = std::sqrt(truncated_cost(errors, kLoss_px) / static_cast<double>(all.size()));
    if (rms < rms_px) {
      rms_px = rms;
      best = fit;
    }
  }
  if (!best) return std::nullopt;
  const FocalFactor result{best->focal_factor, best->sigma_focal_factor * std::max(0.2, rms_px)};
  if (!(result.sigma < 0.3) || result.factor < 0.3 || result.factor > 3) return std::nullopt;
  return result;
}

}  // namespace collinea
