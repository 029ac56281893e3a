// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/internal/score_normals.h"

namespace collinea::bundle {

/// Score tests (Rao 1948; Lagrange multipliers, Aitchison and Silvey 1958) of the hypotheses about systematic errors.
///
/// Model. If the observations also followed l = A x + H d + e, the estimate after a second adjustment would be, to
/// first order,
///
///     d = N^-1 c,   N = H'P H - H'P A (A'P A)^-1 A'P H,   c = H'P v
///
/// with the residuals v of the adjustment that has been made. Without such an error c has the expectation 0 and the
/// covariance V. With all given sigmas true V is N; here sigma0 multiplies what comes from image points, observations
/// in metres and radians count as given, and those of positions are multiplied by what is left of their residuals after
/// d if that contradicts them (1 %). c' V^-1 c is chi-squared with as many degrees of freedom as N has rank, or times
/// that Fisher's F where a factor was estimated.
///
/// Rank. Directions in which N is below 1e-7 of H'P H, parameter by parameter, are not determined: they are left out,
/// and parameters that they are of have infinite sigmas.
class ScoreTests {
 public:
  /// Needs the factor before it is inverted.
  ScoreTests(const Solved& solved, const SystematicOptions& options, const TileCholesky& factor, const Run& run);

  /// `adjusted`: with sigma0 and redundancy; `inverse`: the factor after invert().
  [[nodiscard]] std::vector<SystematicTest> tests(const Adjusted& adjusted, TileCholesky& inverse, const Run& run);

 private:
  /// A fitted hypothesis.
  struct Fit {
    Eigen::MatrixXd basis;  ///< columns of M that are determined, combined so that their N is the unit matrix
    Eigen::VectorXd score;  ///< of these, and so their estimate
    Eigen::VectorXd value;  ///< parameters
    Eigen::VectorXd by_column;
    double image_variance = 1, position_variance = 1, freedom = 0;
    double strength = 0;  ///< minus the logarithm of p_value, which may be too small for a number
  };
  struct Scores {
    double statistic = 0, p_value = 1, strength = 0;
    int degrees = 0;
  };

  [[nodiscard]] Fit fit(const Hypothesis& hypothesis, SystematicTest& test) const;
  [[nodiscard]] Eigen::MatrixXd columns_of(const Hypothesis& hypothesis) const;
  void scale(Fit& fit) const;
  [[nodiscard]] Eigen::MatrixXd variance(const Fit& fit, const Eigen::MatrixXd& basis) const;
  [[nodiscard]] Scores score(const Fit& fit, const Eigen::MatrixXd& basis) const;
  [[nodiscard]] Scores score_given(const Fit& fit, const std::vector<const Fit*>& others) const;
  void count_redundancy(TileCholesky& inverse);
  void choose_assignment();
  void correct_for_number(double level);
  void group(double level);
  [[nodiscard]] bool are_alike(std::size_t a, std::size_t b, double level) const;
  void measure_effects(TileCholesky& inverse, const Run& run);
  [[nodiscard]] double largest_at_given(const Eigen::VectorXd& by_column) const;

  const Solved& solved_;
  SystematicOptions options_;
  HypothesisColumns columns_;
  ScoreNormals normals_;
  double sigma0_ = 1, redundancy_ = 0, of_positions_ = 0;  ///< redundancies
  std::vector<SystematicTest> tests_;
  std::vector<Fit> fits_;
};

}  // namespace collinea::bundle
