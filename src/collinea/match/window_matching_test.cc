// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/window_matching.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <Eigen/Dense>
#include <cmath>

#include "collinea/match/internal/test_textures.h"
#include "collinea/match/internal/window_fit.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using testing::image_of;
using testing::WaveTexture;

constexpr int kSide_px = 56;
const Vector2d kMiddle(28.3, 27.6);

// What a window of the reference looks like in the other image.
struct Truth {
  Vector2d position_px;
  Matrix2d map = Matrix2d::Identity();
  double gain = 1, offset_grey = 0;
};

GreyImage seen(const WaveTexture& texture, const Truth& truth, double noise_grey, std::uint64_t seed) {
  const Matrix2d back = truth.map.inverse();
  return image_of(
      kSide_px, kSide_px,
      [&](const Vector2d& at) {
        return truth.gain * texture(kMiddle + back * (at - truth.position_px)) + truth.offset_grey;
      },
      noise_grey, seed);
}
GreyImage reference_of(const WaveTexture& texture, double noise_grey = 0, std::uint64_t seed = 1) {
  return image_of(kSide_px, kSide_px, texture, noise_grey, seed);
}

// A truth that the model can express.
Truth truth_of(WindowModel model, WindowLight light, Random& random) {
  const auto within = [&](double reach) { return random.uniform(-reach, reach); };
  Truth truth{kMiddle + Vector2d(within(0.7), within(0.7))};
  const double scale = 1 + within(0.08);
  if (model == WindowModel::kScale) truth.map *= scale;
  if (model == WindowModel::kSimilarity) {
    const double b = within(0.08);
    truth.map << scale, -b, b, scale;
  }
  if (model == WindowModel::kAffine) truth.map << scale, within(0.08), within(0.08), 1 + within(0.08);
  if (light == WindowLight::kGainOffset) truth.gain = 1 + within(0.15);
  if (light != WindowLight::kSame) truth.offset_grey = within(10);
  return truth;
}

// A start that is off; along the line where the model is one.
WindowStart start_near(const Truth& truth, WindowModel model, Random& random) {
  WindowStart start{truth.position_px + Vector2d(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7))};
  if (model != WindowModel::kLine) return start;
  const double angle = random.uniform(0, 6.28);
  start.line = 2 * Vector2d(std::cos(angle), std::sin(angle));
  start.position_px = truth.position_px + random.uniform(-0.4, 0.4) * start.line;
  return start;
}

WindowParameters parameters_of(const Truth& truth, const WindowStart& start, WindowModel model, WindowLight light) {
  std::vector<double> values;
  if (model == WindowModel::kLine) {
    values = {(truth.position_px - start.position_px).dot(start.line.normalized())};
  } else {
    values = {truth.position_px.x(), truth.position_px.y()};
  }
  const Matrix2d& m = truth.map;
  if (model == WindowModel::kScale) values.push_back(m(0, 0));
  if (model == WindowModel::kSimilarity) values.insert(values.end(), {m(0, 0), m(1, 0)});
  if (model == WindowModel::kAffine) values.insert(values.end(), {m(0, 0), m(0, 1), m(1, 0), m(1, 1)});
  if (light == WindowLight::kGainOffset) values.push_back(truth.gain);
  if (light != WindowLight::kSame) values.push_back(truth.offset_grey);
  return Eigen::Map<const WindowParameters>(values.data(), Eigen::Index(values.size()));
}

// Columns of A, as the score shows them, against central differences of the residuals by each unknown.
TEST(WindowFit, DerivativesAreThoseOfTheResiduals) {
  const WaveTexture texture(5, 10, 30);
  const GreyImage image = reference_of(texture);
  auto fit = WindowFit::of(image, kMiddle, 15, false);
  ASSERT_TRUE(fit);
  WindowPlacement at{kMiddle + Vector2d(0.35, -0.15), Matrix2d::Identity()};
  at.map << 1.05, 0.06, -0.04, 0.97;
  const WindowLightValues light{0.9, 120};
  ASSERT_TRUE(fit->sample(image, at));
  const ColumnMatrix matrix = fit->matrix();
  for (int k = 0; k < kWindowColumns; ++k) {
    // Single precision leaves 1e-5 grey to a residual, second differences of these waves a step squared.
    constexpr double kStep = 0.01;
    ColumnVector slope = ColumnVector::Zero();
    for (const int sign : {-1, 1}) {
      WindowPlacement moved = at;
      WindowLightValues lit = light;
      double* const unknowns[] = {&moved.position_px.x(), &moved.position_px.y(), &moved.map(0, 0), &moved.map(0, 1),
                                  &moved.map(1, 0),       &moved.map(1, 1),       &lit.gain,        &lit.offset_grey};
      const double step = k >= 2 && k < 6 ? kStep / 7 : kStep;  // the rim of the window moves as much
      *unknowns[k] += sign * step;
      ASSERT_TRUE(fit->sample(image, moved));
      fit->residuals(lit);
      slope += sign / (2 * step) * fit->score();
    }
    for (int row = 0; row < kWindowColumns; ++row)
      EXPECT_NEAR(slope[row], matrix(row, k),
                  1e-4 * std::sqrt(fit->normal()(row, row) * fit->normal()(k, k)) + 1e-3 * std::abs(matrix(row, k)))
          << row << ' ' << k;
  }
}

