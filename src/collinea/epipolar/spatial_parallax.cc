// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/spatial_parallax.h"

#include <Eigen/Geometry>

#include "collinea/epipolar/relative_elements.h"

namespace collinea {

std::optional<SpatialParallax> spatial_parallax(const Rigid3& second_from_first, const Eigen::Vector2d& first,
                                                const Eigen::Vector2d& second) {
  constexpr double kParallel_rad = 1e-7;
  const Eigen::Vector3d base = base_in_first(second_from_first), s = first.homogeneous().normalized(),
                        t = (second_from_first.rotation.conjugate() * second.homogeneous()).normalized();
  const double sine2 = s.cross(t).squaredNorm();  // 1 - (s . t)^2, exact for nearly parallel rays
  if (!(sine2 > kParallel_rad * kParallel_rad)) return std::nullopt;
  const double cosine = s.dot(t), along_s = s.dot(base), along_t = t.dot(base);
  SpatialParallax out;
  out.along_first = (along_s - along_t * cosine) / sine2;
  out.along_second = (along_s * cosine - along_t) / sine2;
  const Eigen::Vector3d one = out.along_first * s, two = base + out.along_second * t;
  out.point_in_first = (one + two) / 2;
  out.parallax = two - one;
  return out;
}

}  // namespace collinea
