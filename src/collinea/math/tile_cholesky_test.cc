// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/tile_cholesky.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea::bundle {
namespace {

const Run kRun;

// Positive definite with zeros outside some tiles; the last rows (a border) are full.
struct Example {
  Eigen::MatrixXd dense;
  TileMatrix matrix;
  TileCholesky tiles;
};

// Tile rows that hang together as a tree does: two halves that meet only in the last quarter.
TilePattern halves(int rows) {
  TilePattern pattern(static_cast<std::size_t>(rows));
  for (int i = 1; i < rows; ++i)
    for (int k = 0; k < i; ++k) {
      const bool separator = 4 * i >= 3 * rows, same_half = (8 * i < 3 * rows) == (8 * k < 3 * rows);
      if (i == rows - 1 || ((separator || same_half) && (i - k < 3 || (i + k) % 5 == 0)))
        pattern[static_cast<std::size_t>(i)].push_back(k);
    }
  return pattern;
}

Example example(int size) {
  const int rows = (size + kTile - 1) / kTile;
  const TilePattern pattern = halves(rows);
  Random random(3);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  TileMatrix tiles(size, pattern);
  for (int c = 0; c < size; ++c)
    for (int r = c; r < size; ++r) {
      const auto& columns = pattern[static_cast<std::size_t>(r / kTile)];
      if (r / kTile == c / kTile || std::find(columns.begin(), columns.end(), c / kTile) != columns.end())
        dense(r, c) = dense(c, r) = tiles.at(r, c) = random.normal();
    }
  for (int i = 0; i < size; ++i) tiles.at(i, i) = dense(i, i) += 4 * std::sqrt(size) + 10;
  return {dense, tiles, TileCholesky(size, pattern)};
}

TEST(TileCholesky, SolvesAndInvertsLikeADenseOne) {
  for (const int size : {1, 6, 47, 48, 49, 250, 600, 1000}) {
    Example e = example(size);
    ASSERT_TRUE(e.tiles.factor(e.matrix, kRun));
    std::vector<double> x(e.tiles.tile_rows() * kTile, 0.0);
    Random random(4);
    Eigen::VectorXd right(size);
    for (int i = 0; i < size; ++i) right[i] = x[i] = random.normal();
    e.tiles.solve(x.data());
    const Eigen::VectorXd expected = e.dense.llt().solve(right);
    EXPECT_LT((Eigen::Map<Eigen::VectorXd>(x.data(), size) - expected).norm(), 1e-12 * expected.norm());
    e.tiles.invert(kRun);
    const Eigen::MatrixXd inverse = e.dense.llt().solve(Eigen::MatrixXd::Identity(size, size));
    double worst = 0;
    for (int c = 0; c < size; ++c)
      for (int r = c; r < size; ++r)
        if (e.tiles.holds(r / kTile, c / kTile)) worst = std::max(worst, std::abs(e.tiles.at(r, c) - inverse(r, c)));
    EXPECT_LT(worst, 1e-13);
  }
}

TEST(TileMatrix, MultipliesLikeADenseOne) {
  for (const int size : {1, 47, 49, 600}) {
    const Example e = example(size);
    Random random(5);
    std::vector<double> x(e.matrix.tile_rows() * kTile, 0.0), y(x.size());
    for (int i = 0; i < size; ++i) x[i] = random.normal();
    e.matrix.times(x.data(), y.data());
    const Eigen::VectorXd expected = e.dense * Eigen::Map<Eigen::VectorXd>(x.data(), size);
    EXPECT_LT((Eigen::Map<Eigen::VectorXd>(y.data(), size) - expected).norm(), 1e-13 * expected.norm());
  }
}

TEST(TileCholesky, HoldsNothingBetweenPartsThatMeetLater) {
  const TileCholesky tiles(24 * kTile, halves(24));
  for (int i = 9; i < 18; ++i)
    for (int k = 0; k < 9; ++k) EXPECT_FALSE(tiles.holds(i, k)) << i << " " << k;
  EXPECT_TRUE(tiles.holds(20, 0) || tiles.holds(21, 0));
}

TEST(TileCholesky, ThreadsDoNotChangeABit) {
  collinea::Run three;
  three.threads = 3;
  Example a = example(1500), b = example(1500);
  const auto expect_same = [&] {
    for (int c = 0; c < 1500; ++c)
      for (int r = c; r < 1500; ++r)
        if (a.tiles.holds(r / kTile, c / kTile)) {
          ASSERT_EQ(a.tiles.at(r, c), b.tiles.at(r, c));
        }
  };
  ASSERT_TRUE(a.tiles.factor(a.matrix, kRun) && b.tiles.factor(b.matrix, three));
  expect_same();
  a.tiles.invert(kRun);
  b.tiles.invert(three);
  expect_same();
}

TEST(TileCholesky, NamesTheRowThatIsNotDetermined) {
  Example e = example(100);
  for (int i = 0; i < 100; ++i) {
    const int row = std::max(i, 70), column = std::min(i, 70);
    if (e.matrix.holds(row / kTile, column / kTile)) e.matrix.at(row, column) = 0;
  }
  EXPECT_FALSE(e.tiles.factor(e.matrix, kRun));
  EXPECT_EQ(e.tiles.failed_row(), 70);
}

TEST(TileKernels, EveryInstructionSetAgreesWithPlainLoops) {
  Random random(1);
  std::vector<double> a(3 * kTileSize), b(3 * kTileSize), c(kTileSize);
  for (auto* values : {&a, &b, &c})
    for (double& value : *values) value = random.normal();
  PoseRay rays[3];
  for (PoseRay& ray : rays) {
    for (double& value : ray.j) value = random.normal();
    for (double& value : ray.z) value = random.normal();
    for (double& value : ray.residual) value = random.normal();
  }
  for (const std::int64_t target : testing::processor_targets()) {
    const testing::OnTarget chosen(target);
    std::vector<double> product = c;
    subtract_product(product.data(), a.data(), b.data(), 3 * kTile);
    double worst = 0;
    for (int j = 0; j < kTile; ++j)
      for (int i = 0; i < kTile; ++i) {
        double expected = c[j * kTile + i];
        for (int k = 0; k < 3 * kTile; ++k) expected -= a[k * kTile + i] * b[k * kTile + j];
        worst = std::max(worst, std::abs(product[j * kTile + i] - expected));
      }
    EXPECT_LT(worst, 1e-12) << hwy::TargetName(target);

    std::vector<double> blocks(3 * kTileSize, 1.0), diagonal_block(kTileSize, 2.0);
    double right[6] = {}, diagonal[6] = {}, columns[12] = {};
    double* starts[3] = {&blocks[0], &blocks[kTileSize], &blocks[2 * kTileSize]};
    add_pose_ray(rays[1], diagonal_block.data(), right, diagonal, starts, rays, 3);
    add_pose_camera(columns, rays[1], a.data(), 2);
    subtract_pose_camera(columns, rays[1], b.data(), 2);
    const double *j = rays[1].j, *z = rays[1].z;
    for (int r = 0; r < 6; ++r) {
      EXPECT_NEAR(right[r], j[r] * rays[1].residual[0] + j[6 + r] * rays[1].residual[1], 1e-13);
      EXPECT_NEAR(diagonal[r], j[r] * j[r] + j[6 + r] * j[6 + r], 1e-13);
      for (int k = 0; k < 6; ++k) {
        EXPECT_NEAR(diagonal_block[k * kTile + r], 2 + j[r] * j[k] + j[6 + r] * j[6 + k], 1e-13);
        for (int n = 0; n < 3; ++n) {
          const double* q = rays[n].z;
          EXPECT_NEAR(starts[n][k * kTile + r], 1 - z[r] * q[k] - z[6 + r] * q[6 + k] - z[12 + r] * q[12 + k], 1e-13);
        }
      }
      for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(
            columns[6 * k + r],
            j[r] * a[k] + j[6 + r] * a[2 + k] - z[r] * b[3 * k] - z[6 + r] * b[3 * k + 1] - z[12 + r] * b[3 * k + 2],
            1e-13);
    }
    for (int r = 6; r < kTile; ++r) EXPECT_EQ(diagonal_block[r], 2.0);  // nothing beyond the six rows
  }
}

}  // namespace
}  // namespace collinea::bundle