// The covariance of B'W r against what noise really does to it: each variance of n samples is good to sqrt(2 / n).
TEST(WindowFit, NoiseOfTheScoreIsThatOfTheImages) {
  constexpr int kTrials = 400;
  const WaveTexture texture(8, 8, 24);
  const GreyImage clean = reference_of(texture);
  WindowPlacement at{kMiddle + Vector2d(0.5, 0.25), Matrix2d::Identity()};
  at.map << 1.02, 0.05, -0.03, 0.95;
  const double gain = 0.8;
  auto fit = WindowFit::of(clean, kMiddle, 9, true);
  ASSERT_TRUE(fit && fit->sample(clean, at));
  const WindowFit::Noise noise = fit->noise(at, gain);
  ColumnVector sums = ColumnVector::Zero();
  double white = 0;
  constexpr double kNoise = 20;  // far above the rounding to whole numbers
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const auto grey = [](const Vector2d&) { return 128; };
    const GreyImage own = image_of(kSide_px, kSide_px, grey, kNoise, 2 * trial + 1),
                    other = image_of(kSide_px, kSide_px, grey, kNoise, 2 * trial + 2);
    auto noisy = WindowFit::of(own, kMiddle, 9, true);
    ASSERT_TRUE(noisy && noisy->sample(other, at));
    noisy->residuals({gain, 128});
    // The residuals of noise alone, weighted with the columns of the texture.
    std::vector<float> residuals(std::size_t(noisy->count() + kPointGroup), 0);
    for (int i = 0; i < noisy->count(); ++i)
      residuals[std::size_t(i)] = noisy->residual()[i] - float(gain * (noisy->mean_grey() - 128));
    const ColumnVector score = fit->score_of(residuals.data()) / kNoise;
    for (int i = 0; i < noisy->count(); ++i) {
      const double square = (std::pow(i % 9 - 4, 2) + std::pow(i / 9 - 4, 2)) / 16;  // of the half width
      white += std::exp(-0.5 * square / (0.6 * 0.6)) * std::pow(residuals[std::size_t(i)] / kNoise, 2);
    }
    sums += score.cwiseAbs2();
  }
  for (int k = 0; k < kWindowColumns; ++k)
    EXPECT_NEAR(sums[k] / kTrials / noise.covariance(k, k), 1, 4 * std::sqrt(2.0 / kTrials)) << k;
  // 9 x 9 smoothed points, those of the middle with more weight, are some 10 independent ones.
  EXPECT_NEAR(white / kTrials / noise.squares, 1, 4 * std::sqrt(2.0 / (10 * kTrials)));
}

struct ModelCase {
  WindowModel model;
  WindowLight light;
};
class EveryModel : public ::testing::TestWithParam<ModelCase> {
 protected:
  [[nodiscard]] static WindowOptions options() {
    WindowOptions out;
    out.model = GetParam().model;
    out.light = GetParam().light;
    return out;
  }
};

// Rounding to whole grey values is noise of 0.29, the least that is taken: five sigmas of it. Smoothing by 0.58 px
// lessens waves of 14 px by 3.4 %, in an image 8 % larger by a seventh less: a gain is good to 0.005 besides.
TEST_P(EveryModel, IsFoundExactly) {
  Random random(3);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const WaveTexture texture(seed, 14, 40);
    const Truth truth = truth_of(GetParam().model, GetParam().light, random);
    const WindowStart start = start_near(truth, GetParam().model, random);
    const auto found = match_window(reference_of(texture), kMiddle, seen(texture, truth, 0, 2), start, options());
    ASSERT_EQ(found.outcome, WindowOutcome::kFound);
    const WindowParameters expected = parameters_of(truth, start, GetParam().model, GetParam().light);
    const WindowParameters sigmas = found.covariance.diagonal().cwiseSqrt();
    const Eigen::Index light_unknowns = Eigen::Index(GetParam().light);
    for (Eigen::Index i = 0; i < expected.size() - light_unknowns; ++i)
      EXPECT_NEAR(found.parameters[i], expected[i], 5 * sigmas[i]) << i;
    EXPECT_LT(sigmas[0], 0.02);  // of slopes of 4 grey a pixel 0.005, of which map and light may take half and more
    EXPECT_NEAR(found.gain, truth.gain, 0.005 + 5 * 0.001);
    EXPECT_NEAR(found.gain * 128 + found.offset_grey, truth.gain * 128 + truth.offset_grey, 0.5);
    EXPECT_GT(found.correlation, 0.999);
    const auto names = window_parameter_names(GetParam().model, GetParam().light);
    EXPECT_EQ(std::size_t(found.parameters.size()), names.size());
    EXPECT_EQ(found.covariance.rows(), found.parameters.size());
  }
}

