// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/tags.h"

#include <gtest/gtest.h>

#include <limits>

#include "collinea/feature/internal/dark_quads.h"
#include "collinea/feature/internal/tag_model.h"
#include "collinea/feature/test_tags.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

TagScene scene_of(TagFamily family, double side_px, std::uint64_t seed, int middle = 64) {
  Random random(seed, 5);
  return {.family = family,
          .id = int(random.uniform(0, double(tag_codes(family).bits.size()) - 1e-9)),
          .at = Vector2d::Constant(middle) + Vector2d(random.uniform(-1, 1), random.uniform(-1, 1)),
          .side_px = side_px,
          .rotation_rad = random.uniform(0, 6.283),
          .tilt_towards_rad = random.uniform(0, 6.283)};
}

double chi2(const Vector2d& error, const Matrix2d& covariance) { return error.dot(covariance.inverse() * error); }

TEST(TagModel, DerivativesAreTheNumericOnes) {
  TagCells cells{6, {}};
  for (int i = 0; i < 64; ++i) {
    const int x = i % 8, y = i / 8, ring = std::min({x, y, 7 - x, 7 - y});
    cells.light.push_back(ring == 0 ? 1 : ring == 1 ? 0 : (i * 7 / 3) % 2);
  }
  VectorXd u(13);
  u << 20.3, 19.8, 0.8, 40, 0.5, -0.3, 120, 22, -8, 6, 17, 0.15, -0.1;
  const TagModel model(cells, TagUnknowns(u));
  for (double y = 2.5; y < 40; y += 3)
    for (double x = 2.5; x < 40; x += 1) {
      std::array<double, 13> d;
      (void)model.grey(u, {x, y}, d.data());
      for (int k = 0; k < 13; ++k) {
        VectorXd plus = u, minus = u;
        plus[k] += 1e-6;
        minus[k] -= 1e-6;
        const double numeric = (model.grey(plus, {x, y}, nullptr) - model.grey(minus, {x, y}, nullptr)) / 2e-6;
        EXPECT_NEAR(d[std::size_t(k)], numeric, 1e-4) << k << " at " << x << ' ' << y;
      }
    }
}

TEST(TagModel, PositionsGoThereAndBack) {
  const TagCorners corners{Vector2d(10, 12), Vector2d(41, 8), Vector2d(45, 44), Vector2d(6, 37)};
  const TagUnknowns u = tag_unknowns(corners);
  EXPECT_LT((tag_position(u, {-0.5, -0.5}) - corners[0]).norm(), 1e-10);
  EXPECT_LT((tag_position(u, {0.5, -0.5}) - corners[1]).norm(), 1e-10);
  EXPECT_LT((tag_position(u, {0.5, 0.5}) - corners[2]).norm(), 1e-10);
  EXPECT_LT((tag_position(u, {-0.5, 0.5}) - corners[3]).norm(), 1e-10);
  EXPECT_LT((on_tag(u, tag_position(u, {0.2, -0.3})).q - Vector2d(0.2, -0.3)).norm(), 1e-12);
  const CellShares shares = cell_shares(2.3, 0.4, 6);
  double sum = 0, change = 0;
  for (std::size_t i = 0; i < std::size_t(shares.count); ++i) sum += shares.share[i], change += shares.by_position[i];
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_NEAR(change, 0, 1e-12);
}

TEST(DarkQuads, CornersThatWereCutAreExtended) {
  const std::vector<Vector2d> cut{{1, 0}, {9, 0}, {10, 1}, {10, 10}, {0, 10}, {0, 1}};
  const std::vector<Vector2d> quad = quad_about(cut);
  ASSERT_EQ(quad.size(), 4u);
  for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(10, 0), Vector2d(10, 10), Vector2d(0, 10)})
    EXPECT_TRUE(std::ranges::any_of(quad, [&](const Vector2d& q) { return (q - corner).norm() < 1e-9; }));
  EXPECT_TRUE(quad_about({{0, 0}, {1, 0}, {0, 1}}).empty());
}

class TagsOf : public testing::TestWithParam<TagFamily> {};

