// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/internal/control_weights.h"

#include "collinea/math/inverse_root.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Of what is not known: no covariance with the rest, and the variance 1.
void clear_unknown(const AbsoluteControl& pair, Matrix3d& covariance) {
  if (!pair.has_plan) {
    covariance.topRows<2>() = Matrix3d::Identity().topRows<2>();
    covariance.leftCols<2>() = Matrix3d::Identity().leftCols<2>();
  }
  if (!pair.has_height) {
    covariance.row(2) = Vector3d::UnitZ().transpose();
    covariance.col(2) = Vector3d::UnitZ();
  }
}

// All rows one below the other.
auto stacked(std::vector<ControlWeights::Rows>& rows) {
  return Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>>(
      rows.data()->data(), 3 * static_cast<Eigen::Index>(rows.size()), 8);
}
auto stacked(std::vector<Vector3d>& values) {
  return Eigen::Map<Eigen::VectorXd>(values.data()->data(), 3 * static_cast<Eigen::Index>(values.size()));
}

template <class Block>
void whiten_all(const std::vector<Matrix3d>& roots, const Eigen::LLT<MatrixXd>* whole, std::vector<Block>& blocks) {
  if (whole) {
    auto all = stacked(blocks);
    all = whole->matrixL().solve(all).eval();
    return;
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {  // by the lower triangle, from below
    const Matrix3d& r = roots[i];
    Block& b = blocks[i];
    b.row(2) = r(2, 0) * b.row(0) + r(2, 1) * b.row(1) + r(2, 2) * b.row(2);
    b.row(1) = r(1, 0) * b.row(0) + r(1, 1) * b.row(1);
    b.row(0) *= r(0, 0);
  }
}

template <class Block>
void whiten_all_transposed(const std::vector<Matrix3d>& roots, const Eigen::LLT<MatrixXd>* whole,
                           std::vector<Block>& blocks) {
  if (whole) {
    auto all = stacked(blocks);
    all = whole->matrixU().solve(all).eval();
    return;
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Matrix3d& r = roots[i];
    Block& b = blocks[i];
    b.row(0) = r(0, 0) * b.row(0) + r(1, 0) * b.row(1) + r(2, 0) * b.row(2);
    b.row(1) = r(1, 1) * b.row(1) + r(2, 1) * b.row(2);
    b.row(2) *= r(2, 2);
  }
}

}  // namespace

void clear_unknown(const AbsoluteControl& pair, Vector3d& on_axes) {
  if (!pair.has_plan) on_axes.head<2>().setZero();
  if (!pair.has_height) on_axes.z() = 0;
}

bool ControlWeights::set(const Matrix3d& scaled_rotation) {
  scaled_rotation_ = scaled_rotation;
  variances_.resize(pairs_.size());
  if (full_) return set_full();
  roots_.resize(pairs_.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const AbsoluteControl& pair = pairs_[i];
    const Matrix3d by_model = scaled_rotation * pair.model_covariance;
    Matrix3d sum = pair.ground_covariance + by_model * scaled_rotation.transpose();
    if (!pair.is_full()) clear_unknown(pair, sum);
    if (!inverse_root(sum, roots_[i])) return false;
    variances_[i] = sum.diagonal();
  }
  return true;
}

bool ControlWeights::set_full() {
  const auto n = static_cast<Eigen::Index>(pairs_.size());
  MatrixXd sum(3 * n, 3 * n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const AbsoluteControl &row = pairs_[static_cast<std::size_t>(i)], &column = pairs_[static_cast<std::size_t>(j)];
      Matrix3d block = scaled_rotation_ * full_->block<3, 3>(3 * i, 3 * j) * scaled_rotation_.transpose();
      if (i == j) {
        block += row.ground_covariance;
        clear_unknown(row, block);
        variances_[static_cast<std::size_t>(i)] = block.diagonal();
      } else {
        for (int axis = 0; axis < 3; ++axis) {
          if (!(axis < 2 ? row.has_plan : row.has_height)) block.row(axis).setZero();
          if (!(axis < 2 ? column.has_plan : column.has_height)) block.col(axis).setZero();
        }
      }
      sum.block<3, 3>(3 * i, 3 * j) = block;
    }
  whole_.compute(sum);
  return whole_.info() == Eigen::Success;
}

void ControlWeights::whiten(std::vector<Rows>& rows) const { whiten_all(roots_, full_ ? &whole_ : nullptr, rows); }
void ControlWeights::whiten(std::vector<Vector3d>& values) const {
  whiten_all(roots_, full_ ? &whole_ : nullptr, values);
}
void ControlWeights::whiten_transposed(std::vector<Rows>& rows) const {
  whiten_all_transposed(roots_, full_ ? &whole_ : nullptr, rows);
}
void ControlWeights::whiten_transposed(std::vector<Vector3d>& values) const {
  whiten_all_transposed(roots_, full_ ? &whole_ : nullptr, values);
}

ControlWeights::Diagonals ControlWeights::diagonals() const {
  Diagonals out{.inverse = std::vector<Vector3d>(pairs_.size()), .covariance = variances_};
  if (full_) {
    const auto n = 3 * static_cast<Eigen::Index>(pairs_.size());
    stacked(out.inverse) = whole_.solve(MatrixXd::Identity(n, n)).diagonal();
    return out;
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) out.inverse[i] = roots_[i].colwise().squaredNorm().transpose();
  return out;
}

std::vector<Vector3d> ControlWeights::model_corrections(const std::vector<Vector3d>& multipliers) const {
  std::vector<Vector3d> corrections(pairs_.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Vector3d in_model = scaled_rotation_.transpose() * multipliers[i];
    corrections[i] = full_ ? in_model : Vector3d(pairs_[i].model_covariance * in_model);
  }
  if (full_) stacked(corrections) = (*full_ * stacked(corrections)).eval();
  return corrections;
}

}  // namespace collinea
