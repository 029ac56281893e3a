// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/guide.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

Camera lens(double sigma_f_px = 0) {
  Camera camera = ideal_camera(2000, 3000, 2000);
  camera.params[Camera::kK1] = -0.05;
  camera.prior.sigma_f_px = sigma_f_px;
  return camera;
}

// `count` points seen by both cameras; keypoint i of one is keypoint i of the other.
struct MatchedImages {
  std::vector<Keypoint> first, second;
  ImagePair verified;
  Rigid3 motion;

  MatchedImages(const Camera& camera, std::size_t count, std::size_t matched, Random& random)
      : motion(random_motion(random)) {
    while (first.size() < count) {
      const Eigen::Vector3d x = random_point(random);
      const auto a = project(camera, x), b = project(camera, motion * x);
      if (!a || !b || !inside(camera, *a) || !inside(camera, *b)) continue;
      first.push_back({static_cast<float>(a->x()), static_cast<float>(a->y())});
      second.push_back({static_cast<float>(b->x()), static_cast<float>(b->y())});
    }
    verified.geometry = PairGeometry::kGeneral;
    verified.second_from_first = motion;
    for (std::uint32_t i = 0; i < matched; ++i) verified.matches.emplace_back(i, i);
  }
  [[nodiscard]] std::optional<Guide> guided(const Camera& camera) const {
    return guide(camera, first, camera, second, verified, {});
  }
};

std::span<const std::uint32_t> candidates_of(const Guide& guide, std::size_t i) {
  return std::span(guide.candidates).subspan(guide.begin[i], guide.begin[i + 1] - guide.begin[i]);
}

// Distance of keypoint j from the epipolar line of keypoint i, on the image freed from distortion.
double distance_px(const Camera& camera, const MatchedImages& p, std::size_t i, std::size_t j) {
  const Eigen::Vector3d line =
      essential_matrix(p.motion) * normalized(camera, {p.first[i].x, p.first[i].y}).homogeneous();
  const Eigen::Vector2d at = normalized(camera, {p.second[j].x, p.second[j].y});
  return camera.focal_px() * std::abs(line.dot(at.homogeneous())) / line.head<2>().norm();
}

TEST(Guide, GivesExactlyTheKeypointsNearTheLine) {
  const Camera camera = lens();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {  // lines of all slopes, epipoles inside and outside the image
    Random random(seed);
    const MatchedImages p(camera, 300, 40, random);
    const auto found = p.guided(camera);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->begin.size(), p.first.size() + 1);
    for (std::size_t i = 0; i < p.first.size(); ++i) {
      std::vector<std::uint32_t> candidates(candidates_of(*found, i).begin(), candidates_of(*found, i).end());
      std::ranges::sort(candidates);
      std::vector<std::uint32_t> expected;
      for (std::uint32_t j = 0; j < p.second.size(); ++j)
        if (distance_px(camera, p, i, j) < 2 * VerifyOptions{}.max_error_px) expected.push_back(j);
      ASSERT_EQ(candidates, expected) << "keypoint " << i << ", seed " << seed;
    }
  }
}

TEST(Guide, OfADoubtfulFocalLengthComesFromTheMatchesThemselves) {
  Random random(9);
  const MatchedImages p(lens(), 300, 60, random);
  const auto found = [&] {
    Camera wrong = lens(300);
    wrong.params[Camera::kF] *= 1.1;  // and the motion that was given belongs to another focal length
    return p.guided(wrong);
  }();
  ASSERT_TRUE(found);
  std::size_t kept = 0;
  for (std::uint32_t i = 0; i < p.first.size(); ++i) kept += std::ranges::count(candidates_of(*found, i), i) == 1;
  EXPECT_GE(kept, 297u);
  EXPECT_LT(found->candidates.size(), 0.05 * 300 * 300);
}

TEST(Guide, NeedsParallaxAndEnoughMatches) {
  Random random(10);
  MatchedImages p(lens(), 100, 24, random);
  EXPECT_FALSE(p.guided(lens()));
  p.verified.matches.emplace_back(24, 24);
  EXPECT_TRUE(p.guided(lens()));
  EXPECT_FALSE(p.guided(lens(300)));  // two unknowns more
  for (const PairGeometry other : {PairGeometry::kNone, PairGeometry::kRotation}) {
    p.verified.geometry = other;
    EXPECT_FALSE(p.guided(lens()));
  }
}

// Keypoints on a plane: `off` of every hundred lie elsewhere.
MatchedImages flat(std::size_t count, std::size_t matched, int off, Random& random) {
  MatchedImages p(lens(), 0, 0, random);
  while (p.first.size() < count) {
    const bool is_off = static_cast<int>(p.first.size() % 100) < off;
    const Eigen::Vector3d x = is_off ? random_point(random) : random_point_on_plane(random);
    const auto a = project(lens(), x), b = project(lens(), p.motion * x);
    if (!a || !b || !inside(lens(), *a) || !inside(lens(), *b)) continue;
    p.first.push_back({static_cast<float>(a->x()), static_cast<float>(a->y())});
    p.second.push_back({static_cast<float>(b->x()), static_cast<float>(b->y())});
  }
  p.verified.geometry = PairGeometry::kPlanar;
  for (std::uint32_t i = 0; i < matched; ++i) p.verified.matches.emplace_back(i, i);
  return p;
}

TEST(Guide, OfAPlaneIsWhereTheKeypointIsMapped) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const MatchedImages p = flat(600, 60, 0, random);
    const auto found = p.guided(lens());
    ASSERT_TRUE(found);
    ASSERT_EQ(found->begin.size(), p.first.size() + 1);
    std::vector<Eigen::Vector2d> at;
    for (const Keypoint& k : p.second) at.push_back(2000 * normalized(lens(), {k.x, k.y}));
    // Keypoints are exact to a float's rounding, and so is the homography of 60 of them.
    for (std::uint32_t i = 0; i < p.first.size(); ++i) {
      std::vector<std::uint32_t> candidates(candidates_of(*found, i).begin(), candidates_of(*found, i).end());
      std::ranges::sort(candidates);
      std::vector<std::uint32_t> expected;
      for (std::uint32_t j = 0; j < p.second.size(); ++j)
        if ((at[j] - at[i]).norm() < 2 * VerifyOptions{}.max_error_px) expected.push_back(j);
      ASSERT_EQ(candidates, expected) << "keypoint " << i << ", seed " << seed;
    }
  }
}

TEST(Guide, OfAPlaneNeedsEnoughMatchesAndNothingBesideThePlane) {
  Random random(12);
  EXPECT_FALSE(flat(100, 39, 0, random).guided(lens()));
  EXPECT_TRUE(flat(100, 40, 0, random).guided(lens()));
  EXPECT_TRUE(flat(300, 300, 2, random).guided(lens()));
  EXPECT_FALSE(flat(300, 300, 20, random).guided(lens()));
}

TEST(Guide, HasNoCandidatesWhereThereAreNoKeypoints) {
  Random random(11);
  const Camera camera = lens();
  const MatchedImages p(camera, 50, 40, random);
  const auto found = guide(camera, {}, camera, p.second, p.verified, {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->begin, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(found->candidates.empty());
}

}  // namespace
}  // namespace collinea
