// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// A strip of 12 images, each overlapping the next two; a fifth of the points shows something else in each image.
TEST(Exposures, GainsAndFalloffAreRecoveredDespiteOutliers) {
  Random random(11);
  constexpr int kImages = 12;
  std::vector<std::vector<ColourSample>> samples(kImages);
  std::vector<double> log_gain;
  for (int i = 0; i < kImages; ++i) log_gain.push_back(random.uniform(-0.2, 0.2));
  double trend = 0;  // which would be the directions'
  for (int i = 0; i < kImages; ++i) trend += (i - 5.5) * log_gain[std::size_t(i)] / 143;
  for (int i = 0; i < kImages; ++i) log_gain[std::size_t(i)] -= trend * (i - 5.5);
  const std::vector<Eigen::Vector2d> positions(1200, Eigen::Vector2d::Zero());
  for (std::uint32_t index = 0; index < 1200; ++index) {
    const double colour = random.uniform(3.5, 4.5);
    for (int i = int(index) / 100; i < std::min(kImages, int(index) / 100 + 3); ++i) {
      const double r2 = random.uniform(0, 1), wrong = random.uniform() < 0.2 ? random.uniform(-0.5, 0.5) : 0;
      const float value = float(colour + log_gain[std::size_t(i)] - 0.3 * r2 + wrong + 0.02 * random.normal());
      samples[std::size_t(i)].push_back({index, float(r2), {value, value, value}});
    }
  }
  std::vector<Standpoint> standpoints;
  for (int i = 0; i < kImages; ++i) standpoints.push_back({CameraId{1}, {double(i), 0}});
  const auto exposures = balance_exposures(positions, samples, standpoints, collinea::Run{}).value().exposures;
  EXPECT_NEAR(exposures[0].falloff[0], 0.3, 0.02);
  for (std::size_t i = 1; i < kImages; ++i) {
    const double ratio = std::log(double(exposures[i].gain[2]) / double(exposures[i - 1].gain[2]));
    EXPECT_NEAR(ratio, log_gain[i - 1] - log_gain[i], 0.02) << i;
  }
}

// Six strips of eight images over ground that sends more light back to the sun: brighter the further west one stands,
// most where the shadow of the camera falls. The exposures differ at random; they must not take over that trend.
TEST(Exposures, LightSentBackToTheSunDoesNotBecomeATrendOfTheGains) {
  Random random(12);
  constexpr int kAcross = 8, kDown = 6;
  const auto log_brightness = [](const Eigen::Vector2d& u) {
    return -0.5 * u.x() + 0.2 * std::exp(-30 * (u - Eigen::Vector2d(-0.25, 0.1)).squaredNorm());
  };
  std::vector<double> log_gain;
  for (int i = 0; i < kAcross * kDown; ++i) log_gain.push_back(0.05 * random.normal());
  std::vector<std::vector<ColourSample>> samples(kAcross * kDown);
  std::vector<Eigen::Vector2d> positions;
  for (std::uint32_t index = 0; index < 3000; ++index) {
    const Eigen::Vector2d at(random.uniform(-0.3, 0.2 * kAcross + 0.1), random.uniform(-0.3, 0.3 * kDown));
    positions.push_back(at);
    const double colour = random.uniform(3.5, 4.5);
    for (int i = 0; i < kAcross * kDown; ++i) {
      const Eigen::Vector2d from(0.2 * (i % kAcross), 0.3 * (i / kAcross)), t = from - at;  // in flying heights
      if (t.cwiseAbs().maxCoeff() > 0.5) continue;
      const Eigen::Vector2d u = t / std::sqrt(1 + t.squaredNorm());
      const float value = float(colour + log_gain[std::size_t(i)] + log_brightness(u) + 0.02 * random.normal());
      samples[std::size_t(i)].push_back({index, float(2 * t.squaredNorm()), {value, value, value}, u});
    }
  }
  std::vector<Standpoint> standpoints;
  for (int i = 0; i < kAcross * kDown; ++i)
    standpoints.push_back({CameraId{1}, {0.2 * (i % kAcross), 0.3 * (i / kAcross)}});
  const ColourBalance balance = balance_exposures(positions, samples, standpoints, collinea::Run{}).value();
  double trend = 0, squares = 0;  // of the gains from west to east
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double x = double(i % kAcross) - (kAcross - 1) / 2.0;
    trend += x * (std::log(double(balance.exposures[i].gain[1])) + log_gain[i]), squares += x * x;
  }
  // The directions' trend of 0.5 would make 0.1 from image to image. What is left is the chance trend of the gains.
  EXPECT_NEAR(trend / squares, 0, 0.01);
  // Every point looks the same from everywhere. How much of that the fall-off does is arbitrary.
  const auto corrected = [&](const Eigen::Vector2d& t) {
    const Eigen::Vector2d u = t / std::sqrt(1 + t.squaredNorm());
    return double(balance.exposures[0].falloff[1]) * 2 * t.squaredNorm() + double(balance.directions.at(u)[1]) +
           log_brightness(u);
  };
  const double above = corrected({0, 0});
  for (const auto& [x, y] : {std::pair(-0.3, 0.0), {0.3, 0.0}, {0.0, 0.3}, {0.2, -0.3}, {-0.25, 0.1}})
    EXPECT_NEAR(corrected({x, y}), above, 0.05) << x << " " << y;
  // In the middle of the block the directions have nothing to say on the whole; at its eastern border, seen from the
  // west only, the ground keeps the brightness of that side.
  EXPECT_NEAR(double(balance.mean_darkness.at({0.7, 0.75})[1]), 0, 0.03);
  EXPECT_NEAR(double(balance.mean_darkness.at({1.8, 0.75})[1]), -0.5 * 0.4, 0.06);
}

