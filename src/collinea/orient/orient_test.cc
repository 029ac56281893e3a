// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"

#include "collinea/orient/additional.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/block/world_frame.h"
#include "collinea/orient/internal/test_pairs.h"

namespace collinea {
namespace {

using testing::centre_rms_m;
using testing::kPixel_m;
using testing::Matched;
using testing::matched;
using testing::small_block;
using testing::straight_strip;
using testing::test_block;

Matched on_the_map(const Block& block) {
  Matched result = matched(block);
  result.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  return result;
}

// As the next adjustment sees it.
Examined examined(const Orientation& found) {
  auto adjusted = examine(found.block, found.scope, {.adjust = found.options}, {});
  EXPECT_TRUE(adjusted) << adjusted.error().message;
  return *std::move(adjusted);
}

Result<Orientation> orient(const Matched& input, const Run& run = {}) {
  return orient(input.setup, input.pairs, input.source(), {}, run);
}

bool mentions(const std::vector<Finding>& findings, FindingCode code) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& one) { return one.code == code; });
}

TEST(Orient, ExactMatchesGiveTheExactBlock) {
  const Matched input = matched(small_block(0));
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 8u);
  EXPECT_TRUE(found->alone.empty());
  EXPECT_TRUE(found->other_parts.empty());
  // Keypoints are stored as floats: rounding at pixel 2000 is 6e-5 px.
  EXPECT_LT(centre_rms_m(found->block, input.truth, true), 0.002 * kPixel_m);
  const Camera &camera = found->block.cameras.begin()->second, &exact = input.truth.cameras.begin()->second;
  EXPECT_NEAR(camera.focal_px(), exact.focal_px(), 0.01);
  EXPECT_NEAR(camera.params[Camera::kK1], exact.params[Camera::kK1], 1e-5);
}

// The block with noise of half a pixel; `bent`: and a lens with three pixels of what no lens polynomial says.
Block photographed(Block block, bool bent) {
  Camera& camera = block.cameras.begin()->second;
  if (bent) camera.additional = AdditionalSet::kEbner;
  for (std::size_t k = 0; k < count_of(camera.additional); ++k) camera.params[Camera::kParams + k] = k % 2 ? -3 : 2;
  Random random(7);
  const auto measure = [&](auto& seen, const Eigen::Vector3d& position) {
    const double du = random.normal(), dv = random.normal();
    const auto pixel = project(camera, pose_of(block, seen.image) * position);
    if (pixel) seen.pixel = *pixel + 0.5 * Eigen::Vector2d(du, dv);
  };
  for (Observation& seen : block.observations) measure(seen, block.points.at(seen.point).position_in_world);
  return block;
}

// Additional parameters take up what bends the images: the block that densify and ortho go on with has the errors of
// one without it.
TEST(Orient, AdditionalParametersUnbendTheImages) {
  const Matched straight = matched(photographed(small_block(0), false)),
                bent = matched(photographed(small_block(0), true));
  ASSERT_EQ(bent.setup.cameras.begin()->second.additional, AdditionalSet::kNone);
  const auto as_it_is = orient(straight), without = orient(bent),
             with = collinea::orient(bent.setup, bent.pairs, bent.source(), {.additional = AdditionalSet::kEbner}, {});
  ASSERT_TRUE(as_it_is && without && with) << with.error().message;
  EXPECT_EQ(with->block.cameras.begin()->second.additional, AdditionalSet::kEbner);
  const double best = centre_rms_m(as_it_is->block, straight.truth, true);
  // The same noise: that more is unknown costs something, but not half as much again.
  EXPECT_LT(centre_rms_m(with->block, bent.truth, true), 1.5 * best);
  EXPECT_GT(centre_rms_m(without->block, bent.truth, true), 3 * kPixel_m);  // by which the image is bent
  EXPECT_TRUE(mentions(additional_findings(with->block, examined(*with)), FindingCode::kAdditionalSignificant));
}

