// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/restitution/test_stereo.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

struct Strip {
  Block block;
  std::map<ImageId, std::vector<std::size_t>> observations = {};
  PoseCovariances poses = {};
  [[nodiscard]] MarkingBlock marking() const { return {block, observations, poses}; }
};

Strip strip_of(int images, double overlap) {
  SurveyOptions options = testing::strip_of_three();
  options.images_per_strip = images;
  options.forward_overlap = overlap;
  return {make_survey(options)->block};
}

Vector3d middle_of(const Strip& strip) {
  Vector3d sum = Vector3d::Zero();
  const auto images = oriented_images(strip.block);
  for (const OrientedImage& one : images) sum += centre_of(one.cam_from_world);
  sum /= double(images.size());
  sum.z() = 0;
  return sum;
}

TEST(StereoChoices, TheBestHasTheSmallestStandardDeviationOfTheHeight) {
  const Strip strip = strip_of(6, 0.85);
  const Vector3d position = middle_of(strip);
  const auto choices = stereo_choices(strip.marking(), position);
  ASSERT_GE(choices.size(), 4u);
  for (std::size_t i = 1; i < choices.size(); ++i)
    EXPECT_LE(*choices[i - 1].sigma_height_m, kEqualSigma * *choices[i].sigma_height_m);
  for (const StereoChoice& one : choices) {
    EXPECT_GE(one.convergence_rad, kLeastConvergence_rad);
    EXPECT_LE(one.convergence_rad, kMostConvergence_rad);
    for (const ImageId image : one.images) {
      const Camera& camera = strip.block.camera_of(image);
      const auto pixel = project(camera, pose_of(strip.block, image) * position);
      ASSERT_TRUE(pixel);
      for (int axis = 0; axis < 2; ++axis) {
        const double size = axis == 0 ? camera.width_px : camera.height_px;
        EXPECT_GE((*pixel)[axis], kRim * size);
        EXPECT_LE((*pixel)[axis], (1 - kRim) * size);
      }
    }
  }
  // Of equally good pairs the one with most around the place.
  const auto smallest = std::ranges::min(choices, {}, [](const StereoChoice& one) { return *one.sigma_height_m; });
  int equal = 0;
  for (const StereoChoice& one : choices) {
    if (*one.sigma_height_m > kEqualSigma * *smallest.sigma_height_m) continue;
    ++equal;
    EXPECT_GE(one.from_middle, choices.front().from_middle);
  }
  EXPECT_GE(equal, 2);
}

// sigma_h = h/b h/f sigma_p of the normal case, sigma_p = sqrt(2) of a mark; tilts of 3 degrees change it by 5 %.
TEST(StereoChoices, TheStandardDeviationIsThatOfTheNormalCase) {
  const Strip strip = strip_of(3, 0.75);
  const auto choices = stereo_choices(strip.marking(), middle_of(strip));
  ASSERT_FALSE(choices.empty());
  const StereoChoice& best = choices.front();
  const double gsd = (best.gsd_m[0] + best.gsd_m[1]) / 2;
  const double expected = std::sqrt(2.0) * kPointing_px * gsd / best.base_to_height;
  EXPECT_NEAR(*best.sigma_height_m / expected, 1, 0.12);
}

// Real errors: marks with noise, intersected, miss the height as the choice says.
TEST(StereoChoices, RealErrorsConfirmTheStandardDeviation) {
  const Strip strip = strip_of(3, 0.75);
  const Vector3d position = middle_of(strip);
  const auto choices = stereo_choices(strip.marking(), position);
  ASSERT_FALSE(choices.empty());
  const StereoGeometry model = *StereoGeometry::of(strip.block, choices[0].images[0], choices[0].images[1]);
  const StereoMark mark = *model.mark_at(position);
  Random random(8, 1);
  constexpr int kTrials = 2000;
  double squares = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double left = kPointing_px * random.normal(), right = kPointing_px * random.normal();
    const double row = kPointing_px * random.normal() / std::sqrt(2.0);  // of both, in the mean
    const auto at = model.position_in_world({mark.x + left, mark.y + row, mark.parallax + left - right});
    squares += std::pow((at->z() - position.z()) / *choices[0].sigma_height_m, 2);
  }
  // chi-squared over n has the standard deviation sqrt(2 / n): four of them, and 4 % for pixels of the pair that are
  // not quite those of the photographs
  EXPECT_NEAR(squares / kTrials, 1, 4 * std::sqrt(2.0 / kTrials) + 0.04);
}

