// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/relative.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "collinea/base/file.h"
#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/given_pair.h"
#include "collinea/jobs/intersection.h"
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
  fs::path simulated(const std::string& titles, bool in_pixels, std::uint64_t seed = 1) const {
    Random random(seed);
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
  EXPECT_FALSE(fs::exists(*options_.out / "fundamental.txt"));  // of millimetres
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

// What every point is off the line that the written matrix gives it is the misclosure of the orientation. The noise is
// half a pixel in each of four coordinates.
TEST_F(RelativePair, WritesTheFundamentalMatrixOfPixels) {
  options_.photo.principal_distance = 15300;
  options_.photo.principal_point = "10000,10000";
  options_.out = folder_ / "out";
  const fs::path pair = simulated("point x_left[px] y_left[px] x_right[px] y_right[px]", true);
  const auto report = orient_pair(pair, options_);
  ASSERT_TRUE(report) << report.error().message;
  const auto distances = [&]() -> std::vector<double> {
    const auto file = read_file(folder_ / "out/fundamental.txt");
    if (!file) return {};
    const auto rows = parse_number_rows(*file, false, 3, 3);
    if (!rows || rows->size() != 3) return {};
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) matrix(i, k) = (*rows)[std::size_t(i)].numbers[std::size_t(k)];
    const auto table = read_text_table(pair);
    const auto x1 = *table->numbers("x_left", "px"), y1 = *table->numbers("y_left", "px"),
               x2 = *table->numbers("x_right", "px"), y2 = *table->numbers("y_right", "px");
    std::vector<double> out;
    for (std::size_t i = 0; i < x1.size(); ++i) {
      const Eigen::Vector3d line = matrix * Eigen::Vector3d(x1[i], y1[i], 1);
      out.push_back(line.dot(Eigen::Vector3d(x2[i], y2[i], 1)) / line.head<2>().norm());
    }
    return out;
  };
  const std::vector<double> solved = distances();
  ASSERT_EQ(solved.size(), 24u);
  double squares = 0;
  for (const double one : solved) squares += one * one;
  const double rms = std::sqrt(squares / 24);  // of 0.5 sqrt(2) px and 19 of 24 degrees of freedom: 0.63
  EXPECT_GT(rms, 0.4);
  EXPECT_LT(rms, 0.9);
  // A given orientation writes the same.
  options_.given = (folder_ / "out/exterior.txt").string();
  ASSERT_TRUE(orient_pair(pair, options_));
  const std::vector<double> given = distances();
  ASSERT_EQ(given.size(), 24u);
  for (std::size_t i = 0; i < 24; ++i) EXPECT_NEAR(given[i], solved[i], 0.01);
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

// Y, Z, omega, phi, kappa of the second image (X follows from Y, Z and the base): e' C^-1 e is chi-squared with 5
// degrees of freedom, so that its mean over n pairs is 5 within 4 sqrt(10 / n).
TEST_F(RelativePair, CovarianceOfTheSecondImageMatchesTheRealErrors) {
  constexpr int kPairs = 200;
  const double length = 612;
  options_.base_m = length;
  options_.sigma = 0.005;
  Rigid3 truth = motion_of(truth_);
  const Eigen::Vector3d base = length * base_in_first(truth);
  Eigen::Matrix<double, 5, 1> expected;  // omega, phi, kappa of photographs, as truth_ has them
  expected << -base.y(), -base.z(), Eigen::Vector3d(truth_.omega, truth_.phi, truth_.kappa) * 180 / std::numbers::pi;
  double sum = 0;
  for (int i = 0; i < kPairs; ++i) {
    const auto report = orient_pair(
        simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false, 1000 + std::uint64_t(i)), options_);
    ASSERT_TRUE(report) << report.error().message;
    const Eigen::Matrix<double, 5, 1> e = report->right_pose.tail<5>() - expected;
    sum += e.dot(report->right_covariance.bottomRightCorner<5, 5>().ldlt().solve(e));
    EXPECT_NEAR(report->right_pose.head<3>().norm(), length, 1e-9 * length);
    // The base is without error: nothing varies along it.
    const Eigen::Vector3d along = report->right_pose.head<3>().normalized();
    EXPECT_LT(along.dot(report->right_covariance.topLeftCorner<3, 3>() * along), 1e-12);
  }
  EXPECT_NEAR(sum / kPairs, 5, 4 * std::sqrt(10.0 / kPairs));
}

