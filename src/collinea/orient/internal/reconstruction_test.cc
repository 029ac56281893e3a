// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/reconstruction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>

#include "collinea/orient/internal/incremental.h"
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

// Rays that take no part when the others are measured anew count as they do when they come back.
TEST(Reconstruction, RaysThatComeBackCountAsThoseOfTheirPoint) {
  constexpr double kSigma_px = 0.5;
  Matched input =
      matched(testing::test_block({.rows = 2, .columns = 3, .points = 500, .sigma_px = kSigma_px, .seed = 3}));
  input.setup.cameras = input.truth.cameras;
  auto reconstruction = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(reconstruction) << reconstruction.error().message;
  reconstruction->start_from_poses(testing::poses_of(input.truth));
  reconstruction->extend_all({});
  const Block whole = reconstruction->block();
  ASSERT_GT(reconstruction->filter(kSigma_px, {}), 100);
  const Block left = reconstruction->block();
  std::vector<std::optional<Reconstruction::MovedRay>> moved(left.observations.size());
  std::map<PointId, ImageId> references;  // the first ray of a point is measured anew
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (references.emplace(left.observations[i].point, left.observations[i].image).second)
      moved[i] = {left.observations[i].pixel, 0.04};
  reconstruction->move_rays(left, moved);
  reconstruction->extend_all({});
  std::map<std::pair<PointId, ImageId>, double> sigmas;
  for (const Observation& one : whole.observations) sigmas[{one.point, one.image}] = one.sigma_px;
  int come_back = 0;
  const Block again = reconstruction->block();
  for (const Observation& one : again.observations) {
    const auto was = sigmas.find({one.point, one.image});
    if (was == sigmas.end() || !references.contains(one.point) || references.at(one.point) == one.image) continue;
    EXPECT_DOUBLE_EQ(one.sigma_px, std::numbers::sqrt2 * was->second);
    ++come_back;
  }
  EXPECT_GT(again.observations.size(), left.observations.size() + 50);
  EXPECT_GT(come_back, 100);
}

// A block of true cameras and poses, whose points of some numbers are said to be measured anew with twice the standard
// deviation that their errors have.
class MeasuredAnew : public ::testing::Test {
 protected:
  static constexpr double kSigma_px = 0.1;

  void SetUp() override {
    input_ = matched(testing::test_block({.rows = 2, .columns = 3, .points = 1500, .sigma_px = kSigma_px, .seed = 3}));
    input_.setup.cameras = input_.truth.cameras;
    auto created = Reconstruction::create(input_.setup, input_.pairs, input_.source(), {});
    ASSERT_TRUE(created) << created.error().message;
    reconstruction_.emplace(std::move(*created));
    reconstruction_->start_from_poses(testing::poses_of(input_.truth));
    reconstruction_->extend_all({});
    before_ = reconstruction_->shown_noise();
    ASSERT_TRUE(before_);
  }
  // Besides, every 50th ray measured anew is off by as many pixels.
  void move(const std::function<bool(std::uint32_t point)>& is_anew, double off_px = 0) {
    const Block block = reconstruction_->block();
    std::vector<std::optional<Reconstruction::MovedRay>> moved(block.observations.size());
    int count = 0;
    for (std::size_t i = 0; i < moved.size(); ++i)
      if (is_anew(block.observations[i].point.value))
        moved[i] = {block.observations[i].pixel + Eigen::Vector2d(++count % 50 == 0 ? off_px : 0, 0), 2 * kSigma_px};
    reconstruction_->move_rays(block, moved);
  }
  Matched input_;
  std::optional<Reconstruction> reconstruction_;
  std::optional<TieNoise> before_;
};

TEST_F(MeasuredAnew, RaysShowANoiseOfTheirOwn) {
  EXPECT_EQ(before_->anew_factor, 1);
  move([](std::uint32_t point) { return point % 2 == 0; });
  const auto apart = reconstruction_->shown_noise();
  ASSERT_TRUE(apart);
  EXPECT_NEAR(apart->sigma_px, before_->sigma_px, 0.1 * before_->sigma_px);
  EXPECT_NEAR(apart->anew_factor * 2 * kSigma_px, kSigma_px, 0.1 * kSigma_px);
  EXPECT_TRUE(std::isfinite(apart->anew_gross_sigmas));
}

// Too few to show their own: they have the limit of the others, and gross ones leave.
TEST_F(MeasuredAnew, FewRaysHaveTheLimitOfTheOthers) {
  int gross = 0;
  const auto is_few = [](std::uint32_t point) { return point % 97 == 0; };
  move(is_few, 3);
  const auto shown = reconstruction_->shown_noise();
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->anew_factor, 1);
  EXPECT_EQ(shown->anew_gross_sigmas, shown->gross_sigmas);
  reconstruction_->set_noise(*shown);
  const auto off = [&] {
    gross = 0;
    const Block block = reconstruction_->block();
    for (const Observation& one : block.observations) {
      const auto pixel =
          project(block.camera_of(one.image), pose_of(block, one.image) * block.points.at(one.point).position_in_world);
      gross += is_few(one.point.value) && (!pixel || (*pixel - one.pixel).norm() > 2);
    }
    return gross;
  };
  EXPECT_GT(off(), 0);
  EXPECT_TRUE(reconstruction_->leave_out_gross({}));
  EXPECT_EQ(off(), 0);
}

TEST_F(MeasuredAnew, FewFeaturesHaveTheLimitOfTheOthers) {
  move([](std::uint32_t point) { return point % 97 != 0; });
  const auto shown = reconstruction_->shown_noise();
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->sigma_px, reconstruction_->noise().sigma_px);
  EXPECT_TRUE(std::isfinite(shown->gross_sigmas));
  EXPECT_EQ(shown->gross_sigmas, shown->anew_gross_sigmas);
}

TEST_F(MeasuredAnew, BothSigmasAreKeptWithinBounds) {
  TieNoise noise = *before_;
  noise.anew_factor = 1000;
  noise.anew_gross_sigmas = 5;
  reconstruction_->set_noise(noise);
  EXPECT_EQ(reconstruction_->noise().anew_factor, 10);
  EXPECT_EQ(reconstruction_->noise().anew_gross_sigmas, 500);  // the same error in pixels
}

// The noise of the features is known, and no ray comes or goes.
TEST_F(MeasuredAnew, ABlockIsSettledWhenBothSigmasAre) {
  reconstruction_->set_noise(*before_);
  move([](std::uint32_t point) { return point % 2 == 0; });
  const AdjustScope scope{.use_positions = false, .use_control = false, .use_geodetic = false};
  ASSERT_TRUE(settle(*reconstruction_, scope, {}, true, {}));
  EXPECT_NEAR(reconstruction_->noise().anew_factor, 0.5, 0.1);
}

}  // namespace
}  // namespace collinea