TEST(Orient, WithoutReadableImagesNothingIsMeasuredAnew) {
  const Matched input = matched(small_block());
  const auto unreadable = [](ImageId) -> Result<GreyImage> { return fail(Errc::kNotFound, "no image"); };
  const auto found = orient(input.setup, input.pairs, input.source(), {.remeasure = true}, {}, unreadable);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(centre_rms_m(found->block, input.truth, true), 2 * kPixel_m);
  for (const Observation& seen : found->block.observations) {
    const Keypoint& keypoint = input.keypoints.at(seen.image).at(seen.feature);
    EXPECT_EQ(seen.pixel, Eigen::Vector2d(keypoint.x, keypoint.y));
  }
}

TEST(Orient, NoiseOfHalfAPixelMovesCentresByAboutAPixel) {
  const Matched input = matched(small_block());
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 8u);
  EXPECT_LT(centre_rms_m(found->block, input.truth, true), 2 * kPixel_m);
  EXPECT_NEAR(found->adjusted.sigma0, 1, 0.1);  // sigma_px of the options is the noise
  EXPECT_GT(found->block.points.size(), 400u);
}

// e' C^-1 e of f, cx, cy is chi-squared with three degrees of freedom: the mean of 40 lies between 1.89 and 4.44 in 999
// of 1000 cases. With the principal point fixed in the middle, off by 6 and 4 px, f alone would be wrong by tens of its
// sigmas.
TEST(Orient, TheCameraOfASmallBlockIsAsGoodAsItsSigmasSay) {
  constexpr int kBlocks = 40;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Matched input = matched(test_block({.rows = 2, .columns = 3, .points = 150, .sigma_px = 0.5, .seed = seed}));
    const auto found = orient(input);
    ASSERT_TRUE(found) << found.error().message;
    const Camera &camera = found->block.cameras.begin()->second, &exact = input.truth.cameras.begin()->second;
    const Eigen::Vector3d error(camera.params[Camera::kF] - exact.params[Camera::kF],
                                camera.params[Camera::kCx] - exact.params[Camera::kCx],
                                camera.params[Camera::kCy] - exact.params[Camera::kCy]);
    const Examined adjusted = examined(*found);
    const Eigen::Matrix3d covariance = adjusted.camera_covariance.begin()->second.topLeftCorner<3, 3>();
    sum += error.dot(covariance.inverse() * error) / kBlocks;
  }
  EXPECT_GT(sum, 1.89);
  EXPECT_LT(sum, 4.44);
}

TEST(Orient, ObservationsOfTheResultAreSortedAndBelongToPointsAndPoses) {
  const auto found = orient(matched(small_block()));
  ASSERT_TRUE(found) << found.error().message;
  const Block& block = found->block;
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const Observation& seen = block.observations[i];
    ASSERT_TRUE(block.points.contains(seen.point));
    ASSERT_TRUE(is_oriented(block, seen.image));
    if (i == 0) continue;
    const Observation& before = block.observations[i - 1];
    ASSERT_TRUE(std::pair(before.point, before.image) < std::pair(seen.point, seen.image));
  }
  EXPECT_EQ(found->adjusted.residuals_px.size(), block.observations.size());
}

TEST(Orient, WrongMatchesAreLeftOut) {
  Matched input = matched(small_block());
  Random random(5);
  for (ImagePair& pair : input.pairs)
    for (Match& match : pair.matches)
      if (random.uniform() < 0.08)
        match.second = random.below(static_cast<std::uint32_t>(input.keypoints.at(pair.second).size()));
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 8u);
  EXPECT_LT(centre_rms_m(found->block, input.truth, true), 2 * kPixel_m);
  for (const Eigen::Vector2d& residual : found->adjusted.residuals_px) EXPECT_LT(residual.norm(), 3.5);
}

