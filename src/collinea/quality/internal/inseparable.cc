// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/inseparable.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/quality/conditioning.h"
#include "collinea/quality/internal/covariance.h"
#include "collinea/quality/systematics.h"

namespace collinea {
namespace bundle {
namespace {

bool is_along_axis(const AuxiliaryUnknown& auxiliary) {
  return auxiliary.kind == UnknownKind::kLeverArm && auxiliary.axis == 2;
}

// What would part an unknown from another one, or (other = nullptr) from a parameter of a camera.
std::vector<Remedy> remedies_of(const AuxiliaryUnknown& auxiliary, const AuxiliaryUnknown* other) {
  if (auxiliary.kind == UnknownKind::kTimeOffset) return {RemedyCode::kFlyBack, RemedyCode::kGiveOne};
  if (is_of_shape(auxiliary.kind)) return {RemedyCode::kSpreadShapePoints};
  if (is_along_axis(auxiliary) || (other && is_along_axis(*other)))
    return {RemedyCode::kAddHeightsOrOblique, RemedyCode::kGiveOne};
  if (auxiliary.kind == UnknownKind::kOrientation) return {RemedyCode::kMeasureMoreFromSetup};
  if (auxiliary.kind == UnknownKind::kLeverArm || (other && other->kind == UnknownKind::kLeverArm) ||
      auxiliary.kind == UnknownKind::kBoresight)
    return {RemedyCode::kFlyBackAndAcross, RemedyCode::kGiveOne};
  return {RemedyCode::kAddCrossStripOrControl};
}

// What name_inseparable_offsets() says, and what only follows from it: axes of one shift that an offset ties together.
bool parted_elsewhere(const AuxiliaryUnknown& one, const AuxiliaryUnknown& other, bool offsets) {
  if (one.kind == UnknownKind::kTimeOffset) return true;
  return offsets && one.kind == other.kind && one.owner == other.owner;
}

void name_inseparable(const Problem& problem, TileCholesky& inverse, std::vector<Finding>& pairs) {
  const int globals_begin = 6 * problem.poses;
  const bool offsets = !pairs.empty();
  for (int i = 0; i < static_cast<int>(problem.auxiliaries.size()); ++i) {
    const int row = globals_begin + problem.first_auxiliary + i;
    const AuxiliaryUnknown& auxiliary = problem.auxiliaries[static_cast<std::size_t>(i)];
    for (int other = globals_begin; other < row; ++other) {
      const int k = other - globals_begin - problem.first_auxiliary;
      if (k >= 0 && parted_elsewhere(auxiliary, problem.auxiliaries[static_cast<std::size_t>(k)], offsets)) continue;
      const double correlation = inverse.at(row, other) / std::sqrt(inverse.at(row, row) * inverse.at(other, other));
      if (!(std::abs(correlation) > kInseparable)) continue;
      pairs.push_back(
          finding_of(FindingCode::kInseparable, {subject_of_row(problem, row), subject_of_row(problem, other)},
                     {{FigureName::kCorrelation, correlation}},
                     remedies_of(auxiliary, k < 0 ? nullptr : &problem.auxiliaries[static_cast<std::size_t>(k)])));
    }
  }
}

// A time offset moves the antenna along the flight, which need not be an axis: what of it a shift, a drift or a lever
// arm can stand for is its multiple correlation with the three.
void name_inseparable_offsets(const Problem& problem, TileCholesky& inverse, std::vector<Finding>& pairs) {
  const int first = 6 * problem.poses + problem.first_auxiliary;
  for (std::size_t i = 0; i < problem.auxiliaries.size(); ++i) {
    if (problem.auxiliaries[i].kind != UnknownKind::kTimeOffset) continue;
    const int row = first + static_cast<int>(i);
    for (std::size_t k = 0; k < problem.auxiliaries.size(); ++k) {
      const AuxiliaryUnknown& other = problem.auxiliaries[k];
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
      Subject along = subject_of(other.kind, other.owner, 0);
      along.axis = Subject::kAlongFlight;
      pairs.push_back(finding_of(FindingCode::kInseparable, {subject_of_row(problem, row), along},
                                 {{FigureName::kCorrelation, std::sqrt(square)}},
                                 remedies_of(problem.auxiliaries[i], &other)));
    }
  }
}

}  // namespace
}  // namespace bundle

std::vector<Finding> inseparable_unknowns(const Solved& solved, bundle::TileCholesky& inverse) {
  std::vector<Finding> pairs;
  bundle::name_inseparable_offsets(solved.problem(), inverse, pairs);
  bundle::name_inseparable(solved.problem(), inverse, pairs);
  return pairs;
}

Finding undetermined_unknown(const Solved& solved, int row) {
  const bundle::Problem& problem = solved.problem();
  Finding finding = finding_of(FindingCode::kUndetermined, {bundle::subject_of_row(problem, row)});
  const auto auxiliary = static_cast<std::size_t>(row - 6 * problem.poses - problem.first_auxiliary);
  if (auxiliary < problem.auxiliaries.size())
    finding.remedies = bundle::remedies_of(problem.auxiliaries[auxiliary], nullptr);
  return finding;
}

}  // namespace collinea
