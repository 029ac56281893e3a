// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/internal/channel_table.h"

#include <gtest/gtest.h>

#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(ChannelTable, SmoothedValuesFollowAPlaneAndGoOnWhereThereAreNone) {
  Random random(13);
  std::vector<ChannelValues> scattered;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d at(random.uniform(100, 140), random.uniform(-20, 0));
    if (at.x() > 120 && at.x() < 130) continue;  // nothing is known here
    scattered.push_back({at, {float(at.x()), 7, float(-at.y())}});
  }
  const ChannelTable table = smoothed_table(scattered, 1);
  EXPECT_NEAR(double(table.at({110, -10})[0]), 110, 0.3);
  EXPECT_NEAR(double(table.at({110, -5})[2]), 5, 0.3);
  for (const double x : {90.0, 110.0, 124.0, 150.0}) EXPECT_NEAR(double(table.at({x, -10})[1]), 7, 1e-4) << x;
  EXPECT_NEAR(double(table.at({123, -10})[0]), 120, 1.5);  // as the nearest
  EXPECT_NEAR(double(table.at({128, -10})[0]), 130, 1.5);
  EXPECT_EQ(table.at({1000, -10}), table.at({200, -10}));
}

// Two sites in opposite corners: between them a thousand rings of nodes take over from one another.
TEST(ChannelTable, LongGapsStayBetweenTheirEnds) {
  const std::vector<ChannelValues> scattered{{{0, 0}, {1, 1, 1}}, {{990, 990}, {2, 2, 2}}};
  const ChannelTable table = smoothed_table(scattered, 1);
  for (double t = 0; t <= 990; t += 11) {
    EXPECT_GE(table.at({t, 990 - t})[0], 1) << t;
    EXPECT_LE(table.at({t, 990 - t})[0], 2) << t;
  }
  EXPECT_NEAR(double(table.at({900, 900})[0]), 2, 1e-6);
}

TEST(ChannelTable, OfOnePositionOrOfNone) {
  EXPECT_EQ(smoothed_table({}, 1).at({3, 4})[0], 0);
  const std::vector<ChannelValues> one{{{5, 6}, {1, 2, 3}}};
  EXPECT_EQ(smoothed_table(one, 0).at({5, 6})[0], 0);
  for (const double x : {-9.0, 5.0, 99.0}) EXPECT_NEAR(double(smoothed_table(one, 2).at({x, 6})[2]), 3, 1e-6);
}

}  // namespace
}  // namespace collinea
