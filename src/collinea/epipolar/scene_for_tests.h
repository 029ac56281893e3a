// SPDX-License-Identifier: Apache-2.0
// Small synthetic scenes with known truth; for the tests of this module only.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea::scene {

inline Eigen::Vector3d random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// A motion between two cameras that see the same things: a turn of up to about 0.3 rad, a base of unit length.
inline Rigid3 random_motion(Random& random) {
  return {rotation_by(random_vector(random, 0.3)), random_vector(random, 1).normalized()};
}

/// A point in the field of view (about 60 degrees) of the first camera, 3 to 8 bases away.
inline Eigen::Vector3d random_point(Random& random) {
  const double depth = random.uniform(3, 8);
  return {random.uniform(-0.5, 0.5) * depth, random.uniform(-0.5, 0.5) * depth, depth};
}

/// One of a plane across the field of view.
inline Eigen::Vector3d random_point_on_plane(Random& random) {
  const double x = random.uniform(-0.5, 0.5), y = random.uniform(-0.5, 0.5), depth = 5 / (1 + 0.3 * x - 0.2 * y);
  return {x * depth, y * depth, depth};
}

inline Eigen::Vector2d seen(const Rigid3& cam_from_world, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = cam_from_world * point;
  return p.head<2>() / p.z();
}

inline Eigen::Vector2d noise(Random& random, double sigma) {
  return {sigma * random.normal(), sigma * random.normal()};
}

/// How far two matrices are apart when neither scale nor sign counts.
inline double distance_up_to_scale(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d p = a.normalized(), q = b.normalized();
  return std::min((p - q).norm(), (p + q).norm());
}

inline double angle_between_vectors(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// `count` pairs of points given by `point(random)`, noise of sigma_px in each coordinate, focal lengths of 1000 px.
template <class PointOf>
PointPairs pairs_of(const Rigid3& second_from_first, int count, double sigma_px, Random& random, PointOf point) {
  PointPairs pairs;
  pairs.focal_first_px = pairs.focal_second_px = 1000;
  while (pairs.size() < count) {
    const Eigen::Vector3d x = point(random);
    if ((second_from_first * x).z() < 0.5) continue;
    pairs.add(x.head<2>() / x.z() + noise(random, sigma_px / 1000),
              seen(second_from_first, x) + noise(random, sigma_px / 1000));
  }
  return pairs;
}

inline std::vector<int> everyone(const PointPairs& pairs) {
  std::vector<int> all;
  for (int i = 0; i < pairs.size(); ++i) all.push_back(i);
  return all;
}

}  // namespace collinea::scene
