// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// What tells right matches from wrong ones.
enum class PointDecision { kReturn, kRelaxation };
inline constexpr Word<PointDecision> kPointDecisionWords[] = {
    {PointDecision::kReturn, "return", "matched back again it comes to the point, and no other is nearly as good"},
    {PointDecision::kRelaxation, "relaxation", "of all that are good enough the one that its neighbours bear out"},
};
constexpr std::span<const Word<PointDecision>> words(PointDecision) { return kPointDecisionWords; }

struct PairPointOptions {
  int max_points = 1500;
  double evenness = 0.7;
  int template_px = 21;
  int search_px = 61;
  double min_ncc = 0.85;
  PointDecision decision = PointDecision::kReturn;
  double return_px = 2;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PairPointOptions;
    visit(Field{"max_points", &O::max_points, "", "interest points of the left image that are looked for", 20, 1e6});
    visit(Field{"evenness", &O::evenness, "1", "0: the strongest ones, 1: as many in every region", 0, 1});
    visit(Field{"point_template_px", &O::template_px, "px", "side of the window that is compared, odd", 5, 101});
    visit(Field{"point_search_px", &O::search_px, "px", "side of the window that is searched round the prediction, odd",
                7, 1001});
    visit(Field{"point_min_ncc", &O::min_ncc, "1", "smallest correlation", 0, 1});
    visit(Field{"point_decision", &O::decision, "", "how wrong matches are told from right ones at full resolution"});
    visit(Field{"point_return_px", &O::return_px, "px",
                "so near must a point, matched to the right and back again, come to itself", 0, 100});
  }
};

/// A point of one image found in the other.
struct MatchedPoint {
  Eigen::Vector2d left_px, right_px;
  double ncc = 0;
  double sigma_px = 1;  ///< of a coordinate, against those of the other points: its weight in the orientation
};

/// A stage from small images to the whole ones.
struct PairPointStage {
  int shrink = 1;
  std::size_t interest = 0, matched = 0, agreeing = 0;
  Eigen::Vector2d parallax_px = {0, 0};  ///< mean of left less right, in pixels of the whole images
};

struct PairPoints {
  std::vector<MatchedPoint> points;  ///< in the order of the interest points
  std::vector<PairPointStage> stages;
};

/// Homologous points of two images that were taken alike: interest points (Noble's measure of Harris' operator) of the
/// left image by correlation in the right one, there and back again (Karfis 4.4). Where to look is found from small
/// images to large ones (Mussio 7.13, A.28): on images of 256 pixels everywhere, then near what the affine map through
/// the matches of the stage before and the five nearest of them predict. Of each stage but the last those count that
/// agree with the map within eight robust standard deviations, found by the least median of squares of samples.
/// Correlation bears a rotation between the images of some 15 degrees, and scales that differ by a fifth. Errors: no
/// agreement of eight points on the smallest images, or of later stages; stopped.
[[nodiscard]] Result<PairPoints> find_pair_points(const GreyImage& left, const GreyImage& right,
                                                  const PairPointOptions& options, const Run& run);

}  // namespace collinea
