// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/weakness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

using testing::test_block;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

AdjustOptions with_covariances(const std::string& calibration = "none") {
  return {.calibration = calibration, .loss = "none", .position_loss = "none", .covariances = true};
}

std::vector<Weakness> weaknesses_of(const Block& block, const AdjustOptions& options, const AdjustScope& scope = {}) {
  const auto adjusted = adjust(block, scope, options, {});
  EXPECT_TRUE(adjusted) << adjusted.error().message;
  return adjusted ? adjusted->weaknesses : std::vector<Weakness>{};
}

std::string all_of(const std::vector<Weakness>& weaknesses) {
  std::string text;
  for (const Weakness& weak : weaknesses) text += weak.code + ": " + weak.what + " | " + weak.cure + "\n";
  return text;
}

// The one with that code must say `words` and name a cure.
void expect_named(const std::vector<Weakness>& weaknesses, const std::string& code, const std::string& words) {
  const auto its = std::find_if(weaknesses.begin(), weaknesses.end(), [&](const auto& w) { return w.code == code; });
  ASSERT_NE(its, weaknesses.end()) << code << " is missing:\n" << all_of(weaknesses);
  EXPECT_NE(its->what.find(words), std::string::npos) << all_of(weaknesses);
  EXPECT_FALSE(its->cure.empty());
}

testing::TestBlockOptions usual(int control = 0) {
  return {.rows = 3, .columns = 4, .points = 150, .sigma_px = 0.5, .control = control};
}

void keep_control(Block& block, std::size_t count) {
  std::set<ControlId> kept;
  for (auto& [id, control] : block.control)
    if (kept.size() < count) {
      kept.insert(id);
      control.role = ControlRole::kControl;
    }
  std::erase_if(block.control, [&](const auto& one) { return !kept.contains(one.first); });
  std::erase_if(block.control_observations, [&](const auto& seen) { return !kept.contains(seen.point); });
}

// Measures everything anew where poses and points are now.
void measure_again(Block& block, double sigma_px = 0.5) {
  Random random(8);
  const auto measure = [&](auto& seen, const Eigen::Vector3d& place) {
    const auto pixel = project(block.camera_of(seen.image), block.cam_from_world.at(seen.image) * place);
    const double du = random.normal(), dv = random.normal();
    if (pixel && inside(block.camera_of(seen.image), *pixel))
      seen.pixel = *pixel + sigma_px * Eigen::Vector2d(du, dv);
    else
      seen.image = {};
  };
  for (Observation& seen : block.observations) measure(seen, block.points.at(seen.point).position_in_world);
  for (ControlObservation& seen : block.control_observations)
    measure(seen, block.control.at(seen.point).position_in_world);
  std::erase_if(block.observations, [](const Observation& seen) { return !seen.image.valid(); });
  std::erase_if(block.control_observations, [](const ControlObservation& seen) { return !seen.image.valid(); });
}

// Straight down over level ground, every strip the same way.
Block flat_nadir(int control, double middle = 1, double spacing_m = 15) {
  Block block = test_block({.rows = 3,
                            .columns = 5,
                            .points = 250,
                            .spacing_m = spacing_m,
                            .sigma_px = 0.5,
                            .position_sigma_m = 0.03,
                            .control = control,
                            .tilt_rad = 0});
  for (auto& [id, pose] : block.cam_from_world) {
    Eigen::Vector3d centre = centre_of(pose);
    centre.z() = 60;
    pose = {Eigen::Quaterniond(0, 1, 0, 0), {}};
    pose.translation = -(pose.rotation * centre);
    block.images.at(id).position.reset();
  }
  for (auto& [id, point] : block.points) point.position_in_world.z() = 0;
  for (auto& [id, point] : block.control) {
    point.position_in_world.z() = 0;
    point.role = ControlRole::kControl;
  }
  measure_again(block);
  const Camera& camera = block.cameras.begin()->second;
  const auto outside = [&](const auto& seen) {
    return (seen.pixel - Eigen::Vector2d(camera.params[Camera::kCx], camera.params[Camera::kCy])).norm() >
           middle * camera.width_px;
  };
  std::erase_if(block.observations, outside);
  std::erase_if(block.control_observations, outside);
  return block;
}

TEST(Weakness, HealthyBlocksHaveNone) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Block block = test_block({.rows = 4,
                              .columns = 5,
                              .points = 250,
                              .sigma_px = 0.5,
                              .position_sigma_m = 0.05,
                              .control = 9,
                              .seed = seed});
    EXPECT_EQ(all_of(weaknesses_of(block, with_covariances("brown"))), "");
    for (auto& [id, image] : block.images) image.position.reset();
    EXPECT_EQ(all_of(weaknesses_of(block, with_covariances("focal_radial"))), "");
  }
}

TEST(Weakness, NoDatum) {
  expect_named(weaknesses_of(test_block(usual()), with_covariances()), "no_datum", "free network");
}

TEST(Weakness, NoScale) {  // place and attitude are known
  Block block = test_block(usual(6));
  keep_control(block, 1);
  AdjustScope scope;
  for (const auto& [id, pose] : block.cam_from_world)
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.01};
  const auto found = weaknesses_of(block, with_covariances(), scope);
  expect_named(found, "datum_defect", "the scale");
  expect_named(found, "datum_defect", "the turn about the vertical");
}