// e' C^-1 e of all k parameters is chi-squared with k degrees of freedom: divided by k its mean over n windows is 1
// with a standard deviation of sqrt(2 / (k n)); the noise, of 441 smoothed pixels, adds as good as nothing. Of the
// position alone 95 % lie in the ellipse of 95 %.
TEST_P(EveryModel, CovarianceMatchesTheRealErrors) {
  constexpr int kWindows = 200;
  constexpr double kNoise_grey = 3;
  Random random(11);
  double sum = 0, noise = 0;
  int unknowns = 0, inside = 0;
  for (std::uint64_t seed = 1; seed <= kWindows; ++seed) {
    const WaveTexture texture(seed, 7, 24);
    const Truth truth = truth_of(GetParam().model, GetParam().light, random);
    const WindowStart start = start_near(truth, GetParam().model, random);
    const auto found = match_window(reference_of(texture, kNoise_grey, 2 * seed), kMiddle,
                                    seen(texture, truth, kNoise_grey, 2 * seed + 1), start, options());
    ASSERT_EQ(found.outcome, WindowOutcome::kFound) << seed;
    const WindowParameters error = found.parameters - parameters_of(truth, start, GetParam().model, GetParam().light);
    unknowns = int(error.size());
    sum += error.dot(found.covariance.ldlt().solve(error));
    const Vector2d shift = found.position_px - truth.position_px;
    inside += GetParam().model == WindowModel::kLine ? shift.squaredNorm() < 3.8415 * found.covariance(0, 0)
                                                     : shift.dot(found.covariance_px2.ldlt().solve(shift)) < 5.9915;
    noise += found.noise_grey;
  }
  EXPECT_NEAR(sum / kWindows / unknowns, 1, 4 * std::sqrt(2.0 / (unknowns * kWindows)));
  EXPECT_NEAR(inside / double(kWindows), 0.95, 4 * std::sqrt(0.95 * 0.05 / kWindows));
  // Smoothed twice, 441 pixels are worth some 120: a noise is good to 7 % in one window.
  EXPECT_NEAR(noise / kWindows, kNoise_grey, 4 * 0.07 * kNoise_grey / std::sqrt(double(kWindows)));
}

INSTANTIATE_TEST_SUITE_P(WindowMatching, EveryModel,
                         ::testing::Values(ModelCase{WindowModel::kTranslation, WindowLight::kGainOffset},
                                           ModelCase{WindowModel::kLine, WindowLight::kGainOffset},
                                           ModelCase{WindowModel::kScale, WindowLight::kGainOffset},
                                           ModelCase{WindowModel::kSimilarity, WindowLight::kGainOffset},
                                           ModelCase{WindowModel::kAffine, WindowLight::kGainOffset},
                                           ModelCase{WindowModel::kAffine, WindowLight::kOffset},
                                           ModelCase{WindowModel::kAffine, WindowLight::kSame},
                                           ModelCase{WindowModel::kLine, WindowLight::kSame}),
                         [](const auto& each) {
                           return std::string(word_of(each.param.model)) + "_" + std::string(word_of(each.param.light));
                         });

// The noise of the reference makes the gain of plain least squares smaller by its share of the grey values, here 3 %.
TEST(WindowMatching, NoiseOfTheReferenceDoesNotLessenTheGain) {
  constexpr int kWindows = 150;
  double gain = 0, variance = 0;
  for (std::uint64_t seed = 1; seed <= kWindows; ++seed) {
    const WaveTexture texture(seed, 8, 24, 6);
    const Truth truth{kMiddle + Vector2d(0.4, 0.2), Matrix2d::Identity(), 1.1};
    WindowOptions options;
    options.model = WindowModel::kTranslation;
    options.largest_sigma_px = 1;
    options.least_correlation = 0;
    const auto found = match_window(reference_of(texture, 5, 2 * seed), kMiddle, seen(texture, truth, 5, 2 * seed + 1),
                                    {truth.position_px}, options);
    ASSERT_EQ(found.outcome, WindowOutcome::kFound);
    gain += found.gain / kWindows;
    variance += found.covariance(2, 2) / kWindows;
  }
  EXPECT_NEAR(gain, 1.1, 4 * std::sqrt(variance / kWindows));
  EXPECT_LT(4 * std::sqrt(variance / kWindows), 0.03);  // else the test could not see 3 %
}

