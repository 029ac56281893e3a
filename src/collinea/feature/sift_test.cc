// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/sift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kPi = std::numbers::pi;

SiftOptions above(double peak_threshold) {
  SiftOptions options;
  options.peak_threshold = peak_threshold;
  return options;
}

SiftOptions with_upsampling(bool upsample) {
  SiftOptions options;
  options.upsample = upsample;
  return options;
}

struct Blob {
  double x, y, sigma_px, height;
};

// Gaussian blobs on grey. Each pixel holds the value at its centre, as after an ideal sampling, rounded to a byte.
GreyImage image_of(const std::vector<Blob>& blobs, int width, int height) {
  FloatImage sum(width, height, 1, 60);
  for (const Blob& blob : blobs) {
    const int reach = static_cast<int>(5 * blob.sigma_px) + 1, middle_x = static_cast<int>(blob.x),
              middle_y = static_cast<int>(blob.y);
    for (int y = std::max(0, middle_y - reach); y <= std::min(height - 1, middle_y + reach); ++y)
      for (int x = std::max(0, middle_x - reach); x <= std::min(width - 1, middle_x + reach); ++x) {
        const double dx = x + 0.5 - blob.x, dy = y + 0.5 - blob.y;
        sum.at(x, y) +=
            static_cast<float>(blob.height * std::exp(-(dx * dx + dy * dy) / (2 * blob.sigma_px * blob.sigma_px)));
      }
  }
  GreyImage image(width, height);
  std::ranges::transform(sum.data, image.data.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f)));
  });
  return image;
}

double distance(const Keypoint& keypoint, double x, double y) { return std::hypot(keypoint.x - x, keypoint.y - y); }

// An image with structure of many sizes: it can be looked at turned and scaled about its middle.
struct Scene {
  std::vector<Blob> blobs;
  explicit Scene(std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < 220; ++i)
      blobs.push_back({random.uniform(-110, 110), random.uniform(-110, 110), std::exp(random.uniform(0.6, 2.4)),
                       random.uniform(-50, 50)});
  }
  [[nodiscard]] GreyImage seen(double angle_rad, double scale, int size = 240) const {
    std::vector<Blob> moved;
    for (const Blob& blob : blobs) {
      const auto [x, y] = position(blob.x, blob.y, angle_rad, scale, size);
      moved.push_back({x, y, blob.sigma_px * scale, blob.height});
    }
    return image_of(moved, size, size);
  }
  static std::pair<double, double> position(double x, double y, double angle_rad, double scale, int size) {
    return {size / 2.0 + scale * (std::cos(angle_rad) * x - std::sin(angle_rad) * y),
            size / 2.0 + scale * (std::sin(angle_rad) * x + std::cos(angle_rad) * y)};
  }
};

int squared_distance(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (int{a[k]} - int{b[k]}) * (int{a[k]} - int{b[k]});
  return sum;
}

struct Agreement {
  int expected = 0, matched = 0, correct = 0;
  double angle_error_rad = 0, log_scale_error = 0;  // medians over the correct ones
};

double median(std::vector<double> values) {
  if (values.empty()) return 1e9;
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

// Features of the scene as it is, looked for by their descriptors in a turned and scaled view.
Agreement compare(double angle_rad, double scale, bool upsample) {
  const Scene scene(7);
  const int size = 240;
  SiftOptions options = above(0.004);
  options.upsample = upsample;
  const Features a = detect_sift(scene.seen(0, 1, size), options),
                 b = detect_sift(scene.seen(angle_rad, scale, size), options);
  Agreement agreement;
  std::vector<double> angles, scales;
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const Keypoint& from = a.keypoints[i];
    const auto [x, y] = Scene::position(from.x - size / 2.0, from.y - size / 2.0, angle_rad, scale, size);
    if (x < 25 || y < 25 || x > size - 25 || y > size - 25) continue;
    ++agreement.expected;
    int best = 1 << 30, second = 1 << 30;
    std::size_t best_j = 0;
    for (std::size_t j = 0; j < b.descriptors.size(); ++j) {
      const int d = squared_distance(a.descriptors[i], b.descriptors[j]);
      if (d < best) {
        second = best;
        best = d;
        best_j = j;
      } else if (d < second) {
        second = d;
      }
    }
    if (best > 0.64 * second) continue;
    ++agreement.matched;
    const Keypoint& to = b.keypoints[best_j];
    if (distance(to, x, y) > 1) continue;
    ++agreement.correct;
    angles.push_back(std::abs(std::remainder(to.angle_rad - from.angle_rad - angle_rad, 2 * kPi)));
    scales.push_back(std::abs(std::log(to.scale_px / from.scale_px / scale)));
  }
  agreement.angle_error_rad = median(angles);
  agreement.log_scale_error = median(scales);
  return agreement;
}

