// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/mark_readings.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector2d;
using Group = std::vector<const MarkReading*>;

double middle(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

Vector2d median_of(const Group& group) {
  Vector2d median;
  for (int k = 0; k < 2; ++k) {
    std::vector<double> values;
    for (const MarkReading* reading : group) values.push_back(reading->position[k]);
    median[k] = middle(values);
  }
  return median;
}

// Deviations from a median of n readings are smaller than errors, on the average by about sqrt((n - 1) / n).
double spread_of(const std::vector<Group>& groups) {
  std::vector<double> deviations;
  for (const Group& group : groups) {
    if (group.size() < 3) continue;
    const double n = double(group.size()), factor = std::sqrt(n / (n - 1));
    const Vector2d median = median_of(group);
    for (const MarkReading* reading : group)
      for (int k = 0; k < 2; ++k) deviations.push_back(factor * std::abs(reading->position[k] - median[k]));
  }
  return deviations.empty() ? 0 : 1.4826 * middle(std::move(deviations));
}

ReadMark mean_of(const Group& group, double limit) {
  ReadMark out{.mark = group.front()->mark};
  const Vector2d median = median_of(group);
  std::vector<char> is_good(group.size(), 1);
  for (std::size_t i = 0; i < group.size(); ++i) is_good[i] = (group[i]->position - median).norm() <= limit;
  const auto count = std::size_t(std::count(is_good.begin(), is_good.end(), char{1}));
  out.is_contested = 2 * count <= group.size();
  if (out.is_contested) std::fill(is_good.begin(), is_good.end(), char{1});
  double weights = 0;
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (!is_good[i]) {
      out.gross.push_back(int(i) + 1);
      continue;
    }
    const double weight = 1 / (group[i]->sigma * group[i]->sigma);
    out.position += weight * group[i]->position;
    weights += weight;
    ++out.good;
  }
  out.position /= weights;
  out.sigma = 1 / std::sqrt(weights);
  for (std::size_t i = 0; i < group.size() && out.good > 1; ++i)
    if (is_good[i]) out.scatter += (group[i]->position - out.position).array().square().matrix() / double(out.good - 1);
  out.scatter = out.scatter.cwiseSqrt();
  return out;
}

}  // namespace

ReadMarks mean_of_readings(std::span<const MarkReading> readings, double least_sigma) {
  std::vector<Group> groups;
  for (const MarkReading& reading : readings) {
    const auto same = [&](const Group& group) { return group.front()->mark == reading.mark; };
    const auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end())
      groups.push_back({&reading});
    else
      group->push_back(&reading);
  }
  ReadMarks out;
  out.limit = 5 * std::max(least_sigma, spread_of(groups));
  double squares = 0;
  for (const Group& group : groups) {
    out.marks.push_back(mean_of(group, out.limit));
    const ReadMark& mark = out.marks.back();
    if (mark.is_contested) continue;
    squares += (mark.good - 1) * mark.scatter.squaredNorm();
    out.degrees += 2 * (mark.good - 1);
  }
  if (out.degrees > 0) out.sigma = std::sqrt(squares / out.degrees);
  return out;
}

}  // namespace collinea
