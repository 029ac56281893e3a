// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/object_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <stop_token>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

constexpr double kDeg = std::numbers::pi / 180;
constexpr double kSigma_m = 0.01;

// The camera at a position that looks along a direction, rolled about it.
Rigid3 looking(const Vector3d& centre, const Vector3d& along, double roll_rad) {
  const Vector3d z = along.normalized(), x = Vector3d(z.cross(Vector3d::UnitZ())).normalized();
  Eigen::Matrix3d world_from_cam;
  world_from_cam << x, z.cross(x), z;
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ())) *
                                      Eigen::Quaterniond(world_from_cam).conjugate();
  return {rotation, -(rotation * centre)};
}

// The corner of a house, 20 x 8 m and 12 x 8 m, with a bay window and the pavement before it, photographed from the
// street.
struct Corner {
  Block block;
  std::vector<Vector3d> points;

  explicit Corner(double roll_rad = 0) {
    block.cameras[CameraId{0}] = ideal_camera(1100, 1600, 1200);
    for (int i = 0; i < 6; ++i) add_image(looking({2.0 + 3 * i, -12, 1.6}, {0, 1, 0.15}, roll_rad));
    for (int i = 0; i < 5; ++i) add_image(looking({32, 1.0 + 2.5 * i, 1.6}, {-1, 0, 0.15}, roll_rad));
    Random random(4);
    const auto noise = [&] { return kSigma_m * random.normal(); };
    for (int i = 0; i < 32'000; ++i) points.push_back({20 * random.uniform(), noise(), 8 * random.uniform()});
    for (int i = 0; i < 19'200; ++i) points.push_back({20 + noise(), 12 * random.uniform(), 8 * random.uniform()});
    for (int i = 0; i < 40'000; ++i) points.push_back({-2 + 32 * random.uniform(), -8 + 8 * random.uniform(), noise()});
    for (int i = 0; i < 2'000; ++i)
      points.push_back({8 + 3 * random.uniform(), -0.8 + noise(), 3 + 2 * random.uniform()});
    for (int i = 0; i < 500; ++i)
      points.push_back({20 * random.uniform(), -8 * random.uniform(), 8 * random.uniform()});
  }
  void add_image(const Rigid3& cam_from_world) {
    const ImageId id{std::uint32_t(block.images.size())};
    block.images[id] = {.file = std::to_string(id.value) + ".jpg", .camera = CameraId{0}};
    set_pose(block, id, cam_from_world);
  }
  [[nodiscard]] std::vector<ObjectFrame> frames() const {
    return find_object_frames(block, points, {.tolerance_m = 0.1}, {}).value();
  }
};

double angle_deg(const Vector3d& a, const Vector3d& b) { return std::acos(std::min(1.0, a.dot(b))) / kDeg; }

TEST(ObjectFrames, TheWallsOfACornerAreFoundAndThePavementIsNot) {
  const Corner corner;
  const auto frames = corner.frames();
  ASSERT_EQ(frames.size(), 2u);
  const Vector3d normals[] = {-Vector3d::UnitY(), Vector3d::UnitX()}, rights[] = {Vector3d::UnitX(), Vector3d::UnitY()};
  const Vector3d lower_left[] = {{0, 0, 0}, {20, 0, 0}};
  const Eigen::Vector2d sizes[] = {{20, 8}, {12, 8}};
  for (std::size_t i = 0; i < 2; ++i) {
    const ObjectFrame& frame = frames[i];
    EXPECT_EQ(frame.name, "plane" + std::to_string(i + 1));
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(2), normals[i]), 0.2);
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(0), rights[i]), 0.2);
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(1), Vector3d::UnitZ()), 0.2);
    EXPECT_LT((frame.plane.origin_in_world - lower_left[i]).norm(), 0.5);
    EXPECT_LT((frame.extent_m - sizes[i]).norm(), 0.6);
    EXPECT_NEAR(frame.area_m2, sizes[i].prod(), 0.15 * sizes[i].prod());
    EXPECT_LT(frame.rms_m, 3 * kSigma_m);
    EXPECT_GE(frame.images.size(), i == 0 ? 6u : 5u);
    EXPECT_TRUE(frame.holds(frame.plane.in_plane(lower_left[i] + 3 * rights[i] + 3 * Vector3d::UnitZ() + normals[i])));
    EXPECT_FALSE(frame.holds({-1, 3, 0}));
    EXPECT_FALSE(frame.holds({3, 3, 5}));
  }
}

// Who holds the camera a little askew still gets upright walls: two that are not parallel tell where up is.
TEST(ObjectFrames, WallsTellWhereUpIsBetterThanCameras) {
  const Corner corner(4 * kDeg);
  EXPECT_GT(angle_deg(up_in_world(corner.block), Vector3d::UnitZ()), 2);
  const auto frames = corner.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_LT(angle_deg(up_by_walls(corner.block, frames), Vector3d::UnitZ()), 0.2);
  for (const ObjectFrame& frame : frames)
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(1), Vector3d::UnitZ()), 0.3);
  // One wall leaves the turn about its normal as the cameras have it.
  const Vector3d by_one = up_by_walls(corner.block, std::span(frames).first(1));
  EXPECT_NEAR(by_one.dot(frames[0].plane.world_from_plane.col(2)), 0, 1e-3);
  EXPECT_GT(angle_deg(by_one, Vector3d::UnitZ()), 0.5);
}

