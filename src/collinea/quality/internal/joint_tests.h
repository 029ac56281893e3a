// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/quality/internal/measurement.h"

namespace collinea {

/// A coordinate of a measurement that was given.
struct JointRow {
  std::size_t measurement = 0;  ///< its number in JointSystem::measurements
  int axis = 0;
  double residual = 0;  ///< observed minus adjusted [px, m, rad]; of correlated ones (P v) / p
  double weight = 0;    ///< p, the diagonal element of P, with that of the robust loss
  double sigma = 0;     ///< as given
  bool in_image = false;
};

/// All measurements that were given (control in images and on the ground, positions, attitudes, measurements on the
/// ground) in one adjustment of them, with everything that tests of several of them together follow from.
struct JointSystem {
  std::vector<MeasurementIndex> measurements;
  std::vector<JointRow> rows;    ///< those of a measurement side by side
  std::vector<int> first, size;  ///< of each measurement: its rows
  Eigen::VectorXd scores;        ///< P v of these rows
  Eigen::MatrixXd gram;          ///< P C P, C = P^-1 - A Q A' being the cofactor of the residuals
  double squares = 0;            ///< v' P v of the whole adjustment
  long redundancy = 0;
  bool sigma0_known = false;

  [[nodiscard]] double sigma0(double squares_less = 0, int rows_less = 0) const;
};

/// The joint cofactors, by one solution with the factor for each coordinate. Nothing (no measurements) when there are
/// more than `most` measurements; marks of control take part only as long as there are not.
[[nodiscard]] JointSystem joint_system(const Solved& solved, const bundle::TileCholesky& factor, std::size_t most,
                                       bool sigma0_known, const Run& run);

/// The tests of all others when a set of measurements has been rejected, and of each of the set when the rest of it has
/// been: exact for linear equations.
struct JointOutcome {
  bool is_determined = false;  ///< what is left checks the whole set
  double statistic = 0;        ///< T = s' G^-1 s: by how much v' P v falls
  double sigma0 = 1;           ///< without the set
  struct Test {
    double redundancy = 0, gross_error = 0, w = 0;
  };
  std::vector<Test> tests;  ///< parallel to the rows
};

/// The multi-dimensional test of a set S of q coordinates (Teunissen 2000; for q = 1 Baarda's w^2):
///
///     T = s_S' G_SS^-1 s_S,    chi-squared with q degrees of freedom if nothing in S is wrong (sigma0 = 1),
///
/// and the scores s - G_:S G_SS^-1 s_S and cofactors G - G_:S G_SS^-1 G_S: of what is left without S.
[[nodiscard]] double joint_statistic(const JointSystem& system, std::span<const std::size_t> set);
[[nodiscard]] JointOutcome without_set(const JointSystem& system, std::span<const std::size_t> set);

/// How much of the errors of a set shows in its residuals at least: the smallest eigenvalue of its part of the
/// redundancy matrix, for one coordinate its redundancy number.
[[nodiscard]] double redundancy_of(const JointSystem& system, std::span<const std::size_t> set);

/// What the system would be if these rows had been measured otherwise by so much.
[[nodiscard]] JointSystem with_errors(JointSystem system, std::span<const std::size_t> rows,
                                      std::span<const double> errors);

/// The smallest canonical correlation of two sets of measurements in their residuals, after what they have in common:
/// near 1 an error in the one looks like errors in the other, whatever their sizes (for single ones Foerstner's rho).
/// Of sets with different numbers of coordinates: of all errors in the smaller.
[[nodiscard]] double joint_correlation(const JointSystem& system, std::span<const std::size_t> a,
                                       std::span<const std::size_t> b);

/// A set of measurements whose gross errors explain all that does not fit.
struct Explanation {
  std::vector<std::size_t> set;  ///< ascending numbers in JointSystem::measurements
  double statistic = 0;
};

/// The smallest sets of up to three measurements without which no test of another one is beyond `limit`, while that of
/// each of the set is: all of that size, the one with the largest statistic first. Empty: there is none, or nothing is
/// beyond the limit. Of each size the 300 sets with the largest statistic are looked at.
[[nodiscard]] std::vector<Explanation> explanations(const JointSystem& system, double limit);

/// True when the set explains everything as above.
[[nodiscard]] bool explains(const JointSystem& system, std::span<const std::size_t> set, double limit);

}  // namespace collinea
