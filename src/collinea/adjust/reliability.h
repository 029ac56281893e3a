// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/block/ground.h"

namespace collinea {

/// Kinds of observations, each with a sigma of its own that may be wrong.
enum class ObservationGroup {
  kTieImages,
  kControlImages,
  kControlPlan,
  kControlHeight,
  kPositionPlan,
  kPositionHeight,
  kDistance,
  kHeightDifference,
  kDirection,
  kZenithAngle,
  kAtHeight,
  kOnPlane,
  kOnLine,
  kAttitudeLevel,
  kAttitudeHeading,
};
inline constexpr std::size_t kObservationGroups = 15;
inline constexpr std::array<const char*, kObservationGroups> kObservationGroupNames = {"tie points in images",
                                                                                       "control in images",
                                                                                       "control, plan",
                                                                                       "control, height",
                                                                                       "positions, plan",
                                                                                       "positions, height",
                                                                                       "distances",
                                                                                       "height differences",
                                                                                       "directions",
                                                                                       "zenith angles",
                                                                                       "equal heights",
                                                                                       "planes",
                                                                                       "lines",
                                                                                       "attitudes, level",
                                                                                       "attitudes, heading"};

/// Angles, in [rad].
[[nodiscard]] constexpr bool is_angle(ObservationGroup group) {
  return group == ObservationGroup::kDirection || group == ObservationGroup::kZenithAngle ||
         group >= ObservationGroup::kAttitudeLevel;
}

/// The group of a measurement on the ground.
[[nodiscard]] constexpr ObservationGroup group_of(GroundKind kind) {
  return static_cast<ObservationGroup>(static_cast<std::size_t>(ObservationGroup::kDistance) +
                                       static_cast<std::size_t>(kind));
}

/// One measured coordinate and what the others say of it. Units: px in images, m on the ground, rad for angles.
struct TestedObservation {
  ObservationGroup group{};
  std::uint32_t source = 0;     ///< place in Block::observations, Block::control_observations or Block::ground,
                                ///< ControlId or ImageId
  int axis = 0;                 ///< 0 column or east, 1 row or north, 2 height
  double residual = 0;          ///< observed minus adjusted
  double sigma = 0;             ///< as given; of correlated coordinates of a point that of one beside exact others, and
                                ///< so are residual and test
  double redundancy = 0;        ///< r: the part of a blunder that its own residual shows, 0 to 1
  double w = 0;                 ///< residual / its sigma: Baarda's w, or Pope's tau when sigma0 is estimated; infinite
                                ///< (and all but sigma NaN) when the image does not see the point
  double suspicion = 0;         ///< w if sigma0 multiplied all sigmas alike: of all observations the largest is that of
                                ///< the wrong one, if there is but one, which w does not say of itself
  double blunder = 0;           ///< the most probable one: residual / r
  double least_blunder = 0;     ///< minimal detectable blunder (with the stated level and power); infinite when r = 0
  double effect = 0;            ///< of a blunder just not found on the adjusted value of the same coordinate
  double effect_in_sigmas = 0;  ///< Baarda's lambda^1/2: largest effect on anything, in standard deviations of that
};

/// What a surveyed point would have been found to be off by, had its coordinates not taken part.
struct LeftOutPoint {
  ControlId point;
  Eigen::Vector3d difference_m;        ///< estimated minus given; NaN on axes not surveyed
  Eigen::Vector3d difference_sigma_m;  ///< expected of it, with sigma0
};

/// Control points left out in parts, each foretold by the others.
struct Folded {
  int folds = 0;                     ///< parts; 0: too few points (or too many), none were left out
  std::vector<int> part;             ///< of each point, from 1
  std::vector<LeftOutPoint> points;  ///< of parts without which the block is determined, in the order of ControlId
};

/// Root mean squares over points that were left out: of differences, and what their sigmas foretell.
struct LeftOutRms {
  int points = 0;
  double difference_m = 0, foretold_m = 0;
};
/// In plan (of both axes together, points surveyed on both), or in height.
[[nodiscard]] LeftOutRms rms_of(const std::vector<LeftOutPoint>& points, bool height);

/// Sums over one group, as variance components need them.
struct GroupSums {
  long observations = 0;
  double redundancy = 0;
  double squared_redundancy = 0;  ///< the sum of r^2
  double squares = 0;             ///< weighted squares of residuals
  /// The factor by which the given sigmas should be multiplied; 1 when it is not told: not even that
  /// it should be larger.
  [[nodiscard]] double sigma_factor() const;
  /// The standard deviation of sigma_factor() over the factor, (2 sum r^2)^-1/2: as if each observation were checked by
  /// other groups alone, so that its own variance is r of that of its residual. Where a group checks itself it is a
  /// little better known. Infinite when nothing is.
  [[nodiscard]] double relative_sigma() const;
  /// False when the group is drowned in what checks it: its factor would be uncertain by 40 % and more.
  [[nodiscard]] bool told() const;
};

/// Reliability of an adjustment (Baarda 1968; Pope 1976; Foerstner 1983).
struct Reliability {
  double false_alarm = 0, power = 0;  ///< as asked for
  bool sigma0_known = false;          ///< tests by w with sigma0 = 1; otherwise by tau
  double limit = 0;                   ///< of |w| or tau
  double delta0 = 0;              ///< shift of w that is found with that power; of the normal distribution, for tau too
  long tested = 0, rejected = 0;  ///< coordinates; beyond the limit
  long unseen = 0;                ///< rays whose point its image does not see: not tested, all suspect
  double redundancy_sum = 0;      ///< over all observations, weak ones and verticals too: Adjusted::redundancy
  std::vector<Eigen::Vector2d> tie_redundancy;  ///< parallel to Adjusted::observations; NaN when not seen
  std::vector<TestedObservation> others;        ///< all but tie points: control, positions, ground, every one
  std::vector<TestedObservation> suspects;      ///< beyond the limit, by `suspicion`, 1000 at most
  std::vector<LeftOutPoint> left_out;  ///< every control point without whose coordinates the block is determined
  Folded folded;                       ///< the same of parts of them
  std::array<GroupSums, kObservationGroups> groups;
};

}  // namespace collinea