// The pose term: poses drawn by their joint covariance, marks by theirs; heights that are intersected in the poses as
// they are known miss the truth as the choice says.
TEST(StereoChoices, RealErrorsOfPosesAndMarksConfirmTheStandardDeviation) {
  Strip strip = strip_of(3, 0.75);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 2e-4, 3e-4, 2e-4, 0.03, 0.02, 0.04;
  for (const OrientedImage& one : oriented_images(strip.block))
    strip.poses[one.image] = Eigen::Matrix<double, 6, 6>(sigma.cwiseAbs2().asDiagonal());
  strip.observations = observations_by_image(strip.block);
  const Vector3d position = middle_of(strip);
  const auto choices = stereo_choices(strip.marking(), position);
  ASSERT_FALSE(choices.empty());
  const StereoChoice& best = choices.front();
  // The poses of all images that show the place, as the choice has them.
  std::vector<ImageId> images;
  for (const OrientedImage& one : oriented_images(strip.block)) {
    const Camera& camera = strip.block.camera_of(one.image);
    const auto pixel = project(camera, one.cam_from_world * position);
    if (!pixel) continue;
    const Eigen::Array2d share = pixel->array() / Eigen::Array2d(camera.width_px, camera.height_px);
    if (share.minCoeff() >= kRim && share.maxCoeff() <= 1 - kRim) images.push_back(one.image);
  }
  const auto local = local_poses(strip.block, strip.observations, images, strip.poses, 1);
  ASSERT_TRUE(local);
  const Eigen::MatrixXd root = local->covariance.llt().matrixL();
  Random random(8, 2);
  constexpr int kTrials = 2000;
  double squares = 0, of_marks = 0;
  for (int i = 0; i < kTrials; ++i) {
    Eigen::VectorXd errors(root.cols());
    for (double& one : errors) one = random.normal();
    errors = (root * errors).eval();
    std::vector<SightLine> lines, exact;
    for (const ImageId image : best.images) {
      const Eigen::Index at = 6 * (std::ranges::find(images, image) - images.begin());
      const Camera& camera = strip.block.camera_of(image);
      const Rigid3 known = pose_of(strip.block, image);
      const Eigen::Quaterniond rotation = known.rotation * rotation_by(errors.segment<3>(at));
      const Vector3d centre = centre_of(known) + errors.segment<3>(at + 3);
      const double du = random.normal(), dv = random.normal();
      const Eigen::Vector2d noise = kPointing_px * Eigen::Vector2d(du, dv);
      const Rigid3 truth{rotation, -(rotation * centre)};
      lines.push_back({&camera, known, *project(camera, truth * position) + noise, kPointing_px, {}});
      exact.push_back({&camera, known, *project(camera, known * position) + noise, kPointing_px, {}});
    }
    const auto met = intersect(lines), with_exact_poses = intersect(exact);
    ASSERT_TRUE(met && with_exact_poses);
    squares += std::pow((met->point_in_world.z() - position.z()) / *best.sigma_height_m, 2);
    of_marks += std::pow((with_exact_poses->point_in_world.z() - position.z()) / *best.sigma_height_m, 2);
  }
  EXPECT_NEAR(squares / kTrials, 1, 4 * std::sqrt(2.0 / kTrials));
  EXPECT_LT(of_marks / kTrials, 0.8);  // the poses do add something
}

TEST(StereoChoices, WhatTheSurfaceHidesComesLast) {
  const Strip strip = strip_of(4, 0.8);
  const Vector3d position = middle_of(strip);
  const auto open = stereo_choices(strip.marking(), position);
  ASSERT_GE(open.size(), 2u);
  // A wall beside the place, on the side of the image at the left of the best pair.
  const Vector3d centre = centre_of(pose_of(strip.block, open[0].images[0]));
  MarkingBlock marking = strip.marking();
  const Eigen::Vector2d way = (centre - position).head<2>();
  marking.surface = [&](const Eigen::Vector2d& at) -> std::optional<double> {
    const double along = (at - position.head<2>()).dot(way) / way.squaredNorm();
    return along > 0.1 && along < 0.2 ? 100.0 : position.z();
  };
  const auto choices = stereo_choices(marking, position);
  ASSERT_FALSE(choices.empty());
  EXPECT_FALSE(choices.front().is_hidden);
  EXPECT_NE(choices.front().images, open.front().images);
  EXPECT_TRUE(std::ranges::is_sorted(choices, {}, &StereoChoice::is_hidden));
}

TEST(StereoChoices, NobodySeesAPlaceFarAway) {
  const Strip strip = strip_of(3, 0.75);
  EXPECT_TRUE(stereo_choices(strip.marking(), {1e5, 0, 0}).empty());
  const auto images = oriented_images(strip.block);
  const auto refused = stereo_choice(strip.marking(), images[0].image, images[1].image, {1e5, 0, 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
