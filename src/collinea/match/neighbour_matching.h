// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/match/area_matching.h"
#include "collinea/match/relaxation.h"

// Area matching of many points at once: which of its candidates is each, by what its neighbours match (relaxation.h).
namespace collinea {

/// How alike candidates are, 0 to 1, on the scale of the correlation r: r itself of ncc. Of the others with q = value /
/// median of the surface, at most 1 (what a position at random leaves): 1 - q of ssd, for sum (T - S)^2 = 2 n var (1 -
/// r), and of cosine, whose value there is 1 - cosine: half the squared difference of windows that are scaled to one
/// brightness; 1 - q^2 of d, dn, sad and rank, which grow as its root; cos(pi q / 2) of census, for two pixels are in
/// another order with the chance arccos(r) / pi (Sheppard 1899). 0 where the median is 0: nothing tells positions
/// apart.
[[nodiscard]] std::vector<double> likenesses(const CorrelationSurface& surface, std::span<const AreaCandidate> of);

/// A point of one image and where it is expected in the other.
struct AreaPoint {
  Eigen::Vector2d position_px;
  Eigen::Vector2d expected_px;                      ///< parallaxes are counted from it: near points have near ones
  std::optional<Eigen::Vector2d> searched_px = {};  ///< middle of what is searched; nothing: expected_px
};

struct NeighbourMatch {
  AreaOutcome outcome = AreaOutcome::kOutside;
  std::optional<AreaMatch> match;  ///< where it is kFound
  std::size_t candidates = 0;      ///< that have an extremum between the pixels, eight at most
  double likeness = 0;             ///< of the match, 0 to 1
  double probability = 0;          ///< of the most probable candidate after relaxation
};

/// Every point, in their order, by relaxation over its candidates: the best one and its rivals (decisive_ratio of the
/// options; infinite: all that pass the threshold), eight at most. None: no_candidate; a single one that the neighbours
/// do not bear out, or several of which none has the least probability: undecided; a position that a more probable
/// point has: taken. The way back is not asked for. Not every point when stopped.
[[nodiscard]] std::vector<NeighbourMatch> match_areas(const GreyImage& image, const GreyImage& other,
                                                      std::span<const AreaPoint> points, const AreaOptions& options,
                                                      const RelaxationOptions& relaxation, const Run& run);

}  // namespace collinea
