// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/model_points.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "collinea/epipolar/spatial_parallax.h"

namespace collinea {
namespace {

// Rays that meet: the point with its derivatives by the change of the motion and by x1, y1, x2, y2. Between rays that
// meet only to first order the same holds of the middle of the parallax.
struct MeetingPoint {
  Eigen::Matrix<double, 3, 5> by_change;
  Eigen::Matrix<double, 3, 4> by_coordinates;
};

// The point X minimises the distances from both rays: sum (I - r r') (X - c) = 0, differentiated.
MeetingPoint derivatives(const Rigid3& motion, const Eigen::Vector2d& first, const Eigen::Vector2d& second,
                         const SpatialParallax& meeting) {
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d q1 = first.homogeneous(), q2 = second.homogeneous(), base = base_in_first(motion);
  const Eigen::Vector3d s = q1.normalized(), t = (rotation.transpose() * q2).normalized();
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity(), across_s = identity - s * s.transpose(),
                        across_t = identity - t * t.transpose();
  const Eigen::Matrix3d inverse = (across_s + across_t).inverse();
  // A ray that turns by d(direction) shifts the point it passes at distance m by m d(direction), across itself.
  const Eigen::Matrix3d by_s = inverse * across_s * meeting.along_first / q1.norm(),
                        by_t = inverse * across_t * meeting.along_second / q2.norm();
  MeetingPoint out;
  out.by_coordinates.leftCols<2>() = by_s.leftCols<2>();
  out.by_coordinates.rightCols<2>() = (by_t * rotation.transpose()).leftCols<2>();
  // exp(d)' q2 = q2 - d x q2 = q2 + [q2]x d
  Eigen::Matrix3d cross;
  cross << 0, -q2.z(), q2.y(), q2.z(), 0, -q2.x(), -q2.y(), q2.x(), 0;
  out.by_change.leftCols<3>() = by_t * rotation.transpose() * cross;
  out.by_change.rightCols<2>() = inverse * across_t * tangents_of(base);
  return out;
}

// Derivatives of the misclosure by the change and by the coordinates.
struct Condition {
  Vector5 by_change;
  Eigen::Vector4d by_coordinates;
};

Condition condition(const Rigid3& motion, const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d q1 = first.homogeneous(), q2 = second.homogeneous(), base = base_in_first(motion);
  const Eigen::Vector3d turned = rotation.transpose() * q2, across = rotation * base.cross(q1);
  Condition out;
  out.by_change << across.cross(q2), tangents_of(base).transpose() * q1.cross(turned);
  out.by_coordinates << turned.cross(base).head<2>(), across.head<2>();
  return out;
}

}  // namespace

PairModel model_points(const RelativeOrientation& orientation, std::span<const PairPoint> points, double base,
                       bool y_up) {
  const Rigid3& motion = orientation.second_from_first;
  const Matrix5 covariance = orientation.stated_covariance();
  Eigen::Matrix3d scale = base * Eigen::Matrix3d::Identity();
  if (y_up) scale.bottomRows<2>() *= -1;

  PairModel model;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PairPoint& pair = points[i];
    const PairResidual& residual = orientation.residuals[i];
    const Eigen::Vector2d first = pair.first + residual.first, second = pair.second + residual.second;
    const auto observed = spatial_parallax(motion, pair.first, pair.second);
    const auto adjusted = spatial_parallax(motion, first, second);
    if (!observed || !adjusted) {
      model.points.emplace_back();
      continue;
    }
    const MeetingPoint by = derivatives(motion, first, second, *adjusted);
    const Condition c = condition(motion, first, second);
    Eigen::Vector4d variances;
    variances << pair.sigma_first * pair.sigma_first * Eigen::Vector2d::Ones(),
        pair.sigma_second * pair.sigma_second * Eigen::Vector2d::Ones();
    // Adjusted coordinates: l + v, v = -Q B' M^-1 (B dl + A dx). What of dl remains is not correlated with dx.
    const Eigen::Vector4d gain =
        variances.cwiseProduct(c.by_coordinates) / c.by_coordinates.cwiseProduct(variances).dot(c.by_coordinates);
    const Eigen::Matrix4d remains = Eigen::Matrix4d::Identity() - gain * c.by_coordinates.transpose();
    const Eigen::Matrix4d own = remains * variances.asDiagonal() * remains.transpose();
    ModelPoint point;
    point.position = scale * adjusted->point_in_first;
    point.by_orientation = scale * (by.by_change - by.by_coordinates * gain * c.by_change.transpose());
    const Eigen::Matrix<double, 3, 4> by_coordinates = scale * by.by_coordinates;
    point.covariance = orientation.variance_factor * by_coordinates * own * by_coordinates.transpose() +
                       point.by_orientation * covariance * point.by_orientation.transpose();
    point.parallax = scale * observed->parallax;
    point.in_front = adjusted->along_first > 0 && adjusted->along_second > 0;
    model.points.emplace_back(point);
  }
  const Eigen::Vector3d base_direction = base_in_first(motion);
  model.second_centre.position = scale * base_direction;
  model.second_centre.by_orientation.setZero();
  model.second_centre.by_orientation.rightCols<2>() = scale * tangents_of(base_direction);
  model.second_centre.covariance =
      model.second_centre.by_orientation * covariance * model.second_centre.by_orientation.transpose();
  return model;
}

Eigen::MatrixXd full_covariance(const PairModel& model, const Matrix5& orientation) {
  std::vector<const ModelPoint*> there;
  for (const auto& point : model.points)
    if (point) there.push_back(&*point);
  there.push_back(&model.second_centre);
  const auto count = static_cast<Eigen::Index>(there.size());
  Eigen::MatrixXd common(3 * count, 5);
  for (Eigen::Index i = 0; i < count; ++i)
    common.middleRows<3>(3 * i) = there[static_cast<std::size_t>(i)]->by_orientation;
  Eigen::MatrixXd out = common * orientation * common.transpose();
  for (Eigen::Index i = 0; i < count; ++i)
    out.block<3, 3>(3 * i, 3 * i) = there[static_cast<std::size_t>(i)]->covariance;
  return out;
}

}  // namespace collinea