TEST(ObjectFrames, NothingIsFoundWhereNoPlaneIs) {
  Corner corner;
  EXPECT_TRUE(find_object_frames(corner.block, {}, {.tolerance_m = 0.1}, {})->empty());
  EXPECT_TRUE(find_object_frames(corner.block, corner.points, {.tolerance_m = 0}, {})->empty());
  const std::vector<Vector3d> same(1000, Vector3d(1, 2, 3));
  EXPECT_TRUE(find_object_frames(corner.block, same, {.tolerance_m = 0.1}, {})->empty());
  Random random(5);
  std::vector<Vector3d> ball;
  while (ball.size() < 20'000) {
    const Vector3d p(random.normal(), random.normal(), random.normal());
    ball.push_back(Vector3d(10, -4, 4) + 3 * p.normalized());
  }
  for (const ObjectFrame& frame : find_object_frames(corner.block, ball, {.tolerance_m = 0.02}, {}).value())
    EXPECT_LT(frame.area_m2, 5);  // of 113 m^2: what a ball has of a plane
  clear_poses(corner.block);
  EXPECT_TRUE(corner.frames().empty());  // nobody sees it
}

TEST(ObjectFrames, TheSamePointsInAnotherOrderGiveTheSame) {
  Corner corner;
  const auto first = corner.frames();
  std::ranges::reverse(corner.points);
  const auto second = corner.frames();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT((first[i].plane.world_from_plane - second[i].plane.world_from_plane).norm(), 1e-9);
    EXPECT_LT((first[i].plane.origin_in_world - second[i].plane.origin_in_world).norm(), 1e-9);
    EXPECT_LT((first[i].extent_m - second[i].extent_m).norm(), 1e-9);
    EXPECT_EQ(first[i].points, second[i].points);
    EXPECT_EQ(first[i].images, second[i].images);
  }
}

// A plane that is given by its corners is seen by images that show none of them.
TEST(ObjectFrames, AnImageOfTheMiddleSeesALongWall) {
  const Corner corner;
  const std::vector<Vector3d> corners = {{-60, 0, -9}, {80, 0, -9}, {80, 0, 40}, {-60, 0, 40}};
  for (const Vector3d& normal : {Vector3d(0, 1, 0), Vector3d(0, -1, 0)}) {
    const ObjectFrame frame = frame_of_plane(corner.block, corners, {10, 0, 15}, normal, Vector3d::UnitZ());
    EXPECT_GE(frame.images.size(), 6u);
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(2), -Vector3d::UnitY()), 1e-6);
    EXPECT_LT(angle_deg(frame.plane.world_from_plane.col(0), Vector3d::UnitX()), 1e-6);
  }
}

// The back of a wall is no window of its front, however thin the wall.
TEST(ObjectFrames, AThinWallHasTwoFaces) {
  Corner corner;
  for (int i = 0; i < 6; ++i) corner.add_image(looking({2.0 + 3 * i, 12.4, 1.6}, {0, -1, 0.15}, 0));
  std::erase_if(corner.points, [](const Vector3d& p) { return std::abs(p.y()) > 0.2; });
  const std::size_t count = corner.points.size();
  for (std::size_t i = 0; i < count; ++i) corner.points.push_back(corner.points[i] + Vector3d(0, 0.6, 0));
  const auto frames = corner.frames();
  ASSERT_EQ(frames.size(), 2u);
  const Vector3d first = frames[0].plane.world_from_plane.col(2), second = frames[1].plane.world_from_plane.col(2);
  EXPECT_LT(first.dot(second), -0.99);
}

TEST(ObjectFrames, TheSearchCanBeStopped) {
  std::stop_source stop;
  stop.request_stop();
  collinea::Run run;  // not the one of the test
  run.stop = stop.get_token();
  const Corner corner;
  const auto found = find_object_frames(corner.block, corner.points, {.tolerance_m = 0.1}, run);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kCancelled);
}

TEST(ObjectFrames, AnImageSeesAPointOfAFrameWhereItSawItInTheWorld) {
  const Corner corner;
  const auto frames = corner.frames();
  ASSERT_FALSE(frames.empty());
  const Block in_frame = block_in_frame(corner.block, frames[0]);
  ASSERT_EQ(count_oriented(in_frame), frames[0].images.size());
  for (const auto& [image, pose] : oriented_images(in_frame)) {
    const Vector3d p(7, -0.2, 3);
    EXPECT_LT((pose * frames[0].plane.in_plane(p) - pose_of(corner.block, image) * p).norm(), 1e-9);
    EXPECT_GT(centre_of(pose).z(), 5);
  }
}

}  // namespace
}  // namespace collinea
