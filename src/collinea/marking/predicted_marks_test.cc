// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/predicted_marks.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <Eigen/Eigenvalues>

#include "collinea/marking/test_marking.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::images_of;
using testing::marking_scene;
using testing::MarkingScene;

const PredictedMark* mark_in(const PredictedMarks& found, ImageId image) {
  for (const PredictedMark& predicted : found.predicted)
    if (predicted.image == image) return &predicted;
  return nullptr;
}

TEST(PredictedMarks, ExactBlocksShowPointsExactly) {
  const MarkingScene scene = marking_scene(1, false);
  Random random(1);
  for (const auto& [id, point] : scene.points) {
    const std::vector<ImageId> images = images_of(scene, id, random);
    ASSERT_GE(images.size(), 3u);
    std::vector<ControlObservation> marks;
    for (int count = 0; count < 3; ++count) {
      const auto found = predicted_marks(scene.marking(), scene.block.control.at(id), marks);
      EXPECT_FALSE(found.given_disagrees);
      EXPECT_EQ(found.predicted.size(), images.size());
      for (const PredictedMark& predicted : found.predicted)
        EXPECT_LT((predicted.pixel - *scene.seen(predicted.image, id)).norm(), 1e-4)
            << count;  // the adjustment's last step
      marks.push_back(scene.mark(images[std::size_t(count)], id, 0, random));
    }
  }
}

// The ellipses must hold 95 % of the true positions by chi-squared with two degrees of freedom (5.991). One image of
// each of 600 scenes for each number of marks: 0.9 % is the standard deviation of the share.
TEST(PredictedMarks, EllipsesHoldTheTruth) {
  constexpr int kScenes = 600;
  int inside[4] = {}, count[4] = {}, near = 0;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const MarkingScene scene = marking_scene(seed);
    Random random(seed, 3);
    const ControlId id{random.below(4)};
    const std::vector<ImageId> images = images_of(scene, id, random);
    if (images.size() < 5) continue;
    std::vector<ControlObservation> marks;
    for (std::size_t given = 0; given < 4; ++given) {
      const auto found = predicted_marks(scene.marking(), scene.block.control.at(id), marks);
      const PredictedMark* predicted = mark_in(found, images[4]);
      ++count[given];
      if (predicted) {
        const Vector2d error = *scene.seen(images[4], id) - predicted->pixel;
        inside[given] += error.dot(predicted->covariance.inverse() * error) < 5.991;
        near += given == 3 && error.norm() < 10;
      }
      marks.push_back(scene.mark(images[given], id, 0.5, random));
    }
  }
  for (int given = 0; given < 4; ++given) {
    ASSERT_GT(count[given], 400);
    EXPECT_NEAR(double(inside[given]) / count[given], 0.95, 0.02) << given;
    RecordProperty("share_" + std::to_string(given), std::to_string(double(inside[given]) / count[given]));
  }
  EXPECT_EQ(near, count[3]);
}

// Coordinates of another datum, 70 m too high: two marks tell, and three are within 10 px in 95 % and more.
TEST(PredictedMarks, AWrongDatumIsNoticed) {
  int within[4] = {}, count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    MarkingScene scene = marking_scene(seed);
    Random random(seed, 5);
    const ControlId id{random.below(4)};
    const std::vector<ImageId> images = images_of(scene, id, random);
    if (images.size() < 5) continue;
    scene.block.control.at(id).position_in_world.z() -= 70;
    ++count;
    std::vector<ControlObservation> marks;
    for (std::size_t given = 0; given < 4; ++given) {
      const auto found = predicted_marks(scene.marking(), scene.block.control.at(id), marks);
      EXPECT_EQ(found.given_disagrees, given > 0) << seed;
      const PredictedMark* predicted = mark_in(found, images[4]);
      within[given] += predicted && (*scene.seen(images[4], id) - predicted->pixel).norm() < 10;
      marks.push_back(scene.mark(images[given], id, 0.5, random));
    }
  }
  ASSERT_GT(count, 60);
  EXPECT_GE(within[2], 0.95 * count);
  EXPECT_GE(within[3], 0.95 * count);
  EXPECT_LT(within[0], count / 2);  // 70 m are far more than 10 px: the test can fail
}