TEST(Orient, TheLargestOfTwoPartsIsKeptAndTheOtherIsNamed) {
  const Block large = small_block();
  const Block small = test_block({.rows = 1, .columns = 4, .points = 200, .sigma_px = 0.5, .seed = 7});
  const auto found = orient(matched(testing::side_by_side(large, small)));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 8u);
  ASSERT_EQ(found->other_parts.size(), 1u);
  EXPECT_EQ(found->other_parts[0].size(), 4u);
  for (const ImageId image : found->other_parts[0]) EXPECT_GE(image.value, 1000u);
  EXPECT_TRUE(found->alone.empty());
  EXPECT_TRUE(mentions(found->findings, FindingCode::kPartApart));
}

// The pair with the most matches starts the first part, and the second, before the block of eight comes up.
TEST(Orient, StrongPairsThatHangTogetherWithNothingDoNotHideTheBlock) {
  const Block first = test_block({.rows = 1, .columns = 2, .points = 3000, .sigma_px = 0.5, .seed = 7});
  const Block second = test_block({.rows = 1, .columns = 2, .points = 2500, .sigma_px = 0.5, .seed = 8});
  const auto found = orient(matched(testing::side_by_side(testing::side_by_side(small_block(), first), second, 2000)));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 8u);
  EXPECT_TRUE(found->other_parts.empty());
  ASSERT_EQ(found->alone.size(), 4u);
  for (const ImageId image : found->alone) EXPECT_GE(image.value, 1000u);
}

TEST(Orient, AnImageThatMatchesNothingIsNamed) {
  Matched input = matched(small_block());
  input.setup.images[ImageId{77}] = {"stranger.jpg", input.setup.images.begin()->second.camera, "", {}, {}, 1};
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->alone, std::vector{ImageId{77}});
  EXPECT_TRUE(mentions(found->findings, FindingCode::kImagesAlone));
}

TEST(Orient, PositionsBringTheBlockToTheMap) {
  const Matched input = on_the_map(small_block(0.5, 0, 0.3));
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  EXPECT_EQ(found->gauge.positions, 8u);
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 3 * 0.3);
  EXPECT_NEAR(found->gsd_m, kPixel_m, 0.15 * kPixel_m);
}

TEST(Orient, ControlDecidesAgainstPositionsThatAreFarOff) {
  Matched input = on_the_map(small_block(0.5, 9, 0.3));
  for (auto& [id, image] : input.setup.images) image.position->position_in_world.z() += 40;  // another height system
  for (auto& [id, image] : input.setup.images) image.position->sigma_m.setConstant(3);
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  EXPECT_TRUE(found->gauge.by_control);
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 5 * kPixel_m);
}

TEST(Orient, CheckPointsAreComparedButDoNotTakePart) {
  const Matched input = on_the_map(small_block(0.5, 9));
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  int used = 0, compared = 0;
  for (const ControlDifference& control : found->adjusted.control) ++(control.used ? used : compared);
  EXPECT_EQ(used, 6);
  EXPECT_EQ(compared, 3);
  for (const ControlDifference& control : found->adjusted.control)
    EXPECT_LT(control.difference_m.norm(), 5 * kPixel_m) << input.setup.control.at(control.point).name;
}

TEST(Orient, AWronglySurveyedPointIsNamedAndNotUsed) {
  Matched input = on_the_map(small_block(0.5, 9));
  const ControlId wrong{4};
  ASSERT_EQ(input.setup.control.at(wrong).role, ControlRole::kControl);
  input.setup.control.at(wrong).position_in_world.x() += 2;
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->excluded_control, std::set{wrong});
  EXPECT_TRUE(mentions(found->findings, FindingCode::kControlPoint));
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 5 * kPixel_m);
}

