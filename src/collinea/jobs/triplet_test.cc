// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/triplet.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/text.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

// Three vertical photographs in a row, c = 153 mm; bases 600 m and 480 m; attitudes of a few degrees.
class Triplet : public ::testing::Test {
 protected:
  Triplet() {
    options_.photo.principal_distance = 153;
    options_.base_m = 600;
  }
  [[nodiscard]] std::filesystem::path file(const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / "m.txt", text));
    return folder_ / "m.txt";
  }
  // `off_mm` is added to y of point 3 in the third image.
  [[nodiscard]] std::string measured(double sigma_mm, std::uint64_t seed, double off_mm = 0) const {
    Random random(seed);
    std::string text = "image point x[mm] y[mm]\n";
    const char* names[] = {"A", "B", "C"};
    for (int p = 0; p < 18; ++p) {
      const Eigen::Vector3d point(random.uniform(200, 900), random.uniform(-700, 700), random.uniform(-1100, -900));
      for (std::size_t i = 0; i < 3; ++i) {
        const Rigid3 pose{cam_from_world(kAngles[i]), -(cam_from_world(kAngles[i]) * kCentres[i])};
        const Eigen::Vector2d seen = 153 * (pose * point).hnormalized();
        text += std::string(names[i]) + " " + std::to_string(p) + " " + exact(seen.x() + sigma_mm * random.normal()) +
                " " + exact(-seen.y() + sigma_mm * random.normal() + (i == 2 && p == 3 ? off_mm : 0)) + "\n";
      }
    }
    return text;
  }
  static double value(const std::vector<Estimate>& estimates, const std::string& name) {
    for (const Estimate& e : estimates)
      if (e.name == name) return e.value;
    return NAN;
  }

  const OmegaPhiKappa kAngles[3] = {{0, 0, 0}, {1.2, -0.8, 2.5}, {-0.7, 1.5, -3.0}};
  const Eigen::Vector3d kCentres[3] = {{0, 0, 0}, {600, 0, 0}, {1075, 66, 20}};
  TripletOptions options_;
  TestFolder folder_;
};

TEST_F(Triplet, ExactMeasurementsGiveTheTruthByOneOfSixteen) {
  options_.sigma = 0.005;
  const auto report = orient_triplet(file(measured(0, 1)), options_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->common, 18u);
  int acceptable = 0;
  for (const ThreeImageCombination& one : report->joined.combinations) acceptable += one.is_joined;
  EXPECT_EQ(acceptable, 2);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(value(report->images[i].exterior, "X"), kCentres[i].x(), 1e-5);
    EXPECT_NEAR(value(report->images[i].exterior, "Z"), kCentres[i].z(), 1e-5);
    EXPECT_NEAR(value(report->images[i].exterior, "omega"), kAngles[i].omega_deg, 1e-7);
    EXPECT_NEAR(value(report->images[i].exterior, "kappa"), kAngles[i].kappa_deg, 1e-7);
  }
  EXPECT_NEAR(report->base_ratio.value, (kCentres[2] - kCentres[1]).norm() / 600, 1e-8);
  EXPECT_EQ(report->variance.redundancy, 2 * 3 * 18 - 11 - 3 * 18);
}

// Errors of 5 um over the stated sigmas: 200 seeds of the ratio of the bases, each normal.
TEST_F(Triplet, TheRatioOfBasesHasItsStandardDeviation) {
  constexpr int kSeeds = 200;
  options_.sigma = 0.005;
  options_.adjustment.start = PairStart::kLinear;
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto report = orient_triplet(file(measured(0.005, seed)), options_);
    ASSERT_TRUE(report) << report.error().message;
    const double error = report->base_ratio.value - (kCentres[2] - kCentres[1]).norm() / 600;
    squares += std::pow(error / *report->base_ratio.sigma, 2);
  }
  EXPECT_NEAR(squares / kSeeds, 1, 4 * std::sqrt(2.0 / kSeeds));
}

// An error of x moves the point in depth: each pair takes it, the three rays do not meet. One redundant coordinate
// along the bases finds the point, but cannot tell which of its images is wrong.
TEST_F(Triplet, AnErrorAlongTheBaseThatNoPairSeesIsFoundByAllThree) {
  std::string text = measured(0.003, 5);
  const std::size_t row = text.find("\nC 7 ") + 5, end = text.find(' ', row);
  const double x = *number(text.substr(row, end - row));
  text.replace(row, end - row, exact(x + 0.05));
  options_.sigma = 0.003;
  const auto report = orient_triplet(file(text), options_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->pairs[0].rejected.empty() && report->pairs[1].rejected.empty());
  int rejected = 0;
  for (const TripletReport::Mark& mark : report->marks) {
    rejected += mark.is_rejected;
    EXPECT_TRUE(mark.point == "7" || !mark.is_rejected) << mark.point << " " << mark.image;
  }
  EXPECT_EQ(rejected, 1);
  EXPECT_LT(report->variance.sigma0, 1.5);
  options_.adjustment.rejection = PairRejection::kNone;
  EXPECT_NE(triplet_text(*orient_triplet(file(text), options_)).find("contradicts the others: largest"),
            std::string::npos);
}

TEST_F(Triplet, TextAndTablesSayWhatWasFound) {
  options_.adjustment.rejection = PairRejection::kNone;
  const auto report = orient_triplet(file(measured(0.005, 2)), options_);
  ASSERT_TRUE(report);
  const std::string text = triplet_text(*report);
  for (const char* words : {"2 of 16 combinations", "1A", "2D", "base_ratio", "18 points common", "redundancy 43"})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  for (const NamedTable& table : triplet_tables(*report)) {
    const auto parsed = parse_text_table(text_of(table.table));
    ASSERT_TRUE(parsed) << table.name;
    EXPECT_GE(parsed->rows.size(), 3u);
    EXPECT_TRUE(table.name != "combinations.txt" || parsed->rows.size() == 16);
    EXPECT_TRUE(table.name != "model.txt" || parsed->unit_of("W") == "m");
  }
}

TEST_F(Triplet, WhatJoinsNothingIsRefusedInWords) {
  const auto message = [&](const std::string& text) {
    const auto report = orient_triplet(file(text), options_);
    return report ? std::string() : report.error().message;
  };
  EXPECT_NE(message("image point x[mm] y[mm]\nA 1 0 0\nB 1 1 1\n").find("three images"), std::string::npos);
  EXPECT_NE(message("image point x[mm] y[mm]\nA 1 0 0\nA 1 1 1\n").find("twice"), std::string::npos);
  EXPECT_NE(message("image point x[mm]\nA 1 0\n").find("y"), std::string::npos);
  // Without a point in all three the pairs are oriented but not joined: points get other names in the third image.
  std::string apart = measured(0, 1), twice;
  for (const std::string_view line : lines_of(apart)) {
    twice += std::string(line) + "\n";
    if (line.starts_with("B ")) twice += "B n" + std::string(line.substr(2)) + "\n";
  }
  for (std::size_t at = twice.find("\nC "); at != std::string::npos; at = twice.find("\nC ", at + 1))
    twice.insert(at + 3, "n");
  EXPECT_NE(message(twice).find("0 points common"), std::string::npos) << message(twice);
  options_.photo.principal_distance.reset();
  EXPECT_FALSE(orient_triplet(file(measured(0, 1)), options_));
}

}  // namespace
}  // namespace collinea