// The wrong one of three marks takes no part, and is named.
TEST(PredictedMarks, AMarkOfAnotherPointIsNamed) {
  int named = 0, within = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const MarkingScene scene = marking_scene(seed);
    Random random(seed, 13);
    const ControlId id{random.below(4)};
    const std::vector<ImageId> images = images_of(scene, id, random);
    if (images.size() < 5) continue;
    std::vector<ControlObservation> marks;
    for (std::size_t i = 0; i < 3; ++i) marks.push_back(scene.mark(images[i], id, 0.5, random));
    marks[1].pixel += 200 * Vector2d(random.normal(), random.normal()).normalized();
    const auto found = predicted_marks(scene.marking(), scene.block.control.at(id), marks);
    const PredictedMark* mark = mark_in(found, images[4]);
    ++count;
    named += found.contradicting == std::vector{images[1]};
    within += mark && (*scene.seen(images[4], id) - mark->pixel).norm() < 10;
  }
  ASSERT_GT(count, 40);
  // An error along the rays' common plane hides in the depth of the others.
  EXPECT_GE(named, 0.8 * count);
  EXPECT_GE(within, 0.9 * count);
}

TEST(PredictedMarks, PointsWithoutCoordinatesFollowFromMarks) {
  MarkingScene scene = marking_scene(3);
  Random random(3);
  const ControlId id{1};
  ControlPoint& given = scene.block.control.at(id);
  given.sigma_m.setConstant(std::numeric_limits<double>::infinity());
  given.position_in_world.setConstant(std::nan(""));
  const std::vector<ImageId> images = images_of(scene, id, random);
  EXPECT_TRUE(predicted_marks(scene.marking(), given, {}).predicted.empty());
  std::vector<ControlObservation> marks{scene.mark(images[0], id, 0.5, random)};
  const auto first = predicted_marks(scene.marking(), given, marks);  // by the depth of tie points
  EXPECT_FALSE(first.predicted.empty());
  marks.push_back(scene.mark(images[1], id, 0.5, random));
  const auto second = predicted_marks(scene.marking(), given, marks);
  ASSERT_TRUE(second.marked);
  for (const PredictedMark& predicted : second.predicted)
    EXPECT_LT((predicted.pixel - *scene.seen(predicted.image, id)).norm(), 6) << predicted.image.value;
  EXPECT_FALSE(second.given_disagrees);
}

// A height alone is missing: that of the ground stands for it.
TEST(PredictedMarks, PlanOnlyPointsLieOnTheGround) {
  MarkingScene scene = marking_scene(4);
  ControlPoint& given = scene.block.control.at(ControlId{1});
  given.sigma_m.z() = std::numeric_limits<double>::infinity();
  given.position_in_world.z() = std::nan("");
  const auto found = predicted_marks(scene.marking(), given, {});
  ASSERT_FALSE(found.predicted.empty());
  for (const PredictedMark& predicted : found.predicted)
    if (const auto seen = scene.seen(predicted.image, ControlId{1})) {
      const Vector2d error = *seen - predicted.pixel;
      EXPECT_LT(error.dot(predicted.covariance.inverse() * error), 18.4);  // 0.01 %
    }
}

TEST(PredictedMarks, TheBestMarkComesFirst) {
  const MarkingScene scene = marking_scene(5);
  Random random(5);
  const ControlId id{2};
  const std::vector<ImageId> images = images_of(scene, id, random);
  const std::vector<ControlObservation> marks{scene.mark(images[0], id, 0.5, random),
                                              scene.mark(images[1], id, 0.5, random)};
  const auto found = predicted_marks(scene.marking(), scene.block.control.at(id), marks);
  ASSERT_GE(found.predicted.size(), 4u);
  EXPECT_TRUE(found.predicted.back().marked);
  EXPECT_FALSE(found.predicted.front().marked);
  const double before =
      std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(found.marked->covariance).eigenvalues()[2]);
  for (const PredictedMark& predicted : found.predicted) {
    ASSERT_TRUE(predicted.sigma_after_m);
    EXPECT_LE(*predicted.sigma_after_m, before * (1 + 1e-6));
    EXPECT_TRUE(predicted.marked || *predicted.sigma_after_m >= *found.predicted.front().sigma_after_m / 1.1);
  }
  // What is promised is kept.
  auto more = marks;
  more.push_back(scene.mark(found.predicted.front().image, id, 0.5, random));
  const auto after = predicted_marks(scene.marking(), scene.block.control.at(id), more);
  EXPECT_NEAR(std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(after.marked->covariance).eigenvalues()[2]) /
                  *found.predicted.front().sigma_after_m,
              1, 0.02);
}

