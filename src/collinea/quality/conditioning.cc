// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/conditioning.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "collinea/math/random.h"

namespace collinea {
namespace bundle {
namespace {

constexpr int kMostRounds = 60;
constexpr double kSettled = 0.01;  // of the eigenvalue: what is reported has one digit
constexpr std::size_t kNamed = 3;
constexpr double kLeastShare = 0.05;  // of the combination, to be named

// The unknowns with the largest shares, all images and each parameter taken together.
std::vector<UnknownShare> shares_of(const Problem& problem, const Eigen::VectorXd& vector) {
  const auto of_images = [](int row) {
    return Subject(SubjectKind::kImage, Subject::kAll, row % 6 < 3 ? Aspect::kAttitude : Aspect::kPosition);
  };
  std::map<Subject, double> shares;
  for (int row = 0; row < static_cast<int>(vector.size()); ++row)
    shares[row < 6 * problem.poses ? of_images(row) : subject_of_row(problem, row)] += vector[row] * vector[row];
  std::vector<UnknownShare> largest;
  for (const auto& [unknown, share] : shares)
    if (share > kLeastShare) largest.push_back({unknown, share});
  std::stable_sort(largest.begin(), largest.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  if (largest.size() > kNamed) largest.resize(kNamed);
  return largest;
}

}  // namespace

Subject subject_of_row(const Problem& problem, int row) {
  if (row < 6 * problem.poses) return {problem.images[row / 6].id, row % 6 < 3 ? Aspect::kAttitude : Aspect::kPosition};
  const int among_globals = row - 6 * problem.poses;
  for (const ProblemCamera& camera : problem.cameras)
    if (const int k = among_globals - camera.first_global; k >= 0 && k < static_cast<int>(camera.free.size()))
      return {camera.id, Aspect::kParameter, camera.free[k]};
  if (const auto k = static_cast<std::size_t>(among_globals - problem.first_auxiliary); k < problem.auxiliaries.size())
    return subject_of(problem.auxiliaries[k].kind, problem.auxiliaries[k].owner, problem.auxiliaries[k].axis);
  for (const std::uint32_t p : problem.retained_points)
    if (const int k = among_globals - problem.point(p).first_retained; k >= 0 && k < 3)
      return {ControlId{problem.point(p).id}, Aspect::kPosition};
  return {};
}

}  // namespace bundle

Conditioning conditioning_of(const Solved& solved, const bundle::TileCholesky& factor, const Run& run) {
  const bundle::Problem& problem = solved.problem();
  const std::vector<double>& weights = solved.diagonal();
  Conditioning found;
  const int size = 6 * problem.poses + problem.global_count;
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
  found.mostly = bundle::shares_of(problem, vector.normalized());
  return found;
}

}  // namespace collinea
