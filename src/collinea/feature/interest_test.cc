// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/interest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "collinea/feature/internal/separable_rows.h"
#include "collinea/feature/internal/tensor_patch.h"
#include "collinea/feature/local_maxima.h"

namespace collinea {
namespace {

using O = InterestOperator;

// Bolognesi T1: white, with a black square in the lower left.
GreyImage bolognesi() {
  GreyImage image(6, 6, 1, 255);
  for (int y = 3; y < 6; ++y)
    for (int x = 0; x < 3; ++x) image.at(x, y) = 0;
  return image;
}

GreyImage random_image(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  GreyImage image(width, height);
  for (auto& value : image.data) value = static_cast<std::uint8_t>(random() % 256);
  return image;
}

// A bright rectangle with soft edges: four corners.
GreyImage rectangle(int width, int height) {
  GreyImage image(width, height);
  const auto inside = [](double x, double low, double high) {
    return 0.5 * (std::erf((x - low) / 1.2) - std::erf((x - high) / 1.2));
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double part = inside(x + 0.5, 20, width - 20) * inside(y + 0.5, 20, height - 20);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(40 + 160 * part));
    }
  return image;
}

// Bolognesi T1: C / 255^2 is 1 1 / 2 1 in rows 3 and 4; suppression leaves row 4, column 3 (from 1).
TEST(Interest, MoravecOfBolognesiT1) {
  const FloatImage map = interest_map(bolognesi(), {.method = O::kMoravec});
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 6; ++x) {
      const bool is_inside = x >= 2 && x <= 3 && y >= 2 && y <= 3;
      EXPECT_EQ(map.at(x, y), !is_inside ? 0.0f : x == 2 && y == 3 ? 2 * 65025.0f : 65025.0f) << x << ' ' << y;
    }
  const auto maxima = local_maxima(map, 1, 0);
  ASSERT_EQ(maxima.size(), 1u);
  EXPECT_EQ(maxima[0], (MapPixel{2, 3, 130050}));
}

// Karfis W1: an isolated pixel, 0 among 255, has 2 * 255^2 = 130050 by his own formula (520200 is printed, the sum of
// eight squared differences, which is no V); a constant image has 0.
TEST(Interest, MoravecOfAnIsolatedPixelByKarfisW1) {
  GreyImage image(9, 9, 1, 255);
  image.at(4, 4) = 0;
  EXPECT_EQ(interest_map(image, {.method = O::kMoravec}).at(4, 4), 130050.0f);
  const FloatImage flat = interest_map(GreyImage(9, 9, 1, 140), {.method = O::kMoravec});
  EXPECT_EQ(*std::ranges::max_element(flat.data), 0.0f);
}

// Bolognesi T1 with the 3 x 3 window .04 .12 .36 (sigma 0.6746): eigenvalues and Harris' measure with k = 0.05.
TEST(Interest, HarrisAndShiTomasiOfBolognesiT1) {
  InterestOptions o{.method = O::kHarris, .sigma_px = 0.6746, .window_radius_px = 1, .harris_k = 0.05};
  const FloatImage harris = interest_map(bolognesi(), o);
  o.method = O::kShiTomasi;
  const FloatImage smaller = interest_map(bolognesi(), o);
  o.method = O::kNoble;
  const FloatImage noble = interest_map(bolognesi(), o);
  o.method = O::kHarris;
  o.harris_k = 0;
  const FloatImage determinant = interest_map(bolognesi(), o);
  const struct {
    int column, row;
    double harris, larger, smaller, a, b, c;
  } expected[] = {{2, 2, .056, .66833, .13167, .16, .64, .12},
                  {3, 2, .01888, .2, .12, .16, .16, .04},
                  {2, 3, .19808, 1, .28, .64, .64, .36},
                  {3, 3, .056, .66833, .13167, .64, .16, .12}};
  constexpr double kWhite2 = 255.0 * 255.0;
  for (const auto& e : expected) {
    EXPECT_NEAR(harris.at(e.column, e.row) / (kWhite2 * kWhite2), e.harris, 1e-4);
    EXPECT_NEAR(smaller.at(e.column, e.row) / kWhite2, e.smaller, 1e-4);
    EXPECT_NEAR(determinant.at(e.column, e.row) / kWhite2 / smaller.at(e.column, e.row), e.larger, 1e-4);
    EXPECT_NEAR(noble.at(e.column, e.row) / kWhite2, (e.a * e.b - e.c * e.c) / (e.a + e.b), 1e-4);
  }
}

