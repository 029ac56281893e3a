// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// A measurement that data snooping took out: an image point (both coordinates), the plan or the height of a control
/// point or of a position, a measurement on the ground, level or heading of an attitude.
struct Rejected {
  ObservationGroup group{};
  ImageId image;             ///< of rays, positions and attitudes
  PointId point;             ///< of rays of tie points
  ControlId control;         ///< of rays and coordinates of control
  std::uint32_t ground = 0;  ///< place in Block::ground
  int axis = 0;           ///< of the coordinate that was beyond the limit; 0 column or east, 1 row or north, 2 height
  double w = 0;           ///< of it, when it was the worst; infinite: its image does not see the point
  double redundancy = 0;  ///< NaN: gross
  double influence = 0;      ///< by how much the adjusted value of that coordinate was drawn to it [px, m, rad]
  /// Measured minus what the adjustment without it says, with the standard deviation that this would have without a
  /// blunder [px, m, rad], of what is measured on the ground in the first place; NaN for axes that were not measured
  /// or, of the sigma, not tested.
  Eigen::Vector3d gross_error = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  double sigma = 0;      ///< of blunder[axis]
  bool as_pair = false;  ///< one of the two rays of a point: which of them was wrong cannot be told, both went
  int round = 0;         ///< 0: gross, before the first adjustment
};

/// Why a suspect had to stay.
enum class StayReason : std::uint8_t {
  kTooLittleChecks,  ///< too little of a gross error shows in its residual
  kSameDegree,       ///< others are suspect to the same degree
  kBlockNeedsIt,     ///< without it the block is not determined
  kWorseOfItsPoint,  ///< what is more suspect of its point stays
  kImageNeedsIt,     ///< its image would keep too few measurements
};
inline constexpr Word<StayReason> kStayReasonWords[] = {{StayReason::kTooLittleChecks, "too_little_checks"},
                                                        {StayReason::kSameDegree, "same_degree"},
                                                        {StayReason::kBlockNeedsIt, "block_needs_it"},
                                                        {StayReason::kWorseOfItsPoint, "worse_of_its_point"},
                                                        {StayReason::kImageNeedsIt, "image_needs_it"}};
constexpr std::span<const Word<StayReason>> words(StayReason) { return kStayReasonWords; }

/// A suspect that had to stay.
struct KeptSuspect {
  TestedObservation observation;  ///< its source refers to Snooped::block
  StayReason reason{};
};

struct Snooped {
  Block block;  ///< without what was taken out; measurements on the ground are only compared
  std::map<ImageId, GivenAttitude> attitudes;  ///< of the scope, those that were taken out with infinite sigmas
  std::vector<Rejected> rejected;             ///< in the order in which it went
  std::vector<KeptSuspect> kept;               ///< suspects of the last adjustment that cannot go, worst first
  int put_back = 0;                            ///< that went, and in the end agreed with what was left
  int rounds = 0;                              ///< adjustments
  bool finished = false;                       ///< nothing is left that could be taken out
  double sigma0_before = 0;                    ///< with everything
  std::vector<ControlDifference> with;         ///< control and check points, with everything
  Examined adjusted;                           ///< the last, with reliability
};

/// Data snooping (Baarda 1968; Kok 1984): adjust, take out the worst suspect, adjust again, until no suspect is left or
/// `most` have gone. The worst is the one of the largest TestedObservation::suspicion. Rays of control that miss the
/// others of their point by more than a hundred sigmas go before the first adjustment, which they would bend
/// (check_control). Suspects that cannot disturb each other go together: of each point one, of each image those that
/// would be suspect whatever the worse ones in it did to them; of the observations that are no image points only the
/// worst, and with it no ray that is less suspect. In the end what went goes back, once, that agrees with what is left:
/// another blunder had spoilt it. A suspect stays when less than a hundredth of a blunder shows in its residual, when
/// its image would keep fewer than six rays, when another says the same of itself (without the one nothing checks the
/// other: which is wrong cannot be told), or when without it something is not determined: a round after which that is
/// so is taken back, and half of it tried. Errors: those of adjust(); kIllPosed when something is not determined with
/// all observations.
[[nodiscard]] Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                    int most, const Run& run);

}  // namespace collinea
