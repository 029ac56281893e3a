// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/quality/mark_systems.h"

namespace collinea {

/// How many marks of control the other marks of their points confirm.
struct MarkMeeting {
  int meeting = 0;            ///< marks whose ray passes the point of their rays within the tolerance
  int marks = 0;              ///< of all points that are marked in two oriented images and more
  int redundancy_met = 0;     ///< 2 n - 3 of the n marks that meet, over all points
  int redundancy = 0;         ///< the same of all marks
  double cost_met = 0;        ///< sum of the squared misclosures of the marks that meet [px^2]
  double truncated_cost = 0;  ///< sum of the squared misclosures, each no more than the squared tolerance [px^2]

  /// What part of the redundancy confirms the marks: chance pairs of many rays count little.
  [[nodiscard]] double share() const { return redundancy > 0 ? double(redundancy_met) / redundancy : 0; }
};

/// What was found of how marks were counted.
struct MarkDiagnosis {
  std::vector<Finding> findings;  ///< kMarksCountedOtherwise of each system that explains them; kMarksCorrected
  MarkHypothesis correction;      ///< kAsGiven: none, or not certain
};

/// Looks for another system of image coordinates where the marks of control do not fit an oriented block (in any
/// frame): when less than half of their redundancy confirms them, each system of MarkSystem is tried, its factor
/// estimated from the coplanarity of all pairs of rays. A system explains the marks when seven tenths of the redundancy
/// (and six of it at least, on three points) confirm it: rays of a point must pass each other within the larger of six
/// sigmas, three pixels and two thousandths of the image's side, inside the images, and at a depth that the tie points
/// of the images have within a factor of two. (Vertical images that are all turned alike meet at any factor about
/// their middle, only at another depth.) It is certain when no other one reaches half of that and, with a factor, when
/// an error of this by its standard deviation moves the marks by less than their own. Marks that fit are never tried
/// otherwise.
[[nodiscard]] MarkDiagnosis check_marks(const Block& block);

/// Brings marks into the images where findings of check_marks() say so (kMarksCorrected). Standard deviations follow
/// the factor of marks that were measured in images of another size; those of other units stay.
void correct_marks(std::span<const Finding> findings, Block& block);

/// Removes the marks that do not lie in their images.
void remove_marks_outside(Block& block);

/// How the marks meet when they are read as the hypothesis says.
[[nodiscard]] MarkMeeting meeting_of(const Block& block, const MarkHypothesis& hypothesis);

}  // namespace collinea