TEST(PredictedMarks, ImagesThatTheSurfaceHidesComeLastAndAreNamed) {
  const MarkingScene scene = marking_scene(6, false);
  ControlId id{0};  // the one farthest east
  for (const auto& [other, position] : scene.points)
    if (position.x() > scene.points.at(id).x()) id = other;
  const Vector3d point = scene.points.at(id);
  // A wall 30 m high, 4 m west of the point: images from the west do not see it.
  const auto wall = [&](const Vector2d& p) {
    return std::optional(p.x() < point.x() - 4 && p.x() > point.x() - 6 ? 30.0 : -20.0);
  };
  MarkingBlock marking = scene.marking();
  const auto free = predicted_marks(marking, scene.block.control.at(id), {});
  marking.surface = wall;
  const auto hidden = predicted_marks(marking, scene.block.control.at(id), {});
  ASSERT_EQ(hidden.predicted.size(), free.predicted.size());
  EXPECT_TRUE(std::ranges::none_of(free.predicted, &PredictedMark::hidden));
  EXPECT_TRUE(std::ranges::is_sorted(hidden.predicted, {}, &PredictedMark::hidden));
  const auto count = std::ranges::count_if(hidden.predicted, &PredictedMark::hidden);
  EXPECT_GT(count, 0);
  EXPECT_LT(count, std::ptrdiff_t(hidden.predicted.size()));
  for (const PredictedMark& one : hidden.predicted) {
    const double from_wall = point.x() - centre_of(pose_of(scene.block, one.image)).x();
    EXPECT_TRUE(one.hidden || from_wall < 20);  // over the wall: 60 m up, 5 of 30
    EXPECT_TRUE(!one.hidden || from_wall > 4);  // beyond it
  }
  // A mark in a hidden image is listed with the marks: a person has seen the point there.
  const ImageId last = hidden.predicted.back().image;
  const auto marked = predicted_marks(marking, scene.block.control.at(id), {{id, last, *scene.seen(last, id), 0.5}});
  EXPECT_TRUE(marked.predicted.back().image == last && marked.predicted.back().marked);
}

TEST(PredictedMarks, DegenerateOnesGiveNone) {
  MarkingScene scene = marking_scene(7, false);
  ControlPoint given = scene.block.control.at(ControlId{1});
  Random random(7);
  given.position_in_world.z() = 1000;  // above all cameras
  EXPECT_TRUE(predicted_marks(scene.marking(), given, {}).predicted.empty());
  given.position_in_world = {1e9, 0, 0};
  EXPECT_TRUE(predicted_marks(scene.marking(), given, {}).predicted.empty());
  given.position_in_world.setConstant(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(predicted_marks(scene.marking(), given, {}).predicted.empty());
  // Two marks in one direction: a point at infinity.
  const OrientedImage first = oriented_images(scene.block)[0];
  ControlObservation twice{ControlId{1}, first.image, {1000, 750}, 0.5};
  given.sigma_m.setConstant(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(predicted_marks(scene.marking(), given, {twice, twice}).marked);
  clear_poses(scene.block);
  EXPECT_TRUE(predicted_marks(scene.marking(), scene.block.control.at(ControlId{1}), {twice}).predicted.empty());
}

// An ended adjustment may know no covariances: positions stay, with the precision of the ground.
TEST(PredictedMarks, WithoutCovariancesTwoMarksAreEnough) {
  MarkingScene scene = marking_scene(8);
  scene.poses.clear();
  Random random(8);
  const ControlId id{1};
  const std::vector<ImageId> images = images_of(scene, id, random);
  const std::vector<ControlObservation> marks{scene.mark(images[0], id, 0.5, random),
                                              scene.mark(images[1], id, 0.5, random)};
  for (const PredictedMark& predicted : predicted_marks(scene.marking(), scene.block.control.at(id), marks).predicted)
    EXPECT_LT((predicted.pixel - *scene.seen(predicted.image, id)).norm(), 6);
}

}  // namespace
}  // namespace collinea