// Blobs of different sizes belong to different octaves; their positions are known to any fraction of a pixel. What is
// left is the error of the quadratic, up to 0.05 pixels of the octave between four pixels, and of the rounding to
// bytes.
TEST(Sift, BlobsAreFoundWhereTheyAreInEveryOctaveAndWithoutBias) {
  for (const bool upsample : {false, true})
    for (const double sigma_px : {2.4, 3.6, 6.0, 11.0, 20.0}) {
      Random random(static_cast<std::uint64_t>(sigma_px * 10));
      double sum_x = 0, sum_y = 0;
      constexpr int kTrials = 24;
      for (int trial = 0; trial < kTrials; ++trial) {
        const int size = static_cast<int>(60 + 10 * sigma_px);
        // Over a whole pixel of the coarsest octave.
        const double x = size / 2 + random.uniform(-8, 8), y = size / 2 + random.uniform(-8, 8);
        const Features features = detect_sift(image_of({{x, y, sigma_px, 150}}, size, size), with_upsampling(upsample));
        ASSERT_FALSE(features.keypoints.empty()) << sigma_px;
        const Keypoint& found = features.keypoints.front();
        EXPECT_LT(distance(found, x, y), 0.025 * found.scale_px) << sigma_px << " upsampled " << upsample;
        sum_x += found.x - x;
        sum_y += found.y - y;
      }
      EXPECT_LT(std::abs(sum_x / kTrials), 0.005 * sigma_px) << sigma_px << " upsampled " << upsample;
      EXPECT_LT(std::abs(sum_y / kTrials), 0.005 * sigma_px) << sigma_px << " upsampled " << upsample;
    }
}

// The difference of Gaussians of blur s and k s is extremal over a Gaussian blob of size t at s = t / sqrt(k), k =
// 2^(1/3).
TEST(Sift, TheScaleIsThatOfTheBlob) {
  for (const bool upsample : {false, true})
    for (const double sigma_px : {2.5, 4.0, 5.0, 8.0, 13.0}) {
      const int size = static_cast<int>(60 + 10 * sigma_px);
      // The area of a pixel is counted as blur, which a sampled function does not have.
      const double expected_px = std::sqrt(sigma_px * sigma_px + 1.0 / 12) / std::pow(2.0, 1.0 / 6);
      const Features features =
          detect_sift(image_of({{size / 2.0, size / 2.0, sigma_px, 150}}, size, size), with_upsampling(upsample));
      ASSERT_FALSE(features.keypoints.empty()) << sigma_px;
      const Keypoint& found = features.keypoints.front();
      EXPECT_NEAR(found.scale_px / expected_px, 1, 0.05) << sigma_px << " upsampled " << upsample;
    }
}

TEST(Sift, TurningTheSceneTurnsTheFeatures) {
  double matched = 0, correct = 0;
  for (const double angle_deg : {20.0, 45.0, 90.0, 133.0, 250.0})
    for (const bool upsample : {false, true}) {
      const Agreement agreement = compare(angle_deg * kPi / 180, 1, upsample);
      EXPECT_GT(agreement.expected, 40);
      EXPECT_GT(agreement.correct, 0.75 * agreement.expected) << angle_deg;
      // About 100 matches, 2.3 % of them wrong: three binomial deviations.
      EXPECT_GT(agreement.correct, 0.93 * agreement.matched) << angle_deg;
      EXPECT_LT(agreement.angle_error_rad, 0.02) << angle_deg;
      EXPECT_LT(agreement.log_scale_error, 0.02) << angle_deg;
      matched += agreement.matched, correct += agreement.correct;
    }
  EXPECT_GT(correct, 0.96 * matched);  // of 1100: four
}

TEST(Sift, ScalingTheSceneScalesTheFeatures) {
  for (const double scale : {0.7, 1.4, 2.0}) {
    const Agreement agreement = compare(0.3, scale, true);
    EXPECT_GT(agreement.expected, 15);
    EXPECT_GT(agreement.correct, 0.6 * agreement.expected) << scale;
    EXPECT_GE(agreement.correct, 0.9 * agreement.matched) << scale;
    EXPECT_LT(agreement.angle_error_rad, 0.03) << scale;
    EXPECT_LT(agreement.log_scale_error, 0.03) << scale;
  }
}

