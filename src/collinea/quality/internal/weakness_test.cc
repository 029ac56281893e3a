// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/weakness.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "collinea/block/subject_label.h"
#include "collinea/quality/additional_choice.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ExamineOptions with_covariances(Calibration calibration = Calibration::kNone) {
  return {.adjust = {.calibration = calibration, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

std::vector<Finding> weaknesses_of(const Block& block, const ExamineOptions& options, const AdjustScope& scope = {}) {
  const auto adjusted = examine(block, scope, options, {});
  EXPECT_TRUE(adjusted) << adjusted.error().message;
  return adjusted ? adjusted->weaknesses : std::vector<Finding>{};
}

std::string all_of(const std::vector<Finding>& weaknesses, const Block& block) {
  std::string text;
  for (const Finding& weak : weaknesses) text += label_of(weak, block) + "\n";
  return text;
}

// The one with that code must have such a label and name a remedy.
void expect_named(const Block& block, const std::vector<Finding>& weaknesses, FindingCode code,
                  const std::string& label) {
  const auto its = std::find_if(weaknesses.begin(), weaknesses.end(), [&](const auto& w) { return w.code == code; });
  ASSERT_NE(its, weaknesses.end()) << word_of(code) << " is missing:\n" << all_of(weaknesses, block);
  EXPECT_NE(label_of(*its, block).find(label), std::string::npos) << all_of(weaknesses, block);
  EXPECT_FALSE(its->remedies.empty());
}

// Of the weak rotations one is about a level axis of that azimuth.
void expect_level_axis(const Block& block, const std::vector<Finding>& weaknesses, double azimuth_deg) {
  const auto its = std::find_if(weaknesses.begin(), weaknesses.end(),
                                [](const auto& w) { return w.code == FindingCode::kWeakRotation; });
  ASSERT_NE(its, weaknesses.end()) << all_of(weaknesses, block);
  EXPECT_NEAR(its->figure(FigureName::kAzimuth).value_or(kInfinity), azimuth_deg, 0.5);
  EXPECT_LT(its->figure(FigureName::kSteepness).value_or(kInfinity), 0.3);
  EXPECT_FALSE(its->remedies.empty());
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
  const auto measure = [&](auto& seen, const Eigen::Vector3d& position) {
    const auto pixel = project(block.camera_of(seen.image), pose_of(block, seen.image) * position);
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
  for (auto [id, pose] : oriented_images(block)) {
    Eigen::Vector3d centre = centre_of(pose);
    centre.z() = 60;
    pose = {Eigen::Quaterniond(0, 1, 0, 0), {}};
    pose.translation = -(pose.rotation * centre);
    block.images.at(id).position.reset();
    set_pose(block, id, pose);
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
    EXPECT_EQ(all_of(weaknesses_of(block, with_covariances(Calibration::kBrown)), block), "");
    for (auto& [id, image] : block.images) image.position.reset();
    EXPECT_EQ(all_of(weaknesses_of(block, with_covariances(Calibration::kFocalRadial)), block), "");
  }
}

// A narrow view from above: each projection centre goes with the tilt of its image, and is known ten times worse in
// plan than the ground, to which control all over the block gives scale, azimuth and level.
Block narrow_view(int rows, std::uint64_t seed) {
  Block block = test_block({.rows = rows,
                            .columns = 6,
                            .points = 500,
                            .spacing_m = 4,
                            .relief_m = 2,
                            .sigma_px = 0.3,
                            .control = 30,
                            .control_sigma_m = 0.003,
                            .tilt_rad = 0.02,
                            .seed = seed});
  const Camera& camera = block.cameras.begin()->second;
  const auto outside = [&](const auto& seen) {
    return (seen.pixel - Eigen::Vector2d(camera.params[Camera::kCx], camera.params[Camera::kCy])).norm() >
           0.17 * camera.width_px;
  };
  std::erase_if(block.observations, outside);
  std::erase_if(block.control_observations, outside);
  return block;
}

TEST(Weakness, CentresThatGoWithTheirTiltsAreNoMotionOfTheBlock) {
  for (const int rows : {1, 2})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Block block = narrow_view(rows, seed);
      EXPECT_EQ(all_of(weaknesses_of(block, with_covariances()), block), "") << rows << " strips, seed " << seed;
    }
}

// The same block, its plan held in one corner and its heights everywhere; all control is at one height, so that these
// tell nothing of the scale.
TEST(Weakness, PlanHeldInACornerLeavesScaleAndAzimuthWeak) {
  Block block = narrow_view(2, 1);
  int corner = 0;
  for (auto& [id, control] : block.control) {
    control.role = ControlRole::kControl;
    control.position_in_world.z() = 0;
    if (corner < 4) {
      control.position_in_world.head<2>() = Eigen::Vector2d(5 + 0.2 * (corner % 2), 3 + 0.2 * (corner / 2));
      ++corner;
    } else {
      control.sigma_m.head<2>().setConstant(kInfinity);
    }
  }
  measure_again(block, 0.3);
  const auto found = weaknesses_of(block, with_covariances());
  expect_named(block, found, FindingCode::kWeakScale, "sigma_scale");
  const auto turn = std::find_if(found.begin(), found.end(),
                                 [](const Finding& weak) { return weak.code == FindingCode::kWeakRotation; });
  ASSERT_NE(turn, found.end()) << all_of(found, block);
  EXPECT_GT(turn->figure(FigureName::kSteepness).value_or(0), 0.9);
}

TEST(Weakness, NoDatum) {
  const Block block = test_block(usual());
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kNoDatum, "degrees_of_freedom 7");
}

TEST(Weakness, NoScale) {  // position and attitude are known
  Block block = test_block(usual(6));
  keep_control(block, 1);
  AdjustScope scope;
  for (const auto& [id, pose] : oriented_images(block))
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.01};
  const auto found = weaknesses_of(block, with_covariances(), scope);
  expect_named(block, found, FindingCode::kDatumDefect, "scale of block");
  expect_named(block, found, FindingCode::kDatumDefect, "rotation of block");
}

