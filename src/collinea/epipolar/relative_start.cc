// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_start.h"

#include "collinea/epipolar/internal/two_view_problems.h"
#include "collinea/epipolar/intersect_rays.h"

namespace collinea {
namespace {

constexpr int kLeastPairs = 8;  // of which five wrong ones leave three: fewer say nothing
constexpr double kUncapped_px = 1e6;

// Pairs of the inliers whose rays meet in front of both cameras.
int in_front(const Rigid3& second_from_first, const PointPairs& pairs, const std::vector<int>& inliers) {
  int count = 0;
  for (const int i : inliers) {
    const Eigen::Vector3d first = pairs.first(i).homogeneous(),
                          second = second_from_first.rotation.conjugate() * pairs.second(i).homogeneous(),
                          base = -(second_from_first.rotation.conjugate() * second_from_first.translation);
    const Eigen::Vector3d normal = first.cross(second);
    const double along_first = base.cross(second).dot(normal), along_second = base.cross(first).dot(normal);
    count += along_first > 0 && along_second > 0;
  }
  return count;
}

}  // namespace

std::optional<RelativeStart> relative_start(const PointPairs& pairs, RobustStart kind, std::uint64_t seed) {
  if (pairs.size() < kLeastPairs) return std::nullopt;
  Random random(seed);
  const EssentialProblem problem{pairs, kUncapped_px};
  const RobustStart estimator = kind == RobustStart::kTruncated ? RobustStart::kLeastMedian : kind;
  const auto fit = robust_start(problem, estimator, 1, random);
  if (!fit) return std::nullopt;
  RelativeStart start{.inliers = fit->inliers, .scale_px = fit->scale_px, .in_front = -1};
  for (const Rigid3& motion : motions(fit->model))
    if (const int count = in_front(motion, pairs, start.inliers); count > start.in_front) {
      start.in_front = count;
      start.second_from_first = motion;
    }
  return start;
}

}  // namespace collinea
