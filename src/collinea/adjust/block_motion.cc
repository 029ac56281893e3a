// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/block_motion.h"

#include <cmath>

#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

// By how much a motion turns azimuths back, which are clockwise.
double heading_of(const Similarity3& moved) {
  const Eigen::Matrix3d rotation = moved.rotation.toRotationMatrix();
  return std::atan2(rotation(1, 0), rotation(0, 0));
}

// A height that points have in common, as a position at the centre of the block.
Eigen::Vector3d at_height(double height, const Eigen::Vector3d& centre) { return {centre.x(), centre.y(), height}; }

}  // namespace

Matrix37 motion_of(const Eigen::Vector3d& point, const Eigen::Vector3d& centre, double size) {
  const Eigen::Vector3d d = (point - centre) / size;
  Matrix37 g;
  g << 1, 0, 0, 0, d.z(), -d.y(), d.x(),  //
      0, 1, 0, -d.z(), 0, d.x(), d.y(),   //
      0, 0, 1, d.y(), -d.x(), 0, d.z();
  return g;
}

BlockMotion BlockMotion::after(const Vector7& motion) const {
  const Eigen::Quaterniond rotation = rotation_by(motion.segment<3>(3));
  const double scale = std::exp(motion[6]);
  const Eigen::Vector3d translation =
      centre + scale * (rotation * (moved.translation - centre)) + size * motion.head<3>();
  return {{scale * moved.scale, (rotation * moved.rotation).normalized(), translation}, centre, size};
}

double BlockMotion::moved_auxiliary(const AuxiliaryUnknown& unknown, double value) const {
  if (unknown.kind == UnknownKind::kOrientation) return value - heading_of(moved);
  if (unknown.kind == UnknownKind::kHeight) return (moved * at_height(value, centre)).z();
  return value;
}

void BlockMotion::add_auxiliary(const AuxiliaryUnknown& unknown, double value, double derivative, Row7& row) const {
  if (unknown.kind == UnknownKind::kOrientation) row[5] -= derivative;
  if (unknown.kind == UnknownKind::kHeight) row += derivative * derivatives_at(moved * at_height(value, centre)).row(2);
}

void MotionNormals::add_position(const BlockMotion& motion, const Eigen::Vector3d& position,
                                 const Eigen::Vector3d& given, const Eigen::Matrix3d& weight, const Loss& loss) {
  const Eigen::Vector3d now = motion.moved * position, residual = given - now;
  const Matrix37 by_motion = motion.derivatives_at(now);
  const double s = residual.dot(weight * residual), robust = loss.weight(s);
  matrix += robust * by_motion.transpose() * weight * by_motion;
  right += robust * by_motion.transpose() * (weight * residual);
  cost += loss.cost(s);
}

}  // namespace collinea::bundle
