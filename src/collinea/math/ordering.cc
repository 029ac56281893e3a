// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/ordering.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {
namespace {

constexpr int kTilesOfLeaf = 4;  // parts this small are not cut any further

struct Cut {
  std::vector<int> one, other, separator;
};

/// The fewest images that touch every edge between two sides: Koenig's theorem from a maximum matching of the edges,
/// which is found by augmenting paths.
class VertexCover {
 public:
  /// neighbours[a]: those of image a of the left side, as numbers of the right one.
  VertexCover(const std::vector<std::vector<int>>& neighbours, int right)
      : neighbours_(neighbours), left_mate_(neighbours.size(), -1), right_mate_(right, -1), seen_(right, -1) {
    for (int a = 0; a < static_cast<int>(neighbours.size()); ++a) augment(a, a);
    left_reached_.assign(neighbours.size(), 0);
    right_reached_.assign(right, 0);
    for (int a = 0; a < static_cast<int>(neighbours.size()); ++a)
      if (left_mate_[a] < 0) reach(a);
  }
  [[nodiscard]] bool covers_left(int a) const { return !left_reached_[a]; }
  [[nodiscard]] bool covers_right(int b) const { return right_reached_[b] != 0; }

 private:
  bool augment(int a, int round) {
    for (const int b : neighbours_[a])
      if (right_mate_[b] < 0) {
        left_mate_[a] = b;
        right_mate_[b] = a;
        return true;
      }
    for (const int b : neighbours_[a]) {
      if (seen_[b] == round) continue;
      seen_[b] = round;
      if (!augment(right_mate_[b], round)) continue;
      left_mate_[a] = b;
      right_mate_[b] = a;
      return true;
    }
    return false;
  }
  void reach(int a) {
    std::vector<int> open{a};
    left_reached_[a] = 1;
    while (!open.empty()) {
      const int next = open.back();
      open.pop_back();
      for (const int b : neighbours_[next]) {
        if (right_reached_[b]) continue;
        right_reached_[b] = 1;
        const int mate = right_mate_[b];
        if (mate < 0 || left_reached_[mate]) continue;
        left_reached_[mate] = 1;
        open.push_back(mate);
      }
    }
  }

  const std::vector<std::vector<int>>& neighbours_;
  std::vector<int> left_mate_, right_mate_, seen_;
  std::vector<char> left_reached_, right_reached_;
};

class Dissector {
 public:
  Dissector(const Covisibility& graph, const std::vector<Eigen::Vector3d>& centres, int per_tile)
      : graph_(graph), centres_(centres), per_tile_(per_tile), part_(graph.size(), 0), local_(graph.size(), -1) {}

  std::vector<int> order() {
    std::vector<int> all(graph_.size());
    std::iota(all.begin(), all.end(), 0);
    for (const int image : dissect(all, 0)) order_.push_back(image);
    return std::move(order_);
  }

 private:
  // Appends whole tiles of the images to the order; answers those left over. part_[image] is `label` for all of them.
  std::vector<int> dissect(const std::vector<int>& images, int label) {
    if (static_cast<int>(images.size()) <= kTilesOfLeaf * per_tile_) return emit(images, label);
    const std::optional<Cut> cut = best_cut(images, label);
    if (!cut) return emit(walk(images, label), label);
    const int one = ++labels_, other = ++labels_;
    for (const int image : cut->one) part_[image] = one;
    for (const int image : cut->other) part_[image] = other;
    std::vector<int> rest = dissect(cut->one, one);
    const std::vector<int> others = dissect(cut->other, other);
    rest.insert(rest.end(), others.begin(), others.end());
    rest.insert(rest.end(), cut->separator.begin(), cut->separator.end());
    for (const int image : rest) part_[image] = label;
    return emit(walk(rest, label), label);  // along the cut: what a smaller part touches of it lies in few tiles
  }

  // Those with most ties to the outside are left over: they belong to the next cut anyway.
  std::vector<int> emit(std::vector<int> images, int label) {
    const std::size_t over = images.size() % static_cast<std::size_t>(per_tile_);
    std::vector<int> ties(images.size());
    for (std::size_t i = 0; i < images.size(); ++i)
      for (const int other : graph_[images[i]]) ties[i] += part_[other] != label && part_[other] != kDone;
    std::vector<std::size_t> by_ties(images.size());
    std::iota(by_ties.begin(), by_ties.end(), std::size_t{0});
    std::stable_sort(by_ties.begin(), by_ties.end(), [&](auto a, auto b) { return ties[a] < ties[b]; });
    std::vector<char> goes(images.size(), 1);
    for (std::size_t i = images.size() - over; i < images.size(); ++i) goes[by_ties[i]] = 0;
    std::vector<int> left;
    for (std::size_t i = 0; i < images.size(); ++i) (goes[i] ? order_ : left).push_back(images[i]);
    for (std::size_t i = 0; i < images.size(); ++i)
      if (goes[i]) part_[images[i]] = kDone;
    return left;
  }

