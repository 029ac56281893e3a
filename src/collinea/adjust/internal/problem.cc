// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

Frame frame_of(const Eigen::Quaterniond& rotation, const double* centre) {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  return {r(0, 0), r(0, 1), r(0, 2), r(1, 0),   r(1, 1),   r(1, 2),
          r(2, 0), r(2, 1), r(2, 2), centre[0], centre[1], centre[2]};
}

}  // namespace collinea::bundle