TEST(Orient, ControlWithExchangedColumnsIsNamedAndUsedTheRightWayRound) {
  Matched input = on_the_map(small_block(0.5, 9, 0.3));
  const auto frame = world_frame(*input.setup.georeference);
  ASSERT_TRUE(frame);
  for (auto& [id, point] : input.setup.control) {
    point.position_in_map = frame->map_from_local(point.position_in_world);
    std::swap(point.position_in_map.x(), point.position_in_map.y());
    point.position_in_world = frame->local_from_map(point.position_in_map);  // wherever that is
  }
  ControlObservation& bad_mark = input.setup.control_observations[1];
  bad_mark.pixel.x() += 60;
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(mentions(found->findings, FindingCode::kControlAxesSwapped));
  EXPECT_TRUE(mentions(found->findings, FindingCode::kControlAxesExchanged));
  const auto named = std::count_if(found->findings.begin(), found->findings.end(), [](const Finding& finding) {
    return finding.code == FindingCode::kControlMeasurement;
  });
  EXPECT_EQ(named, 1);
  EXPECT_TRUE(found->gauge.by_control);
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 5 * kPixel_m);
}

TEST(Orient, SloppyMarksAreWeighedByWhatTheyShowAndTheCoordinatesAreNotBlamed) {
  Matched input = on_the_map(small_block(0.5, 9));
  Random random(6);
  for (ControlObservation& seen : input.setup.control_observations) {
    const double du = random.normal(), dv = random.normal();
    seen.pixel += 4 * Eigen::Vector2d(du, dv);  // stated: 0.5 px
  }
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(mentions(found->findings, FindingCode::kControlMeasurementSigma));
  EXPECT_FALSE(mentions(found->findings, FindingCode::kControlSigmaPlan));
  EXPECT_FALSE(mentions(found->findings, FindingCode::kControlSigmaHeight));
  EXPECT_FALSE(mentions(found->findings, FindingCode::kPositionsShifted));
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 10 * kPixel_m);  // marks err by 4 pixels
}

// The sigma that a finding states control is given, in plan or in height [m].
std::optional<double> sigma_stated(const std::vector<Finding>& findings, FindingCode code) {
  for (const Finding& finding : findings)
    if (finding.code == code) return finding.figure(FigureName::kSigma);
  return std::nullopt;
}

// Coordinates ten times worse than stated, and positions that all have an error of 1.2 m in common. Six control points
// less seven parameters leave eight coordinates in plan and three in height, so over eight blocks the root mean square
// of the sigma they show is known to 1 / sqrt(2 * 8 * 8), 9 %, and 1 / sqrt(2 * 8 * 3), 14 %: three of those. The
// estimated positions have errors of their own, far below those of control.
TEST(Orient, ControlThatIsWorseThanStatedGetsTheSigmaItShows) {
  constexpr int kBlocks = 8;
  constexpr double kStated_m = 0.01, kReal_m = 0.1;
  double plan = 0, height = 0, shift_m = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    Matched input = on_the_map(test_block({.rows = 2,
                                           .columns = 4,
                                           .points = 300,
                                           .sigma_px = 0.5,
                                           .position_sigma_m = 0.2,
                                           .control = 9,
                                           .seed = seed}));
    Random random(seed, 3);
    for (auto& [id, point] : input.setup.control) point.position_in_world += kReal_m * testing::normal3(random);
    for (auto& [id, image] : input.setup.images) {
      image.position->position_in_world += Eigen::Vector3d(1.2, 0, 0);
      image.position->sigma_m.setConstant(2);
    }
    const auto found = orient(input);
    ASSERT_TRUE(found) << found.error().message;
    const auto plan_m = sigma_stated(found->findings, FindingCode::kControlSigmaPlan);
    const double height_m = sigma_stated(found->findings, FindingCode::kControlSigmaHeight).value_or(kStated_m);
    ASSERT_TRUE(plan_m);
    plan += *plan_m * *plan_m / kBlocks;
    height += height_m * height_m / kBlocks;
    EXPECT_TRUE(mentions(found->findings, FindingCode::kPositionsShifted));
    const Examined adjusted = examined(*found);
    for (const ControlDifference& control : adjusted.control) {
      if (!control.used) continue;
      shift_m += control.difference_m.x() / (6 * kBlocks);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_LT(std::abs(control.difference_m[axis]), 4 * control.difference_sigma_m[axis]);
    }
  }
  EXPECT_NEAR(std::sqrt(plan) / kReal_m, 1, 0.27);
  EXPECT_NEAR(std::sqrt(height) / kReal_m, 1, 0.42);
  EXPECT_NEAR(shift_m, 0, 4 * kReal_m / std::sqrt(6.0 * kBlocks));  // control decides the position
}

