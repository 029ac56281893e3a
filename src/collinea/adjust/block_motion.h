// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/adjust/internal/problem.h"
#include "collinea/geometry/similarity3.h"

namespace collinea::bundle {

// Motions of a block as a whole, seven numbers: shift / size, angles about x, y, z of the world [rad], log scale.
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Matrix37 = Eigen::Matrix<double, 3, 7>;
using Row7 = Eigen::Matrix<double, 1, 7>;

/// A motion is not seen where its eigenvalue is at most this part of the largest one, in the sum of g' g of derivatives
/// g by motion_of(): 3e-5 in angle or relative scale. That is geometry alone, whatever the sigmas are. By it the datum
/// finds what is not determined of a part of the block, and tie points tell whether they can stand for it.
inline constexpr double kSeenMotion = 1e-9;

/// The projection centre of an image.
[[nodiscard]] inline Eigen::Vector3d centre_in(const State& state, std::size_t image) {
  return Eigen::Map<const Eigen::Vector3d>(state.frames[image].data() + 9);
}

/// How a point moves when its world is shifted, turned and scaled about `centre`, divided by `size`:
/// by [shift / size, angles (rad), log scale].
[[nodiscard]] Matrix37 motion_of(const Eigen::Vector3d& point, const Eigen::Vector3d& centre, double size);

/// A block that was moved as a whole.
struct BlockMotion {
  Similarity3 moved;       ///< of all its positions
  Eigen::Vector3d centre;  ///< of further motions
  double size;

  /// The derivatives of a position of the moved block by a further motion [m].
  [[nodiscard]] Matrix37 derivatives_at(const Eigen::Vector3d& position) const {
    return size * motion_of(position, centre, size);
  }
  /// The moved block after a further motion.
  [[nodiscard]] BlockMotion after(const Vector7& motion) const;
  /// An auxiliary unknown of the moved block: orientations of set-ups and common heights go with it, all others stay.
  [[nodiscard]] double moved_auxiliary(const AuxiliaryUnknown& unknown, double value) const;
  /// Adds to the derivatives of an observation by a further motion what it sees of such an unknown with its
  /// `derivative`. `value`: before the block was moved.
  void add_auxiliary(const AuxiliaryUnknown& unknown, double value, double derivative, Row7& row) const;
};

/// The normal equations of a further motion of a moved block, and what its observations cost there.
struct MotionNormals {
  Matrix7 matrix = Matrix7::Zero();
  Vector7 right = Vector7::Zero();
  double cost = 0;

  /// A position of the block before it was moved, with what is given for it and its weight matrix.
  void add_position(const BlockMotion& motion, const Eigen::Vector3d& position, const Eigen::Vector3d& given,
                    const Eigen::Matrix3d& weight, const Loss& loss);
};

}  // namespace collinea::bundle
