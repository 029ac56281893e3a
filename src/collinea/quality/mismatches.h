// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/adjust/bundle.h"
#include "collinea/quality/tie_errors.h"

namespace collinea {

/// Measurements of tie points that are of another point: what they are and what the others are distributed like.
struct Mismatches {
  std::vector<std::uint32_t> wrong;      ///< indices in Block::observations, ascending
  std::vector<std::uint32_t> with_them;  ///< others that go: the last ray of a point, and rays of points of which it
                                         ///< cannot be told which of them is wrong; ascending
  double expected_good = 0;              ///< of `wrong`: the number that is expected to be good after all
  long tested = 0;                       ///< rays of points that their rays check
  TieErrors errors;                      ///< the distribution, of gross errors too

  [[nodiscard]] std::size_t size() const { return wrong.size() + with_them.size(); }
};

/// Finds the mismatches of an adjusted block, all at once.
///
/// Model: the errors of rays have Student's distribution, but a part has gross errors that may be anywhere
/// (ErrorDistribution). It is estimated from the errors themselves, so that a noise that is wider than stated, or has
/// longer tails than normal errors, is not taken for mismatches: Student's tail bounds what is wrong beyond doubt.
///
/// Procedure: rays of each point are examined by themselves with poses and cameras fixed (PointRays). Its worst ray
/// goes when it is more probably gross than not, the point is intersected without it, and so on. Where another ray T'
/// explains the contradiction nearly as well as the worst T (T (T - T') < 18, three standard deviations of the
/// difference of two tests with the correlation T' / T), both go; of points with two rays both. The distribution is
/// fitted again to what stays, with what went, and the points are examined again. The bound of the probability is
/// raised from one half until of all rays fewer than the part `false_alarm` are expected to be good among the wrong.
///
/// Adjusted with a robust loss poses hardly follow mismatches. Fewer than 500 rays that others check: nothing is found.
/// Cost: some passes over the rays; no factor and no inverse of the normal equations.
[[nodiscard]] Mismatches find_mismatches(const Solved& solved, double false_alarm, const Run& run);

/// A block without its mismatches.
struct WithoutMismatches {
  Block block;       ///< as adjusted; without them, and without points that have no two rays left of those they had
  Mismatches found;  ///< indices are those of the block as it was
  int rounds = 0;    ///< adjustments
};

/// Adjusts by a robust loss (Huber's of 2 sigmas where `options` have none), rejects the mismatches, and where these
/// were more than one of a hundred does so once more.
///
///     COLLINEA_TRY(WithoutMismatches clean, reject_mismatches(block, scope, options.adjust, 0.001, run));
///     COLLINEA_TRY(const Examined adjusted, examine(clean.block, scope, options, run));
///
/// The scope has to have the first cameras (with_first_cameras()): those of the block are adjusted ones afterwards.
/// Cost: an adjustment to the accuracy of a tenth of a standard deviation, without covariances; from a good start one
/// or two iterations. Errors: those of adjust().
[[nodiscard]] Result<WithoutMismatches> reject_mismatches(Block block, const AdjustScope& scope,
                                                          const AdjustOptions& options, double false_alarm,
                                                          const Run& run);

/// That mismatches are left among the tie points of an adjusted block: more than one measurement of a hundred lies ten
/// robust standard deviations off and more, where Student's distribution with three degrees of freedom has 0.15.
/// Nothing with fewer than 500 measurements.
[[nodiscard]] std::optional<Finding> mismatches_left(const Block& block, const Adjusted& adjusted);

}  // namespace collinea
