// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/tracks.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "collinea/base/result.h"

namespace collinea {
namespace {

using Feature = std::pair<ImageId, std::uint32_t>;
using Node = std::uint32_t;  // index in the sorted list of all matched features

struct Link {
  Node a, b;  // a < b
  friend auto operator<=>(const Link&, const Link&) = default;
};

struct Graph {
  std::vector<Feature> features;  // sorted
  std::vector<Link> links;        // sorted, each once
};

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  Node root(Node node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  /// The smaller root becomes the root of both: the result does not depend on the order.
  void join(Node a, Node b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Node> parent_;
};

using Pairs = std::span<const ImagePair* const>;

// The matched features of all images, numbered in the order of image and feature.
class Numbering {
 public:
  explicit Numbering(Pairs pairs) {
    for (const ImagePair* pair : pairs) {
      std::uint32_t &first = nodes_[pair->first].count, &second = nodes_[pair->second].count;
      for (const auto& [i, j] : pair->matches) {
        first = std::max(first, i + 1);
        second = std::max(second, j + 1);
      }
    }
    for (auto& [image, table] : nodes_) table.nodes.assign(table.count, kUnused);
    for (const ImagePair* pair : pairs) {
      std::vector<Node>&first = nodes_.at(pair->first).nodes, &second = nodes_.at(pair->second).nodes;
      for (const auto& [i, j] : pair->matches) first[i] = second[j] = 0;
    }
    for (auto& [image, table] : nodes_)
      for (std::uint32_t i = 0; i < table.count; ++i)
        if (table.nodes[i] != kUnused) {
          table.nodes[i] = static_cast<Node>(features_.size());
          features_.emplace_back(image, i);
        }
  }
  [[nodiscard]] const std::vector<Node>& of(ImageId image) const { return nodes_.at(image).nodes; }
  [[nodiscard]] std::vector<Feature>&& take_features() { return std::move(features_); }

 private:
  static constexpr Node kUnused = ~Node{0};
  struct Table {
    std::uint32_t count = 0;
    std::vector<Node> nodes;
  };
  std::map<ImageId, Table> nodes_;
  std::vector<Feature> features_;
};

Graph graph_of(Pairs pairs) {
  Graph graph;
  Numbering numbering(pairs);
  for (const ImagePair* pair : pairs) {
    COLLINEA_CHECK(pair->first != pair->second);
    if (pair->matches.empty()) continue;
    const std::vector<Node>&first = numbering.of(pair->first), &second = numbering.of(pair->second);
    for (const auto& [i, j] : pair->matches)
      graph.links.push_back({std::min(first[i], second[j]), std::max(first[i], second[j])});
  }
  std::ranges::sort(graph.links);
  graph.links.erase(std::ranges::unique(graph.links).begin(), graph.links.end());
  graph.features = numbering.take_features();
  return graph;
}

// The nodes of each group that hangs together and the links between them, as ranges of lists sorted by group.
struct Groups {
  std::vector<Node> nodes;
  std::vector<Link> links;
  struct Range {
    std::size_t node, node_end, link, link_end;
  };
  std::vector<Range> ranges;
};

Groups groups_of(const Graph& graph) {
  DisjointSets sets(graph.features.size());
  for (const Link& link : graph.links) sets.join(link.a, link.b);
  Groups groups;
  groups.nodes.resize(graph.features.size());
  std::iota(groups.nodes.begin(), groups.nodes.end(), 0u);
  std::ranges::stable_sort(groups.nodes, {}, [&](Node node) { return sets.root(node); });
  groups.links = graph.links;
  std::ranges::stable_sort(groups.links, {}, [&](const Link& link) { return sets.root(link.a); });
  std::size_t node = 0, link = 0;
  while (node < groups.nodes.size()) {
    const Node root = sets.root(groups.nodes[node]);
    Groups::Range range{node, node, link, link};
    while (node < groups.nodes.size() && sets.root(groups.nodes[node]) == root) ++node;
    while (link < groups.links.size() && sets.root(groups.links[link].a) == root) ++link;
    range.node_end = node;
    range.link_end = link;
    groups.ranges.push_back(range);
  }
  return groups;
}

bool has_two_of_one_image(std::span<const Node> sorted_nodes, const std::vector<Feature>& features) {
  return std::ranges::adjacent_find(sorted_nodes, [&](Node a, Node b) {
           return features[a].first == features[b].first;
         }) != sorted_nodes.end();
}

std::size_t index_among(std::span<const Node> sorted_nodes, Node node) {
  return static_cast<std::size_t>(std::ranges::lower_bound(sorted_nodes, node) - sorted_nodes.begin());
}

// How many third nodes are linked with both ends of each link.
std::vector<std::uint32_t> confirmations(std::span<const Node> nodes, std::span<const Link> links) {
  const auto local = [&](Node node) { return index_among(nodes, node); };
  std::vector<std::vector<Node>> neighbours(nodes.size());
  for (const Link& link : links) {
    neighbours[local(link.a)].push_back(link.b);
    neighbours[local(link.b)].push_back(link.a);
  }
  for (auto& list : neighbours) std::ranges::sort(list);
  std::vector<std::uint32_t> counts;
  counts.reserve(links.size());
  for (const Link& link : links) {
    const auto &a = neighbours[local(link.a)], &b = neighbours[local(link.b)];
    std::uint32_t count = 0;
    for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
      if (*i == *j) ++count;
      const bool step_i = *i <= *j, step_j = *j <= *i;
      i += step_i;
      j += step_j;
    }
    counts.push_back(count);
  }
  return counts;
}

bool share_an_image(std::span<const Node> a, std::span<const Node> b, const std::vector<Feature>& features) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    const ImageId in_a = features[*i].first, in_b = features[*j].first;
    if (in_a == in_b) return true;
    if (in_a < in_b)
      ++i;
    else
      ++j;
  }
  return false;
}