// Plan ten times worse than stated, heights as stated: these are still believed.
TEST(Orient, ControlThatIsWrongInPlanIsBelievedInHeight) {
  Matched input = on_the_map(test_block(
      {.rows = 2, .columns = 4, .points = 300, .sigma_px = 0.5, .position_sigma_m = 0.2, .control = 9, .seed = 2}));
  Random random(4);
  std::map<ControlId, double> height_m;
  for (auto& [id, point] : input.setup.control) {
    point.position_in_world.head<2>() += 0.2 * testing::normal3(random).head<2>();
    height_m[id] = point.sigma_m.z();
  }
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(sigma_stated(found->findings, FindingCode::kControlSigmaPlan));
  EXPECT_FALSE(sigma_stated(found->findings, FindingCode::kControlSigmaHeight));
  for (const ControlDifference& control : found->adjusted.control)
    if (control.used) {
      EXPECT_LT(std::abs(control.difference_m.z()), 4 * height_m.at(control.point));
    }
}

TEST(Orient, WithoutControlOrPositionsTheGaugeIsLocalAndReadable) {
  const Matched input = matched(small_block());
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found->georeferenced);
  EXPECT_EQ(found->gauge, Gauge{});
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& [image, pose] : oriented_images(found->block)) middle += centre_of(pose) / 8;
  EXPECT_LT(middle.norm(), 0.1);
}

// One strip flown with the camera turned by a quarter: the right edge of its pixels is the lower edge of the image.
TEST(Orient, InTheFreeGaugeImagesStandAsTheyAreLookedAt) {
  for (const int orientation : {1, 6}) {
    Block strip = test_block({.rows = 1, .columns = 5, .points = 400, .sigma_px = 0.5, .seed = 3});
    for (auto& [id, image] : strip.images) image.orientation = orientation;
    const auto found = orient(matched(strip));
    ASSERT_TRUE(found) << found.error().message;
    Eigen::Vector3d down = Eigen::Vector3d::Zero();
    for (const auto& [image, pose] : oriented_images(found->block))
      down += pose.rotation.conjugate() * (orientation == 6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY());
    EXPECT_LT((down.normalized() + Eigen::Vector3d::UnitZ()).norm(), 1e-4) << orientation;
  }
}

TEST(Orient, TwoPositionsDoNotFixTheBlockAndThisIsStated) {
  Matched input = on_the_map(small_block(0.5, 0, 0.3));
  int kept = 0;
  for (auto& [id, image] : input.setup.images)
    if (++kept > 2) image.position.reset();
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found->georeferenced);
  EXPECT_TRUE(mentions(found->findings, FindingCode::kLocalGauge));
}

TEST(Orient, ASingleStripGetsItsTiltFromTheAttitudes) {
  const Matched input = on_the_map(straight_strip());
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  EXPECT_EQ(found->gauge.position_use, PositionUse::kOnLine);
  EXPECT_TRUE(mentions(found->findings, FindingCode::kPositionsOnLine));
  EXPECT_LT(centre_rms_m(found->block, input.truth, false), 2 * 3);
  for (const auto& [image, pose] : oriented_images(found->block))
    EXPECT_LT((pose.rotation.conjugate() * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 0.05)
        << image.value;
}

TEST(Orient, ASingleStripWithoutAttitudesKeepsItsOwnGauge) {
  Matched input = on_the_map(straight_strip());
  for (auto& [id, image] : input.setup.images) image.attitude.reset();
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found->georeferenced);
  EXPECT_TRUE(mentions(found->findings, FindingCode::kLocalGauge));
}

