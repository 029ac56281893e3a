// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/given_coplanarity.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// In a photograph: y up, z backwards.
Vector3d ray_of(const Eigen::Vector2d& in_camera) { return {in_camera.x(), -in_camera.y(), -1}; }

// The condition of a unit base in the cameras with its derivatives by changed() and by the four coordinates:
//     C = b . (q1 x u),   u = R' q2,   R <- exp([d]) R,   b <- b + T e
struct Linearised {
  Vector5 by_change;
  Eigen::Vector4d by_coordinates;
};

Linearised linearised(const PairPoint& point, const Rigid3& second_from_first) {
  const Matrix3d to_first = second_from_first.rotation.toRotationMatrix().transpose();
  const Vector3d base = base_in_first(second_from_first), one = point.first.homogeneous(),
                 two = point.second.homogeneous(), second = to_first * two;
  const Vector3d of_second = base.cross(one);  // C = of_second . second
  Linearised out;
  for (int k = 0; k < 3; ++k) out.by_change(k) = of_second.dot(to_first * two.cross(Vector3d::Unit(k)));
  out.by_change.tail<2>() = tangents_of(base).transpose() * one.cross(second);
  out.by_coordinates.head<2>() = second.cross(base).head<2>();
  out.by_coordinates.tail<2>() = (to_first.transpose() * of_second).head<2>();
  return out;
}

}  // namespace

GivenCoplanarity given_coplanarity(std::span<const PairPoint> points, const std::array<Rigid3, 2>& cam_from_world,
                                   const Matrix5& covariance) {
  Rigid3 motion = cam_from_world[1] * inverse(cam_from_world[0]);
  motion.translation.normalize();
  const auto dependent = dependent_elements(motion);
  const SymmetricElements symmetric = symmetric_elements(motion);
  const Vector3d base = centre_of(cam_from_world[1]) - centre_of(cam_from_world[0]);
  const Matrix3d photo_from_cam = Vector3d(1, -1, -1).asDiagonal();
  const Matrix3d first = photo_from_cam * cam_from_world[0].rotation.toRotationMatrix(),
                 second = photo_from_cam * cam_from_world[1].rotation.toRotationMatrix();
  GivenCoplanarity out;
  // C' S^-1 C with S = M + A Q A', M diagonal (Woodbury): Q may be singular.
  Matrix5 normal = Matrix5::Zero();
  Vector5 right = Vector5::Zero();
  double squares = 0;
  for (const PairPoint& point : points) {
    const Vector3d ray1 = ray_of(point.first), ray2 = ray_of(point.second);
    const Linearised by = linearised(point, motion);
    PointCoplanarity one;
    if (dependent) one.dependent = coplanarity(*dependent, ray1, ray2).value;
    one.symmetric = coplanarity(symmetric, ray1, ray2).value;
    one.exterior = coplanarity_in_model(base, first, second, ray1, ray2);
    const double measured = by.by_coordinates.head<2>().squaredNorm() * point.sigma_first * point.sigma_first +
                            by.by_coordinates.tail<2>().squaredNorm() * point.sigma_second * point.sigma_second;
    one.sigma = std::sqrt(measured + by.by_change.dot(covariance * by.by_change));
    one.gap = one.symmetric / by.by_coordinates.norm();
    one.w = one.symmetric / one.sigma;
    normal += by.by_change * by.by_change.transpose() / measured;
    right += by.by_change * one.symmetric / measured;
    squares += one.symmetric * one.symmetric / measured;
    out.points.push_back(one);
  }
  if (points.empty()) return out;
  const Matrix5 inner = (Matrix5::Identity() + covariance * normal).inverse() * covariance;
  out.sigma0 = std::sqrt(std::max(0.0, squares - right.dot(inner * right)) / double(points.size()));
  return out;
}

}  // namespace collinea