TEST(Weakness, OneControlPoint) {
  Block block = test_block(usual(6));
  keep_control(block, 1);
  const auto found = weaknesses_of(block, with_covariances());
  expect_named(block, found, FindingCode::kDatumDefect, "scale of block, attitude of block");
  expect_named(block, found, FindingCode::kDatumDefect, "control_point gcp0;");
}

TEST(Weakness, TwoControlPoints) {
  Block block = test_block(usual(6));
  keep_control(block, 2);
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kDatumDefect,
               "rotation of block, control_point gcp0, control_point gcp1");
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
  expect_level_axis(block, weaknesses_of(block, with_covariances()), 90);
}

TEST(Weakness, ControlWithoutHeights) {
  Block block = test_block(usual(9));
  for (auto& [id, control] : block.control) control.sigma_m.z() = kInfinity;
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kDatumDefect, "height of block");
}

TEST(Weakness, HeightsOnly) {
  Block block = test_block(usual(9));
  for (auto& [id, control] : block.control) control.sigma_m.head<2>().setConstant(kInfinity);
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kDatumDefect, "plan of block");
}

TEST(Weakness, FocalLengthAndHeightOverLevelGround) {
  const Block block = flat_nadir(9);
  const auto found = weaknesses_of(block, with_covariances(Calibration::kFocal));
  expect_named(block, found, FindingCode::kFocalAndHeight, "distance of camera test");
}

TEST(Weakness, PrincipalPointAndPositionOverLevelGround) {
  expect_named(flat_nadir(9), weaknesses_of(flat_nadir(9), with_covariances(Calibration::kBrown)),
               FindingCode::kCameraAndPose, "cx of camera test");
}

// A correlation for each parameter that is named; where none alone is like the motion, the strongest of all.
TEST(Weakness, AMixtureOfManyParametersHasItsStrongestCorrelation) {
  int each = 0, together = 0;
  for (const auto& [set, word, meaning] : kAdditionalWords) {
    Block block = flat_nadir(0, 1, 5);
    AdjustScope scope;
    for (auto& [id, camera] : block.cameras) {
      camera.additional = set;
      scope.camera_sigmas[id] = with_additional(calibration_sigmas(Calibration::kBrown, camera), camera, {}).value();
    }
    for (const Finding& found : weaknesses_of(block, with_covariances(Calibration::kBrown), scope)) {
      if (found.code != FindingCode::kFocalAndHeight && found.code != FindingCode::kCameraAndPose) continue;
      const auto correlations = found.figures_of(FigureName::kCorrelation);
      ASSERT_FALSE(correlations.empty()) << word;
      EXPECT_EQ(correlations.size(), std::max<std::size_t>(1, found.subjects.size() - 1)) << word;
      const bool alone = found.subjects.size() > 1;
      for (const double one : correlations) EXPECT_EQ(std::abs(one) > 0.8, alone) << word << " " << one;
      EXPECT_GT(std::abs(correlations.front()), 0.1) << word;
      ++(alone ? each : together);
    }
  }
  EXPECT_GT(each, 0);
  EXPECT_GT(together, 0);
}

