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
  for (const char* text : {"0.1", "0,0", "0,0,0,0", "0,0,inf", "guess", "wide:", ":0,0,1", "wide:0,0,1;", "wide:1,2",
                           "0,0,1;0,0,2", "wide:0,0,1; wide:0,0,2"}) {
    const auto checked = check_instruments({.lever_arm = text});
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().code, Errc::kBadInput);
    EXPECT_EQ(checked.error().message, "lever_arm = \"" + std::string(text) +
                                           "\": give x,y,z in metres (right, down, forward in the camera), estimate "
                                           "or none, once for all cameras or for each: NAME:x,y,z; NAME:estimate");
    EXPECT_EQ(checked.error().options, std::vector{OptionName{"lever_arm"}});
  }
}

// Three cameras with a position each; one has a colon in its name.
Block with_cameras() {
  Block block;
  for (const auto& [number, name] : {std::pair(1u, "wide"), std::pair(2u, "tele: 85 mm"), std::pair(3u, "other")}) {
    block.cameras[CameraId{number}].name = name;
    block.images[ImageId{number}].camera = CameraId{number};
    block.images[ImageId{number}].position.emplace();
  }
  return block;
}

TEST(InstrumentOptions, EachCameraMayHaveItsOwnLeverArm) {
  AdjustScope scope;
  ASSERT_TRUE(add_instruments(with_cameras(), {.lever_arm = "wide:0.1,0,-0.3; tele: 85 mm: estimate"}, scope));
  ASSERT_EQ(scope.lever_arms.size(), 2u);
  EXPECT_EQ(scope.lever_arms.at({1}).antenna_in_cam_m, Eigen::Vector3d(0.1, 0, -0.3));
  EXPECT_TRUE(scope.lever_arms.at({1}).sigma_m.isZero(0));
  EXPECT_FALSE(scope.lever_arms.at({2}).sigma_m.array().isFinite().any());
  scope = {};
  ASSERT_TRUE(add_instruments(with_cameras(), {.lever_arm = "wide:none; 0,0,0.5; other:0,0,0.7"}, scope));
  ASSERT_EQ(scope.lever_arms.size(), 2u);
  EXPECT_EQ(scope.lever_arms.at({2}).antenna_in_cam_m.z(), 0.5);
  EXPECT_EQ(scope.lever_arms.at({3}).antenna_in_cam_m.z(), 0.7);
}

TEST(InstrumentOptions, ALeverArmOfACameraThatIsNotThereIsRefusedByItsName) {
  AdjustScope scope;
  const auto added = add_instruments(with_cameras(), {.lever_arm = "wid:0.1,0,-0.3"}, scope);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, Errc::kBadInput);
  EXPECT_NE(added.error().message.find("\"wid\""), std::string::npos) << added.error().message;
  EXPECT_EQ(added.error().options, std::vector{OptionName{"lever_arm"}});
}

}  // namespace
}  // namespace collinea
