// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/ground_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/match/window_matching.h"
#include "collinea/math/random.h"
#include "collinea/restitution/test_stereo.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Pair {
  testing::StereoScene scene;
  StereoGeometry model;
};

const Pair& rendered_pair() {
  static const Pair pair = [] {
    testing::StereoScene scene = testing::stereo_scene(testing::strip_of_three(), 2);
    const auto model = StereoGeometry::of(scene.block(), scene.greys.begin()->first, scene.greys.rbegin()->first);
    return Pair{std::move(scene), *model};
  }();
  return pair;
}

// Where the surface truly is under a position of the left epipolar image; nothing where the right image shows it not.
std::optional<StereoMark> true_mark(const Pair& pair, double x, double y) {
  const Block& block = pair.scene.block();
  const EpipolarPair& geometry = pair.model.pair;
  const Vector3d ray((x - geometry.left.params[Camera::kCx]) / geometry.left.focal_px(),
                     (y - geometry.left.params[Camera::kCy]) / geometry.left.focal_px(), 1);
  const auto pixel = project(block.camera_of(pair.model.left), geometry.left_from_image.conjugate() * ray);
  if (!pixel || !inside(block.camera_of(pair.model.left), *pixel)) return std::nullopt;
  const auto hit = shown_at(pair.scene.truth, pair.model.left, *pixel);
  if (!hit || !seen_at(pair.scene.truth, pair.model.right, hit->point, 40) ||
      !seen_at(pair.scene.truth, pair.model.left, hit->point, 40))
    return std::nullopt;
  return pair.model.mark_at(hit->point);
}

std::vector<StereoMark> true_marks(const Pair& pair, std::size_t count, std::uint64_t seed) {
  Random random(seed, 1);
  std::vector<StereoMark> marks;
  for (int i = 0; i < 10'000 && marks.size() < count; ++i)
    if (const auto mark = true_mark(pair, random.uniform() * pair.model.pair.left.width_px,
                                    random.uniform() * pair.model.pair.left.height_px))
      marks.push_back(*mark);
  return marks;
}

// 95 % of errors lie within 1.96 sigmas; of a hundred at least 89 but once in 200 (binomial).
TEST(GroundMatch, SetsHeightsWithinTheirBounds) {
  const Pair& pair = rendered_pair();
  Random random(4, 1);
  int set = 0, within = 0, tried = 0;
  double squares = 0, chi2 = 0;
  for (const StereoMark& truth : true_marks(pair, 140, 2)) {
    StereoMark start = truth;
    start.parallax += 16 * (random.uniform() - 0.5);
    ++tried;
    const auto found = match_ground(pair.scene.block(), pair.model, start, pair.scene.photo(), {});
    if (!found) continue;
    ++set;
    const double off = found->mark.parallax - truth.parallax;
    within += std::abs(off) <= 1.96 * found->sigma_px;
    squares += off * off;
    chi2 += off * off / (found->sigma_px * found->sigma_px);
    EXPECT_EQ(found->mark.x, truth.x);
    EXPECT_LT((found->position_in_world - *pair.model.position_in_world(found->mark)).norm(), 1e-9);
    if (set == 100) break;
  }
  ASSERT_EQ(set, 100);
  EXPECT_GE(within, 89) << "root mean square " << std::sqrt(squares / set);
  // At most twice too large, as kResampling_px is a bound of what interpolation does; not too small by chi-squared of
  // 100, whose mean has the standard deviation 0.14: four of them.
  EXPECT_GT(chi2 / set, 0.25);
  EXPECT_LT(chi2 / set, 1 + 4 * std::sqrt(2.0 / set));
  EXPECT_LE(tried, 110);
  RecordProperty("within", within);
  RecordProperty("chi2", std::to_string(chi2 / set));
  RecordProperty("tried", tried);
}

// What a person would see as a y-parallax: windows of the resampled pair, matched freely in both directions.
TEST(GroundMatch, TheResampledPairHasNoVerticalParallax) {
  const Pair& pair = rendered_pair();
  const Block& block = pair.scene.block();
  const auto image = [&](ImageId id) -> const GreyImage& { return pair.scene.greys.at(id); };
  const GreyImage left = resampled(image(pair.model.left), block.camera_of(pair.model.left),
                                   pair.model.pair.left_from_image, pair.model.pair.left, {});
  const GreyImage right = resampled(image(pair.model.right), block.camera_of(pair.model.right),
                                    pair.model.pair.right_from_image, pair.model.pair.right, {});
  std::vector<double> vertical;
  for (const StereoMark& mark : true_marks(pair, 100, 3)) {
    const WindowMatch match = match_window(left, {mark.x, mark.y}, right, {{mark.x - mark.parallax, mark.y}}, {});
    if (match.outcome == WindowOutcome::kFound) vertical.push_back(std::abs(match.position_px.y() - mark.y));
  }
  ASSERT_GE(vertical.size(), 60u);
  std::ranges::sort(vertical);
  EXPECT_LT(vertical[vertical.size() * 95 / 100], 0.3);
}

TEST(GroundMatch, SaysWhyItSetsNothing) {
  const Pair& pair = rendered_pair();
  const StereoMark mark = true_marks(pair, 1, 6).front();
  StereoMark beside = mark;
  beside.y = -20;
  const auto outside = match_ground(pair.scene.block(), pair.model, beside, pair.scene.photo(), {});
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().code, Errc::kBadInput);
  const PhotoWindow grey = [](ImageId, const PixelWindow& window) -> Result<FloatImage> {
    return FloatImage(window.width, window.height, 1, 100.0f);
  };
  const auto plain = match_ground(pair.scene.block(), pair.model, mark, grey, {});
  ASSERT_FALSE(plain);
  EXPECT_EQ(plain.error().code, Errc::kNotConverged);
  // Two photographs of something else: no match, never a wrong one.
  const PhotoWindow noise = [](ImageId image, const PixelWindow& window) -> Result<FloatImage> {
    FloatImage out(window.width, window.height);
    Random random(image.value, 9);
    for (float& value : out.data) value = float(255 * random.uniform());
    return out;
  };
  EXPECT_FALSE(match_ground(pair.scene.block(), pair.model, mark, noise, {}));
}

}  // namespace
}  // namespace collinea