// Parts of a group with no image twice: links are taken in the order of their confirmation.
std::vector<std::vector<Node>> parts_of(std::span<const Node> nodes, std::span<const Link> links,
                                        const std::vector<Feature>& features) {
  const std::vector<std::uint32_t> confirmed = confirmations(nodes, links);
  std::vector<std::size_t> order(links.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return confirmed[i]; });

  const auto local = [&](Node node) { return index_among(nodes, node); };
  std::vector<std::vector<Node>> parts(nodes.size());
  std::vector<std::size_t> part_of(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    parts[i] = {nodes[i]};
    part_of[i] = i;
  }
  for (const std::size_t i : order) {
    std::size_t keep = part_of[local(links[i].a)], give = part_of[local(links[i].b)];
    if (keep == give || share_an_image(parts[keep], parts[give], features)) continue;
    if (parts[keep].size() < parts[give].size()) std::swap(keep, give);
    std::vector<Node> joined;
    std::ranges::merge(parts[keep], parts[give], std::back_inserter(joined));
    for (const Node node : parts[give]) part_of[local(node)] = keep;
    parts[give].clear();
    parts[keep] = std::move(joined);
  }
  return parts;
}

}  // namespace

std::vector<Track> merge_tracks(std::span<const ImagePair> pairs) {
  std::vector<const ImagePair*> all;
  all.reserve(pairs.size());
  for (const ImagePair& pair : pairs) all.push_back(&pair);
  return merge_tracks(all);
}

std::vector<Track> merge_tracks(std::span<const ImagePair* const> pairs) {
  const Graph graph = graph_of(pairs);
  const Groups groups = groups_of(graph);
  std::vector<Track> tracks;
  const auto add = [&](std::span<const Node> nodes) {
    if (nodes.size() < 2) return;
    Track& track = tracks.emplace_back();
    for (const Node node : nodes) track.features.push_back(graph.features[node]);
  };
  for (const Groups::Range& range : groups.ranges) {
    const auto nodes = std::span(groups.nodes).subspan(range.node, range.node_end - range.node);
    const auto links = std::span(groups.links).subspan(range.link, range.link_end - range.link);
    if (!has_two_of_one_image(nodes, graph.features)) {
      add(nodes);
      continue;
    }
    for (const std::vector<Node>& part : parts_of(nodes, links, graph.features)) add(part);
  }
  std::ranges::sort(tracks, {}, &Track::features);
  return tracks;
}

}  // namespace collinea
