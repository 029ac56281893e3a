// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/words.h"
#include "collinea/match/correlation_surface.h"
#include "collinea/raster/raster.h"

// Area matching: a square template of one image is compared with every position in a search area of another, pixel by
// pixel (Mussio 7.4 and A.9; Karfis 4.3; Bolognesi 5.6). Good to a fifth of a pixel; least_squares_matching.h
// and multi_image_matching.h go on from there.
namespace collinea {

struct AreaOptions {
  Similarity method = Similarity::kNcc;
  int template_px = 21;
  int search_px = 81;
  int neighbourhood_px = 5;
  std::optional<double> threshold;
  double decisive_ratio = 1.5;
  std::optional<double> return_px = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AreaOptions;
    visit(Field{"method", &O::method, "", "what is compared"});
    visit(Field{"template_px", &O::template_px, "px", "side of the template, odd", 3, 151});
    visit(Field{"search_px", &O::search_px, "px", "side of the window of the right image that is searched, odd", 5,
                4001});
    visit(Field{"neighbourhood_px", &O::neighbourhood_px, "px",
                "side of the neighbourhood of rank and census: 3, 5 or 7", 3, 7});
    visit(Field{"threshold", &O::threshold, "",
                "smallest correlation of ncc (nothing: 0.8) and of cosine (nothing: none); of the others the largest "
                "value for each pixel of the "
                "template, of ssd and d that of dn (nothing: none)"});
    visit(Field{"decisive_ratio", &O::decisive_ratio, "",
                "of several candidates the best is taken when the next has as many times its residual variance "
                "(ncc, cosine: 1 - correlation squared); neighbours choose among the others",
                1, 1e6});
    visit(Field{"return_px", &O::return_px, "px",
                "the match, looked for in the left image, must come back so near to the point (forward-backward "
                "check); nothing: not checked",
                0, 1000}
              .or_auto("no check"));
  }
};

/// A place of a surface that is better than all around it.
struct AreaCandidate {
  Eigen::Vector2i pixel;  ///< middle of the window, in the other image
  double value = 0;
  /// What the template leaves unexplained there: 1 - correlation^2 (1 where the correlation is negative), also of
  /// cosine, the ssd, the square of sad; rank and census as they are.
  double residual = 0;
};

/// Positions that are better than all others within `radius` pixels (the first of equal ones) and pass the threshold of
/// AreaOptions, best first.
[[nodiscard]] std::vector<AreaCandidate> candidates(const CorrelationSurface& surface, int radius,
                                                    std::optional<double> threshold);

/// How many of the candidates, best first, rival each other: the best one, and those behind it that do not leave
/// `ratio` times as much unexplained. What is less than a grey value a pixel, or 1 - correlation^2 of 0.01, counts as
/// that: of two so good ones neither is better. 1: it is decisive.
[[nodiscard]] std::size_t rivals(const CorrelationSurface& surface, std::span<const AreaCandidate> candidates,
                                 double ratio);

struct SubpixelPeak {
  Eigen::Vector2d offset_px;  ///< from the middle of the pixel, within one pixel
  /// Of ncc, cosine, ssd, sad, d and dn; nothing for rank and census, whose surface does not tell it
  /// (rank_covariance.h).
  std::optional<Eigen::Matrix2d> covariance_px2;
};

/// The extremum of the paraboloid through the nine values round a candidate, by least squares (6 parameters, redundancy
/// 3). Covariance (docs/theory/area-matching.md): with the residual sum of squares O (ssd; of ncc and cosine with the
/// gain at the candidate) and the Hesse matrix H at its minimum 2 O / (n - 4) H^-1 + O^2 / (6 (n - 4)) H^-2; of sad
/// pi/2 sad/n H^-1
/// + 0.0525 sad^2/n H^-2. It holds for white noise alike in both images, that of sad as a
/// bound (errors were 0.77 of it); what a paraboloid over whole pixels adds (up
/// to 0.1 px) no statistics tell. Nothing at the border of the surface or without an extremum within a pixel.
[[nodiscard]] std::optional<SubpixelPeak> subpixel_peak(const CorrelationSurface& surface,
                                                        const Eigen::Vector2i& pixel);

/// Why there is no match.
enum class AreaOutcome { kFound, kOutside, kNoCandidate, kAmbiguous, kAtBorder, kNotReturned, kUndecided, kTaken };
inline constexpr Word<AreaOutcome> kAreaOutcomeWords[] = {
    {AreaOutcome::kFound, "found"},
    {AreaOutcome::kOutside, "outside", "the window leaves its image, or nothing is searched"},
    {AreaOutcome::kNoCandidate, "no_candidate", "nothing reaches the threshold"},
    {AreaOutcome::kAmbiguous, "ambiguous", "the second best is nearly as good"},
    {AreaOutcome::kAtBorder, "at_border", "the best lies at the border of what was searched"},
    {AreaOutcome::kNotReturned, "not_returned", "matched back it comes to another position"},
    {AreaOutcome::kUndecided, "undecided", "the neighbours bear out no candidate, or several"},
    {AreaOutcome::kTaken, "taken", "another point, more probable, matches the same position"},
};
constexpr std::span<const Word<AreaOutcome>> words(AreaOutcome) { return kAreaOutcomeWords; }

struct AreaMatch {
  Eigen::Vector2d position_px;                    ///< in the other image
  std::optional<Eigen::Matrix2d> covariance_px2;  ///< of rank and census by rank_covariance.h or match_areas()
  double value = 0;                               ///< of the similarity
  std::optional<double> returned_px;              ///< distance from the point after matching back
};

struct AreaMatching {
  AreaOutcome outcome = AreaOutcome::kOutside;
  std::optional<AreaMatch> match;  ///< where it is kFound
  std::vector<AreaCandidate> candidates;
  CorrelationSurface surface;
};

/// The position in `other` of what lies at position_px in `image`, near expected_px: 0, 1 or many candidates
/// (Mussio 7.9: none fails, one is accepted, of many the best when it is decisively better), sub-pixel position, and
/// the way back.
[[nodiscard]] AreaMatching match_area(const GreyImage& image, const Eigen::Vector2d& position_px,
                                      const GreyImage& other, const Eigen::Vector2d& expected_px,
                                      const AreaOptions& options);

}  // namespace collinea