// Karfis W4: row 3 of his kernel / 273 is printed 7 16 41 16 7; only with 26 is it a Gaussian (of sigma 1).
// Karfis W4: the 25 whole numbers are integrals over pixels of the Gaussian of one pixel, here of a window of 99 taps a
// pixel, times a factor. Any of 280.2 to 282.2 gives them all (7 must not fall below 6.5, 16 not exceed 16.5); their
// sum is 273. With the misprint, 16 in place of 26, no factor does.
TEST(Interest, TheWindowIsThatOfKarfisW4) {
  const int printed[3][3] = {{41, 26, 7}, {26, 16, 4}, {7, 4, 1}};  // from the middle outwards
  constexpr int kTaps = 99;
  const std::vector<float> taps = gaussian_window(kTaps, 6 * kTaps);
  double integrals[3] = {taps[0], 0, 0};
  for (int j = 1; j <= kTaps / 2; ++j) integrals[0] += 2 * double{taps[std::size_t(j)]};
  for (int pixel = 1; pixel < 3; ++pixel)
    for (int j = -(kTaps / 2); j <= kTaps / 2; ++j) integrals[pixel] += double{taps[std::size_t(pixel * kTaps + j)]};
  for (const double factor : {280.3, 281.0, 282.0})
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(std::lround(factor * integrals[i] * integrals[j]), printed[j][i]) << factor;
  int sum = printed[0][0];
  for (int i = 1; i < 3; ++i) {
    sum += 4 * printed[0][i];
    for (int j = 1; j < 3; ++j) sum += 4 * printed[i][j];
  }
  EXPECT_EQ(sum, 273);
}

TEST(Interest, CurvatureTapsAreASecondDerivative) {
  for (const double sigma : {0.7, 1.0, 2.5}) {
    const std::vector<float> taps = gaussian_curvature(sigma, static_cast<int>(std::ceil(4 * sigma)));
    double sum = taps[0], moment = 0;
    for (std::size_t j = 1; j < taps.size(); ++j) {
      sum += 2 * double{taps[j]};
      moment += 2 * static_cast<double>(j * j) * double{taps[j]};
    }
    EXPECT_NEAR(sum, 0, 1e-6);
    EXPECT_NEAR(moment, 2, 1e-5);
  }
}

// The tensor straight from its definition.
double kovesi_at(const GreyImage& image, int column, int row, double sigma, int radius) {
  double a = 0, b = 0, c = 0, weights = 0;
  for (int v = -radius; v <= radius; ++v)
    for (int u = -radius; u <= radius; ++u) {
      double gx = 0, gy = 0;
      for (int k = -1; k <= 1; ++k) {
        const int x = column + u, y = row + v;
        gx += double(image.at(x + 1, y + k)) - image.at(x - 1, y + k);
        gy += double(image.at(x + k, y + 1)) - image.at(x + k, y - 1);
      }
      const double w = std::exp(-0.5 * (u * u + v * v) / (sigma * sigma));
      weights += w;
      a += w * gx * gx;
      b += w * gy * gy;
      c += w * gx * gy;
    }
  return (a * b - c * c) / (a + b) / weights;
}

TEST(Interest, TheMapIsItsDefinitionAlsoAcrossStrips) {
  const GreyImage image = random_image(2080, 24, 7);
  const FloatImage map = interest_map(image, {.method = O::kKovesi, .sigma_px = 1.2});
  for (int y = 5; y < 19; ++y)
    for (const int x : {5, 6, 40, 2040, 2045, 2046, 2047, 2048, 2049, 2052, 2074}) {
      const double expected = kovesi_at(image, x, y, 1.2, 4);
      EXPECT_NEAR(map.at(x, y), expected, 1e-4 * expected) << x << ' ' << y;
    }
  EXPECT_EQ(map.at(4, 10), 0);
  EXPECT_EQ(map.at(2075, 10), 0);
  EXPECT_EQ(map.at(100, 4), 0);
}

class EveryOperator : public ::testing::TestWithParam<O> {};

