// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/mark_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/adjust/test_block.h"
#include "collinea/block/subject_label.h"
#include "collinea/block/transform.h"

namespace collinea {
namespace {

using testing::test_block;
using testing::TestBlockOptions;

// Six points in a block whose frame is arbitrary, with noise and one gross mark, its marks written as a program that
// counts them otherwise would.
Block block_with_marks(std::uint64_t seed, const MarkHypothesis& written, double sigma_px = 0.5,
                       double tilt_rad = 0.15) {
  Block block =
      test_block({.rows = 3, .columns = 5, .sigma_px = sigma_px, .control = 6, .tilt_rad = tilt_rad, .seed = seed});
  Random random(seed, 77);
  const std::size_t gross = std::size_t(random.uniform() * double(block.control_observations.size()));
  block.control_observations[gross].pixel += Eigen::Vector2d(70, -50);
  for (ControlObservation& seen : block.control_observations) {
    const Camera& camera = block.camera_of(seen.image);
    const MarkMap map = map_of(written, camera.width_px, camera.height_px);
    seen.pixel = map.linear.inverse() * (seen.pixel - map.origin);
  }
  transform(block, {0.1, rotation_by({1, 2, 0.4}), {5, 6, 7}});
  return block;
}

std::string labels(const MarkDiagnosis& diagnosis, const Block& block) {
  std::string text;
  for (const Finding& finding : diagnosis.findings) text += label_of(finding, block) + " " + finding.detail + "\n";
  return text;
}

TEST(MarkSystems, EachTakesThePixelsThatItsProgramWroteBackIntoTheImage) {
  const Camera camera = ideal_camera(1000, 2000, 1500);
  const auto pixel = [&](MarkSystem system, double u, double v) {
    return pixel_of({system, has_factor(system) ? 2.0 : 1.0}, camera, {u, v});
  };
  EXPECT_EQ(pixel(MarkSystem::kAsGiven, 10, 20), Eigen::Vector2d(10, 20));
  EXPECT_EQ(pixel(MarkSystem::kRowsUp, 10, 20), Eigen::Vector2d(10, 1480));
  EXPECT_EQ(pixel(MarkSystem::kColumnsLeft, 10, 20), Eigen::Vector2d(1990, 20));
  EXPECT_EQ(pixel(MarkSystem::kUpsideDown, 10, 20), Eigen::Vector2d(1990, 1480));
  EXPECT_EQ(pixel(MarkSystem::kExchanged, 10, 20), Eigen::Vector2d(20, 10));
  EXPECT_EQ(pixel(MarkSystem::kCentre, 10, 20), Eigen::Vector2d(1010, 770));
  EXPECT_EQ(pixel(MarkSystem::kCentreRowsUp, 10, 20), Eigen::Vector2d(1010, 730));
  EXPECT_EQ(pixel(MarkSystem::kResampled, 10, 20), Eigen::Vector2d(20, 40));
  EXPECT_EQ(pixel(MarkSystem::kResampledRowsUp, 10, 20), Eigen::Vector2d(20, 1460));
  EXPECT_EQ(pixel(MarkSystem::kScaledCentre, 10, 20), Eigen::Vector2d(1020, 790));
  EXPECT_EQ(pixel(MarkSystem::kScaledCentreRowsUp, 10, 20), Eigen::Vector2d(1020, 710));
  // The upper-left corner of the stored image is shown at the upper right when it is turned clockwise.
  EXPECT_EQ(pixel(MarkSystem::kTurnedRight, 1500, 0), Eigen::Vector2d(0, 0));
  EXPECT_EQ(pixel(MarkSystem::kTurnedLeft, 0, 2000), Eigen::Vector2d(0, 0));
}

TEST(CheckMarks, NamesAndCorrectsEachSystem) {
  for (const auto& [system, word, meaning] : kMarkSystemWords) {
    if (system == MarkSystem::kAsGiven) continue;
    const bool is_resampled = system == MarkSystem::kResampled || system == MarkSystem::kResampledRowsUp;
    const double factor = is_resampled ? 1.92 : has_factor(system) ? 227 : 1;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Block block = block_with_marks(seed, {system, factor});
      const MarkDiagnosis diagnosis = check_marks(block);
      ASSERT_EQ(diagnosis.findings.size(), 2u) << word << " " << seed << "\n" << labels(diagnosis, block);
      EXPECT_EQ(diagnosis.correction.system, system) << word << " " << seed << "\n" << labels(diagnosis, block);
      const Finding& named = diagnosis.findings[0];
      EXPECT_EQ(named.code, FindingCode::kMarksCountedOtherwise);
      EXPECT_EQ(named.detail, word);
      // All meet but the gross one; as given nearly none did.
      EXPECT_GE(named.figure(FigureName::kCount).value(), named.figure(FigureName::kOf).value() - 4);
      EXPECT_LT(named.figures_of(FigureName::kCount)[1], 0.4 * named.figure(FigureName::kOf).value());
      EXPECT_NEAR(named.figure(FigureName::kRatio).value() / factor, 1, 3e-3) << word << " " << seed;
      EXPECT_EQ(diagnosis.findings[1].code, FindingCode::kMarksCorrected);
      Block corrected = block;
      correct_marks(diagnosis.findings, corrected);
      EXPECT_GT(meeting_of(corrected, {}).share(), 0.7) << word << " " << seed;
      EXPECT_TRUE(check_marks(corrected).findings.empty()) << word << " " << seed;
    }
  }
}

// Squared errors over variances are chi-squared: the mean of n is 1 with the standard deviation sqrt(2 / n).
TEST(CheckMarks, TheFactorIsAsGoodAsItsSigmaSays) {
  for (const MarkHypothesis written :
       {MarkHypothesis{MarkSystem::kResampled, 1.92}, MarkHypothesis{MarkSystem::kScaledCentre, 227}}) {
    double sum = 0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      const MarkDiagnosis diagnosis = check_marks(block_with_marks(seed, written));
      if (diagnosis.findings.empty() || diagnosis.findings[0].detail != word_of(written.system)) continue;
      const Finding& named = diagnosis.findings[0];
      const double error = named.figure(FigureName::kRatio).value() / written.factor - 1;
      sum += std::pow(error / named.figure(FigureName::kSigmaScale).value(), 2);
      ++count;
    }
    EXPECT_GT(count, 50);
    EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2.0 / count)) << word_of(written.system);
  }
}

