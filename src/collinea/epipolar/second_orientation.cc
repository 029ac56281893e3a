// SPDX-License-Identifier: Apache-2.0
// The other orientation of images of a plane.
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "collinea/epipolar/internal/homography.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

constexpr double kSame_rad = 1e-6;
constexpr double kThroughCentre = 1e-6;  // distance of the plane from the first projection centre, in bases

double apart(const Rigid3& a, const Rigid3& b) {
  const Eigen::Vector3d one = base_in_first(a), two = base_in_first(b);
  return angle_between(a.rotation, b.rotation) + std::atan2(one.cross(two).norm(), one.dot(two));
}

}  // namespace

std::optional<RelativeOrientation> second_orientation(const Rigid3& second_from_first, const PairShape& shape,
                                                      std::span<const PairPoint> used, const RelativeOptions& options) {
  const double distance = shape.plane_normal.dot(shape.plane_middle);
  if (!(std::abs(distance) > kThroughCentre)) return std::nullopt;
  const Eigen::Matrix3d homography = second_from_first.rotation.toRotationMatrix() +
                                     second_from_first.translation * shape.plane_normal.transpose() / distance;
  PointPairs pairs;
  std::vector<int> all;
  for (const PairPoint& point : used) {
    all.push_back(pairs.size());
    pairs.add(point.first, point.second);
  }
  const Rigid3* other = nullptr;
  const auto two = planar_motions(homography, pairs, all);
  for (const PlanarMotion& motion : two)
    if (!other || apart(motion.second_from_first, second_from_first) > apart(*other, second_from_first))
      other = &motion.second_from_first;
  if (!other || apart(*other, second_from_first) < kSame_rad) return std::nullopt;
  RelativeOptions without_rejection = options;
  without_rejection.rejection = PairRejection::kNone;
  const auto found = relative_orientation(used, without_rejection, 1, *other);
  if (!found || apart(found->second_from_first, second_from_first) < kSame_rad) return std::nullopt;
  return *found;
}

}  // namespace collinea