TEST(Weakness, K3FromTheMiddleOfTheImages) {
  const Block block = flat_nadir(9, 0.13, 5);
  expect_named(block, weaknesses_of(block, with_covariances(Calibration::kBrown)), FindingCode::kParameterNotDetermined,
               "k3 of camera test");
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
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kScaleDrifts, "image IMG_");
}

TEST(Weakness, ImagesTurnedOnly) {
  Block block = test_block(usual(9));
  const Eigen::Vector3d position(20, 15, 60);
  for (auto [id, pose] : oriented_images(block)) {
    pose.translation = -(pose.rotation * position);
    set_pose(block, id, pose);
  }
  measure_again(block);
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kNoBase, "image IMG_0.jpg");
}

// Control in the images gives their positions to centimetres, and with them bases that are nothing but its errors.
TEST(Weakness, ImagesTurnedOnlyAmongControl) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    testing::TestBlockOptions options = usual(24);
    options.seed = seed;
    Block block = test_block(options);
    for (auto& [id, control] : block.control) control.role = ControlRole::kControl;
    const Eigen::Vector3d position(20, 15, 60);
    for (auto [id, pose] : oriented_images(block)) {
      pose.translation = -(pose.rotation * position);
      set_pose(block, id, pose);
    }
    measure_again(block);
    expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kNoBase, "image IMG_0.jpg");
  }
}

// Coarse positions, and a small object before them: the scale is uncertain, the distances among each other are not.
TEST(Weakness, ABlockOfUncertainScaleHasBases) {
  const Block block =
      test_block({.rows = 3, .columns = 4, .points = 150, .sigma_px = 0.5, .position_sigma_m = 30, .tilt_rad = 0.05});
  for (const Finding& weak : weaknesses_of(block, with_covariances())) EXPECT_NE(weak.code, FindingCode::kNoBase);
}

TEST(Weakness, ControlInACornerLeavesScaleAndTurnsWeak) {
  Block block = test_block({.rows = 3, .columns = 5, .points = 200, .sigma_px = 0.5, .control = 4});
  keep_control(block, 4);
  const Eigen::Vector3d corner(2, 2, 1);
  int number = 0;
  for (auto& [id, control] : block.control)
    control.position_in_world = corner + Eigen::Vector3d(number % 2, number / 2, 0.3 * (number % 3)), ++number;
  measure_again(block);
  const auto found = weaknesses_of(block, with_covariances());
  expect_named(block, found, FindingCode::kWeakScale, "sigma_scale");
  expect_named(block, found, FindingCode::kWeakRotation, "sigma_deg");
}

// The control of the other part does not help.
TEST(Weakness, AnotherPartsControlDoesNotCount) {
  Block block = test_block(usual(9));
  for (auto& [id, control] : block.control) control.role = ControlRole::kControl;
  // A second block a kilometre away with one control point of its own.
  Block other = test_block({.rows = 2, .columns = 3, .points = 80, .sigma_px = 0.5, .control = 2, .seed = 5});
  const Eigen::Vector3d away(1000, 0, 0);
  for (const auto& [id, pose] : oriented_images(other)) {
    const ImageId image{id.value + 500};
    block.images[image] = other.images.at(id);
    block.images[image].file = "far_" + block.images[image].file;
    set_pose(block, image, {pose.rotation, pose.translation - pose.rotation * away});
  }
  for (const auto& [id, point] : other.points)
    block.points[{id.value + 5000}].position_in_world = point.position_in_world + away;
  for (Observation seen : other.observations) {
    seen.image.value += 500;
    seen.point.value += 5000;
    block.observations.push_back(seen);
  }
  ControlPoint lone = other.control.at({0});
  lone.name = "lone";
  lone.position_in_world += away;
  block.control[{700}] = lone;
  ControlPoint blank = other.control.at({1});
  blank.name = "blank";
  blank.position_in_world += away;
  blank.sigma_m.setConstant(kInfinity);
  block.control[{701}] = blank;
  for (ControlObservation seen : other.control_observations) {
    seen.image.value += 500;
    seen.point.value += 700;
    block.control_observations.push_back(seen);
  }
  const auto found = weaknesses_of(block, with_covariances());
  expect_named(block, found, FindingCode::kDatumDefect, "control_point lone");
}

// Every other image of a second camera.
Block two_cameras(Block block) {
  block.cameras[{2}] = block.cameras.at({1});
  block.cameras.at({2}).name = "second";
  for (auto& [id, image] : block.images)
    if (id.value % 2) image.camera = {2};
  return block;
}

