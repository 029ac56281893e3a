// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/position_tree.h"

#include <algorithm>
#include <numeric>

namespace collinea {

PositionTree::PositionTree(std::vector<Eigen::Vector3d> points)
    : points_(std::move(points)), order_(points_.size()), axis_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, order_.size());
}

void PositionTree::build(std::size_t begin, std::size_t end) {
  if (end - begin < 2) return;
  Eigen::Vector3d low = points_[order_[begin]], high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points_[order_[i]]);
    high = high.cwiseMax(points_[order_[i]]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(points_[a][axis], a) < std::pair(points_[b][axis], b);
  });
  axis_[middle] = static_cast<std::uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

std::vector<PositionTree::Neighbour> PositionTree::nearest(std::uint32_t index, std::size_t count) const {
  std::vector<Neighbour> heap;  // the farthest on top
  if (count > 0) search(0, order_.size(), index, count, heap);
  std::sort_heap(heap.begin(), heap.end());
  return heap;
}

void PositionTree::search(std::size_t begin, std::size_t end, std::uint32_t index, std::size_t count,
                          std::vector<Neighbour>& heap) const {
  if (begin >= end) return;
  const std::size_t middle = begin + (end - begin) / 2;
  const std::uint32_t here = order_[middle];
  const Eigen::Vector3d& from = points_[index];
  if (here != index) {
    const Neighbour found{(points_[here] - from).squaredNorm(), here};
    if (heap.size() < count) {
      heap.push_back(found);
      std::push_heap(heap.begin(), heap.end());
    } else if (found < heap.front()) {
      std::pop_heap(heap.begin(), heap.end());
      heap.back() = found;
      std::push_heap(heap.begin(), heap.end());
    }
  }
  const double beyond = from[axis_[middle]] - points_[here][axis_[middle]];
  const bool low_first = beyond < 0;
  if (low_first)
    search(begin, middle, index, count, heap);
  else
    search(middle + 1, end, index, count, heap);
  if (heap.size() == count && beyond * beyond > heap.front().squared_distance) return;
  if (low_first)
    search(middle + 1, end, index, count, heap);
  else
    search(begin, middle, index, count, heap);
}

}  // namespace collinea
