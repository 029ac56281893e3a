// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/inseparable.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/quality/conditioning.h"
#include "collinea/quality/covariance.h"

namespace collinea {
namespace bundle {
namespace {

constexpr double kInseparable = 0.99;  // correlation: the sigma of each is seven times what it were without the other

bool is_along_axis(const ExtraUnknown& extra) { return extra.kind == UnknownKind::kLeverArm && extra.axis == 2; }

// What would part an unknown from another one, or (other = nullptr) from a parameter of a camera.
const char* cure_of(const ExtraUnknown& extra, const ExtraUnknown* other) {
  if (extra.kind == UnknownKind::kTimeOffset)
    return "fly strips in the opposite direction under one shift, or give one of them";
  if (is_of_shape(extra.kind)) return "give control, or points that are further apart";
  if (is_along_axis(extra) || (other && is_along_axis(*other)))
    return "add strips at another height or oblique images, or give one of them";
  if (extra.kind == UnknownKind::kOrientation) return "measure to more points from there";
  if (extra.kind == UnknownKind::kLeverArm || (other && other->kind == UnknownKind::kLeverArm) ||
      extra.kind == UnknownKind::kBoresight)
    return "add strips in the opposite direction and across, or give one of them";
  return "add cross strips, or control in every strip";
}

// What name_inseparable_offsets() says, and what only follows from it: axes of one shift that an offset ties together.
bool parted_elsewhere(const ExtraUnknown& one, const ExtraUnknown& other, bool offsets) {
  if (one.kind == UnknownKind::kTimeOffset) return true;
  return offsets && one.kind == other.kind && one.owner == other.owner;
}

void name_inseparable(const Block& block, const Problem& problem, TileCholesky& inverse,
                      std::vector<std::string>& pairs) {
  const int border = 6 * problem.poses;
  const bool offsets = !pairs.empty();
  for (int i = 0; i < static_cast<int>(problem.extras.size()); ++i) {
    const int row = border + problem.first_extra + i;
    const ExtraUnknown& extra = problem.extras[static_cast<std::size_t>(i)];
    for (int other = border; other < row; ++other) {
      const int k = other - border - problem.first_extra;
      if (k >= 0 && parted_elsewhere(extra, problem.extras[static_cast<std::size_t>(k)], offsets)) continue;
      const double correlation = inverse.at(row, other) / std::sqrt(inverse.at(row, row) * inverse.at(other, other));
      if (!(std::abs(correlation) > kInseparable)) continue;
      pairs.push_back(name_of_unknown(block, problem, row) + " and " + name_of_unknown(block, problem, other) +
                      " can hardly be separated (correlation " +
                      std::to_string(correlation).substr(0, correlation < 0 ? 6 : 5) +
                      "): " + cure_of(extra, k < 0 ? nullptr : &problem.extras[static_cast<std::size_t>(k)]));
    }
  }
}

// A time offset moves the antenna along the flight, which need not be an axis: what of it a shift, a drift or a lever
// arm can stand for is its multiple correlation with the three.
void name_inseparable_offsets(const Block& block, const Problem& problem, TileCholesky& inverse,
                              std::vector<std::string>& pairs) {
  const int first = 6 * problem.poses + problem.first_extra;
  for (std::size_t i = 0; i < problem.extras.size(); ++i) {
    if (problem.extras[i].kind != UnknownKind::kTimeOffset) continue;
    const int row = first + static_cast<int>(i);
    for (std::size_t k = 0; k < problem.extras.size(); ++k) {
      const ExtraUnknown& other = problem.extras[k];
      const bool moves_antennas = other.kind == UnknownKind::kShift || other.kind == UnknownKind::kDrift ||
                                  other.kind == UnknownKind::kLeverArm;
      if (!moves_antennas || other.axis != 0) continue;
      const int three = first + static_cast<int>(k);
      const Eigen::Matrix3d own = block_of(inverse, three, 3, three, 3);
      const Eigen::Vector3d with = block_of(inverse, three, 3, row, 1);
      const Eigen::Vector3d scale = own.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::Matrix3d correlations = scale.asDiagonal() * own * scale.asDiagonal();
      const Eigen::Vector3d coupling = scale.asDiagonal() * with / std::sqrt(inverse.at(row, row));
      const double square = coupling.dot(correlations.ldlt().solve(coupling));
      if (!(square > kInseparable * kInseparable)) continue;
      std::string name = name_of_extra(block, other.kind, other.owner, 0);
      const std::size_t axis = name.find(other.kind == UnknownKind::kLeverArm ? " to the right" : " in east");
      name.replace(axis, other.kind == UnknownKind::kLeverArm ? 13 : 8, " along the flight");
      pairs.push_back(name_of_unknown(block, problem, row) + " and " + name + " can hardly be separated (correlation " +
                      std::to_string(std::sqrt(square)).substr(0, 5) + "): " + cure_of(problem.extras[i], &other));
    }
  }
}

}  // namespace
}  // namespace bundle

std::vector<std::string> inseparable_unknowns(const Solved& solved, bundle::TileCholesky& inverse) {
  std::vector<std::string> pairs;
  bundle::name_inseparable_offsets(solved.block(), solved.problem(), inverse, pairs);
  bundle::name_inseparable(solved.block(), solved.problem(), inverse, pairs);
  return pairs;
}

std::string undetermined_unknown(const Solved& solved, int row) {
  const bundle::Problem& problem = solved.problem();
  std::string text = bundle::name_of_unknown(solved.block(), problem, row) + " is not determined by the observations";
  const auto extra = static_cast<std::size_t>(row - 6 * problem.poses - problem.first_extra);
  if (extra < problem.extras.size()) text += std::string(": ") + bundle::cure_of(problem.extras[extra], nullptr);
  return text;
}

}  // namespace collinea
