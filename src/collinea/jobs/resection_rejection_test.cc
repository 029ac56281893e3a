// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/absolute.h"
#include "collinea/jobs/resection.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kSigma_mm = 0.005;

// An image of 20 points (of a plane, or in space) with errors of 5 um, and what is added to some of them.
struct MeasuredImage {
  std::string measurements = "point x[mm] y[mm] sigma[mm]\n", ground = "point X Y Z\n";

  MeasuredImage(bool is_plane, const std::vector<std::pair<int, Vector2d>>& wrong) {
    Random random(11);
    const Eigen::Matrix3d r = rotation_matrix(CardanAngles{0.1, -0.2, 0.6});
    const Vector3d centre(20, -30, 900);
    for (int i = 0; i < 20; ++i) {
      const Vector3d point(random.uniform(-400, 400), random.uniform(-400, 400), is_plane ? 0 : random.uniform(0, 150));
      const Vector3d seen = r * (point - centre);
      Vector2d xy = -150 * seen.head<2>() / seen.z() + kSigma_mm * Vector2d(random.normal(), random.normal());
      for (const auto& [index, error] : wrong)
        if (index == i) xy += error;
      const std::string name = std::to_string(i);
      measurements += name + " " + exact(xy.x()) + " " + exact(xy.y()) + " " + exact(kSigma_mm) + "\n";
      ground += name + " " + exact(point.x()) + " " + exact(point.y()) + " " + exact(point.z()) + "\n";
    }
  }
};

class Rejection : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  [[nodiscard]] Result<ResectionReport> resect(const MeasuredImage& image, const ResectOneOptions& options) const {
    return resect_from_tables(file("m.txt", image.measurements), file("g.txt", image.ground), options);
  }
  TestFolder folder_;
};

std::vector<std::string> rejected(const ResectionReport& report) {
  std::vector<std::string> names;
  for (const ResectionReport::Mark& mark : report.marks)
    if (mark.is_rejected) names.push_back(mark.point);
  return names;
}

// sigma0 of 20 points without what is wrong: 1 within four of its standard deviations, 1 / sqrt(2 r), r = 25 of 11
// parameters and 18 points.
TEST_F(Rejection, TransformationsLeaveOutWhatIsWrong) {
  for (const ResectionMethod method : {ResectionMethod::kDlt, ResectionMethod::kPlane})
    for (const bool by_median : {false, true}) {
      const MeasuredImage image(method == ResectionMethod::kPlane, {{3, {3, 0}}, {12, {-1, 2.5}}});
      ResectOneOptions options;
      options.method = method;
      const auto bent = resect(image, options);
      ASSERT_TRUE(bent);
      EXPECT_GT(bent->variance.sigma0, 50);
      EXPECT_TRUE(rejected(*bent).empty());
      (by_median ? options.least_median : options.reject) = true;
      const auto report = resect(image, options);
      ASSERT_TRUE(report) << report.error().message;
      const auto names = rejected(*report);
      EXPECT_TRUE(std::count(names.begin(), names.end(), "3") && std::count(names.begin(), names.end(), "12"));
      EXPECT_LE(names.size(), by_median ? 4u : 2u);  // the median leaves out one of 100 right ones, and more of few
      EXPECT_NEAR(report->variance.sigma0, 1, 0.57);
      EXPECT_EQ(report->marks.size(), 20u);
      const double error = report->marks[3].misfit.x();
      EXPECT_NEAR(error, 3, 10 * kSigma_mm);  // of the computed position: some standard deviations at the edge
      EXPECT_EQ(report->images[0].robust_scale > 0, by_median);
      EXPECT_NE(resection_text(*report).find("point 3 in 1 takes no part"), std::string::npos);
    }
}

TEST_F(Rejection, TheLeastMedianOfTooFewIsRefused) {
  ResectOneOptions options;
  options.method = ResectionMethod::kPlane;
  options.least_median = true;
  const auto report = resect_from_tables(
      file("m.txt", "point x[mm] y[mm]\n1 -100 100\n2 100 100\n3 100 -100\n4 -100 -100\n5 0 0\n"),
      file("g.txt", "point X Y\n1 -900 1200\n2 1100 1200\n3 1100 -800\n4 -900 -800\n5 100 200\n"), options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Errc::kIllPosed);
}

