// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/reconstruction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/orient/internal/test_pairs.h"

namespace collinea {
namespace {

using testing::Matched;
using testing::matched;

// One image has a camera of its own whose focal length nobody knows.
Matched with_a_stranger(ImageId stranger) {
  Matched input = matched(testing::test_block({.rows = 2, .columns = 3, .points = 400, .sigma_px = 0.5, .seed = 3}));
  Camera camera = input.setup.cameras.begin()->second;
  camera.params[Camera::kF] *= 1.3;
  camera.prior.sigma_f_px = 0.4 * camera.focal_px();
  input.setup.cameras[{2}] = camera;
  input.setup.images.at(stranger).camera = {2};
  return input;
}

TEST(Reconstruction, AnImageThatIsGivenUpLeavesNoFocalLengthBehind) {
  const ImageId stranger{12};
  const Matched input = with_a_stranger(stranger);
  auto block = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(block) << block.error().message;
  std::map<ImageId, Rigid3> poses = testing::poses_of(input.truth);
  poses.erase(stranger);
  block->start_from_poses(poses);
  block->extend_all({});
  const double first_px = block->camera_of(stranger).focal_px();
  ASSERT_TRUE(block->orient_image(stranger, 1));
  ASSERT_GT(std::abs(block->camera_of(stranger).focal_px() - first_px), 0.1 * first_px);
  block->drop_image(stranger);
  EXPECT_EQ(block->camera_of(stranger).focal_px(), first_px);
}

TEST(Reconstruction, GrossErrorsLeaveForGoodAndTheLossWithThem) {
  constexpr double kSigma_px = 0.1, kOff_px = 2;
  Matched input =
      matched(testing::test_block({.rows = 2, .columns = 3, .points = 400, .sigma_px = kSigma_px, .seed = 3}));
  input.setup.cameras = input.truth.cameras;
  auto reconstruction = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(reconstruction) << reconstruction.error().message;
  reconstruction->start_from_poses(testing::poses_of(input.truth));
  reconstruction->extend_all({});
  EXPECT_FALSE(reconstruction->leave_out_gross({}));  // nothing is known of the noise
  const Block before = reconstruction->block();
  std::vector<std::optional<Reconstruction::MovedRay>> rays(before.observations.size());
  std::size_t moved = 0;
  // In points of four rays and more: an error along the line between two rays only moves their point.
  const auto rays_of = [&](PointId point) {
    return std::count_if(before.observations.begin(), before.observations.end(),
                         [&](const Observation& seen) { return seen.point == point; });
  };
  for (std::size_t i = 0; i < rays.size(); i += 50) {
    if (rays_of(before.observations[i].point) < 4) continue;
    rays[i] = {before.observations[i].pixel + Eigen::Vector2d(0, kOff_px), kSigma_px};
    ++moved;
  }
  ASSERT_GT(moved, 10u);
  reconstruction->move_rays(before, rays);
  reconstruction->set_noise(
      {.sigma_px = kSigma_px, .loss = Loss::kCauchy, .gross_sigmas = 10, .anew_gross_sigmas = 10});
  ASSERT_TRUE(reconstruction->adjust_all({.calibration = Calibration::kNone, .loss = Loss::kCauchy}, {}, {}));
  const auto inactive = reconstruction->leave_out_gross({});
  ASSERT_TRUE(inactive);
  EXPECT_GE(static_cast<std::size_t>(*inactive), moved);
  EXPECT_EQ(reconstruction->noise().loss, Loss::kNone);
  const auto left = [&] {
    std::size_t count = 0;
    const Block block = reconstruction->block();
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (rays[i])
        count += std::count_if(block.observations.begin(), block.observations.end(), [&](const Observation& seen) {
          return seen.image == before.observations[i].image && seen.pixel == rays[i]->pixel;
        });
    return count;
  };
  EXPECT_EQ(left(), 0u);
  EXPECT_GT(reconstruction->block().observations.size(), before.observations.size() - 2 * moved);
  reconstruction->extend_all({});
  EXPECT_EQ(left(), 0u);
}

TEST(Reconstruction, ARayThatIsMovedHasItsOwnSigma) {
  Matched input = matched(testing::test_block({.rows = 2, .columns = 3, .points = 100, .sigma_px = 0, .seed = 3}));
  input.setup.cameras = input.truth.cameras;
  auto reconstruction = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(reconstruction) << reconstruction.error().message;
  reconstruction->start_from_poses(testing::poses_of(input.truth));
  reconstruction->extend_all({});
  const Block before = reconstruction->block();
  ASSERT_GT(before.observations.size(), 100u);
  constexpr std::size_t kMoved = 51;
  std::vector<std::optional<Reconstruction::MovedRay>> moved(before.observations.size());
  moved[kMoved] = {before.observations[kMoved].pixel + Eigen::Vector2d(0.25, -0.5), 0.04};
  reconstruction->move_rays(before, moved);
  const Block after = reconstruction->block();
  ASSERT_EQ(after.observations.size(), before.observations.size());
  for (std::size_t i = 0; i < after.observations.size(); ++i) {
    const Observation &was = before.observations[i], &is = after.observations[i];
    if (i == kMoved) {
      EXPECT_EQ(is.pixel, moved[i]->pixel);
      EXPECT_DOUBLE_EQ(is.sigma_px, 0.04);
      continue;
    }
    // The others of its point are against its reference, whose feature errs as theirs do.
    const bool is_beside = was.point == before.observations[kMoved].point;
    EXPECT_EQ(is.pixel, was.pixel);
    EXPECT_DOUBLE_EQ(is.sigma_px, (is_beside ? std::numbers::sqrt2 : 1) * was.sigma_px);
  }
}

// Every second point is said to be measured anew with twice the standard deviation that its errors have.
TEST(Reconstruction, RaysMeasuredAnewShowANoiseOfTheirOwn) {
  constexpr double kSigma_px = 0.1;
  Matched input =
      matched(testing::test_block({.rows = 2, .columns = 3, .points = 1500, .sigma_px = kSigma_px, .seed = 3}));
  input.setup.cameras = input.truth.cameras;
  auto reconstruction = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(reconstruction) << reconstruction.error().message;
  reconstruction->start_from_poses(testing::poses_of(input.truth));
  reconstruction->extend_all({});
  const auto alike = reconstruction->shown_noise();
  ASSERT_TRUE(alike);
  EXPECT_EQ(alike->anew_factor, 1);
  const Block block = reconstruction->block();
  std::vector<std::optional<Reconstruction::MovedRay>> moved(block.observations.size());
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (block.observations[i].point.value % 2 == 0) moved[i] = {block.observations[i].pixel, 2 * kSigma_px};
  reconstruction->move_rays(block, moved);
  const auto apart = reconstruction->shown_noise();
  ASSERT_TRUE(apart);
  EXPECT_NEAR(apart->sigma_px, alike->sigma_px, 0.1 * alike->sigma_px);
  EXPECT_NEAR(apart->anew_factor * 2 * kSigma_px, kSigma_px, 0.1 * kSigma_px);
  EXPECT_TRUE(std::isfinite(apart->anew_gross_sigmas));
}

}  // namespace
}  // namespace collinea
