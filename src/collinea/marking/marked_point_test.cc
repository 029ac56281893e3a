// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/marked_point.h"

#include <gtest/gtest.h>

#include "collinea/marking/test_marking.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::images_of;
using testing::marking_scene;
using testing::MarkingScene;

struct Measured {
  JointPoses images;
  std::vector<PointMark> marks;
};

std::optional<Measured> measured(const MarkingScene& scene, ControlId id, std::size_t count, double sigma_px,
                                 Random& random) {
  std::vector<ImageId> images = images_of(scene, id, random);
  if (images.size() < count) return std::nullopt;
  const auto local = local_poses(scene.block, scene.observations, images, scene.poses, 1);
  if (!local) return std::nullopt;
  Measured out{{.images = local->images, .covariance = local->covariance}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    const ControlObservation mark = scene.mark(images[i], id, sigma_px, random);
    out.marks.push_back({i, mark.pixel, mark.sigma_px * mark.sigma_px * Eigen::Matrix2d::Identity()});
  }
  return out;
}

TEST(MarkedPoint, ExactMarksMeetInThePoint) {
  const MarkingScene scene = marking_scene(1, false);
  Random random(1);
  for (const auto& [id, truth] : scene.points) {
    const auto made = measured(scene, id, 3, 0, random);
    ASSERT_TRUE(made);
    const auto point = marked_point(scene.block, made->images, made->marks);
    ASSERT_TRUE(point);
    EXPECT_LT((point->position_in_world - truth).norm(), 1e-5);
    double redundancy = 0;
    for (const PointMarkTest& test : point->tests) redundancy += test.redundancy.sum();
    EXPECT_NEAR(redundancy, point->redundancy, 1e-6);
    EXPECT_EQ(point->redundancy, 3);
  }
}

// Errors of marks and of the adjusted poses: e' C^-1 e has the mean 3 and the standard deviation sqrt(6), w the mean
// square 1.
TEST(MarkedPoint, CovarianceAndTestsAreThoseOfTheErrors) {
  double sum = 0, squares = 0;
  int count = 0, tests = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const MarkingScene scene = marking_scene(seed);
    Random random(seed, 9);
    const ControlId id{random.below(4)};
    const auto made = measured(scene, id, 4, 0.5, random);
    if (!made) continue;
    const auto point = marked_point(scene.block, made->images, made->marks);
    ASSERT_TRUE(point);
    const Vector3d error = point->position_in_world - scene.points.at(id);
    sum += error.dot(point->covariance.ldlt().solve(error));
    ++count;
    for (const PointMarkTest& test : point->tests)
      for (int k = 0; k < 2; ++k)
        if (!std::isnan(test.w[k])) squares += test.w[k] * test.w[k], ++tests;
  }
  ASSERT_GT(count, 250);
  EXPECT_NEAR(sum / count, 3, 4 * std::sqrt(6.0 / count));      // one false alarm in 16,000
  EXPECT_NEAR(squares / tests, 1, 4 * std::sqrt(2.0 / count));  // the tests of a point are not independent
}

// An error of the detectable size is found in 80 %: |w| beyond 3.29.
TEST(MarkedPoint, DetectableErrorsAreFound) {
  int found = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const MarkingScene scene = marking_scene(seed);
    Random random(seed, 11);
    const ControlId id{random.below(4)};
    auto made = measured(scene, id, 4, 0.5, random);
    if (!made) continue;
    const auto clean = marked_point(scene.block, made->images, made->marks);
    ASSERT_TRUE(clean);
    made->marks[1].pixel.x() += clean->tests[1].detectable_px.x();
    const auto wrong = marked_point(scene.block, made->images, made->marks);
    ASSERT_TRUE(wrong);
    found += std::abs(wrong->tests[1].w.x()) > 3.2905;
    ++count;
  }
  ASSERT_GT(count, 250);
  EXPECT_NEAR(double(found) / count, 0.8, 4 * std::sqrt(0.16 / count));
}

TEST(MarkedPoint, NothingMeetsWhereRaysDoNot) {
  const MarkingScene scene = marking_scene(2);
  Random random(2);
  const auto made = measured(scene, ControlId{1}, 2, 0.5, random);
  ASSERT_TRUE(made);
  EXPECT_FALSE(marked_point(scene.block, made->images, std::span(made->marks).first(1)));
  EXPECT_FALSE(marked_point(scene.block, made->images, {}));
  const std::vector<PointMark> twice{made->marks[0], made->marks[0]};
  EXPECT_FALSE(marked_point(scene.block, made->images, twice));
  EXPECT_FALSE(local_poses(scene.block, scene.observations, {}, scene.poses, 1));
  EXPECT_FALSE(local_poses(scene.block, scene.observations, std::vector{ImageId{999}}, scene.poses, 1));
}

}  // namespace
}  // namespace collinea
