// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/conditioning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "collinea/math/random.h"

namespace collinea {
namespace bundle {
namespace {

constexpr int kMostRounds = 60;
constexpr double kSettled = 0.01;  // of the eigenvalue: what is told has one digit
constexpr std::size_t kNamed = 3;
constexpr double kLeastShare = 0.05;  // of the combination, to be named

// The unknowns with the largest shares, all images and each parameter taken together.
std::string shares_of(const Block& block, const Problem& problem, const Eigen::VectorXd& vector) {
  std::map<std::string, double> shares;
  for (int row = 0; row < static_cast<int>(vector.size()); ++row) {
    const double share = vector[row] * vector[row];
    if (row >= 6 * problem.poses)
      shares[name_of_unknown(block, problem, row)] += share;
    else
      shares[row % 6 < 3 ? "the attitudes of the images" : "the positions of the images"] += share;
  }
  std::vector<std::pair<double, std::string>> largest;
  for (const auto& [name, share] : shares) largest.emplace_back(share, name);
  std::stable_sort(largest.begin(), largest.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, largest.size()) && largest[i].first > kLeastShare; ++i)
    text += fmt::format("{}{} ({:.0f} %)", i > 0 ? ", " : "", largest[i].second, 100 * largest[i].first);
  return text;
}

}  // namespace

std::string name_of_unknown(const Block& block, const Problem& problem, int row) {
  if (row < 6 * problem.poses)
    return (row % 6 < 3 ? "the attitude of " : "the position of ") + block.images.at(problem.images[row / 6].id).file;
  for (const ProblemCamera& camera : problem.cameras)
    if (const int k = row - 6 * problem.poses - camera.border; k >= 0 && k < static_cast<int>(camera.free.size()))
      return param_name(camera.free[k]) + " of camera " + block.cameras.at(camera.id).name;
  const int in_border = row - 6 * problem.poses;
  if (const auto k = static_cast<std::size_t>(in_border - problem.first_extra); k < problem.extras.size())
    return name_of_extra(block, problem.extras[k].kind, problem.extras[k].owner, problem.extras[k].axis);
  for (const std::uint32_t p : problem.joined)
    if (const int k = in_border - problem.point(p).joined; k >= 0 && k < 3)
      return "the position of " + block.control.at(ControlId{problem.point(p).id}).name;
  return "an unknown";
}

}  // namespace bundle

Conditioning conditioning_of(const Solved& solved, const bundle::TileCholesky& factor, const Run& run) {
  const bundle::Problem& problem = solved.problem();
  const std::vector<double>& weights = solved.diagonal();
  Conditioning found;
  const int size = 6 * problem.poses + problem.border;
  if (size == 0) return found;
  Eigen::VectorXd root(size), vector(size);
  Random random(1);
  for (int i = 0; i < size; ++i) {
    root[i] = std::sqrt(weights[static_cast<std::size_t>(i)]);
    vector[i] = random.normal();
  }
  std::vector<double> x(static_cast<std::size_t>(factor.tile_rows()) * bundle::kTile);
  for (int round = 0; round < bundle::kMostRounds && !run.stopped(); ++round) {
    vector.normalize();
    std::fill(x.begin(), x.end(), 0.0);
    Eigen::Map<Eigen::VectorXd> solution(x.data(), size);
    solution = root.cwiseProduct(vector);
    factor.solve(x.data());
    vector = root.cwiseProduct(solution);
    const double before = found.inflation;
    found.inflation = vector.norm();
    if (std::abs(found.inflation - before) < bundle::kSettled * found.inflation) break;
  }
  found.mostly = bundle::shares_of(solved.block(), problem, vector.normalized());
  return found;
}

}  // namespace collinea