  // The direction is chosen by cuts in the middle, then the position of the cut.
  std::optional<Cut> best_cut(const std::vector<int>& images, int label) {
    std::optional<Cut> best;
    double least = 1;  // a separator as large as a half is no gain
    const auto look_at = [&](const std::vector<int>& sorted, double share) {
      Cut cut = cut_at(sorted, share, label);
      const std::size_t smaller = std::min(cut.one.size(), cut.other.size());
      if (static_cast<int>(smaller) < per_tile_) return false;
      const double price = static_cast<double>(cut.separator.size()) / static_cast<double>(smaller);
      if (price >= least) return false;
      least = price;
      best = std::move(cut);
      return true;
    };
    std::vector<std::vector<int>> directions;
    for (const Eigen::Vector3d& axis : axes(images)) {
      directions.push_back(images);
      std::stable_sort(directions.back().begin(), directions.back().end(),
                       [&](int a, int b) { return axis.dot(centres_[a]) < axis.dot(centres_[b]); });
    }
    directions.push_back(walk(images, label));
    std::size_t chosen = directions.size();
    for (std::size_t i = 0; i < directions.size(); ++i)
      if (look_at(directions[i], 0.5)) chosen = i;
    if (chosen < directions.size())
      for (const double share : {0.45, 0.55, 0.4, 0.6}) look_at(directions[chosen], share);
    return best;
  }

  // The two longer principal axes of the centres, and the directions between them.
  [[nodiscard]] std::vector<Eigen::Vector3d> axes(const std::vector<int>& images) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int image : images) mean += centres_[image] / static_cast<double>(images.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int image : images) spread += (centres_[image] - mean) * (centres_[image] - mean).transpose();
    if (!spread.allFinite()) return {};
    const Eigen::Matrix3d found = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
    const Eigen::Vector3d first = found.col(2), second = found.col(1);
    return {first, second, first + second, first - second};
  }

  Cut cut_at(const std::vector<int>& sorted, double share, int label) {
    const auto middle = static_cast<std::size_t>(share * static_cast<double>(sorted.size()));
    std::vector<int> left, right;  // images with ties across
    std::vector<std::vector<int>> across;
    for (std::size_t i = middle; i < sorted.size(); ++i) local_[sorted[i]] = -2;  // on the other side
    for (std::size_t i = 0; i < middle; ++i) {
      std::vector<int> ties;
      for (const int other : graph_[sorted[i]]) {
        if (part_[other] != label || local_[other] == -1) continue;
        if (local_[other] == -2) {
          local_[other] = static_cast<int>(right.size());
          right.push_back(other);
        }
        ties.push_back(local_[other]);
      }
      if (ties.empty()) continue;
      left.push_back(sorted[i]);
      across.push_back(std::move(ties));
    }
    const VertexCover cover(across, static_cast<int>(right.size()));
    for (const int image : sorted) local_[image] = -1;
    for (std::size_t a = 0; a < left.size(); ++a)
      if (cover.covers_left(static_cast<int>(a))) local_[left[a]] = 0;
    for (std::size_t b = 0; b < right.size(); ++b)
      if (cover.covers_right(static_cast<int>(b))) local_[right[b]] = 0;
    Cut cut;
    for (std::size_t i = 0; i < sorted.size(); ++i)
      (local_[sorted[i]] == 0 ? cut.separator : i < middle ? cut.one : cut.other).push_back(sorted[i]);
    for (const int image : sorted) local_[image] = -1;
    return cut;
  }

  // Breadth first through the part, from an end of it; what does not hang together follows.
  std::vector<int> walk(const std::vector<int>& images, int label) {
    std::vector<int> order;
    std::vector<char> seen(images.size(), 0);
    for (std::size_t i = 0; i < images.size(); ++i) local_[images[i]] = static_cast<int>(i);
    const auto from = [&](int start) {
      std::size_t next = order.size();
      order.push_back(start);
      seen[local_[start]] = 1;
      for (; next < order.size(); ++next)
        for (const int other : graph_[order[next]])
          if (part_[other] == label && !seen[local_[other]]) {
            seen[local_[other]] = 1;
            order.push_back(other);
          }
    };
    for (const int image : images) {
      if (seen[local_[image]]) continue;
      int start = image;
      const std::size_t begin = order.size();
      for (int round = 0; round < 2; ++round) {  // the last one reached, and from there again: an end
        from(start);
        start = order.back();
        for (std::size_t i = begin; i < order.size(); ++i) seen[local_[order[i]]] = 0;
        order.resize(begin);
      }
      from(start);
    }
    for (const int image : images) local_[image] = -1;
    return order;
  }

  static constexpr int kDone = -1;
  const Covisibility& graph_;
  const std::vector<Eigen::Vector3d>& centres_;
  const int per_tile_;
  int labels_ = 0;
  std::vector<int> part_, local_;  // local_: scratch, -1 between uses
  std::vector<int> order_;
};

