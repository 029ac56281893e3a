// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/inverse_root.h"

#include <gtest/gtest.h>

#include <limits>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;

Matrix3d random_matrix(Random& random) {
  Matrix3d m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = random.normal();
  return m;
}

// Rounding of some dozen operations, times the condition of the matrix, which the added unit keeps below some hundred.
TEST(InverseRoot, MakesTheInverseAndIsTriangular) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d half = random_matrix(random), w = half * half.transpose() + 0.1 * Matrix3d::Identity();
    Matrix3d root;
    ASSERT_TRUE(inverse_root(w, root));
    EXPECT_LT((root.transpose() * root * w - Matrix3d::Identity()).norm(), 1e-11);
    EXPECT_TRUE(root.isLowerTriangular(0));
  }
}

TEST(InverseRoot, RefusesWhatIsNotPositiveDefinite) {
  Matrix3d root, w = Matrix3d::Identity();
  w(2, 2) = 0;
  EXPECT_FALSE(inverse_root(w, root));
  w << 1, 2, 0, 2, 1, 0, 0, 0, 1;  // eigenvalues 3, -1, 1
  EXPECT_FALSE(inverse_root(w, root));
  w = 1e-3 * Matrix3d::Identity();
  EXPECT_TRUE(inverse_root(w, root, 9e-4));
  EXPECT_FALSE(inverse_root(w, root, 2e-3));
  w(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(inverse_root(w, root));
}

}  // namespace
}  // namespace collinea
