// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_geometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"
#include "collinea/restitution/test_stereo.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

StereoGeometry model_of(const Block& block, std::uint32_t one, std::uint32_t other) {
  const auto model = StereoGeometry::of(block, ImageId{one}, ImageId{other});
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

std::vector<ImageId> ids_of(const Block& block) {
  std::vector<ImageId> ids;
  for (const auto& [id, image] : block.images) ids.push_back(id);
  return ids;
}

Block strip() { return make_survey(testing::strip_of_three())->block; }

// A mark of every place lies, by formula and by lattice, where the core projects the place into both photographs.
void expect_marks_where_projected(const Block& block, const StereoGeometry& model, int positions) {
  const auto left = pixel_lattice(block.camera_of(model.left), model.pair.left_from_image, model.pair.left);
  const auto right = pixel_lattice(block.camera_of(model.right), model.pair.right_from_image, model.pair.right);
  ASSERT_TRUE(left && right);
  EXPECT_LE(std::max(left->error_px, right->error_px), kLatticeError_px);
  Random random(5, 1);
  for (int i = 0, found = 0; found < positions; ++i) {
    ASSERT_LT(i, 100 * positions);
    const StereoMark mark{random.uniform() * model.pair.left.width_px, random.uniform() * model.pair.left.height_px,
                          model.pair.disparity_at(80 * (1 + random.uniform()))};
    const auto pixels = model.pixels_of(block, mark);
    if (!pixels) continue;
    ++found;
    const Vector3d position = *model.position_in_world(mark);
    for (const auto& [image, k] : {std::pair(model.left, 0u), {model.right, 1u}}) {
      const Vector2d truth = *project(block.camera_of(image), pose_of(block, image) * position);
      EXPECT_LT(((*pixels)[k] - truth).norm(), 1e-6);
      const Vector2d through = k == 0 ? left->at(mark.x, mark.y) : right->at(mark.x - mark.parallax, mark.y);
      EXPECT_LT((through - truth).norm(), kLatticeError_px);
    }
    const auto again = model.mark_at(position);
    ASSERT_TRUE(again);
    EXPECT_NEAR(again->x, mark.x, 1e-6);
    EXPECT_NEAR(again->y, mark.y, 1e-6);
    EXPECT_NEAR(again->parallax, mark.parallax, 1e-6);
  }
}

TEST(StereoGeometry, MarksLieWhereTheCoreProjectsThem) {
  const Block block = strip();
  const auto ids = ids_of(block);
  expect_marks_where_projected(block, model_of(block, ids[0].value, ids[1].value), 1000);
}

// Every model of cameras: the lattice is checked against what the model itself says.
TEST(StereoGeometry, MarksLieThereWithEveryModelOfCameras) {
  Block block = strip();
  const auto ids = ids_of(block);
  Camera& camera = block.cameras.begin()->second;
  const Camera plain = camera;
  camera.params[Camera::kK1] = -0.12;
  camera.params[Camera::kK2] = 0.05;
  camera.params[Camera::kP1] = 1e-3;
  expect_marks_where_projected(block, model_of(block, ids[0].value, ids[1].value), 100);
  camera = plain;
  camera.model = Equidistant{};
  expect_marks_where_projected(block, model_of(block, ids[0].value, ids[1].value), 100);
}

TEST(StereoGeometry, ThePictureIsUprightWhicheverImageIsNamedFirst) {
  const Block block = strip();
  const auto ids = ids_of(block);
  const StereoGeometry model = model_of(block, ids[1].value, ids[0].value),
                       same = model_of(block, ids[0].value, ids[1].value);
  EXPECT_EQ(model.left, same.left);
  // Turned against the photograph by a right angle at most.
  const Vector3d row = model.pair.left_from_image * Vector3d::UnitX();
  EXPECT_GT(row.x(), -1e-9);
}

TEST(StereoGeometry, RefusesWhatIsNoPair) {
  Block block = strip();
  const auto ids = ids_of(block);
  EXPECT_EQ(StereoGeometry::of(block, ids[0], ids[0]).error().code, Errc::kBadInput);
  EXPECT_EQ(StereoGeometry::of(block, ids[0], ImageId{999}).error().code, Errc::kNotFound);
  remove_pose(block, ids[1]);
  EXPECT_EQ(StereoGeometry::of(block, ids[0], ids[1]).error().code, Errc::kIllPosed);
}

TEST(StereoGeometry, PointsAtInfinityAndBehindHaveNoMark) {
  const Block block = strip();
  const auto ids = ids_of(block);
  const StereoGeometry model = model_of(block, ids[0].value, ids[1].value);
  const double infinity = model.pair.left.params[Camera::kCx] - model.pair.right.params[Camera::kCx];
  EXPECT_FALSE(model.position_in_world({100, 100, infinity}));
  EXPECT_FALSE(model.position_in_world({100, 100, infinity - 1}));
  EXPECT_FALSE(model.mark_at(inverse(model.pair.left_from_world) * Vector3d(0, 0, -10)));
}

TEST(StereoGeometry, ThePolynomialIsTheMapToAMillimetre) {
  const LocalFrame frame = *LocalFrame::create("EPSG:32633", 47.2, 17.5, 300);  // far from the middle of its zone
  const Vector3d origin(800, -500, 20);
  const MapPolynomial map = map_polynomial(&frame, origin, 1000);
  Random random(3, 1);
  for (int i = 0; i < 200; ++i) {
    const Vector3d at =
        origin + 2000 * (Vector3d(random.uniform(), random.uniform(), random.uniform()) - Vector3d::Constant(0.5));
    EXPECT_LT((map.at(at) - frame.map_from_local(at)).norm(), 1e-3);
  }
  const MapPolynomial same = map_polynomial(nullptr, origin, 1000);
  EXPECT_LT((same.at({1, 2, 3}) - Vector3d(1, 2, 3)).norm(), 1e-9);
}

}  // namespace
}  // namespace collinea