// A blot of 5 x 5 pixels: the rest is used, and its sigmas are true.
TEST(WindowMatching, BlotsAreLeftOutWhereAsked) {
  constexpr int kWindows = 150;
  Random random(5);
  double sum = 0, plain = 0;
  int found_all = 0, plain_found = 0;
  for (std::uint64_t seed = 1; seed <= kWindows; ++seed) {
    const WaveTexture texture(seed, 7, 24);
    const Truth truth = truth_of(WindowModel::kAffine, WindowLight::kGainOffset, random);
    GreyImage right = seen(texture, truth, 3, 2 * seed + 1);
    const int left = 20 + int(random.below(12)), top = 20 + int(random.below(12));
    const auto grey = std::uint8_t(random.uniform(0, 1) < 0.5 ? 20 : 230);
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x) right.at(left + x, top + y) = grey;
    const GreyImage reference = reference_of(texture, 3, 2 * seed);
    const WindowStart start = start_near(truth, WindowModel::kAffine, random);
    WindowOptions options;
    const auto affected = match_window(reference, kMiddle, right, start, options);
    options.robust = true;
    const auto found = match_window(reference, kMiddle, right, start, options);
    const auto statistic = [&](const WindowMatch& match) {
      const Vector2d error = match.position_px - truth.position_px;
      return error.dot(match.covariance_px2.ldlt().solve(error));
    };
    if (affected.outcome == WindowOutcome::kFound) {
      plain += statistic(affected);
      ++plain_found;
    }
    if (found.outcome != WindowOutcome::kFound) continue;
    ++found_all;
    sum += statistic(found);
    // A blot wholly inside, with what the spline, the mean of neighbours and the margin round them add: 13 x 13 at
    // most.
    EXPECT_LT(found.share_used, 1 - 25.0 / 441);
    EXPECT_GT(found.share_used, 1 - 200.0 / 441);
  }
  EXPECT_GE(found_all, int(0.97 * kWindows));
  EXPECT_NEAR(sum / found_all / 2, 1, 4 * std::sqrt(1.0 / found_all));
  EXPECT_GT(plain / plain_found / 2, 2);  // what not to leave it out costs
}

TEST(WindowMatching, WhatBelongsTogetherIsHardlyLeftOut) {
  int windows_with_less = 0;
  constexpr int kWindows = 60;
  for (std::uint64_t seed = 1; seed <= kWindows; ++seed) {
    const WaveTexture texture(seed, 7, 24);
    WindowOptions options;
    options.robust = true;
    const auto found = match_window(reference_of(texture, 3, 2 * seed), kMiddle,
                                    seen(texture, {kMiddle}, 3, 2 * seed + 1), {kMiddle}, options);
    ASSERT_EQ(found.outcome, WindowOutcome::kFound);
    windows_with_less += found.share_used < 1;
  }
  // One in twenty is asked for: 3 of 60, and 10 or more once in 1500 times.
  EXPECT_LT(windows_with_less, 10);
}

TEST(WindowMatching, EdgesDetermineWhatLiesAcross) {
  const auto edge = [](const Vector2d& at) { return 128 + 60 * std::tanh((at - kMiddle).dot(Vector2d(0.8, 0.6)) / 2); };
  const GreyImage left = image_of(kSide_px, kSide_px, edge, 1, 1),
                  right = image_of(
                      kSide_px, kSide_px, [&](const Vector2d&at) { return edge(at - Vector2d(0.5, 0)); }, 1, 2);
  WindowOptions options;
  for (const WindowModel model : {WindowModel::kTranslation, WindowModel::kSimilarity, WindowModel::kAffine}) {
    options.model = model;
    EXPECT_EQ(match_window(left, kMiddle, right, {kMiddle}, options).outcome, WindowOutcome::kNoTexture)
        << word_of(model);
  }
  options.model = WindowModel::kLine;
  WindowStart start{kMiddle};
  const auto across = match_window(left, kMiddle, right, start, options);
  ASSERT_EQ(across.outcome, WindowOutcome::kFound);
  EXPECT_NEAR(across.position_px.x(), kMiddle.x() + 0.5, 4 * std::sqrt(across.covariance(0, 0)));
  start.line = {-0.6, 0.8};
  EXPECT_EQ(match_window(left, kMiddle, right, start, options).outcome, WindowOutcome::kNoTexture);
}

