// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/cells.h"

#include <gtest/gtest.h>

#include <limits>

namespace collinea {
namespace {

TEST(Cells, EachStandardDeviationShowsTwoDigits) {
  EXPECT_EQ(decimals_for(0.02, 4), 4);
  EXPECT_EQ(decimals_for(0.001, 4), 4);
  EXPECT_EQ(decimals_for(0.00099, 4), 5);
  EXPECT_EQ(decimals_for(3.4e-6, 4), 7);
  const double several[] = {0.02, 3.4e-6, 0.5};
  EXPECT_EQ(decimals_for(several, 4), 7);
}

TEST(Cells, WhatIsNotKnownAndWhatIsExactDoNotCount) {
  const double none[] = {0, -1, 1e-17, std::numeric_limits<double>::quiet_NaN(),
                         std::numeric_limits<double>::infinity()};
  EXPECT_EQ(decimals_for(none, 4), 4);
}

}  // namespace
}  // namespace collinea