TEST(Sift, ContrastAndBrightnessDoNotMatterToTheDescriptor) {
  const Scene scene(3);
  GreyImage bright = scene.seen(0, 1);
  for (std::uint8_t& value : bright.data) value = static_cast<std::uint8_t>(value / 2 * 2);  // exactly halvable
  GreyImage dark = bright;
  for (std::uint8_t& value : dark.data) value = static_cast<std::uint8_t>(value / 2 + 20);
  const Features a = detect_sift(bright, above(0.004)), b = detect_sift(dark, above(0.002));
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    EXPECT_LT(distance(a.keypoints[i], b.keypoints[i].x, b.keypoints[i].y), 0.01);
    EXPECT_LT(squared_distance(a.descriptors[i], b.descriptors[i]), 128 * 2);
  }
}

TEST(Sift, EverythingIsAsTheHeaderPromises) {
  const GreyImage image = Scene(5).seen(0, 1);
  SiftOptions options;
  options.max_features = 150;
  const Features features = detect_sift(image, options);
  ASSERT_EQ(features.keypoints.size(), 150u);
  ASSERT_EQ(features.descriptors.size(), 150u);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    EXPECT_LE(keypoint.strength, features.keypoints[i > 0 ? i - 1 : 0].strength);
    EXPECT_GE(keypoint.angle_rad, 0);
    EXPECT_LT(keypoint.angle_rad, 2 * kPi + 1e-6);
    EXPECT_TRUE(keypoint.x > 0 && keypoint.y > 0 && keypoint.x < image.width && keypoint.y < image.height);
    double squares = 0;
    for (const std::uint8_t value : features.descriptors[i]) squares += double{1} * value * value;
    EXPECT_NEAR(std::sqrt(squares), 512, 6);
  }
}

TEST(Sift, TheSameImageGivesTheSameBits) {
  const GreyImage image = Scene(6).seen(0.1, 1);
  const Features a = detect_sift(image, {}), b = detect_sift(image, {});
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    EXPECT_EQ(a.keypoints[i].x, b.keypoints[i].x);
    EXPECT_EQ(a.keypoints[i].y, b.keypoints[i].y);
    EXPECT_EQ(a.keypoints[i].angle_rad, b.keypoints[i].angle_rad);
  }
  EXPECT_EQ(a.descriptors, b.descriptors);
}

TEST(Sift, ImagesWithoutStructureHaveNoFeatures) {
  EXPECT_TRUE(detect_sift(GreyImage(), {}).keypoints.empty());
  EXPECT_TRUE(detect_sift(GreyImage(15, 400, 1, 9), {}).keypoints.empty());
  EXPECT_TRUE(detect_sift(GreyImage(16, 16, 1, 9), {}).keypoints.empty());
  EXPECT_TRUE(detect_sift(GreyImage(200, 130, 1, 255), {}).keypoints.empty());
}

TEST(Sift, AStraightEdgeHasNoFeatures) {
  GreyImage image(200, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) image.at(x, y) = x + y / 3 < 130 ? 30 : 220;
  for (const Keypoint& keypoint : detect_sift(image, above(0.01)).keypoints)
    EXPECT_TRUE(keypoint.y < 40 || keypoint.y > 160) << keypoint.x << " " << keypoint.y;
}

// Whether levels are kept, or made three times a few rows at a time, the features are the same to the bit.
TEST(Sift, BandsOfALargeImageChangeNothing) {
  const Scene scene(7);
  for (const bool upsample : {false, true})
    for (const int height : {255, 431}) {
      GreyImage image = scene.seen(0, 1, 431);
      image.data.resize(std::size_t(image.width) * std::size_t(height));
      image.height = height;
      SiftOptions options = with_upsampling(upsample);
      options.max_features = 300;  // so that not all are described
      const Features kept = detect_sift(image, options, std::size_t{1} << 40);
      ASSERT_GT(kept.keypoints.size(), 100u);
      for (const std::size_t bytes : {std::size_t{0}, std::size_t{300'000}}) {
        const Features in_bands = detect_sift(image, options, bytes);
        ASSERT_EQ(in_bands.keypoints.size(), kept.keypoints.size());
        for (std::size_t i = 0; i < kept.keypoints.size(); ++i) {
          EXPECT_EQ(in_bands.keypoints[i].x, kept.keypoints[i].x);
          EXPECT_EQ(in_bands.keypoints[i].y, kept.keypoints[i].y);
          EXPECT_EQ(in_bands.keypoints[i].angle_rad, kept.keypoints[i].angle_rad);
          EXPECT_EQ(in_bands.keypoints[i].strength, kept.keypoints[i].strength);
          EXPECT_EQ(in_bands.descriptors[i], kept.descriptors[i]);
        }
      }
    }
}

}  // namespace
}  // namespace collinea