// A degree of error that all attitudes of a flight down have in common, in a random direction.
void write_attitudes(Block& block, Random& random) {
  const double x_deg = random.normal(), y_deg = random.normal();
  const AttitudePrior attitude{90, -90 + std::hypot(x_deg, y_deg), std::atan2(x_deg, y_deg) * 180 / std::numbers::pi};
  for (auto& [id, image] : block.images) image.attitude = attitude;
}

// e' C^-1 e of one pose is chi-squared with six degrees of freedom: the mean of 40 lies between 4.36 and 7.97 in 999 of
// 1000 cases. The same of the turn about the line of flight alone: between 0.42 and 1.90.
TEST(Orient, ASingleStripErrsAsItsSigmasSay) {
  constexpr int kStrips = 40;
  double pose_sum = 0, rotation_sum = 0;
  for (std::uint64_t seed = 1; seed <= kStrips; ++seed) {
    Block block = test_block({.rows = 1,
                              .columns = 8,
                              .points = 150,
                              .sigma_px = 0.5,
                              .position_sigma_m = 0.4,
                              .tilt_rad = 0,
                              .seed = seed});
    Random random(100 + seed);
    write_attitudes(block, random);
    const Matched input = on_the_map(block);
    const auto found = orient(input);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_TRUE(found->georeferenced);
    const ImageId middle{13};
    const Rigid3 &pose = pose_of(found->block, middle), &exact = pose_of(input.truth, middle);
    Eigen::Matrix<double, 6, 1> error;
    error << rotation_vector(pose.rotation.conjugate() * exact.rotation), centre_of(exact) - centre_of(pose);
    const Examined adjusted = examined(*found);
    const Matrix6d& covariance = adjusted.pose_covariance.at(middle);
    pose_sum += error.dot(covariance.ldlt().solve(error)) / kStrips;
    rotation_sum += error[0] * error[0] / covariance(0, 0) / kStrips;
    EXPECT_GT(std::sqrt(covariance(0, 0)), 0.005);  // 17 mrad of the attitudes, and what the positions add
  }
  EXPECT_GT(pose_sum, 4.36);
  EXPECT_LT(pose_sum, 7.97);
  EXPECT_GT(rotation_sum, 0.42);
  EXPECT_LT(rotation_sum, 1.90);
}

Matched without_heights(double sigma_m) {
  Matched input = on_the_map(small_block(0.5, 0, sigma_m));
  for (auto& [id, image] : input.setup.images) {
    image.position->position_in_world.z() = 0;
    image.position->sigma_m.z() = std::numeric_limits<double>::infinity();
  }
  return input;
}

double rotation_deg(const Orientation& found, const Block& truth, const Eigen::Vector3d& axis) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [image, pose] : oriented_images(found.block))
    mean += rotation_vector(pose.rotation.conjugate() * pose_of(truth, image).rotation) /
            static_cast<double>(count_oriented(found.block));
  return mean.dot(axis) * 180 / std::numbers::pi;
}

TEST(Orient, PositionsWithoutHeightsPlaceTheBlockInPlan) {
  const Matched input = without_heights(0.3);
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  EXPECT_EQ(found->gauge.positions, 8u);
  EXPECT_EQ(found->gauge.position_use, PositionUse::kPlan);
  EXPECT_NE(found->gauge.level, LevelSource::kNone);
  EXPECT_TRUE(mentions(found->findings, FindingCode::kHeightsRelative));
  for (const auto& [image, pose] : oriented_images(found->block))
    EXPECT_LT((centre_of(pose) - centre_of(pose_of(input.truth, image))).head<2>().norm(), 1) << image.value;
  EXPECT_NEAR(rotation_deg(*found, input.truth, Eigen::Vector3d::UnitZ()), 0, 1.5);
  // Each image is held up to 0.15 rad askew; eight of them say what is level.
  EXPECT_NEAR(rotation_deg(*found, input.truth, Eigen::Vector3d::UnitX()), 0, 9);
  EXPECT_NEAR(rotation_deg(*found, input.truth, Eigen::Vector3d::UnitY()), 0, 9);
  EXPECT_NEAR(found->gsd_m, kPixel_m, 0.1 * kPixel_m);
}

