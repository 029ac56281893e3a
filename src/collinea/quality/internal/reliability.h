// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "collinea/adjust/observation_group.h"
#include "collinea/adjust/solved.h"
#include "collinea/base/id.h"
#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/quality/internal/control_folds.h"
#include "collinea/quality/tie_errors.h"

namespace collinea {

/// How observations are tested for gross errors.
struct TestOptions {
  double false_alarm = 0.001;
  double power = 0.8;
  bool sigma0_known = false;
  bool normal_ties = false;
  int folds = 5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = TestOptions;
    visit(
        Field{"false_alarm", &O::false_alarm, "1", "probability that the test rejects a good observation", 1e-12, 0.5});
    visit(Field{"power", &O::power, "1", "probability with which a minimal detectable bias is found", 0.5, 0.999});
    visit(Field{"sigma0_known", &O::sigma0_known, "",
                "the given sigmas are true: test by Baarda's w; otherwise by Pope's tau"});
    visit(
        Field{"normal_ties", &O::normal_ties, "",
              "test tie points against the normal distribution, as all else; otherwise against the one that their own "
              "errors show (and with sigma0 known always)"});
    visit(Field{"folds", &O::folds, "1",
                "parts of the control, each left out together and predicted by the others; fewer where a part would "
                "have one point",
                2, 100});
  }
};

/// Shift of a normally distributed test that is found with the power asked for (Baarda's delta0).
[[nodiscard]] double detectable_shift(const TestOptions& options);

/// One measured coordinate and what the others say of it. Units: px in images, m on the ground, rad for angles.
struct TestedObservation {
  ObservationGroup group{};
  std::uint32_t source = 0;  ///< index in Block::observations, Block::control_observations or Block::geodetic,
                             ///< ControlId or ImageId
  int axis = 0;              ///< 0 column or east, 1 row or north, 2 height
  double residual = 0;       ///< observed minus adjusted
  double sigma = 0;          ///< as given; of correlated coordinates of a point that of one beside exact others, and
                             ///< so are residual and test
  double redundancy = 0;     ///< r: the part of a blunder that its own residual shows, 0 to 1
  double w = 0;              ///< residual / its sigma: Baarda's w, or Pope's tau when sigma0 is estimated; infinite
                             ///< (and all but sigma NaN) when the image does not see the point
  double limit = 0;          ///< beyond which |w| is suspect
  double suspicion = 0;      ///< w if sigma0 multiplied all sigmas alike: of all observations the largest is that of
                             ///< the wrong one, if there is but one, which w does not say of itself
  double gross_error = 0;    ///< the most probable one: residual / r
  double minimal_detectable_bias =
      0;                        ///< minimal detectable bias (with the stated level and power); infinite when r = 0
  double effect = 0;            ///< of a blunder just not found on the adjusted value of the same coordinate
  double effect_in_sigmas = 0;  ///< Baarda's lambda^1/2: largest effect on anything, in standard deviations of that
};

/// Sums over one group, as variance components need them.
struct GroupSums {
  long observations = 0;
  double redundancy = 0;
  double squared_redundancy = 0;  ///< the sum of r^2
  double squares = 0;             ///< weighted squares of residuals
  /// The factor by which the given sigmas should be multiplied; 1 when it is not determined: not even that
  /// it should be larger.
  [[nodiscard]] double sigma_factor() const;
  /// The standard deviation of sigma_factor() over the factor, (2 sum r^2)^-1/2: as if each observation were checked by
  /// other groups alone, so that its own variance is r of that of its residual. Where a group checks itself it is a
  /// little better known. Infinite when nothing is.
  [[nodiscard]] double relative_sigma() const;
  /// False when the group is drowned in what checks it: its factor would be uncertain by 40 % and more.
  [[nodiscard]] bool is_determined() const;
};

/// Reliability of an adjustment (Baarda 1968; Pope 1976; Foerstner 1983).
struct Reliability {
  double false_alarm = 0, power = 0;  ///< as asked for
  bool sigma0_known = false;          ///< tests by w with sigma0 = 1; otherwise by tau
  double limit = 0;                   ///< of |w| or tau, of all but tie points
  TieErrors tie_errors;  ///< what w of tie points is distributed like; empty: tested by the normal distribution
  std::vector<double> tie_limits;  ///< of |w| of tie points, for each class of `tie_errors`
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

/// The test of one coordinate of a ray of a tie point, as reliability_of() does it.
struct TieTest {
  double w = 0;       ///< NaN: nothing checks it
  double weight = 0;  ///< by the loss, times 1 / sigma^2
};
/// `residual_px`: both coordinates, by whose length the loss weighs; `redundancy` of coordinate `axis`, as in
/// Reliability::tie_redundancy.
[[nodiscard]] TieTest tie_test(const Adjusted& adjusted, const Reliability& tests, const Eigen::Vector2d& residual_px,
                               double sigma_px, int axis, double redundancy);

/// Tests every observation of an adjustment, by the selected inverse of the reduced normal equations (Solved).
///
/// Model: the residuals v = -R e follow the errors e by the redundancy matrix R = I - A (A'PA)^-1 A'P; its diagonal
/// elements r, from 0 to 1, are the part of an error that its own residual shows, and their sum is the redundancy. The
/// test of one observation is w = v / (sigma sqrt(r)) against its standard normal distribution (Baarda 1968), or,
/// sigma0 being estimated too, against that of tau (Pope 1976). Errors of automatic tie points have longer tails than
/// normal ones: the distribution of their w is estimated from all of them by classes of rays a point
/// (fit_tie_errors()), and w is tested against the limit that it exceeds with the given probability, gross errors
/// apart; where it is normal, or less than 500 tell, that is the limit of all else. The minimal detectable bias is
/// delta0 sigma / sqrt(r), the shift delta0 being that of w which is found with the wanted power.
///
/// Rank and datum: r and w do not depend on the datum. Observations with r = 0 cannot be tested; they are counted, with
/// an infinite minimal detectable bias.
///
/// Cost: one 2 x 2 block of A (A'PA)^-1 A'P for each image point, in parallel. Control is not folded (fold_control).
[[nodiscard]] Reliability reliability_of(const Solved& solved, const Adjusted& adjusted, const TestOptions& options,
                                         bundle::TileCholesky& inverse, const Run& run);

}  // namespace collinea