TEST(CheckMarks, NothingIsNamedOnGoodMarks) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Block block = block_with_marks(seed, {}, seed % 2 ? 0.5 : 2.0, seed % 3 ? 0.15 : 0.02);
    const MarkDiagnosis diagnosis = check_marks(block);
    EXPECT_TRUE(diagnosis.findings.empty()) << seed << "\n" << labels(diagnosis, block);
  }
}

// Marks of points that are somewhere else in each image, and of images that are confused, fit no system.
TEST(CheckMarks, NothingIsNamedOnMarksThatNothingExplains) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Block block = block_with_marks(seed, {});
    Random random(seed, 5);
    for (ControlObservation& seen : block.control_observations)
      seen.pixel = {random.uniform(0, 2000), random.uniform(0, 1500)};
    EXPECT_TRUE(check_marks(block).findings.empty()) << seed << "\n" << labels(check_marks(block), block);
    block = block_with_marks(seed, {});
    std::vector<ImageId> images;
    for (const auto& [id, image] : block.images) images.push_back(id);
    for (ControlObservation& seen : block.control_observations)
      seen.image = images[(seen.image.value - images[0].value + 1) % images.size()];
    EXPECT_TRUE(check_marks(block).findings.empty()) << seed << "\n" << labels(check_marks(block), block);
  }
}

// Images that look straight down and are all turned alike: marks scaled about their middle meet as well, at another
// depth. What tie points show tells that they are wrong, and nothing tells how.
TEST(CheckMarks, WhatOnlyTheDepthContradictsIsNotCorrected) {
  Block block = test_block({.rows = 1, .columns = 5, .sigma_px = 0.5, .control = 8, .tilt_rad = 1e-6});
  for (ControlObservation& seen : block.control_observations) {
    const Camera& camera = block.camera_of(seen.image);
    const Eigen::Vector2d middle(camera.width_px / 2, camera.height_px / 2);
    seen.pixel = (seen.pixel - middle) / 5;
  }
  const MarkDiagnosis diagnosis = check_marks(block);
  EXPECT_EQ(diagnosis.correction.system, MarkSystem::kAsGiven) << labels(diagnosis, block);
}

TEST(CheckMarks, FewMarksSayNothing) {
  Block block = block_with_marks(3, {MarkSystem::kRowsUp, 1});
  std::erase_if(block.control_observations, [](const ControlObservation& seen) { return seen.point.value > 1; });
  EXPECT_TRUE(check_marks(block).findings.empty());
  block.control_observations.clear();
  EXPECT_TRUE(check_marks(block).findings.empty());
  EXPECT_TRUE(check_marks({}).findings.empty());
}

TEST(CheckMarks, StandardDeviationsFollowTheSizeOfTheImages) {
  const Block block = block_with_marks(2, {MarkSystem::kResampled, 1.92});
  Block corrected = block;
  correct_marks(check_marks(block).findings, corrected);
  EXPECT_NEAR(corrected.control_observations[0].sigma_px / block.control_observations[0].sigma_px, 1.92, 2e-3);
  Block outside = block;
  for (ControlObservation& seen : outside.control_observations) seen.pixel.x() += 5000;
  outside.control_observations[0].pixel = {10, 10};
  remove_marks_outside(outside);
  EXPECT_EQ(outside.control_observations.size(), 1u);
}

}  // namespace
}  // namespace collinea
