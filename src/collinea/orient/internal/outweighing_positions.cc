// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/outweighing_positions.h"

#include "collinea/orient/internal/datum.h"

namespace collinea {
namespace {

constexpr std::size_t kMost = 2, kFewestAgree = 4;
constexpr double kPart = 0.5;  // of the pull of those that agree

}  // namespace

OutweighingPositions outweighing_positions(const Block& block, std::uint64_t seed) {
  std::vector<ImageId> images;
  const std::vector<bundle::PositionPair> pairs = position_pairs(block, images);
  OutweighingPositions found;
  const auto fit = bundle::robust_similarity(pairs, seed);
  if (!fit) return found;
  double agreeing = 0, contradicting = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    (fit->weights[i] == 0 ? contradicting : agreeing) += 1 / pairs[i].sigma_m;
    if (fit->weights[i] != 0) continue;
    found.images.push_back(images[i]);
    found.findings.push_back(
        finding_of(FindingCode::kPositionOutweighs, {images[i]},
                   {{FigureName::kOffset, fit->distances_m[i]}, {FigureName::kSigma, pairs[i].sigma_m}}));
  }
  const bool few = found.images.size() <= kMost && pairs.size() - found.images.size() >= kFewestAgree;
  if (!few || contradicting <= kPart * agreeing) return {};
  return found;
}

}  // namespace collinea
