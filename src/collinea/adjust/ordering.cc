// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "collinea/adjust/problem.h"

namespace collinea::bundle {
namespace {

using Graph = std::vector<std::vector<int>>;

// Which images share a point.
Graph covisibility(int images, const std::vector<std::uint32_t>& first, const std::vector<int>& image_of_ray) {
  std::vector<std::uint32_t> begin(images + 1, 0), point_of_slot;
  for (const int image : image_of_ray) ++begin[image + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  point_of_slot.resize(image_of_ray.size());
  std::vector<std::uint32_t> fill(begin.begin(), begin.end() - 1);
  for (std::uint32_t p = 0; p + 1 < first.size(); ++p)
    for (std::uint32_t r = first[p]; r < first[p + 1]; ++r) point_of_slot[fill[image_of_ray[r]]++] = p;

  Graph graph(images);
  std::vector<int> mark(images, -1);
  for (int image = 0; image < images; ++image) {
    mark[image] = image;
    for (std::uint32_t s = begin[image]; s < begin[image + 1]; ++s)
      for (std::uint32_t r = first[point_of_slot[s]]; r < first[point_of_slot[s] + 1]; ++r) {
        const int other = image_of_ray[r];
        if (mark[other] == image) continue;
        mark[other] = image;
        graph[image].push_back(other);
      }
  }
  for (auto& neighbours : graph)
    std::sort(neighbours.begin(), neighbours.end(),
              [&](int a, int b) { return std::pair(graph[a].size(), a) < std::pair(graph[b].size(), b); });
  return graph;
}

// Breadth first from `start`; appends to `order`.
void walk(const Graph& graph, int start, std::vector<char>& seen, std::vector<int>& order) {
  std::size_t next = order.size();
  order.push_back(start);
  seen[start] = 1;
  for (; next < order.size(); ++next)
    for (const int neighbour : graph[order[next]])
      if (!seen[neighbour]) {
        seen[neighbour] = 1;
        order.push_back(neighbour);
      }
}

// The last image reached from `start`, and from there again: an end of the block.
int far_end(const Graph& graph, int start, const std::vector<char>& seen) {
  for (int round = 0; round < 2; ++round) {
    std::vector<char> visited = seen;
    std::vector<int> order;
    walk(graph, start, visited, order);
    start = order.back();
  }
  return start;
}

}  // namespace

std::vector<int> elimination_order(int images, const std::vector<std::uint32_t>& first,
                                   const std::vector<int>& image_of_ray) {
  std::vector<int> number(images);
  std::iota(number.begin(), number.end(), 0);
  if (images <= 16) return number;  // two tiles: nothing to gain
  const Graph graph = covisibility(images, first, image_of_ray);
  std::vector<char> seen(images, 0);
  std::vector<int> order;
  for (int image = 0; image < images; ++image)
    if (!seen[image]) walk(graph, far_end(graph, image, seen), seen, order);
  for (int i = 0; i < images; ++i) number[order[i]] = images - 1 - i;
  return number;
}

}  // namespace collinea::bundle