// A new point, measured in both images, by way of exterior.txt: its covariance is that which the model has for points
// that gave nothing to the orientation. Sigmas without the correlations would be off by far: those of by and omega are
// near -1.
TEST_F(RelativePair, IntersectionByItsExteriorOrientationHasTheCovarianceOfTheModel) {
  options_.base_m = 600;
  options_.sigma = 0.005;
  options_.out = folder_ / "out";
  const auto report = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(report) << report.error().message;
  RelativeOrientation orientation = report->orientation;
  const Rigid3 motion = orientation.second_from_first;
  std::vector<PairPoint> points = report->points;
  const Eigen::Vector3d ground(0.3, 0.9, 1.6);
  const double sigma = 0.005 / 153;
  points.push_back({ground.hnormalized(), (motion * ground).hnormalized(), sigma, sigma});
  orientation.residuals.push_back({});
  orientation.residuals.back().used = false;
  const auto expected = model_points(orientation, points, 600, true).points.back();
  ASSERT_TRUE(expected);
  std::ofstream rays(folder_ / "rays.txt");
  rays.precision(12);
  rays << "image point x[mm] y[mm] sigma[mm]\n";
  rays << "left N " << 153 * points.back().first.x() << ' ' << -153 * points.back().first.y() << " 0.005\n";
  rays << "right N " << 153 * points.back().second.x() << ' ' << -153 * points.back().second.y() << " 0.005\n";
  rays.close();
  IntersectTableOptions options;
  options.photo = options_.photo;
  const auto found = intersect_from_tables(folder_ / "rays.txt", *options_.out / "exterior.txt", options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->orientations_have_sigmas);
  ASSERT_TRUE(found->points[0].is_found);
  EXPECT_LT((found->points[0].position - expected->position).norm(), 1e-4);  // nine digits of angles and 600 m
  // The middle of the parallax is no least squares, which knows the point at most so much better.
  for (int k = 0; k < 3; ++k) {
    const double ratio = found->points[0].sigma(k) / std::sqrt(expected->covariance(k, k));
    EXPECT_LT(ratio, 1.001) << k;
    EXPECT_GT(ratio, 0.98) << k;
  }
}

// The pair that a table of exterior orientations gives knows as much of its relative orientation. Nine digits are
// written, and derivatives are taken over steps of 1e-6.
TEST_F(RelativePair, ItsExteriorOrientationGivesAPairWithItsCovariance) {
  options_.base_m = 600;
  options_.out = folder_ / "out";
  const auto report = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(report) << report.error().message;
  PairChainOptions options;
  options.exterior = *options_.out / "exterior.txt";
  const auto given = read_given_pair("left", "right", options);
  ASSERT_TRUE(given) << given.error().message;
  const Matrix5 expected = report->orientation.stated_covariance();
  for (Eigen::Index i = 0; i < 5; ++i)
    for (Eigen::Index k = 0; k < 5; ++k)
      EXPECT_NEAR(given->covariance(i, k), expected(i, k), 1e-6 * std::sqrt(expected(i, i) * expected(k, k)))
          << i << ' ' << k;
}

TEST_F(RelativePair, CorrelationsThatContradictEachOtherAreRefused) {
  std::ofstream(folder_ / "rays.txt") << "image point x[mm] y[mm]\nleft N 1 1\nright N -1 1\n";
  const auto asked =
      [&](const char* a, const char* b, const char* c) {
        std::ofstream(folder_ / "poses.txt")
            << "image X Y Z omega phi kappa sigma_X sigma_Y sigma_Z correlation_X_Y correlation_X_Z correlation_Y_Z\n"
            << "left 0 0 0 0 0 0 1 1 1 0 0 0\nright 1 0 0 0 0 0 1 1 1 " << a << ' ' << b << ' ' << c << '\n';
        IntersectTableOptions options;
        options.photo = options_.photo;
        return intersect_from_tables(folder_ / "rays.txt", folder_ / "poses.txt", options);
      };
  EXPECT_TRUE(asked("0.9", "0.9", "0.9"));
  const auto none = asked("0.9", "0.9", "-0.9");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::kBadFormat);
}

