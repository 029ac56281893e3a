// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/quantiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace collinea {
namespace {

// Tables of Abramowitz and Stegun (26.10), and closed forms for 1 and 2 degrees of freedom.
TEST(Quantiles, OfStudentsDistributionAreThoseOfTheTables) {
  EXPECT_NEAR(student_limit(0.05, 10), 2.228139, 1e-6);
  EXPECT_NEAR(student_limit(0.001, 3), 12.923979, 1e-6);
  EXPECT_NEAR(student_limit(0.001, 30), 3.645959, 1e-6);
  for (const double alpha : {0.5, 0.01, 1e-6}) {
    EXPECT_NEAR(student_limit(alpha, 1) * std::tan(alpha * std::acos(-1.0) / 2), 1, 1e-8);
    const double p = 1 - alpha;
    EXPECT_NEAR(student_limit(alpha, 2) / (p * std::sqrt(2 / (1 - p * p))), 1, 1e-6);
  }
  EXPECT_NEAR(student_limit(0.001, 1e5), normal_limit(0.001), 1.1e-4);
  EXPECT_EQ(student_limit(0.001, std::numeric_limits<double>::infinity()), normal_limit(0.001));
}

TEST(Quantiles, IncompleteBetaFunctionAgreesWithItsClosedForms) {
  for (const double x : {0.0, 1e-6, 0.2, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(incomplete_beta(3, 1, x), x * x * x, 1e-12);
    EXPECT_NEAR(incomplete_beta(1, 2.5, x), 1 - std::pow(1 - x, 2.5), 1e-12);
    EXPECT_NEAR(incomplete_beta(0.5, 0.5, x), 2 / std::acos(-1.0) * std::asin(std::sqrt(x)), 1e-12);
  }
}

// Karfis (829) calls 2.67 sigma 95 %: it is 99.24 %, and 95 % are 1.96 sigma (erratum 4).
TEST(Quantiles, ShareWithinTheLimitOfKarfis) {
  EXPECT_NEAR(1 - power_of_test(0, 2.67), 0.9924, 5e-5);
  EXPECT_NEAR(normal_limit(0.05), 1.96, 5e-3);
}

}  // namespace
}  // namespace collinea
