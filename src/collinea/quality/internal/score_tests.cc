// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/score_tests.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/math/fisher.h"
#include "collinea/math/series_tests.h"
#include "collinea/quality/internal/covariance.h"
#include "collinea/quality/internal/hypothesis_layout.h"

namespace collinea::bundle {
namespace {

constexpr double kDetermined = 1e-7;         // part of H'P H that is left after the adjustment
constexpr double kSeparable = 1e-4;          // the same of a hypothesis beside others
constexpr double kUndeterminedShare = 1e-6;  // of a parameter in directions that are not determined
constexpr double kContradicted = 0.01;       // chance of residuals of positions as large by their sigmas
constexpr double kAlike = 0.95;              // correlation
constexpr double kNearOne = 0.3;             // of an assignment, or four sigmas
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

ScoreTests::ScoreTests(const Solved& solved, const SystematicOptions& options, const TileCholesky& factor,
                       const Run& run)
    : solved_(solved),
      options_(options),
      columns_(lay_out_hypotheses(solved, options)),
      normals_(solved, columns_, factor, run) {}

Eigen::MatrixXd ScoreTests::columns_of(const Hypothesis& hypothesis) const {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(columns_.count(), hypothesis.parameters());
  for (std::size_t k = 0; k < hypothesis.columns.size(); ++k)
    if (hypothesis.combination.size() > 0)
      basis.row(hypothesis.columns[k]) = hypothesis.combination.row(static_cast<Eigen::Index>(k));
    else
      basis(hypothesis.columns[k], static_cast<Eigen::Index>(k)) = 1;
  return basis;
}

Eigen::MatrixXd ScoreTests::variance(const Fit& fit, const Eigen::MatrixXd& basis) const {
  const auto of = [&](const Eigen::MatrixXd& gram) -> Eigen::MatrixXd { return basis.transpose() * gram * basis; };
  const Eigen::MatrixXd positions = of(normals_.of_positions()), others = of(normals_.of_others());
  return fit.image_variance * (of(normals_.gram()) - positions - others) + fit.position_variance * positions + others;
}

ScoreTests::Scores ScoreTests::score(const Fit& fit, const Eigen::MatrixXd& basis) const {
  Scores scores;
  scores.degrees = static_cast<int>(basis.cols());
  if (scores.degrees == 0) return scores;
  const Eigen::VectorXd c = basis.transpose() * normals_.gram().col(columns_.residual());
  scores.statistic = c.dot(variance(fit, basis).ldlt().solve(c));
  scores.p_value = fisher_tail(scores.statistic / scores.degrees, scores.degrees, fit.freedom);
  scores.strength = -log_fisher_tail(scores.statistic / scores.degrees, scores.degrees, fit.freedom);
  return scores;
}

// The variance factors, from the residuals that the hypothesis would leave.
void ScoreTests::scale(Fit& fit) const {
  const int v = columns_.residual();
  const double rank = static_cast<double>(fit.basis.cols());
  fit.freedom = kInfinity;
  if (!options_.sigma0_known && redundancy_ > rank) {
    fit.freedom = redundancy_ - rank;
    fit.image_variance =
        std::max((sigma0_ * sigma0_ * redundancy_ - fit.score.squaredNorm()) / fit.freedom, 1e-3 * sigma0_ * sigma0_);
  }
  const double freedom = of_positions_ - rank;
  if (!(freedom >= 1)) return;
  const Eigen::VectorXd& d = fit.by_column;
  const double squares =
      normals_.of_positions()(v, v) - 2 * d.dot(normals_.of_positions().col(v)) + d.dot(normals_.of_positions() * d);
  if (!(squares > freedom) || fisher_tail(squares / freedom, freedom, kInfinity) > kContradicted) return;
  fit.position_variance = squares / freedom;
  const Eigen::MatrixXd whole = variance(fit, fit.basis);
  const double share =
      (fit.position_variance * whole.ldlt().solve(fit.basis.transpose() * normals_.of_positions() * fit.basis)).trace();
  if (share > 0.5 * rank) fit.freedom = freedom;
}

ScoreTests::Fit ScoreTests::fit(const Hypothesis& hypothesis, SystematicTest& test) const {
  Fit fit;
  const Eigen::MatrixXd basis = columns_of(hypothesis);
  const Eigen::MatrixXd n = basis.transpose() * normals_.gram() * basis;
  Eigen::VectorXd unit(n.rows());
  for (Eigen::Index k = 0; k < n.rows(); ++k) {
    const double before = basis.col(k).dot(normals_.before_reduction() * basis.col(k));
    unit[k] = before > 0 ? 1 / std::sqrt(before) : 0;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * n * unit.asDiagonal());
  Eigen::Index lost = 0;
  while (lost < n.rows() && !(eigen.eigenvalues()[lost] > kDetermined)) ++lost;
  const Eigen::Index rank = n.rows() - lost;
  const Eigen::MatrixXd parameters = unit.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                                     eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  fit.basis = basis * parameters;
  fit.score = fit.basis.transpose() * normals_.gram().col(columns_.residual());
  fit.value = parameters * fit.score;
  fit.by_column = fit.basis * fit.score;
  scale(fit);
  const Scores scores = score(fit, fit.basis);
  fit.strength = scores.strength;
  test.statistic = scores.statistic;
  test.degrees = scores.degrees;
  test.p_value = scores.p_value;
  test.determined = lost == 0;
  if (test.determined) {
    const Eigen::VectorXd shares = parameters.rowwise().squaredNorm().cwiseQuotient(unit.cwiseAbs2()).cwiseInverse();
    test.multiple_correlation = std::sqrt(std::clamp(1 - shares.minCoeff(), 0.0, 1.0));
  }
  const Eigen::MatrixXd covariance = parameters * variance(fit, fit.basis) * parameters.transpose();
  for (Eigen::Index k = 0; k < n.rows(); ++k) {
    const bool is_known = unit[k] > 0 && eigen.eigenvectors().row(k).head(lost).squaredNorm() < kUndeterminedShare;
    test.values.push_back(fit.value[k]);
    test.sigmas.push_back(is_known ? std::sqrt(std::max(covariance(k, k), 0.0)) : kInfinity);
  }
  return fit;
}

// What others leave of a hypothesis: the columns of its basis less what these explain.
ScoreTests::Scores ScoreTests::score_given(const Fit& fit, const std::vector<const Fit*>& others) const {
  Eigen::Index width = 0;
  for (const Fit* other : others) width += other->basis.cols();
  Eigen::MatrixXd all(columns_.count(), width);
  Eigen::Index at = 0;
  Fit joint = fit;
  for (const Fit* other : others) {
    all.middleCols(at, other->basis.cols()) = other->basis;
    at += other->basis.cols();
    joint.image_variance = std::min(joint.image_variance, other->image_variance);
    joint.position_variance = std::min(joint.position_variance, other->position_variance);
    joint.freedom = std::min(joint.freedom, other->freedom);
  }
  const Eigen::MatrixXd by = all.transpose() * normals_.gram();
  const Eigen::MatrixXd basis = fit.basis - all * (by * all).completeOrthogonalDecomposition().solve(by * fit.basis);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(basis.transpose() * normals_.gram() * basis);
  Eigen::Index lost = 0;
  while (lost < eigen.eigenvalues().size() && !(eigen.eigenvalues()[lost] > kSeparable)) ++lost;
  return score(joint, basis * eigen.eigenvectors().rightCols(eigen.eigenvalues().size() - lost));
}

void ScoreTests::count_redundancy(TileCholesky& inverse) {
  of_positions_ = 0;
  for_each_row<GnssPosition>(solved_.problem(), solved_.state(), [&](const auto&, int, const ObservationRow& row) {
    const double weight = row.weight * row.inverse_sigma * row.inverse_sigma;
    of_positions_ += 1 - weight * variance_of(row.derivatives, inverse);
  });
}

// Both directions are one hypothesis, of which the value has to be a whole image.
void ScoreTests::choose_assignment() {
  const auto is_it = [](const SystematicTest& test) { return test.kind == SystematicKind::kAssignment; };
  const auto first = std::ranges::find_if(tests_, is_it);
  if (first == tests_.end()) return;
  const auto a = static_cast<std::size_t>(first - tests_.begin());
  const auto off = [&](std::size_t i, double whole) { return std::abs(tests_[i].values[0] - whole); };
  const std::size_t chosen = off(a, 1) < off(a + 1, -1) ? a : a + 1;
  const double from_whole = off(chosen, chosen == a ? 1 : -1);
  SystematicTest& test = tests_[chosen];
  if (!(from_whole < std::max(kNearOne, 4 * test.sigmas[0])) || !(from_whole < 1)) test.p_value = 1;
  const auto dropped = static_cast<std::ptrdiff_t>(chosen == a ? a + 1 : a);
  tests_.erase(tests_.begin() + dropped);
  fits_.erase(fits_.begin() + dropped);
}

void ScoreTests::correct_for_number(double level) {
  std::vector<std::size_t> tested;
  std::vector<double> p_values;
  for (std::size_t i = 0; i < tests_.size(); ++i) {
    if (tests_[i].degrees == 0) continue;
    tested.push_back(i);
    p_values.push_back(tests_[i].p_value);
  }
  const std::vector<double> corrected = holm(p_values);
  for (std::size_t k = 0; k < tested.size(); ++k) {
    tests_[tested[k]].p_corrected = corrected[k];
    tests_[tested[k]].significant = corrected[k] < level;
  }
}

bool ScoreTests::are_alike(std::size_t a, std::size_t b, double level) const {
  const Fit &x = fits_[a], &y = fits_[b];
  const double both = x.by_column.dot(normals_.gram() * y.by_column);
  if (std::abs(both) > kAlike * x.score.norm() * y.score.norm()) return true;
  return score_given(x, {&y}).p_value > level && score_given(y, {&x}).p_value > level;
}

// Forward selection: the strongest stands for itself; of the others the strongest that it leaves significant, and so
// on.
void ScoreTests::group(double level) {
  std::vector<std::size_t> left, leaders;
  std::vector<const Fit*> fitted;
  for (std::size_t i = 0; i < tests_.size(); ++i)
    if (tests_[i].significant) left.push_back(i);
  const double single = level / static_cast<double>(std::max<std::size_t>(1, tests_.size()));
  while (!left.empty()) {
    std::size_t best = left[0];
    double strongest = -kInfinity;
    std::vector<std::size_t> still;
    for (const std::size_t i : left) {
      const Scores scores =
          leaders.empty() ? Scores{.p_value = 0, .strength = fits_[i].strength} : score_given(fits_[i], fitted);
      if (scores.p_value > single) {
        const auto leaves = [&](std::size_t leader) { return score_given(fits_[i], {&fits_[leader]}).strength; };
        tests_[i].explained_by = *std::ranges::min_element(leaders, {}, leaves);
        continue;
      }
      still.push_back(i);
      if (scores.strength > strongest) best = i;
      strongest = std::max(strongest, scores.strength);
    }
    left = std::move(still);
    if (left.empty()) break;
    std::erase(left, best);
    leaders.push_back(best);
    fitted.push_back(&fits_[best]);
  }
  for (std::size_t i = 0; i < tests_.size(); ++i) {
    if (!tests_[i].explained_by || !are_alike(i, *tests_[i].explained_by, single)) continue;
    tests_[i].indistinguishable.push_back(*tests_[i].explained_by);
    tests_[*tests_[i].explained_by].indistinguishable.push_back(i);
  }
}

std::vector<SystematicTest> ScoreTests::tests(const Adjusted& adjusted, TileCholesky& inverse, const Run& run) {
  if (run.stopped()) return {};
  redundancy_ = static_cast<double>(adjusted.redundancy);
  sigma0_ = options_.sigma0_known ? 1 : sigma_scale(adjusted);
  count_redundancy(inverse);
  for (const Hypothesis& hypothesis : columns_.hypotheses) {
    tests_.push_back(hypothesis.test);
    fits_.push_back(fit(hypothesis, tests_.back()));
  }
  choose_assignment();
  correct_for_number(options_.level);
  group(options_.level);
  measure_effects(inverse, run);
  return std::move(tests_);
}

}  // namespace collinea::bundle