// From 12 px a side on (1.5 px a cell), in all positions, and seen obliquely from 14 px on.
TEST_P(TagsOf, AreFoundFromTwelvePixelsOn) {
  int trials = 0, found = 0;
  double squares = 0;
  for (const double side : {12.0, 14.0, 16.0, 20.0, 30.0, 60.0})
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      TagScene scene = scene_of(GetParam(), side, seed + std::uint64_t(side) * 100);
      if (side >= 14) scene.tilt_rad = 0.1 * double(seed);
      const FloatImage image = image_of_tag(scene, 128, 128, 3, seed);
      const std::vector<Tag> tags = find_tags(image, {.least_side_px = 8});
      ++trials;
      ASSERT_LE(tags.size(), 1u);
      if (tags.empty() || tags[0].id != scene.id || tags[0].family != GetParam()) continue;
      ++found;
      const auto truth = scene.corners();
      for (std::size_t k = 0; k < 4; ++k) squares += (tags[0].corners[k] - truth[k]).squaredNorm() / 8;
      EXPECT_LT((tags[0].at - scene.at).norm(), 0.08) << side;
    }
  EXPECT_GE(found, trials - 1);  // of 1024 original codes a few are others turned
  EXPECT_LT(std::sqrt(squares / found), 0.03);
}

INSTANTIATE_TEST_SUITE_P(Families, TagsOf, testing::ValuesIn(kWidestTagFamilies), [](const auto& tested) {
  std::string name(word_of(tested.param));
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
});

// 200 tags of 14 to 40 px, turned, tilted, with noise: e' C^-1 e of the centre is chi-squared with 2 degrees of
// freedom, its mean over n tags 2 with the standard deviation 2 / sqrt(n). The same of a corner.
TEST(Tags, CovariancesAreTheErrors) {
  double centre = 0, corner = 0, within = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed, 9);
    TagScene scene = scene_of(kWidestTagFamilies[seed % 5], random.uniform(16, 40), seed, 48);
    scene.id = int(seed % 200);
    scene.tilt_rad = random.uniform(0, 0.9);
    scene.blur_px = random.uniform(0.5, 0.9);
    const auto tags = find_tags(image_of_tag(scene, 96, 96, random.uniform(4, 8), seed), {.family = scene.family});
    if (tags.size() != 1 || tags[0].id != scene.id) continue;
    ++count;
    const double at = chi2(tags[0].at - scene.at, tags[0].covariance);
    centre += at;
    within += at < 5.991;
    corner += chi2(tags[0].corners[1] - scene.corners()[1], tags[0].corner_covariances[1]);
  }
  EXPECT_GE(count, 190);
  RecordProperty("chi2", std::to_string(centre / count));
  RecordProperty("chi2_corner", std::to_string(corner / count));
  EXPECT_NEAR(centre / count, 2, 4 * 2 / std::sqrt(count));
  EXPECT_NEAR(corner / count, 2, 4 * 2 / std::sqrt(count));
  EXPECT_NEAR(within / count, 0.95, 4 * std::sqrt(0.95 * 0.05 / count));
}

// Where the diagonals cross, and not the mean of the corners: 3 px apart here.
TEST(Tags, TheCentreIsThatOfThePlane) {
  TagScene scene = scene_of(TagFamily::kAruco5x5x250, 120, 4, 100);
  scene.tilt_rad = 1.0;
  const auto tags = find_tags(image_of_tag(scene, 200, 200, 2), {});
  ASSERT_EQ(tags.size(), 1u);
  const auto corners = scene.corners();
  EXPECT_GT(((corners[0] + corners[1] + corners[2] + corners[3]) / 4 - scene.at).norm(), 1.0);
  EXPECT_LT((tags[0].at - scene.at).norm(), 0.02);
}

TEST(Tags, LargeOnesAreMeasuredInASmallerImage) {
  TagScene scene = scene_of(TagFamily::kApriltag36h11, 420, 4, 400);
  scene.tilt_rad = 0.3;
  FloatImage image(800, 800, 1, 0.5f);
  draw_tag(image, scene, 2);
  for (float& grey : image.data) grey = 40 + 160 * grey;
  const auto tags = find_tags(with_noise(std::move(image), 3, 1), {});
  ASSERT_EQ(tags.size(), 1u);
  EXPECT_EQ(tags[0].id, scene.id);
  EXPECT_LT((tags[0].at - scene.at).norm(), 0.03);
  EXPECT_LT((tags[0].corners[2] - scene.corners()[2]).norm(), 0.1);
}

