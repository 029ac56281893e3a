// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/median.h"

#include <gtest/gtest.h>

#include <vector>

namespace collinea {
namespace {

TEST(Median, IsTheUpperOneOfAnEvenNumber) {
  EXPECT_EQ(median(std::vector{3.0, 1.0, 2.0}), 2);
  EXPECT_EQ(median(std::vector{4.0F, 1.0F, 3.0F, 2.0F}), 3);
  std::vector<int> one{7};
  EXPECT_EQ(median(one), 7);
}

TEST(Quantile, IsTheNearestValue) {
  EXPECT_EQ(quantile(std::vector{5, 1, 4, 2, 3}, 0), 1);
  EXPECT_EQ(quantile(std::vector{5, 1, 4, 2, 3}, 0.3), 2);
  EXPECT_EQ(quantile(std::vector{5, 1, 4, 2, 3}, 1), 5);
  EXPECT_EQ(quantile(std::vector{7.0}, 0.5), 7.0);
}

}  // namespace
}  // namespace collinea
