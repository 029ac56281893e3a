// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/normal.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

// Abramowitz and Stegun, tables 26.1 and 26.2.
TEST(Normal, ProbabilitiesAreThoseOfTables) {
  EXPECT_DOUBLE_EQ(normal_probability(0), 0.5);
  EXPECT_NEAR(normal_probability(1), 0.841344746068543, 1e-15);
  EXPECT_NEAR(normal_probability(-1.96), 0.024997895148220, 1e-15);
  EXPECT_NEAR(std::log10(normal_probability(-10)), -23.11805, 1e-5);
  EXPECT_EQ(normal_probability(40), 1);
}

TEST(Normal, DensityIsTheDerivative) {
  for (double x = -4; x <= 4; x += 0.3)
    EXPECT_NEAR(normal_density(x), (normal_probability(x + 1e-5) - normal_probability(x - 1e-5)) / 2e-5, 1e-9);
}

}  // namespace
}  // namespace collinea
