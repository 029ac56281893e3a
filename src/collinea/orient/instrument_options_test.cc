// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/instrument_options.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

// One camera, one image with a position.
Block with_position() {
  Block block;
  block.cameras[CameraId{1}];
  block.images[ImageId{1}].camera = CameraId{1};
  block.images[ImageId{1}].position.emplace();
  return block;
}

TEST(InstrumentOptions, ALeverArmIsGivenOrToBeFound) {
  AdjustScope scope;
  ASSERT_TRUE(add_instruments(with_position(), {.lever_arm = "0.02, -0.05,-0.19"}, scope));
  EXPECT_EQ(scope.lever_arms.at({1}).antenna_in_cam_m, Eigen::Vector3d(0.02, -0.05, -0.19));
  EXPECT_TRUE(scope.lever_arms.at({1}).sigma_m.isZero(0));
  ASSERT_TRUE(add_instruments(with_position(), {.lever_arm = LeverArmWord::kEstimate}, scope));
  EXPECT_TRUE(scope.lever_arms.at({1}).antenna_in_cam_m.isZero(0));
  EXPECT_FALSE(scope.lever_arms.at({1}).sigma_m.array().isFinite().any());
}

TEST(InstrumentOptions, NoneAndAnEmptyTextAreNoLeverArm) {
  for (const InstrumentOptions& asked :
       {InstrumentOptions{}, InstrumentOptions{.lever_arm = "none"}, InstrumentOptions{.lever_arm = ""}}) {
    EXPECT_FALSE(has_lever_arm(asked));
    AdjustScope scope;
    ASSERT_TRUE(add_instruments(with_position(), asked, scope));
    EXPECT_TRUE(scope.lever_arms.empty());
  }
}

TEST(InstrumentOptions, ATextThatIsNoLeverArmIsRefusedByTheNameOfTheOption) {
  for (const char* text : {"0.1", "0,0", "0,0,0,0", "0,0,inf", "guess"}) {
    const auto checked = check_instruments({.lever_arm = text});
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().code, Errc::kBadInput);
    EXPECT_EQ(checked.error().message, "lever_arm = \"" + std::string(text) +
                                           "\": give x,y,z in metres (right, down, forward in the camera), estimate "
                                           "or none");
    EXPECT_EQ(checked.error().options, std::vector{OptionName{"lever_arm"}});
  }
}

}  // namespace
}  // namespace collinea
