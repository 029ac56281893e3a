// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/relative.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <string>

#include "collinea/epipolar/relative_elements.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

class RelativePair : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("collinea_relative_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    options_.photo.principal_distance = 153.0;
    options_.adjustment.start = PairStart::kLinear;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& text) const {
    std::ofstream(folder_ / "pair.txt") << text;
    return folder_ / "pair.txt";
  }
  // Photographs with c = 153 mm of ground with relief, noise of 5 um.
  fs::path simulated(const std::string& titles, bool in_pixels) const {
    Random random(1);
    const Rigid3 motion = motion_of(truth_);
    std::string text = titles + "\n";
    for (int i = 0; i < 24; ++i) {
      const Eigen::Vector3d x(random.uniform(-0.2, 1.2), random.uniform(-1, 1), random.uniform(1.4, 1.8));
      const Eigen::Vector2d one = x.hnormalized(), two = (motion * x).hnormalized();
      const auto coordinate = [&](double v, bool is_y) {
        const double mm = 153 * v + 0.005 * random.normal();
        return std::to_string(in_pixels ? mm * 100 + 10000 : is_y ? -mm : mm) + " ";
      };
      text += "P" + std::to_string(i) + " ";
      text += coordinate(one.x(), false) + coordinate(one.y(), true) + coordinate(two.x(), false);
      text += coordinate(two.y(), true) + "\n";
    }
    return write(text);
  }

  DependentElements truth_{1, 0.03, -0.02, 0.011, -0.013, 0.02};
  RelativePairOptions options_;
  fs::path folder_;
};

TEST_F(RelativePair, IsOrientedFromMillimetresAsFromPixels) {
  const auto in_mm = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(in_mm) << in_mm.error().message;
  options_.photo.principal_distance = 15300;
  options_.photo.principal_point = "10000,10000";
  const auto in_px = orient_pair(simulated("point x_left[px] y_left[px] x_right[px] y_right[px]", true), options_);
  ASSERT_TRUE(in_px) << in_px.error().message;
  const Vector5 a = dependent_elements(in_mm->orientation.second_from_first)->values(),
                b = dependent_elements(in_px->orientation.second_from_first)->values();
  EXPECT_LT((a - b).norm(), 1e-6);
  EXPECT_LT((a - truth_.values()).norm(), 2e-3);
  EXPECT_NEAR(in_mm->orientation.sigma0 * in_mm->sigma, 0.005, 0.002);
  EXPECT_EQ(in_mm->frame.unit(), "mm");
}

TEST_F(RelativePair, TextAndTablesSayWhatWasFound) {
  options_.out = folder_ / "out";
  options_.base_m = 600;
  const auto report = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(report) << report.error().message;
  const std::string text = relative_text(*report);
  for (const char* words : {"24 points", "redundancy 19", "dependent pair, bx = 1", "symmetric pair", "kappa2",
                            "residual y-parallax", "lambda_min / lambda_max", "cylinder"})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  for (const char* name : {"parameters.txt", "residuals.txt", "model.txt", "exterior.txt"})
    EXPECT_TRUE(read_text_table(*options_.out / name)) << name;
  EXPECT_TRUE(fs::exists(*options_.out / "geometry.svg"));
  const TextTable model = relative_model_table(*report);
  EXPECT_EQ(model.unit_of("W"), "m");
  const auto w = model.numbers("W", "m");
  ASSERT_TRUE(w);
  EXPECT_LT(w->front(), -700);
  EXPECT_GT(w->front(), -1200);
  // The tables agree with each other: bases, angles
  const auto x = relative_exterior_table(*report).numbers("X", "m");
  EXPECT_NEAR((*x)[1], 600 / std::sqrt(1 + truth_.by * truth_.by + truth_.bz * truth_.bz), 1);
}

TEST_F(RelativePair, DistancesGiveTheBase) {
  const fs::path pair = simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false);
  options_.base_m = 600;
  const auto given = orient_pair(pair, options_);
  ASSERT_TRUE(given);
  const auto distance = [&](std::size_t i, std::size_t k) {
    return std::to_string((given->model.points[i]->position - given->model.points[k]->position).norm());
  };
  options_.base_m.reset();
  options_.distances = folder_ / "distances.txt";
  std::ofstream(*options_.distances) << "from to distance[m] sigma[m]\nP0 P1 " << distance(0, 1) << " 0.05\nP2 P3 "
                                     << distance(2, 3) << " 0.05\n";
  const auto scaled = orient_pair(pair, options_);
  ASSERT_TRUE(scaled) << scaled.error().message;
  EXPECT_NEAR(scaled->base, 600, 1e-3);
  EXPECT_NE(relative_text(*scaled).find("base by 2 distances"), std::string::npos);
  std::ofstream(*options_.distances) << "from to distance[m] sigma[m]\nP0 Q1 100 0.05\n";
  EXPECT_FALSE(orient_pair(pair, options_));
}

TEST_F(RelativePair, RefusesTablesThatAreNone) {
  EXPECT_FALSE(orient_pair(folder_ / "missing.txt", options_));
  EXPECT_FALSE(orient_pair(write("point x_left[mm] y_left[mm]\n1 2 3\n"), options_));
  EXPECT_FALSE(orient_pair(write("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]\n1 2 3 4 5\n"), options_));
  const fs::path good = simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false);
  options_.photo.principal_distance.reset();
  EXPECT_FALSE(orient_pair(good, options_));
}

}  // namespace
}  // namespace collinea