// All four have the coplanarity of the points; one has them in front, and it is the orientation.
TEST_F(RelativePair, TheFourSolutionsStandInTextAndTable) {
  options_.adjustment.start = PairStart::kGrid;
  const auto report = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->solutions[0].in_front, 24);
  for (const RelativeSolution& solution : report->solutions) {
    EXPECT_TRUE(&solution == &report->solutions[0] || solution.in_front == 0);
    for (const PairPoint& point : report->points) {
      const auto value = [&](const Rigid3& m) {
        return std::abs(
            base_in_first(m).dot(point.first.homogeneous().cross(m.rotation.conjugate() * point.second.homogeneous())));
      };
      EXPECT_NEAR(value(solution.second_from_first), value(report->orientation.second_from_first), 1e-12);
    }
  }
  const TextTable table = relative_solutions_table(*report);
  EXPECT_EQ(table.rows.size(), 4u * 11);
  const std::string text = relative_text(*report);
  EXPECT_NE(text.find("of 5408 starts converge; 4 different"), std::string::npos) << text;
  EXPECT_NE(text.find("the four solutions, points of 24 in front"), std::string::npos) << text;
}

// Where points leave no orientation, conditioning and picture are what there is to see.
TEST_F(RelativePair, ACriticalPairLeavesItsGeometry) {
  std::string text = "point x_left[mm] y_left[mm] x_right[mm] y_right[mm]\n";
  for (int i = 0; i < 24; ++i) {
    const double angle = -1 + i / 12.0, x = (i % 5) / 4.0, y = 0.8 * std::sin(angle), z = 0.8 + 0.8 * std::cos(angle);
    char line[200];
    std::snprintf(line, sizeof line, "C%d %.12f %.12f %.12f %.12f\n", i, 153 * x / z, -153 * y / z, 153 * (x - 1) / z,
                  -153 * y / z);
    text += line;
  }
  options_.out = folder_ / "critical";
  options_.adjustment.start = PairStart::kNearVertical;
  const auto report = orient_pair(write(text), options_);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Errc::kIllPosed);
  EXPECT_NE(report.error().message.find("lambda_min / lambda_max"), std::string::npos) << report.error().message;
  EXPECT_NE(report.error().message.find("critical: points and base lie on a cylinder"), std::string::npos);
  EXPECT_TRUE(fs::exists(*options_.out / "geometry.svg"));
  EXPECT_TRUE(fs::exists(*options_.out / "geometry.txt"));
}

TEST_F(RelativePair, TheSimplifiedOrientationStandsBesideTheRigorousOne) {
  options_.out = folder_ / "out";
  const auto report = orient_pair(simulated("point x_left[mm] y_left[mm] x_right[mm] y_right[mm]", false), options_);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->linear);
  const TextTable table = relative_linear_table(*report);
  const auto linear = table.numbers("linear", ""), rigorous = table.numbers("rigorous", ""),
             difference = table.numbers("difference", ""), sigma = table.numbers("sigma", "");
  ASSERT_TRUE(linear && rigorous && difference && sigma);
  const double kept[] = {truth_.by, truth_.bz, truth_.omega, truth_.phi, truth_.kappa};
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR((*difference)[k], (*linear)[k] - (*rigorous)[k], 1e-8);
    // Products of elements of 0.03, and noise
    EXPECT_NEAR((*linear)[k] * (k < 2 ? 1 : std::numbers::pi / 180), kept[k], 3e-3) << k;
    EXPECT_GT((*sigma)[k], 0);
  }
  EXPECT_EQ(relative_linear_parallax_table(*report).rows.size(), 24u);
  EXPECT_NE(relative_text(*report).find("simplified orientation"), std::string::npos);
  options_.adjustment.start = PairStart::kNearVertical;
  EXPECT_FALSE(orient_pair(folder_ / "pair.txt", options_)->linear);
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