TEST(WindowMatching, SaysWhyNot) {
  const WaveTexture texture(3);
  const GreyImage left = reference_of(texture, 2, 1), right = reference_of(texture, 2, 2);
  const auto outcome = [&](const Vector2d& at, const WindowStart& start, const GreyImage& other,
                           const WindowOptions& options = {}) {
    return match_window(left, at, other, start, options).outcome;
  };
  EXPECT_EQ(outcome(kMiddle, {kMiddle}, right), WindowOutcome::kFound);
  EXPECT_EQ(outcome({6, 30}, {kMiddle}, right), WindowOutcome::kOutside);
  EXPECT_EQ(outcome({NAN, 30}, {kMiddle}, right), WindowOutcome::kOutside);
  EXPECT_EQ(outcome(kMiddle, {Vector2d(30, 50)}, right), WindowOutcome::kOutside);
  EXPECT_EQ(outcome(kMiddle, {Vector2d(NAN, 30)}, right), WindowOutcome::kOutside);
  EXPECT_EQ(outcome(kMiddle, {kMiddle, Matrix2d::Zero()}, right), WindowOutcome::kOutside);
  EXPECT_EQ(outcome(kMiddle, {kMiddle, Matrix2d::Identity(), Vector2d(0, 0)}, right), WindowOutcome::kOutside);
  const GreyImage blank(kSide_px, kSide_px, 1, 90);
  EXPECT_EQ(match_window(blank, kMiddle, right, {kMiddle}, {}).outcome, WindowOutcome::kNoTexture);
  EXPECT_EQ(match_window(GreyImage(), kMiddle, right, {kMiddle}, {}).outcome, WindowOutcome::kOutside);
  EXPECT_NE(outcome(kMiddle, {kMiddle}, blank), WindowOutcome::kFound);
  GreyImage negative = right;
  for (std::uint8_t& grey : negative.data) grey = std::uint8_t(255 - grey);
  EXPECT_NE(outcome(kMiddle, {kMiddle}, negative), WindowOutcome::kFound);
  WindowOptions near;
  near.farthest_px = 0.3;
  EXPECT_EQ(outcome(kMiddle, {kMiddle + Vector2d(0.8, 0.2)}, right, near), WindowOutcome::kDiverged);
  WindowOptions precise;
  precise.largest_sigma_px = 0.001;
  EXPECT_EQ(outcome(kMiddle, {kMiddle}, right, precise), WindowOutcome::kNoTexture);
}

// Other textures, and noise alone, are no match: a correlation of 0.7 of 441 pixels does not come about by chance.
TEST(WindowMatching, RefusesWhatIsNotTheSame) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const GreyImage left = reference_of(WaveTexture(seed, 6, 14), 2, seed);
    found +=
        match_window(left, kMiddle, reference_of(WaveTexture(seed + 100, 6, 14), 2, seed + 1), {kMiddle}, {}).outcome ==
        WindowOutcome::kFound;
    const auto flat = [](const Vector2d&) { return 128; };
    found += match_window(image_of(kSide_px, kSide_px, flat, 8, seed), kMiddle,
                          image_of(kSide_px, kSide_px, flat, 8, seed + 500), {kMiddle}, {})
                 .outcome == WindowOutcome::kFound;
  }
  EXPECT_EQ(found, 0);
}

TEST(WindowMatching, EveryProcessorGivesTheSameBits) {
  const WaveTexture texture(9);
  const GreyImage left = reference_of(texture, 3, 1), right = seen(texture, {kMiddle + Vector2d(0.3, 0.4)}, 3, 2);
  std::vector<WindowMatch> matches;
  for (const std::int64_t target : testing::processor_targets()) {
    const testing::OnTarget chosen(target);
    for (const bool robust : {false, true}) {
      WindowOptions options;
      options.robust = robust;
      const auto found = match_window(left, kMiddle, right, {kMiddle}, options);
      ASSERT_EQ(found.outcome, WindowOutcome::kFound);
      matches.push_back(found);
      EXPECT_EQ(found.position_px, matches[robust].position_px) << hwy::TargetName(target);
      EXPECT_EQ(found.covariance_px2, matches[robust].covariance_px2) << hwy::TargetName(target);
    }
  }
}

}  // namespace
}  // namespace collinea
