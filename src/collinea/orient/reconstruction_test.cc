// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/reconstruction.h"

#include <gtest/gtest.h>

#include "collinea/orient/test_pairs.h"

namespace collinea {
namespace {

using testing::Matched;
using testing::matched;

// One image has a camera of its own whose focal length nobody knows.
Matched with_a_stranger(ImageId stranger) {
  Matched input = matched(testing::test_block({.rows = 2, .columns = 3, .points = 400, .sigma_px = 0.5, .seed = 3}));
  Camera camera = input.setup.cameras.begin()->second;
  camera.params[Camera::kF] *= 1.3;
  camera.sigma_f_px = 0.4 * camera.focal_px();
  input.setup.cameras[{2}] = camera;
  input.setup.images.at(stranger).camera = {2};
  return input;
}

TEST(Reconstruction, AnImageThatIsGivenUpLeavesNoFocalLengthBehind) {
  const ImageId stranger{12};
  const Matched input = with_a_stranger(stranger);
  auto block = Reconstruction::create(input.setup, input.pairs, input.source(), {});
  ASSERT_TRUE(block) << block.error().message;
  std::map<ImageId, Rigid3> poses = input.truth.cam_from_world;
  poses.erase(stranger);
  block->place(poses);
  block->extend_all({});
  const double first_px = block->camera_of(stranger).focal_px();
  ASSERT_TRUE(block->orient_image(stranger, 1));
  ASSERT_GT(std::abs(block->camera_of(stranger).focal_px() - first_px), 0.1 * first_px);
  block->drop_image(stranger);
  EXPECT_EQ(block->camera_of(stranger).focal_px(), first_px);
}

}  // namespace
}  // namespace collinea
