// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/whitened_positions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>

#include "collinea/adjust/observation_kinds.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kWindow = 20;
constexpr double kNothingLeft = 1e-3;  // of its variance: rounding, and what shifts of positions take

struct PositionRow {
  std::size_t at = 0;  // in the answer
  double residual = 0, variance = 0;
  Row derivatives;
};

// The cofactor a Q b'; 0 for what the selected inverse does not hold.
double cofactor(const Row& a, const Row& b, TileCholesky& inverse) {
  double sum = 0;
  for (const RowPart& one : a)
    for (const RowPart& other : b) {
      const int row = std::max(one.row, other.row), column = std::min(one.row, other.row);
      if (inverse.holds(row / kTile, column / kTile))
        sum += one.derivative * other.derivative * inverse.at(row, column);
    }
  return sum;
}

// Nothing when hardly anything of it is left by those before.
double whitened(const PositionRow& one, const std::deque<const PositionRow*>& before, TileCholesky& inverse) {
  const auto n = Eigen::Index(before.size());
  const auto covariance = [&](const PositionRow& a, const PositionRow& b) {
    return (a.at == b.at ? a.variance : 0) - cofactor(a.derivatives, b.derivatives, inverse);
  };
  const double own = covariance(one, one);
  if (n == 0)
    return own > kNothingLeft * one.variance ? one.residual / std::sqrt(own) : std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd joint(n, n);
  Eigen::VectorXd with(n), residuals(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PositionRow& other = *before[std::size_t(i)];
    for (Eigen::Index k = 0; k <= i; ++k) joint(i, k) = joint(k, i) = covariance(other, *before[std::size_t(k)]);
    with[i] = covariance(one, other);
    residuals[i] = other.residual;
  }
  const Eigen::VectorXd gain = joint.ldlt().solve(with);
  const double left = own - gain.dot(with);
  if (!(left > kNothingLeft * one.variance)) return std::numeric_limits<double>::quiet_NaN();
  return (one.residual - gain.dot(residuals)) / std::sqrt(left);
}

}  // namespace

std::vector<WhitenedPosition> whitened_positions(const Solved& solved, const std::vector<ImageId>& order,
                                                 TileCholesky& inverse) {
  std::map<ImageId, std::size_t> at;
  std::vector<WhitenedPosition> list;
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const ImageId image : order)
    if (at.try_emplace(image, list.size()).second) list.push_back({image, none, none});
  std::array<std::vector<PositionRow>, 3> axes;
  for_each_row<GnssPosition>(
      solved.problem(), solved.state(), [&](const GivenPosition& item, int axis, const ObservationRow& row) {
        const auto its = at.find(ImageId{GnssPosition::source(solved.problem(), item)});
        if (its == at.end()) return;
        axes[std::size_t(axis)].push_back(
            {its->second, row.residual, 1 / (row.inverse_sigma * row.inverse_sigma), row.derivatives});
      });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::ranges::sort(axes[axis], {}, &PositionRow::at);
    std::deque<const PositionRow*> before;
    for (const PositionRow& one : axes[axis]) {
      WhitenedPosition& its = list[one.at];
      its.residual_m[Eigen::Index(axis)] = one.residual;
      its.whitened[Eigen::Index(axis)] = whitened(one, before, inverse);
      if (std::isnan(its.whitened[Eigen::Index(axis)])) continue;
      before.push_back(&one);
      if (before.size() > kWindow) before.pop_front();
    }
  }
  std::erase_if(list, [](const WhitenedPosition& one) { return one.residual_m.array().isNaN().all(); });
  return list;
}

}  // namespace collinea::bundle