// Both are calibrated: their errors are as long as their covariances say, within four deviations of 80 blocks, and
// nothing is weak.
TEST(Weakness, TwoCalibratedCamerasAreAsGoodAsStated) {
  constexpr int kBlocks = 80;
  const std::vector<int> free = {Camera::kF, Camera::kK1, Camera::kK2};
  double sum[3] = {}, squares[3] = {};
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block truth = two_cameras(test_block({.rows = 3, .columns = 4, .points = 90, .seed = seed}));
    AdjustScope scope;
    const Block block = testing::measured_anew(truth, scope, seed);
    Random random(seed, 5);
    scope.first_cameras.at({2}).params[Camera::kF] += 50 * random.normal();
    for (auto& [id, camera] : scope.first_cameras) {
      camera.params[Camera::kK1] += 0.2 * random.normal();
      camera.params[Camera::kK2] += 0.5 * random.normal();
    }
    const auto adjusted = examine(block, scope, with_covariances(Calibration::kFocalRadial), {});
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    EXPECT_EQ(all_of(adjusted->weaknesses, block), "");
    ASSERT_EQ(adjusted->camera_covariance.size(), 2u);
    double both = 0;
    for (const auto& [id, camera] : adjusted->cameras) {
      Eigen::Vector3d error;
      Eigen::Matrix3d covariance;
      for (int a = 0; a < 3; ++a) {
        error[a] = camera.params[free[a]] - truth.cameras.at(id).params[free[a]];
        for (int b = 0; b < 3; ++b) covariance(a, b) = adjusted->camera_covariance.at(id)(free[a], free[b]);
      }
      const double length = error.dot(covariance.inverse() * error) / 3 / std::pow(adjusted->sigma0, 2);
      sum[id.value] += length;
      squares[id.value] += length * length;
      both += length / 2;
    }
    sum[0] += both;
    squares[0] += both * both;
  }
  for (int k = 0; k < 3; ++k) {
    const double mean = sum[k] / kBlocks, deviation = std::sqrt((squares[k] / kBlocks - mean * mean) / kBlocks);
    EXPECT_NEAR(mean, 1, 4 * deviation) << k;
    EXPECT_LT(4 * deviation, 0.5) << k;
  }
}

TEST(Weakness, OfTwoCamerasTheWeakOneIsNamed) {
  Block block = two_cameras(test_block(usual(9)));
  const Camera& camera = block.cameras.at({2});
  const auto beside = [&](const auto& seen) {  // the middle of its images alone
    return block.images.at(seen.image).camera == CameraId{2} &&
           (seen.pixel - Eigen::Vector2d(camera.params[Camera::kCx], camera.params[Camera::kCy])).norm() >
               0.15 * camera.width_px;
  };
  std::erase_if(block.observations, beside);
  std::erase_if(block.control_observations, beside);
  const auto found = weaknesses_of(block, with_covariances(Calibration::kBrown));
  expect_named(block, found, FindingCode::kParameterNotDetermined, "of camera second");
  EXPECT_EQ(all_of(found, block).find("camera test"), std::string::npos) << all_of(found, block);
}

TEST(Weakness, AStripWithPositionsAlone) {
  const Block block =
      test_block({.rows = 1, .columns = 10, .points = 300, .sigma_px = 0.5, .position_sigma_m = 0.5, .tilt_rad = 0.02});
  expect_level_axis(block, weaknesses_of(block, with_covariances()), 90);
}

TEST(Weakness, ImagesThatHangOnTooLittle) {
  Block block = test_block(usual(9));
  const ImageId lonely{12};
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) { return seen.image == lonely; });
  int kept = 0;
  std::erase_if(block.observations, [&](const Observation& seen) { return seen.image == lonely && kept++ >= 2; });
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kImagesLeftOut, "IMG_2.jpg");
  block = test_block(usual(9));
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) { return seen.image == lonely; });
  std::vector<double> from_corner;
  for (const Observation& seen : block.observations)
    if (seen.image == lonely) from_corner.push_back(seen.pixel.norm());
  std::sort(from_corner.begin(), from_corner.end());
  std::erase_if(block.observations, [&](const Observation& seen) {
    return seen.image == lonely && seen.pixel.norm() > from_corner[4];  // five points are left
  });
  expect_named(block, weaknesses_of(block, with_covariances()), FindingCode::kWeakImages, "IMG_2.jpg");
}

TEST(Weakness, ASingleImageIsRefusedWithItsRemedy) {
  Block block = test_block(usual());
  std::erase_if(block.observations, [](const Observation& seen) { return seen.image != ImageId{10}; });
  const auto refused = examine(block, {}, with_covariances(), {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
  EXPECT_NE(refused.error().message.find("second image"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace collinea