TEST_P(EveryOperator, FindsNothingWhereNothingIs) {
  for (const GreyImage& image : {GreyImage(), GreyImage(3, 3, 1, 7), GreyImage(80, 60, 1, 128)})
    EXPECT_TRUE(find_interest_points(image, {.method = GetParam()}).points.empty());
}

TEST_P(EveryOperator, TurnsWithTheImage) {
  const GreyImage image = rectangle(90, 70);
  GreyImage turned(70, 90);  // by a quarter
  for (int y = 0; y < 70; ++y)
    for (int x = 0; x < 90; ++x) turned.at(69 - y, x) = image.at(x, y);
  const InterestOptions options{.method = GetParam(), .relative_threshold = 0.3};
  const auto points = find_interest_points(image, options).points, there = find_interest_points(turned, options).points;
  ASSERT_EQ(points.size(), there.size());
  for (const InterestPoint& p : points) {
    double nearest = 1e9;
    for (const InterestPoint& q : there)
      nearest = std::min(nearest, (q.position_px - Eigen::Vector2d(70 - p.position_px.y(), p.position_px.x())).norm());
    EXPECT_LT(nearest, GetParam() == O::kSift ? 0.1 : 0.01);  // of its octaves each takes the upper left of four pixels
  }
}

TEST_P(EveryOperator, DependsOnNoChanceAndOnNoOrder) {
  const GreyImage image = random_image(120, 90, 3);
  const auto a = find_interest_points(image, {.method = GetParam(), .max_points = 50});
  const auto b = find_interest_points(image, {.method = GetParam(), .max_points = 50});
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_LE(a.points.size(), 50u);
  for (std::size_t i = 0; i < a.points.size(); ++i) EXPECT_EQ(a.points[i].position_px, b.points[i].position_px);
}

INSTANTIATE_TEST_SUITE_P(Interest, EveryOperator,
                         ::testing::Values(O::kMoravec, O::kHarris, O::kNoble, O::kKovesi, O::kShiTomasi, O::kFoerstner,
                                           O::kLog, O::kDog, O::kSift),
                         [](const auto& tested) {
                           std::string name(word_of(tested.param));
                           std::erase(name, '-');
                           return name;
                         });

class EveryCornerOperator : public ::testing::TestWithParam<O> {};

TEST_P(EveryCornerOperator, FindsTheFourCorners) {
  const GreyImage image = rectangle(90, 70);
  const auto found = find_interest_points(image, {.method = GetParam(), .relative_threshold = 0.3});
  ASSERT_EQ(found.points.size(), 4u);
  for (const InterestPoint& p : found.points) {
    const double dx = std::min(std::abs(p.position_px.x() - 20), std::abs(p.position_px.x() - 70));
    const double dy = std::min(std::abs(p.position_px.y() - 20), std::abs(p.position_px.y() - 50));
    EXPECT_LT(std::hypot(dx, dy), 2.2);  // inside the corner, as blur and window draw it
  }
}

INSTANTIATE_TEST_SUITE_P(Interest, EveryCornerOperator,
                         ::testing::Values(O::kMoravec, O::kHarris, O::kNoble, O::kKovesi, O::kShiTomasi,
                                           O::kFoerstner));

// A single pixel looks like a corner (Karfis 2.2): noise, and no template to match.
TEST(Interest, AnIsolatedPixelIsRejected) {
  for (const O method : {O::kMoravec, O::kHarris, O::kShiTomasi}) {
    GreyImage image = rectangle(90, 70);
    image.at(45, 35) = 0;
    image.at(20, 35) = 255;  // on an edge
    InterestOptions options{.method = method, .relative_threshold = 0.02};
    const auto near = [](const InterestPoints& found, double x, double y) {
      return std::ranges::count_if(
          found.points, [&](const InterestPoint& p) { return (p.position_px - Eigen::Vector2d(x, y)).norm() < 2; });
    };
    const InterestPoints found = find_interest_points(image, options);
    EXPECT_EQ(near(found, 45.5, 35.5), 0);
    EXPECT_EQ(near(found, 20.5, 35.5), 0);
    EXPECT_GE(found.isolated, 2u);
    options.keep_isolated = true;
    EXPECT_GE(near(find_interest_points(image, options), 45.5, 35.5), 1);
  }
}

