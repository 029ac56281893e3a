// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/closed_orientation.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/closed_similarity.h"
#include "collinea/geometry/internal/control_weights.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix7 = AbsoluteOrientation::Matrix7;
using Design = Eigen::Matrix<double, 3, 7>;
using Influence = Eigen::Matrix<double, 7, 3>;  // of a point's misfit on the parameters

struct Solved {
  Similarity3 b_from_a;
  std::optional<Vector3d> abc;  // of the linear solution by Rodrigues' parameters
};

std::optional<Solved> solved(std::span<const AbsoluteControl> pairs, ClosedForm form) {
  std::vector<Vector3d> a, b;
  for (const AbsoluteControl& pair : pairs) {
    COLLINEA_CHECK(pair.is_full());
    a.push_back(pair.in_model);
    b.push_back(pair.in_ground);
  }
  if (form == ClosedForm::kRodrigues) {
    const auto fit = align_by_rodrigues(a, b);
    return fit ? std::optional(Solved{fit->b_from_a, fit->abc}) : std::nullopt;
  }
  const auto fit = form == ClosedForm::kUmeyama ? align(a, b) : align_by_quaternion(a, b);
  return fit ? std::optional(Solved{*fit, {}}) : std::nullopt;
}

// Least squares rotation: from sum [a]x' [a]x dr = sum [a]x e.
std::vector<Matrix3d> rotation_of_least_squares(const std::vector<Vector3d>& arms) {
  Matrix3d normal = Matrix3d::Zero();
  for (const Vector3d& arm : arms) normal += skew(arm).transpose() * skew(arm);
  const Matrix3d inverse = normal.inverse();
  std::vector<Matrix3d> out;
  for (const Vector3d& arm : arms) out.push_back(inverse * skew(arm));
  return out;
}

// The linear equations  X - u = s x abc,  s = X + u = 2 (I - K)^-1 X,  K = [abc]x:  a misfit e of X is one of (I + K) e
// in them, and dr = -2 / (1 + abc^2) (I - K) dabc (the rotation by a Gibbs vector, Shuster 1993).
std::vector<Matrix3d> rotation_of_rodrigues(const std::vector<Vector3d>& arms, const Vector3d& abc) {
  const Matrix3d k = skew(abc), to_sum = 2 * (Matrix3d::Identity() - k).inverse();
  Matrix3d normal = Matrix3d::Zero();
  for (const Vector3d& arm : arms) {
    const Matrix3d s = skew(to_sum * arm);
    normal += s.transpose() * s;
  }
  const Matrix3d by_equations = -2 / (1 + abc.squaredNorm()) * (Matrix3d::Identity() - k) * normal.inverse();
  std::vector<Matrix3d> out;
  for (const Vector3d& arm : arms)
    out.push_back(by_equations * skew(to_sum * arm).transpose() * (Matrix3d::Identity() + k));
  return out;
}

// What the misfits of the points do to [position, rotation, ln scale]; of the scale both its formulas do the same.
std::vector<Influence> influences(const std::vector<Vector3d>& arms, const std::optional<Vector3d>& abc) {
  const auto rotations = abc ? rotation_of_rodrigues(arms, *abc) : rotation_of_least_squares(arms);
  double spread = 0;
  Vector3d by_scale = Vector3d::Zero();  // of the rotation, zero in least squares
  for (std::size_t i = 0; i < arms.size(); ++i) {
    spread += arms[i].squaredNorm();
    by_scale += rotations[i] * arms[i];
  }
  std::vector<Influence> out(arms.size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const Eigen::RowVector3d scale = arms[i].transpose() / spread;
    out[i] << Matrix3d::Identity() / double(arms.size()), rotations[i] - by_scale * scale, scale;
  }
  return out;
}

// W between two points.
class Covariances {
 public:
  Covariances(std::span<const AbsoluteControl> pairs, const MatrixXd* full, const Matrix3d& turned)
      : pairs_(pairs), full_(full), turned_(turned) {}

  [[nodiscard]] Matrix3d between(std::size_t i, std::size_t j) const {
    const Matrix3d ground = i == j ? pairs_[i].ground_covariance : Matrix3d(Matrix3d::Zero());
    const Matrix3d model = full_    ? Matrix3d(full_->block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * j)))
                           : i == j ? pairs_[i].model_covariance
                                    : Matrix3d(Matrix3d::Zero());
    return ground + turned_ * model * turned_.transpose();
  }
  // sum over j of H_j W_ji
  [[nodiscard]] Influence towards(const std::vector<Influence>& influence, std::size_t i) const {
    if (!full_) return influence[i] * between(i, i);
    Influence sum = Influence::Zero();
    for (std::size_t j = 0; j < influence.size(); ++j) sum += influence[j] * between(j, i);
    return sum;
  }

 private:
  std::span<const AbsoluteControl> pairs_;
  const MatrixXd* full_;
  Matrix3d turned_;
};