// Reverse Cuthill-McKee: breadth first from an end of each part, few neighbours first; then all backwards.
std::vector<int> walk_backwards(const Covisibility& graph) {
  std::vector<int> order;
  std::vector<char> seen(graph.size(), 0);
  const auto from = [&](int start) {
    std::size_t next = order.size();
    order.push_back(start);
    seen[start] = 1;
    for (; next < order.size(); ++next) {
      const std::size_t first = order.size();
      for (const int other : graph[order[next]])
        if (!std::exchange(seen[other], 1)) order.push_back(other);
      std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(first), order.end(),
                       [&](int a, int b) { return graph[a].size() < graph[b].size(); });
    }
  };
  for (int image = 0; image < static_cast<int>(graph.size()); ++image) {
    if (seen[image]) continue;
    int start = image;
    const std::size_t begin = order.size();
    for (int round = 0; round < 2; ++round) {  // the last one reached, and from there again: an end
      from(start);
      start = order.back();
      for (std::size_t i = begin; i < order.size(); ++i) seen[order[i]] = 0;
      order.resize(begin);
    }
    from(start);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

std::vector<int> numbers_of(const std::vector<int>& order) {
  std::vector<int> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<int>(i);
  return number;
}

// Products of tiles in Cholesky's factor.
double work(const Covisibility& graph, const std::vector<int>& order, int per_tile) {
  const std::vector<int> number = numbers_of(order);
  TilePattern pattern((graph.size() + static_cast<std::size_t>(per_tile) - 1) / static_cast<std::size_t>(per_tile));
  for (std::size_t i = 0; i < graph.size(); ++i)
    for (const int other : graph[i])
      if (number[other] < number[i]) pattern[number[i] / per_tile].push_back(number[other] / per_tile);
  double products = 0;
  for (const std::vector<int>& below : factor_columns(pattern))
    products += static_cast<double>((below.size() + 1) * (below.size() + 1));
  return products;
}

}  // namespace

Covisibility covisibility(int images, const std::vector<std::uint32_t>& first, const std::vector<int>& image_of_ray) {
  std::vector<std::uint32_t> begin(static_cast<std::size_t>(images) + 1, 0), point_of_slot(image_of_ray.size());
  for (const int image : image_of_ray) ++begin[static_cast<std::size_t>(image) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> fill(begin.begin(), begin.end() - 1);
  for (std::uint32_t p = 0; p + 1 < first.size(); ++p)
    for (std::uint32_t r = first[p]; r < first[p + 1]; ++r) point_of_slot[fill[image_of_ray[r]]++] = p;

  Covisibility graph(static_cast<std::size_t>(images));
  std::vector<int> mark(static_cast<std::size_t>(images), -1);
  for (int image = 0; image < images; ++image) {
    mark[image] = image;
    for (std::uint32_t s = begin[image]; s < begin[image + 1]; ++s)
      for (std::uint32_t r = first[point_of_slot[s]]; r < first[point_of_slot[s] + 1]; ++r) {
        const int other = image_of_ray[r];
        if (mark[other] == image) continue;
        mark[other] = image;
        graph[image].push_back(other);
      }
    std::sort(graph[image].begin(), graph[image].end());
  }
  return graph;
}

std::vector<int> elimination_order(const Covisibility& graph, const std::vector<Eigen::Vector3d>& centres,
                                   int per_tile) {
  const std::vector<int> dissected = Dissector(graph, centres, per_tile).order(), band = walk_backwards(graph);
  const std::vector<int>& order = work(graph, dissected, per_tile) < work(graph, band, per_tile) ? dissected : band;
  return numbers_of(order);
}

}  // namespace collinea::bundle
