// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/collinearity.h"

namespace collinea {

CollinearityAt collinearity(const CollinearityPhoto& photo, const Eigen::Vector3d& point) {
  const Eigen::Matrix3d rotation = rotation_matrix(photo.angles);
  const RotationDerivatives by = derivatives(photo.angles);
  const Eigen::Vector3d arm = point - photo.centre, in_image = rotation * arm;
  const double c = photo.principal_distance, d = in_image.z();
  CollinearityAt at;
  at.denominator = d;
  at.xy = -c / d * in_image.head<2>();
  Eigen::Matrix<double, 2, 3> by_image;  // of x, y by N and D
  by_image << -c / d, 0, -at.xy.x() / d, 0, -c / d, -at.xy.y() / d;
  at.by_point = by_image * rotation;
  at.by_centre = -at.by_point;
  at.by_angles << by_image * by.by_omega * arm, by_image * by.by_phi * arm, by_image * by.by_kappa * arm;
  return at;
}

}  // namespace collinea