TEST(Weakness, OneControlPoint) {
  Block block = test_block(usual(6));
  keep_control(block, 1);
  const auto found = weaknesses_of(block, with_covariances());
  expect_named(found, "datum_defect", "the scale and the attitude");
  expect_named(found, "datum_defect", "one control point: gcp0");
}

TEST(Weakness, TwoControlPoints) {
  Block block = test_block(usual(6));
  keep_control(block, 2);
  expect_named(weaknesses_of(block, with_covariances()), "datum_defect", "the line through gcp0 and gcp1");
}

TEST(Weakness, ControlOnALine) {
  Block block = test_block(usual(6));
  keep_control(block, 3);
  int number = 0;
  for (auto& [id, control] : block.control) {
    control.position_in_world = {5.0 + 15 * number, 20 + (number == 1 ? 0.2 : 0), 1};
    ++number;
  }
  measure_again(block);
  expect_named(weaknesses_of(block, with_covariances()), "weak_turn", "azimuth 90");
}

TEST(Weakness, ControlWithoutHeights) {
  Block block = test_block(usual(9));
  for (auto& [id, control] : block.control) control.sigma_m.z() = kInfinity;
  expect_named(weaknesses_of(block, with_covariances()), "datum_defect", "the height");
}

TEST(Weakness, HeightsOnly) {
  Block block = test_block(usual(9));
  for (auto& [id, control] : block.control) control.sigma_m.head<2>().setConstant(kInfinity);
  expect_named(weaknesses_of(block, with_covariances()), "datum_defect", "the place in plan");
}

TEST(Weakness, FocalLengthAndHeightOverLevelGround) {
  const auto found = weaknesses_of(flat_nadir(9), with_covariances("focal"));
  expect_named(found, "focal_and_height", "distance between images and object");
}

TEST(Weakness, PrincipalPointAndPlaceOverLevelGround) {
  expect_named(weaknesses_of(flat_nadir(9), with_covariances("brown")), "camera_and_pose", "cx");
}

TEST(Weakness, K3FromTheMiddleOfTheImages) {
  const Block block = flat_nadir(9, 0.13, 5);
  expect_named(weaknesses_of(block, with_covariances("brown")), "parameter_not_determined", "k3");
}

TEST(Weakness, ModelsWithoutTripleOverlap) {
  Block block = test_block({.rows = 1, .columns = 7, .points = 300, .sigma_px = 0.5, .control = 6});
  std::map<PointId, int> first;
  std::erase_if(block.observations, [&](const Observation& seen) {
    const auto its = first.try_emplace(seen.point, static_cast<int>(seen.image.value)).first;
    return static_cast<int>(seen.image.value) > its->second + 1;
  });
  std::map<ControlId, int> first_control;
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) {
    return seen.image.value > 11;  // all control in the first pair
  });
  expect_named(weaknesses_of(block, with_covariances()), "scale_drifts", "triple overlap");
}

TEST(Weakness, ImagesTurnedOnly) {
  Block block = test_block(usual(9));
  const Eigen::Vector3d place(20, 15, 60);
  for (auto& [id, pose] : block.cam_from_world) pose.translation = -(pose.rotation * place);
  measure_again(block);
  expect_named(weaknesses_of(block, with_covariances()), "no_base", "turned only");
}

TEST(Weakness, AStripWithPositionsAlone) {
  const Block block =
      test_block({.rows = 1, .columns = 10, .points = 300, .sigma_px = 0.5, .position_sigma_m = 0.5, .tilt_rad = 0.02});
  expect_named(weaknesses_of(block, with_covariances()), "weak_turn", "azimuth 90");
}

TEST(Weakness, ImagesThatHangOnTooLittle) {
  Block block = test_block(usual(9));
  const ImageId lonely{12};
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) { return seen.image == lonely; });
  int kept = 0;
  std::erase_if(block.observations, [&](const Observation& seen) { return seen.image == lonely && kept++ >= 2; });
  expect_named(weaknesses_of(block, with_covariances()), "images_left_out", "IMG_2.jpg");
  block = test_block(usual(9));
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) { return seen.image == lonely; });
  std::vector<double> from_corner;
  for (const Observation& seen : block.observations)
    if (seen.image == lonely) from_corner.push_back(seen.pixel.norm());
  std::sort(from_corner.begin(), from_corner.end());
  std::erase_if(block.observations, [&](const Observation& seen) {
    return seen.image == lonely && seen.pixel.norm() > from_corner[4];  // five points are left
  });
  expect_named(weaknesses_of(block, with_covariances()), "weak_images", "IMG_2.jpg");
}

TEST(Weakness, ASingleImageIsRefusedWithItsCure) {
  Block block = test_block(usual());
  std::erase_if(block.observations, [](const Observation& seen) { return seen.image != ImageId{10}; });
  const auto refused = adjust(block, {}, with_covariances(), {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
  EXPECT_NE(refused.error().message.find("second image"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace collinea