Design design_of(const Vector3d& arm) {
  Design design;
  design << Matrix3d::Identity(), -skew(arm), arm;
  return design;
}

// e' (W^-1 - W^-1 A (A' W^-1 A)^-1 A' W^-1) e; nothing when W is not positive definite.
std::optional<double> squares_across(std::span<const AbsoluteControl> pairs, const MatrixXd* full,
                                     const Matrix3d& turned, const std::vector<Vector3d>& arms,
                                     const std::vector<Vector3d>& misfits) {
  ControlWeights weights(pairs, full);
  if (!weights.set(turned)) return std::nullopt;
  std::vector<ControlWeights::Rows> rows(pairs.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] << design_of(arms[i]), misfits[i];
  weights.whiten(rows);
  Matrix7 normal = Matrix7::Zero();
  Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
  double squares = 0;
  for (const ControlWeights::Rows& row : rows) {
    normal += row.leftCols<7>().transpose() * row.leftCols<7>();
    right += row.leftCols<7>().transpose() * row.col(7);
    squares += row.col(7).squaredNorm();
  }
  const Eigen::Matrix<double, 7, 1> unit = normal.diagonal().cwiseSqrt().cwiseInverse(),
                                    scaled = unit.asDiagonal() * right;
  const Matrix7 unit_normal = unit.asDiagonal() * normal * unit.asDiagonal();
  return std::max(0.0, squares - scaled.dot(unit_normal.ldlt().solve(scaled)));
}

ControlResidual residual_of(const Design& design, const Influence& influence, const Matrix3d& own,
                            const Influence& towards, const Matrix7& covariance, const Vector3d& misfit) {
  const Matrix3d taken = design * towards;
  const Matrix3d of_misfit = own - taken - taken.transpose() + design * covariance * design.transpose();
  ControlResidual out;
  out.misfit = misfit;
  out.sigma = of_misfit.diagonal().cwiseMax(0).cwiseSqrt();
  out.redundancy = (Vector3d::Ones() - (design * influence).diagonal()).cwiseMax(0);
  for (int axis = 0; axis < 3; ++axis)
    if (of_misfit(axis, axis) > 1e-9 * own(axis, axis)) out.w[axis] = misfit[axis] / out.sigma[axis];
  return out;
}

}  // namespace

std::optional<AbsoluteOrientation> closed_orientation(std::span<const AbsoluteControl> pairs, ClosedForm form,
                                                      const MatrixXd* model_covariance) {
  const auto found = solved(pairs, form);
  if (!found || !(found->b_from_a.scale > 0)) return std::nullopt;
  AbsoluteOrientation out;
  out.ground_from_model = found->b_from_a;
  const Matrix3d turned = found->b_from_a.scale * found->b_from_a.rotation.toRotationMatrix();
  for (const AbsoluteControl& pair : pairs) out.centroid_in_model += pair.in_model / double(pairs.size());
  std::vector<Vector3d> arms, misfits;
  for (const AbsoluteControl& pair : pairs) {
    arms.push_back(turned * (pair.in_model - out.centroid_in_model));
    misfits.push_back(pair.in_ground - found->b_from_a * pair.in_model);
  }
  const auto squares = squares_across(pairs, model_covariance, turned, arms, misfits);
  if (!squares) return std::nullopt;
  out.redundancy = 3 * static_cast<int>(pairs.size()) - 7;
  out.sigma0 = std::sqrt(*squares / out.redundancy);

  const std::vector<Influence> influence = influences(arms, found->abc);
  const Covariances covariances(pairs, model_covariance, turned);
  std::vector<Influence> towards;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    towards.push_back(covariances.towards(influence, i));
    out.covariance += towards[i] * influence[i].transpose();
  }
  for (std::size_t i = 0; i < pairs.size(); ++i)
    out.residuals.push_back(residual_of(design_of(arms[i]), influence[i], covariances.between(i, i), towards[i],
                                        out.covariance, misfits[i]));
  return out;
}

}  // namespace collinea
