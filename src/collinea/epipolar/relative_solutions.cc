// SPDX-License-Identifier: Apache-2.0
// Choice among the four solutions, and weights by distribution.
#include <algorithm>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/relative_orientation.h"

namespace collinea {

std::array<RelativeSolution, 4> relative_solutions(const Rigid3& second_from_first, std::span<const PairPoint> points) {
  const std::array<Rigid3, 4> four = motions(essential_matrix(second_from_first));
  std::array<RelativeSolution, 4> out;
  for (std::size_t k = 0; k < 4; ++k) {
    out[k].second_from_first = four[k];
    const Eigen::Matrix3d first_from_second = four[k].rotation.toRotationMatrix().transpose();
    const Eigen::Vector3d base = base_in_first(four[k]);
    for (const PairPoint& point : points) {
      // Signs of the distances along both rays where they come nearest to each other.
      const Eigen::Vector3d first = point.first.homogeneous(), second = first_from_second * point.second.homogeneous();
      const Eigen::Vector3d normal = first.cross(second);
      out[k].in_front += base.cross(second).dot(normal) > 0 && base.cross(first).dot(normal) > 0;
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const RelativeSolution& a, const RelativeSolution& b) { return a.in_front > b.in_front; });
  return out;
}

std::vector<double> distribution_weights(std::span<const PairPoint> points, PairWeights weights) {
  std::vector<double> out(points.size(), 1.0);
  if (weights == PairWeights::kEqual || points.empty()) return out;
  Eigen::Array2d least = points[0].first, most = least;
  for (const PairPoint& point : points) {
    least = least.min(point.first.array());
    most = most.max(point.first.array());
  }
  const Eigen::Array2i cells = weights == PairWeights::kGruber ? Eigen::Array2i(2, 3) : Eigen::Array2i(5, 5);
  const auto cell_of = [&](const PairPoint& point) {
    const Eigen::Array2d share = (point.first.array() - least) / (most - least).max(1e-300);
    const Eigen::Array2i cell = (share * cells.cast<double>()).floor().cast<int>().max(0).min(cells - 1);
    return static_cast<std::size_t>(cell.y() * cells.x() + cell.x());
  };
  std::vector<int> count(static_cast<std::size_t>(cells.prod()), 0);
  for (const PairPoint& point : points) ++count[cell_of(point)];
  const auto filled = std::count_if(count.begin(), count.end(), [](int n) { return n > 0; });
  for (std::size_t i = 0; i < points.size(); ++i)
    out[i] = static_cast<double>(points.size()) / (static_cast<double>(filled) * count[cell_of(points[i])]);
  return out;
}

}  // namespace collinea