TEST(Orient, PositionsTooVagueToTellTheTiltLeaveItToTheImages) {
  const Matched input = on_the_map(small_block(0.5, 0, 9));
  const auto found = orient(input);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  EXPECT_NE(found->gauge.level, LevelSource::kNone);
  EXPECT_TRUE(std::any_of(found->findings.begin(), found->findings.end(), [](const Finding& one) {
    return one.code >= FindingCode::kLevelByEdges && one.code <= FindingCode::kLevelByAttitudes &&
           one.figure(FigureName::kSigmaAzimuth) > 0;
  }));
  EXPECT_NEAR(rotation_deg(*found, input.truth, Eigen::Vector3d::UnitX()), 0, 9);
  EXPECT_NEAR(rotation_deg(*found, input.truth, Eigen::Vector3d::UnitY()), 0, 9);
}

TEST(Orient, PositionsThatDoNotTellTheScaleDoNotPlaceTheBlock) {
  const auto found = orient(on_the_map(small_block(0.5, 0, 60)));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found->georeferenced);
}

TEST(Orient, NoPairsAreAnErrorInWords) {
  Matched input = matched(small_block());
  input.pairs.clear();
  const auto found = orient(input);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kIllPosed);
  EXPECT_NE(found.error().message.find("overlapping"), std::string::npos) << found.error().message;
}

TEST(Orient, ImagesOfARotationAloneAreAnErrorInWords) {
  Matched input = matched(small_block());
  for (ImagePair& pair : input.pairs) {
    pair.geometry = PairGeometry::kRotation;
    pair.median_parallax_rad = 0;
  }
  const auto found = orient(input);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kIllPosed);
  EXPECT_NE(found.error().message.find("different positions"), std::string::npos) << found.error().message;
}

TEST(Orient, ItStopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const auto found = orient(matched(small_block()), {.stop = stop.get_token()});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kCancelled);
}

TEST(Orient, AFailureToReadKeypointsIsHandedOn) {
  const Matched input = matched(small_block());
  const KeypointSource broken = [](ImageId) -> Result<std::vector<Keypoint>> {
    return fail(Errc::kBadFormat, "torn page");
  };
  const auto found = orient(input.setup, input.pairs, broken, {}, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kBadFormat);
}

TEST(Orient, TheNumberOfThreadsDoesNotChangeABit) {
  const Matched input = on_the_map(small_block(0.5, 9, 0.3));
  const auto one = orient(input, {.threads = 1}), three = orient(input, {.threads = 3});
  ASSERT_TRUE(one && three);
  ASSERT_EQ(count_oriented(one->block), count_oriented(three->block));
  for (const auto& [image, pose] : oriented_images(one->block)) {
    EXPECT_EQ(pose.rotation.coeffs(), pose_of(three->block, image).rotation.coeffs());
    EXPECT_EQ(pose.translation, pose_of(three->block, image).translation);
  }
  ASSERT_EQ(one->block.points.size(), three->block.points.size());
  for (const auto& [id, point] : one->block.points)
    EXPECT_EQ(point.position_in_world, three->block.points.at(id).position_in_world);
  EXPECT_EQ(one->block.cameras.begin()->second.params, three->block.cameras.begin()->second.params);
  EXPECT_EQ(one->adjusted.sigma0, three->adjusted.sigma0);
}

}  // namespace
}  // namespace collinea
