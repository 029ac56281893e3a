// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace collinea {

/// What images may be oriented by: homologous points, straight lines (no point on them is homologous) and circles
/// (Mussio A.5, A.6).
enum class OrientingFeature { kPoint, kLine, kCircle };

/// Coordinates that an image of one gives: 2 of a point, 2 of a line (theta, r), 5 of a circle (an ellipse).
[[nodiscard]] constexpr int observed_of(OrientingFeature feature) {
  return feature == OrientingFeature::kCircle ? 5 : 2;
}
/// Parameters of one in space: 3, 4, 6 (centre, radius, direction of the axis).
[[nodiscard]] constexpr int unknowns_of(OrientingFeature feature) {
  return feature == OrientingFeature::kPoint ? 3 : feature == OrientingFeature::kLine ? 4 : 6;
}

/// Redundancy of the relative orientation of `images` images of known interior orientation by features that all of them
/// show: observations less 6 unknowns an image and those of the features, plus the 7 of a free similarity. A count: it
/// says nothing of features in critical position (parallel lines, coplanar circles). Fewer than two images or no
/// feature: meaningless, nothing.
[[nodiscard]] constexpr std::optional<int> orientation_redundancy(OrientingFeature feature, int images, int features) {
  if (images < 2 || features < 1) return std::nullopt;
  return images * features * observed_of(feature) - (6 * images - 7) - features * unknowns_of(feature);
}

/// The fewest features that orient so many images: the redundancy is no longer negative. Nothing: no number of them
/// does, as of lines in two images, whose planes of rays always meet.
[[nodiscard]] constexpr std::optional<int> fewest_features(OrientingFeature feature, int images) {
  const int gain = images * observed_of(feature) - unknowns_of(feature);
  if (images < 2 || gain <= 0) return std::nullopt;
  return (6 * images - 7 + gain - 1) / gain;
}

}  // namespace collinea
