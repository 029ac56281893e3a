// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/guarded.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

namespace collinea {
namespace {

TEST(Guarded, HandsOnWhatTheWorkReturns) {
  EXPECT_EQ(guarded([] { return 6; }), 6);
}

TEST(Guarded, EveryExceptionIsADefectWithExitCodeOne) {
  const auto printed = [](const std::function<int()>& work) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(guarded(work), 1);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(printed([]() -> int { throw std::logic_error("a < b"); }),
            "collinea has a defect, please report it: a < b\n");
  EXPECT_NE(printed([]() -> int { throw std::bad_alloc(); }).find("memory does not suffice"), std::string::npos);
  EXPECT_NE(printed([]() -> int { throw 7; }).find("unknown kind"), std::string::npos);
}

}  // namespace
}  // namespace collinea