TEST_F(Rejection, AStationLeavesOutAWrongDirection) {
  Random random(5);
  std::string measurements = "point direction[gon] sigma[gon]\n", ground = "point X[m] Y[m]\n";
  for (int i = 0; i < 9; ++i) {
    const Vector2d to(500 * random.normal(), 500 * random.normal()), d = to - Vector2d(100, 50);
    const double direction = std::atan2(d.x(), d.y()) * 200 / M_PI - 30 + 0.002 * random.normal() + (i == 4 ? 0.5 : 0);
    measurements += std::to_string(i) + " " + exact(direction) + " 0.002\n";
    ground += std::to_string(i) + " " + exact(to.x()) + " " + exact(to.y()) + "\n";
  }
  for (const bool by_median : {false, true}) {
    ResectOneOptions options;
    options.method = ResectionMethod::kStation;
    (by_median ? options.least_median : options.reject) = true;
    const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(rejected(*report), std::vector<std::string>{"4"});
    EXPECT_NEAR(report->marks[4].misfit.x(), 500, 20);  // mgon; what is computed is good to some of 2 mgon
  }
}

// A model turned by (0.3, -0.2, 2), scale 2.5, of ten points with errors of 1 cm on the ground, two of them wrong.
TEST_F(Rejection, EveryAbsoluteOrientationLeavesOutWhatIsWrong) {
  Random random(3);
  std::string model = "point U V W\n", ground = "point X[m] Y[m] Z[m]\n";
  for (int i = 0; i < 10; ++i) {
    const Vector3d u(random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(-5, 5));
    Vector3d x = 2.5 * rotation_matrix(CardanAngles{0, 0, 2}).transpose() * u + Vector3d(100, 200, 50) +
                 0.01 * Vector3d(random.normal(), random.normal(), random.normal());
    if (i == 2) x.x() += 0.5;
    if (i == 7) x.y() -= 2;
    model += std::to_string(i) + " " + exact(u.x()) + " " + exact(u.y()) + " " + exact(u.z()) + "\n";
    ground += std::to_string(i) + " " + exact(x.x()) + " " + exact(x.y()) + " " + exact(x.z()) + "\n";
  }
  for (const AbsoluteMethod method : {AbsoluteMethod::kLeastSquares, AbsoluteMethod::kUmeyama,
                                      AbsoluteMethod::kQuaternion, AbsoluteMethod::kRodrigues, AbsoluteMethod::kPlane})
    for (const bool by_median : {false, true}) {
      OrientAbsoluteOptions options;
      options.method = method;
      options.sigma_ground = 0.01;
      (by_median ? options.least_median : options.reject) = true;
      const auto report = orient_absolutely(file("model.txt", model), file("ground.txt", ground), options);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_TRUE(report->points[2].is_rejected && report->points[7].is_rejected) << word_of(method) << by_median;
      EXPECT_LE(
          std::count_if(report->points.begin(), report->points.end(), [](const auto& p) { return p.is_rejected; }),
          by_median ? 3 : 2);
      EXPECT_NEAR(report->variance.sigma0, 1, method == AbsoluteMethod::kPlane ? 0.82 : 0.69);  // 4 / sqrt(2 r)
      EXPECT_NEAR(report->points[2].misfit.x(), 0.5, 0.05);  // the orientation is good to 1 cm, the point has 1 cm
      for (const Estimate& parameter : report->parameters) {
        ASSERT_TRUE(parameter.sigma);
        EXPECT_GT(*parameter.sigma, 0);
      }
      EXPECT_NE(absolute_text(*report).find("sigma0"), std::string::npos);
    }
}

TEST_F(Rejection, AClosedFormOnlyComparesWhatIsKnownInPart) {
  OrientAbsoluteOptions options;
  options.method = AbsoluteMethod::kUmeyama;
  const auto report =
      orient_absolutely(file("model.txt", "point U V W\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 10 10 1\n5 5 5 2\n"),
                        file("ground.txt", "point X Y Z\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 10 10 1\n5 5 5 -\n"), options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->full, 4);
  EXPECT_TRUE(report->points[4].is_check);
  EXPECT_EQ(report->variance.redundancy, 5);
}

}  // namespace
}  // namespace collinea
