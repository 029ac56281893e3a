// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kept_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "collinea/math/random.h"

namespace collinea::bundle {
namespace {

const Run kRun;
constexpr int kImages = 200, kSize = 6 * kImages, kRows = kSize / kTile;

Problem problem_of(const std::vector<int>& images) {
  Problem problem;
  problem.poses = static_cast<int>(images.size());
  for (const int image : images) problem.images.push_back({ImageId{static_cast<std::uint32_t>(image)}, 0});
  return problem;
}

std::vector<int> in_order() {
  std::vector<int> images(kImages);
  for (int i = 0; i < kImages; ++i) images[static_cast<std::size_t>(i)] = i;
  return images;
}

TilePattern full() {
  TilePattern pattern(kRows);
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < i; ++k) pattern[static_cast<std::size_t>(i)].push_back(k);
  return pattern;
}

// Its eigenvalues reach over three powers of ten.
Eigen::MatrixXd dense_example() {
  Random random(1);
  Eigen::MatrixXd half(kSize, 30);
  for (int c = 0; c < half.cols(); ++c)
    for (int r = 0; r < kSize; ++r) half(r, c) = random.normal();
  Eigen::MatrixXd dense = half * half.transpose();
  dense.diagonal().array() += 2;
  return dense;
}

// The images may be numbered otherwise: image k of the matrix is images[k] of the dense one.
TileMatrix tiles_of(const Eigen::MatrixXd& dense, const std::vector<int>& images) {
  TileMatrix matrix(kSize, full());
  for (int c = 0; c < kSize; ++c)
    for (int r = c; r < kSize; ++r)
      matrix.at(r, c) = dense(6 * images[static_cast<std::size_t>(r / 6)] + r % 6,
                              6 * images[static_cast<std::size_t>(c / 6)] + c % 6);
  return matrix;
}

Eigen::VectorXd some_vector() {
  Random random(2);
  Eigen::VectorXd right(kSize);
  for (int i = 0; i < kSize; ++i) right[i] = random.normal();
  return right;
}

// Solves with `kept`; answers how far that is from the solution, over its length, both in standard deviations.
double error_of(KeptFactor& kept, const Eigen::MatrixXd& dense, const std::vector<int>& images) {
  const Eigen::VectorXd right = some_vector(), exact = dense.llt().solve(right);
  std::vector<double> x(kSize);
  for (int i = 0; i < kSize; ++i) x[i] = right[6 * images[static_cast<std::size_t>(i / 6)] + i % 6];
  EXPECT_TRUE(kept.solve(tiles_of(dense, images), full(), x.data(), kRun));
  Eigen::VectorXd found(kSize);
  for (int i = 0; i < kSize; ++i) found[6 * images[static_cast<std::size_t>(i / 6)] + i % 6] = x[i];
  const Eigen::VectorXd off = found - exact;
  return std::sqrt(off.dot(dense * off) / exact.dot(dense * exact));
}

Eigen::MatrixXd weighted_otherwise(Eigen::MatrixXd dense) {
  Eigen::VectorXd scale(kSize);
  for (int i = 0; i < kSize; ++i) scale[i] = 1 + 0.1 * (i % 5);
  return scale.asDiagonal() * dense * scale.asDiagonal();
}

// As far as asked and no further: the older factor was at work. It serves images in another order as well.
TEST(KeptFactor, SolvesWithAnOlderFactorAsExactlyAsAStepNeeds) {
  const Eigen::MatrixXd dense = dense_example();
  KeptFactor kept;
  kept.meet(problem_of(in_order()));
  EXPECT_LT(error_of(kept, dense, in_order()), 1e-12);
  const Eigen::MatrixXd later = 1.5 * dense + 0.05 * weighted_otherwise(dense);
  const double error = error_of(kept, later, in_order());
  EXPECT_LT(error, 0.05);
  EXPECT_GT(error, 1e-12);
  std::vector<int> reversed = in_order();
  std::reverse(reversed.begin(), reversed.end());
  kept.meet(problem_of(reversed));
  const double renumbered = error_of(kept, later, reversed);
  EXPECT_LT(renumbered, 0.05);
  EXPECT_GT(renumbered, 1e-12);
}

TEST(KeptFactor, FactorsAnewWhereTheOlderFactorIsNoHelp) {
  const Eigen::MatrixXd dense = dense_example();
  KeptFactor kept;
  kept.meet(problem_of(in_order()));
  EXPECT_LT(error_of(kept, dense, in_order()), 1e-12);
  Eigen::MatrixXd other = dense.rowwise().reverse().colwise().reverse();
  EXPECT_LT(error_of(kept, other, in_order()), 1e-12);
}

TEST(KeptFactor, FactorsAnewWhenAnImageIsNew) {
  const Eigen::MatrixXd dense = dense_example();
  KeptFactor kept;
  kept.meet(problem_of(in_order()));
  EXPECT_LT(error_of(kept, dense, in_order()), 1e-12);
  Problem other = problem_of(in_order());
  other.images[7].id = ImageId{kImages};
  kept.meet(other);
  EXPECT_LT(error_of(kept, 1.01 * dense, in_order()), 1e-12);
}

TEST(KeptFactor, SaysWhenAMatrixIsNotPositiveDefinite) {
  Eigen::MatrixXd dense = dense_example();
  KeptFactor kept;
  kept.meet(problem_of(in_order()));
  EXPECT_LT(error_of(kept, dense, in_order()), 1e-12);
  dense(100, 100) = -1;
  std::vector<double> x(kSize, 1.0);
  EXPECT_FALSE(kept.solve(tiles_of(dense, in_order()), full(), x.data(), kRun));
  kept.meet(problem_of(in_order()));  // what is left of that factor serves nothing
  EXPECT_LT(error_of(kept, dense_example(), in_order()), 1e-12);
}

}  // namespace
}  // namespace collinea::bundle
