// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/proj_text.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(ProjText, IsThatOfThePlan) {
  for (const char* crs : {"EPSG:32616", "EPSG:32616+5773"}) {
    const auto frame = LocalFrame::create(crs, 41.3, -81.75, 200);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(proj_text(*frame).value_or(""), "+proj=utm +zone=16 +datum=WGS84 +units=m +no_defs") << crs;
  }
  const auto gauss = LocalFrame::create("EPSG:31256", 48.2, 16.4, 200);
  ASSERT_TRUE(gauss) << gauss.error().message;
  EXPECT_NE(proj_text(*gauss).value_or("").find("+proj=tmerc"), std::string::npos);
}

}  // namespace
}  // namespace collinea