TEST(Tags, WrongCellsAreCorrectedWithinTheDistance) {
  TagScene scene = scene_of(TagFamily::kApriltag36h11, 60, 8);
  scene.damaged = 0b1000'0000'0100;
  const FloatImage image = image_of_tag(scene, 128, 128, 2);
  const auto tags = find_tags(image, {});
  ASSERT_EQ(tags.size(), 1u);
  EXPECT_EQ(tags[0].id, scene.id);
  EXPECT_EQ(tags[0].wrong, 2);
  scene.damaged = 0b1111'0000'0000'1111'0001'1111;
  EXPECT_TRUE(find_tags(image_of_tag(scene, 128, 128, 2), {}).empty());
}

TEST(Tags, LightGroundAndAWholeTagAreNeeded) {
  TagScene scene = scene_of(TagFamily::kAruco4x4x250, 40, 3);
  EXPECT_EQ(find_tags(image_of_tag(scene, 128, 128, 2), {}).size(), 1u);
  EXPECT_EQ(find_tags(image_of_tag(scene, 128, 128, 2), {.family = TagFamily::kAruco6x6x50}).size(), 0u);
  EXPECT_EQ(find_tags(image_of_tag(scene, 128, 128, 2), {.least_side_px = 50}).size(), 0u);
  FloatImage inverse = image_of_tag(scene, 128, 128, 2);
  for (float& grey : inverse.data) grey = 240 - grey;
  EXPECT_TRUE(find_tags(inverse, {}).empty());
  scene.at = {12, 64};  // cut off
  EXPECT_TRUE(find_tags(image_of_tag(scene, 128, 128, 2), {}).empty());
}

TEST(Tags, ThereAreNoneInTexture) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    FloatImage image = with_noise(FloatImage(400, 300, 1, 110), 4, seed);
    for (const double sigma : {1.0, 2.5, 5.0}) {
      const FloatImage layer = smoothed(with_noise(FloatImage(400, 300), 1, seed * 10 + std::uint64_t(sigma)), sigma);
      for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] += float(60 * sigma * layer.data[i]);
    }
    Random random(seed);  // dark windows, some of them with bars
    for (int k = 0; k < 30; ++k) {
      const int x0 = int(random.uniform(5, 350)), y0 = int(random.uniform(5, 250)), side = int(random.uniform(10, 40));
      for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x)
          image.at(x, y) = k % 3 && (std::abs(x - x0 - side / 2) < 2 || std::abs(y - y0 - side / 2) < 2) ? 150 : 40;
    }
    found += find_tags(image, {}).size();
  }
  EXPECT_EQ(found, 0u);
}

// Images of any size and content: no harm, and no tag.
TEST(Tags, OddImagesDoNoHarm) {
  EXPECT_TRUE(find_tags({}, {}).empty());
  const float odd[] = {
      0, 255, -1e30f, 1e30f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed, 2);
    FloatImage image(1 + int(random.uniform(0, seed % 3 ? 40 : 4)), 1 + int(random.uniform(0, seed % 5 ? 40 : 3)));
    for (float& grey : image.data) grey = float(random.uniform(0, 255));
    if (seed % 2 == 0) {  // blocks of one grey, down to the borders
      for (int k = 0; k < 4; ++k) {
        const int x0 = int(random.uniform(0, image.width)), y0 = int(random.uniform(0, image.height));
        for (int y = y0; y < std::min(image.height, y0 + 20); ++y)
          for (int x = x0; x < std::min(image.width, x0 + 20); ++x) image.at(x, y) = k % 2 ? 10 : 240;
      }
    }
    if (seed % 7 == 0)
      for (std::size_t i = 0; i < image.data.size(); i += 1 + seed % 11) image.data[i] = odd[(seed / 7 + i) % 6];
    EXPECT_TRUE(find_tags(image, {.least_side_px = 8, .least_contrast = 5}).empty()) << seed;
  }
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {  // tags with pixels that are none
    Random random(seed, 3);
    FloatImage image = image_of_tag(scene_of(TagFamily::kApriltag36h11, 20, seed, 20), 40, 40);
    for (int k = 0; k < 5; ++k)
      image.at(int(random.uniform(0, 40)), int(random.uniform(0, 40))) = odd[std::size_t(random.uniform(0, 6))];
    for (const Tag& tag : find_tags(image, {})) EXPECT_TRUE(tag.at.allFinite() && tag.covariance.allFinite());
  }
}

}  // namespace
}  // namespace collinea
