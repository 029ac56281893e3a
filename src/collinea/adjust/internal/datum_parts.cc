// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/datum_parts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace collinea::bundle {
namespace {

// Of unknowns of their own, by normal equations with ones on the diagonal: what has an eigenvalue of no more than this
// is not determined by the rows, and takes nothing from the motions. Not a part of the largest one, as kSeenMotion is.
constexpr double kDeterminedAuxiliary = 1e-9;

}  // namespace

MotionsWithAuxiliaries::MotionsWithAuxiliaries(const Problem& problem, std::size_t parts) : problem_(problem) {
  for (std::size_t k = 0; k < problem.auxiliaries.size(); ++k)
    add_column(problem.first_auxiliary + static_cast<int>(k), problem.auxiliaries[k].inverse_sigma > 0);
  for (const std::uint32_t p : problem.retained_points) {
    const ProblemPoint& point = problem.point(p);
    if (!problem.is_unseen(p)) continue;
    for (int c = 0; c < 3; ++c)
      add_column(point.first_retained + c,
                 problem.control[static_cast<std::size_t>(point.control)].inverse_sigma[c] > 0);
  }
  normals_.assign(parts, Eigen::MatrixXd::Zero(7 + count(), 7 + count()));
}

void MotionsWithAuxiliaries::add_column(int among_globals, bool observed) {
  column_[among_globals] = count();
  observed_.push_back(observed);
}

void MotionsWithAuxiliaries::add(int part, const Row7& motions, const Row& row) {
  Eigen::RowVectorXd all = Eigen::RowVectorXd::Zero(7 + count());
  all.head<7>() = motions;
  for (const RowPart& one : row)
    if (const auto k = column_.find(one.row - 6 * problem_.poses); k != column_.end())
      all[7 + k->second] += one.derivative;
  if (all.squaredNorm() > 0) normals_[part] += all.transpose() * all;
}

Matrix7 MotionsWithAuxiliaries::seen(int part) const {
  Eigen::MatrixXd n = normals_[part];
  Matrix7 seen = n.topLeftCorner<7, 7>();
  if (count() == 0) return seen;
  const double whole = seen.trace();
  for (int k = 0; k < count(); ++k)
    if (observed_[static_cast<std::size_t>(k)]) n(7 + k, 7 + k) += std::max(1.0, n(7 + k, 7 + k));
  const Eigen::VectorXd scale = n.diagonal().tail(count()).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd own = scale.asDiagonal() * n.bottomRightCorner(count(), count()) * scale.asDiagonal();
  const Eigen::MatrixXd coupling = n.topRightCorner(7, count()) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own);
  for (int k = 0; k < count(); ++k) {
    if (!(eigen.eigenvalues()[k] > kDeterminedAuxiliary)) continue;
    const Vector7 along = coupling * eigen.eigenvectors().col(k);
    seen -= along * along.transpose() / eigen.eigenvalues()[k];
  }
  const Eigen::SelfAdjointEigenSolver<Matrix7> left(seen);
  // Rounding is of the size of what there was before, the trace, and not of what is left.
  const Vector7 values = (left.eigenvalues().array() > kSeenMotion * whole).select(left.eigenvalues(), 0.0);
  return left.eigenvectors() * values.asDiagonal() * left.eigenvectors().transpose();
}

}  // namespace collinea::bundle