TEST(Exposures, MayBeCancelled) {
  std::vector<std::vector<ColourSample>> samples(2);
  for (std::uint32_t i = 0; i < 50; ++i)
    for (auto& seen : samples) seen.push_back({i, 0.1f, {4, 4, 4}});
  const std::vector<Eigen::Vector2d> positions(50, Eigen::Vector2d::Zero());
  const std::vector<Standpoint> standpoints{{CameraId{1}, {0, 0}}, {CameraId{1}, {1, 0}}};
  std::stop_source stop;
  stop.request_stop();
  collinea::Run run;
  run.stop = stop.get_token();
  const auto balance = balance_exposures(positions, samples, standpoints, run);
  ASSERT_FALSE(balance);
  EXPECT_EQ(balance.error().code, Errc::kCancelled);
}

// The images stand a little aside of the line: that is no axis along which exposures could have a trend.
TEST(Exposures, OfAStripAreNotHeldBackAcrossIt) {
  Random random(14);
  constexpr int kImages = 8;
  std::vector<Standpoint> standpoints;
  std::vector<double> log_gain;
  for (int i = 0; i < kImages; ++i) {
    log_gain.push_back(0.3 * (i % 2 == 0 ? 1 : -1) * (i % 4 < 2 ? 1 : 0.3));
    standpoints.push_back({CameraId{1}, {0.2 * i, 0.01 * (i % 2 == 0 ? 1 : -1)}});
  }
  std::vector<std::vector<ColourSample>> samples(kImages);
  std::vector<Eigen::Vector2d> positions;
  for (std::uint32_t index = 0; index < 600; ++index) {
    positions.emplace_back(random.uniform(0, 1.4), random.uniform(-0.3, 0.3));
    for (std::size_t i = 0; i < kImages; ++i) {
      const Eigen::Vector2d t = standpoints[i].at - positions.back();
      if (t.cwiseAbs().maxCoeff() > 0.4) continue;
      const float value = float(4 + log_gain[i] + 0.02 * random.normal());
      samples[i].push_back(
          {index, float(2 * t.squaredNorm()), {value, value, value}, t / std::sqrt(1 + t.squaredNorm())});
    }
  }
  const ColourBalance balance = balance_exposures(positions, samples, standpoints, collinea::Run{}).value();
  double product = 0, squares = 0;
  for (std::size_t i = 1; i < kImages; ++i) {
    const double truth = log_gain[i - 1] - log_gain[i];
    product += truth * std::log(double(balance.exposures[i].gain[1]) / double(balance.exposures[i - 1].gain[1]));
    squares += truth * truth;
  }
  EXPECT_NEAR(product / squares, 1, 0.02);
}

TEST(Exposures, ImagesWithoutCommonPositionsStayAsTheyAre) {
  std::vector<std::vector<ColourSample>> samples(2);
  const std::vector<Eigen::Vector2d> positions(50, Eigen::Vector2d::Zero());
  for (std::uint32_t i = 0; i < 50; ++i) {
    const bool second = i % 2 == 1;  // is brighter, towards its corners and from the east
    const Eigen::Vector2d direction(0.01 * i - 0.25, 0.2);
    const float r2 = 0.02f * float(i), value = second ? 4.5f + 0.3f * r2 + float(direction.x()) : 4.0f;
    samples[second].push_back({i, r2, {value, value - 0.2f, value + 0.1f}, direction});
  }
  const std::vector<Standpoint> standpoints{{CameraId{1}, {0, 0}}, {CameraId{1}, {1, 0}}};
  const ColourBalance balance = balance_exposures(positions, samples, standpoints, collinea::Run{}).value();
  ASSERT_EQ(balance.exposures.size(), 2u);
  const std::array<float, 3> ones{1, 1, 1}, zeros{0, 0, 0};
  for (const Exposure& exposure : balance.exposures) {
    EXPECT_EQ(exposure.gain, ones);
    EXPECT_EQ(exposure.falloff, zeros);
  }
  for (const double x : {-0.8, -0.2, 0.0, 0.5}) {
    EXPECT_EQ(balance.directions.at({x, 0.2}), zeros) << x;
    EXPECT_EQ(balance.mean_darkness.at({x, 0}), zeros) << x;
  }
}

}  // namespace
}  // namespace collinea
