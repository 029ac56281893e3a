// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/grid_cut.h"

#include <algorithm>
#include <limits>

namespace collinea {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();

}  // namespace

GridCut::GridCut(int width, int height)
    : width_(width), step_{1, width + 2, -1, -(width + 2)}, nodes_(std::size_t(width + 2) * std::size_t(height + 2)) {}

void GridCut::add_edge(int x, int y, Direction to, int forward, int backward) {
  const std::size_t i = index(x, y);
  nodes_[i].residual[to] += forward;
  nodes_[neighbour(i, to)].residual[opposite(to)] += backward;
}

void GridCut::activate(std::size_t i) {
  if (nodes_[i].active) return;
  nodes_[i].active = true;
  queue_.push_back(i);
}

void GridCut::solve() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (node.excess == 0) continue;
    node.tree = node.excess > 0 ? kFirst : kSecond;
    node.parent = kTerminal, node.distance = 1;
    activate(i);
  }
  Bridge bridge;
  while (queue_front_ < queue_.size()) {
    const std::size_t i = queue_[queue_front_];
    // A cell that has found a bridge stays in front: it may have more.
    while (nodes_[i].tree != kFree && grow(i, bridge)) {
      ++time_;
      augment(bridge);
      adopt();
    }
    nodes_[i].active = false;
    if (++queue_front_ > 4096 && 2 * queue_front_ > queue_.size()) {
      queue_.erase(queue_.begin(), queue_.begin() + std::ptrdiff_t(queue_front_));
      queue_front_ = 0;
    }
  }
}

// Takes free neighbours into the tree; true when it meets the other one.
bool GridCut::grow(std::size_t i, Bridge& bridge) {
  const Tree tree = nodes_[i].tree;
  for (std::uint8_t to = 0; to < 4; ++to) {
    if (outward(tree, i, to) == 0) continue;
    const std::size_t j = neighbour(i, to);
    Node& other = nodes_[j];
    const Node& node = nodes_[i];
    if (other.tree == kFree) {
      other.tree = tree, other.parent = opposite(to), other.seen = node.seen, other.distance = node.distance + 1;
      activate(j);
    } else if (other.tree != tree) {
      bridge = tree == kFirst ? Bridge{i, to} : Bridge{j, opposite(to)};
      return true;
    } else if (other.seen <= node.seen && other.distance > node.distance + 1 && other.parent < kTerminal) {
      other.parent = opposite(to), other.seen = node.seen, other.distance = node.distance + 1;
    }
  }
  return false;
}

int GridCut::narrowest(const Bridge& bridge) const {
  int flow = nodes_[bridge.from].residual[bridge.to];
  for (const Tree tree : {kFirst, kSecond}) {
    std::size_t i = tree == kFirst ? bridge.from : neighbour(bridge.from, bridge.to);
    for (; nodes_[i].parent != kTerminal; i = neighbour(i, nodes_[i].parent)) {
      const std::size_t parent = neighbour(i, nodes_[i].parent);
      flow = std::min(flow, outward(tree, parent, opposite(nodes_[i].parent)));
    }
    flow = std::min(flow, std::abs(nodes_[i].excess));
  }
  return flow;
}

void GridCut::push_along(Tree tree, std::size_t i, int flow) {
  while (nodes_[i].parent != kTerminal) {
    const std::uint8_t to = nodes_[i].parent;
    const std::size_t parent = neighbour(i, to);
    int& up = nodes_[i].residual[to];
    int& down = nodes_[parent].residual[opposite(to)];
    (tree == kFirst ? up : down) += flow;
    (tree == kFirst ? down : up) -= flow;
    if ((tree == kFirst ? down : up) == 0) {
      nodes_[i].parent = kOrphan;
      orphans_.push_back(i);
    }
    i = parent;
  }
  nodes_[i].excess -= tree == kFirst ? flow : -flow;
  if (nodes_[i].excess != 0) return;
  nodes_[i].parent = kOrphan;
  orphans_.push_back(i);
}

void GridCut::augment(const Bridge& bridge) {
  const int flow = narrowest(bridge);
  const std::size_t other = neighbour(bridge.from, bridge.to);
  nodes_[bridge.from].residual[bridge.to] -= flow;
  nodes_[other].residual[opposite(bridge.to)] += flow;
  push_along(kFirst, bridge.from, flow);
  push_along(kSecond, other, flow);
}

void GridCut::adopt() {
  for (std::size_t k = 0; k < orphans_.size(); ++k) find_parent(orphans_[k]);
  orphans_.clear();
}

// kFar when the way ends at an orphan.
int GridCut::distance_to_root(std::size_t i) {
  for (int distance = 0;; i = neighbour(i, nodes_[i].parent)) {
    if (nodes_[i].seen == time_) return distance + nodes_[i].distance;
    ++distance;
    if (nodes_[i].parent == kTerminal) {
      nodes_[i].seen = time_, nodes_[i].distance = 1;
      return distance;
    }
    if (nodes_[i].parent >= kOrphan) return kFar;
  }
}

void GridCut::mark_path(std::size_t i, int distance) {
  for (; nodes_[i].seen != time_; i = neighbour(i, nodes_[i].parent))
    nodes_[i].seen = time_, nodes_[i].distance = distance--;
}

void GridCut::find_parent(std::size_t orphan) {
  Node& node = nodes_[orphan];
  const Tree tree = node.tree;
  int nearest = kFar;
  for (std::uint8_t to = 0; to < 4; ++to) {
    const std::size_t j = neighbour(orphan, to);
    if (nodes_[j].tree != tree || outward(tree, j, opposite(to)) == 0) continue;
    const int distance = distance_to_root(j);
    if (distance == kFar) continue;
    if (distance < nearest) nearest = distance, node.parent = to;
    mark_path(j, distance);
  }
  if (nearest != kFar) {
    node.seen = time_, node.distance = nearest + 1;
    return;
  }
  for (std::uint8_t to = 0; to < 4; ++to) {
    const std::size_t j = neighbour(orphan, to);
    Node& other = nodes_[j];
    if (other.tree != tree) continue;
    if (outward(tree, j, opposite(to)) > 0) activate(j);
    if (other.parent != opposite(to)) continue;
    other.parent = kOrphan;
    orphans_.push_back(j);
  }
  node.tree = kFree, node.parent = kNone;
}

}  // namespace collinea