// Strips end at rows 256 and 512: maxima beside them are those of the whole map.
TEST(Interest, PixelsByStripsAreThoseOfTheWholeImage) {
  GreyImage image = random_image(90, 600, 5);
  image.at(40, 300) = 255;
  InterestOptions options{.method = O::kKovesi,
                          .threshold = 9000,
                          .radius_px = 2,
                          .sub_pixel = SubPixel::kNone,
                          .max_points = 1'000'000,
                          .evenness = 0};
  const auto strips = interest_pixels(image, options, {});
  std::vector<MapPixel> whole;
  for (const InterestPoint& point : find_interest_points(image, options).points)
    whole.push_back({int(point.position_px.x()), int(point.position_px.y()), float(point.strength)});
  std::ranges::sort(whole, {}, [](const MapPixel& m) { return std::tuple(-m.value, m.row, m.column); });
  EXPECT_GT(whole.size(), 500u);
  int beside = 0;
  for (const MapPixel& pixel : whole) beside += std::abs(pixel.row - 256) < 4 || std::abs(pixel.row - 512) < 4;
  EXPECT_GT(beside, 10);
  EXPECT_EQ(strips, whole);
  EXPECT_EQ(interest_pixels(image, options, {.threads = 3}), strips);
}

TEST(Interest, APatchHasTheResponsesOfTheMap) {
  const GreyImage image = random_image(60, 50, 8);
  for (const O method : {O::kHarris, O::kNoble, O::kKovesi, O::kShiTomasi}) {
    const InterestOptions options{.method = method, .sigma_px = 1.2};
    const std::vector<float> taps = gaussian_window(1.2, 4);
    const FloatImage map = interest_map(image, options);
    TensorPatch patch(taps, method == O::kKovesi ? GradientMask::kPrewitt : GradientMask::kCentral,
                      method == O::kHarris      ? CornerMeasure::kHarris
                      : method == O::kShiTomasi ? CornerMeasure::kSmallerEigenvalue
                                                : CornerMeasure::kNoble,
                      float(options.harris_k));
    for (int y = patch.reach(); y < image.height - patch.reach(); y += 3)
      for (int x = patch.reach(); x < image.width - patch.reach(); x += 2) {
        float most = 0;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) most = std::max(most, map.at(x + i, y + j));
        patch.take(image, x, y);
        ASSERT_EQ(patch.strongest(), most) << x << ' ' << y;
      }
  }
}

TEST(Interest, EvennessGivesWeakRegionsTheirPart) {
  GreyImage image = random_image(400, 200, 5);
  for (int y = 0; y < 200; ++y)
    for (int x = 200; x < 400; ++x) image.at(x, y) = static_cast<std::uint8_t>(100 + image.at(x, y) / 5);
  const auto weak = [&](double evenness) {
    const auto found = find_interest_points(
        image, {.relative_threshold = 0, .keep_isolated = true, .max_points = 200, .evenness = evenness});
    EXPECT_EQ(found.points.size(), 200u);
    return std::ranges::count_if(found.points, [](const auto& p) { return p.position_px.x() > 200; });
  };
  EXPECT_LT(weak(0), 5);
  EXPECT_GE(weak(1), weak(0));
}

// A disc of radius r is strongest for a Laplacian of sigma = r / sqrt(2), and lies in its middle.
TEST(Interest, BlobsLieInTheMiddleOfDiscs) {
  GreyImage image(80, 80, 1, 60);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) {
      const double r = std::hypot(x + 0.5 - 38.3, y + 0.5 - 41.6);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(60 + 70 * (1 - std::erf((r - 7) / 1.2))));
    }
  for (const O method : {O::kLog, O::kDog}) {
    const auto found = find_interest_points(image, {.method = method, .sigma_px = 5, .relative_threshold = 0.3});
    ASSERT_EQ(found.points.size(), 1u);
    EXPECT_LT((found.points[0].position_px - Eigen::Vector2d(38.3, 41.6)).norm(), 0.05);
  }
  const auto strength = [&](double sigma) {
    const FloatImage map = interest_map(image, {.method = O::kLog, .sigma_px = sigma});
    return map.at(38, 41);
  };
  EXPECT_GT(strength(5), strength(4));
  EXPECT_GT(strength(5), strength(6));
}

}  // namespace
}  // namespace collinea
