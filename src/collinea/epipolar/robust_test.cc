// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/robust.h"

#include <gtest/gtest.h>

#include "collinea/math/few.h"

namespace collinea {
namespace {

// y = slope x + offset: the smallest robust problem.
struct Line {
  double slope, offset;
};

struct LineProblem {
  using Model = Line;
  static constexpr int kSample = 2;
  std::vector<double> x, y;

  [[nodiscard]] int size() const { return static_cast<int>(x.size()); }
  [[nodiscard]] Few<Line, 1> solve(const std::array<int, 2>& sample) const {
    const auto a = static_cast<std::size_t>(sample[0]), b = static_cast<std::size_t>(sample[1]);
    Few<Line, 1> found;
    if (x[a] == x[b]) return found;
    const double slope = (y[b] - y[a]) / (x[b] - x[a]);
    found.add({slope, y[a] - slope * x[a]});
    return found;
  }
  void squared_errors(const Line& line, int begin, int end, double* out) const {
    for (int i = begin; i < end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double e = y[k] - line.slope * x[k] - line.offset;
      out[i - begin] = e * e;
    }
  }
  [[nodiscard]] std::optional<Line> refine(const Line&, std::span<const int> support) const {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const int i : support) {
      const auto k = static_cast<std::size_t>(i);
      n += 1, sx += x[k], sy += y[k], sxx += x[k] * x[k], sxy += x[k] * y[k];
    }
    const double determinant = n * sxx - sx * sx;
    if (!(determinant > 0)) return std::nullopt;
    const double slope = (n * sxy - sx * sy) / determinant;
    return Line{slope, (sy - slope * sx) / n};
  }
};

LineProblem noisy_line(int good, int bad, double sigma, Random& random) {
  LineProblem problem;
  for (const int i : shuffled(good + bad, random)) {
    problem.x.push_back(random.uniform(-10, 10));
    problem.y.push_back(i < good ? 2 * problem.x.back() - 1 + sigma * random.normal() : random.uniform(-40, 40));
  }
  return problem;
}

TEST(Robust, FindsTheLineAmongManyOutliers) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const LineProblem problem = noisy_line(100, 400, 0.1, random);
    RobustOptions options;
    options.max_error_px = 0.3;
    const auto fit = robust_fit(problem, options, random);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->model.slope, 2, 5 * 0.1 / std::sqrt(100 * 33.3));  // 5 sigma of the least-squares slope
    EXPECT_NEAR(fit->model.offset, -1, 5 * 0.1 / std::sqrt(100));
    EXPECT_GE(fit->inliers.size(), 95u);
    EXPECT_LE(fit->inliers.size(), 112u);
  }
}

TEST(Robust, NumberOfTrialsFollowsTheInliers) {
  Random random(4);
  RobustOptions options;
  options.max_error_px = 0.5;
  options.max_trials = 100000;
  const auto clean = robust_fit(noisy_line(300, 0, 0.1, random), options, random);
  const auto dirty = robust_fit(noisy_line(60, 240, 0.1, random), options, random);
  ASSERT_TRUE(clean && dirty);
  EXPECT_EQ(clean->trials, options.min_trials);
  EXPECT_GT(dirty->trials, 100);  // log(1e-4) / log(1 - 0.2^2) = 226 without chance inliers
  EXPECT_LT(dirty->trials, 300);
}

TEST(Robust, WantedShareOfInliersBoundsTheTrials) {
  Random random(5);
  RobustOptions options;
  options.max_error_px = 1e-9;  // nothing but the sample itself ever fits
  options.min_inlier_ratio = 0.5;
  const auto fit = robust_fit(noisy_line(0, 100, 0.1, random), options, random);
  ASSERT_TRUE(fit);
  EXPECT_LE(fit->trials, 34);  // log(1e-4) / log(1 - 0.5^2) = 33, somewhat more without replacement
}

// Bolognesi T3b (eq. 6.7): samples of 2, 3, 5, 6, 7 and 8 items with a chance of 0.01 that none is without outliers,
// of items without end.
TEST(Robust, SamplesNeededByBolognesiT3b) {
  const struct {
    double outliers;
    int samples[6];
  } table[] = {{0.5, {17, 35, 146, 293, 588, 1177}},
               {0.4, {11, 19, 57, 97, 163, 272}},
               {0.3, {7, 11, 26, 37, 54, 78}},
               {0.2, {5, 7, 12, 16, 20, 26}},
               {0.1, {3, 4, 6, 7, 8, 9}}};
  constexpr int kItems[] = {2, 3, 5, 6, 7, 8};
  constexpr double kMany = 1e12;
  for (const auto& row : table)
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(samples_needed((1 - row.outliers) * kMany, kMany, kItems[i], 0.99), row.samples[i]) << row.outliers;
  EXPECT_EQ(samples_needed(10, 10, 2, 0.99), 0);
  EXPECT_EQ(samples_needed(1, 10, 2, 0.99), std::numeric_limits<double>::infinity());
}

// Mussio D.8: minimal subsets of 15 points for relative orientation (5), of the 20 coordinates of ten points for
// resection (6) and of the 27 of nine for absolute orientation (7).
TEST(Robust, SubsetsOfMussioD8) {
  EXPECT_EQ(samples_possible(15, 5), 3003);
  EXPECT_EQ(samples_possible(20, 6), 38760);
  EXPECT_EQ(samples_possible(27, 7), 888030);
  EXPECT_EQ(samples_possible(4, 5), 0);
  EXPECT_EQ(samples_possible(5, 5), 1);
  EXPECT_EQ(samples_possible(60, 30), 118264581564861424.0);
}

TEST(Robust, SameSeedSameAnswer) {
  Random making(6);
  const LineProblem problem = noisy_line(80, 300, 0.1, making);
  RobustOptions options;
  options.max_error_px = 0.3;
  Random one(9), two(9);
  const auto a = robust_fit(problem, options, one), b = robust_fit(problem, options, two);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->model.slope, b->model.slope);
  EXPECT_EQ(a->inliers, b->inliers);
}

TEST(Robust, TooFewOrDegenerateItemsHaveNoAnswer) {
  Random random(7);
  EXPECT_FALSE(robust_fit(LineProblem{{1}, {1}}, RobustOptions{}, random));
  EXPECT_FALSE(robust_fit(LineProblem{{1, 1, 1}, {1, 2, 3}}, RobustOptions{}, random));
}

TEST(Robust, ShuffledIsAPermutation) {
  Random random(8);
  std::vector<int> order = shuffled(1000, random);
  EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
  std::sort(order.begin(), order.end());
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace collinea
