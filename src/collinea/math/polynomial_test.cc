// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/polynomial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// The product of (x - r) over the roots, times `rest`.
template <std::size_t N>
std::array<double, N> polynomial(const std::vector<double>& roots, std::vector<double> rest = {1}) {
  for (const double root : roots) {
    std::vector<double> next(rest.size() + 1);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      next[i + 1] += rest[i];
      next[i] -= root * rest[i];
    }
    rest = next;
  }
  std::array<double, N> c{};
  std::copy(rest.begin(), rest.end(), c.begin());
  return c;
}

template <class Found>
std::vector<double> sorted(const Found& found) {
  std::vector<double> all(found.begin(), found.end());
  std::sort(all.begin(), all.end());
  return all;
}

template <class Found>
void expect_roots(const Found& found, std::vector<double> truth, double tolerance) {
  std::sort(truth.begin(), truth.end());
  const std::vector<double> all = sorted(found);
  ASSERT_EQ(all.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(all[i], truth[i], tolerance * std::max(1.0, std::abs(truth[i])));
}

TEST(Polynomial, QuadraticRootsWithoutCancellation) {
  expect_roots(real_roots(std::array<double, 3>{1e-8, -1, 1}), {1e-8 + 1e-16, 1 - 1e-8}, 1e-15);
  expect_roots(real_roots(std::array<double, 3>{-6, 3, 0}), {2}, 0);
  expect_roots(real_roots(std::array<double, 3>{4, -4, 1}), {2}, 0);
  EXPECT_TRUE(real_roots(std::array<double, 3>{1, 0, 1}).empty());
  EXPECT_TRUE(real_roots(std::array<double, 3>{0, 0, 0}).empty());
}

TEST(Polynomial, CubicRootsAreFound) {
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const std::vector<double> truth = {random.uniform(-3, 3), random.uniform(4, 6), random.uniform(-9, -4)};
    expect_roots(real_roots(polynomial<4>(truth)), truth, 1e-12);
    const double a = random.uniform(-2, 2), b = random.uniform(0.5, 2);
    const double alone = random.uniform(-5, 5);
    expect_roots(real_roots(polynomial<4>({alone}, {a * a + b * b, -2 * a, 1})), {alone}, 1e-12);
  }
}

TEST(Polynomial, CubicWithVanishingLeadingTermKeepsItsOtherRoots) {
  expect_roots(real_roots(polynomial<4>({2, -3})), {2, -3}, 1e-12);
  expect_roots(real_roots(std::array<double, 4>{6, -5, 1, 1e-18}), {2, 3}, 1e-10);
}

// Ten roots in random positions: the error of a root is rounding divided by the slope there, hence the loose bound.
TEST(Polynomial, AllTenRealRootsAreFound) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> truth;
    for (int k = 0; k < 10; ++k) truth.push_back(-2.25 + 0.5 * k + random.uniform(-0.15, 0.15));
    expect_roots(real_roots(polynomial<11>(truth)), truth, 1e-6);
  }
}

TEST(Polynomial, SmallAndLargeRootsAndComplexOnes) {
  const std::vector<double> truth = {-1500, -2, 1e-3, 0.7, 300};
  // (x^2 + 1)(x^2 + x + 3) x remains: 0 is a root too.
  expect_roots(real_roots(polynomial<11>(truth, {0, 3, 1, 4, 1, 1})), {-1500, -2, 0, 1e-3, 0.7, 300}, 1e-9);
}

TEST(Polynomial, LowerDegreeInsideTenIsSolved) {
  expect_roots(real_roots(polynomial<11>({-4, 0.25, 9})), {-4, 0.25, 9}, 1e-12);
  EXPECT_TRUE(real_roots(std::array<double, 11>{}).empty());
  EXPECT_TRUE(real_roots(std::array<double, 11>{5}).empty());
}

TEST(Polynomial, DoubleRootDoesNotHideTheOthers) {
  const auto found = sorted(real_roots(polynomial<11>({-0.5, 0.5, 0.5, 2}, {2, 0, 1})));
  ASSERT_GE(found.size(), 2u);
  EXPECT_NEAR(found.front(), -0.5, 1e-9);
  EXPECT_NEAR(found.back(), 2, 1e-9);
}

}  // namespace
}  // namespace collinea
