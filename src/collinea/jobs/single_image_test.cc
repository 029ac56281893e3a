// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/source_tree.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/intersection.h"
#include "collinea/jobs/resection.h"
#include "collinea/jobs/rotation.h"

namespace collinea {
namespace {

std::filesystem::path exercises() {
  return std::filesystem::path(source_tree()) / "../shared/data/collinearity_exercises/data";
}

double value_of(const std::vector<Estimate>& estimates, const std::string& name) {
  for (const Estimate& e : estimates)
    if (e.name == name) return e.value;
  return NAN;
}

class SingleImage : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  TestFolder folder_;
};

// A vertical photograph from (100, 200, 1500), c = 150 mm, of the points below.
constexpr const char* kVertical =
    "image point x[mm] y[mm]\nA 1 -100 100\nA 2 100 100\nA 3 100 -100\nA 4 -100 -100\nA 5 0 0\nA 6 11.53846153846154 "
    "0\n"
    "A 7 0 -57.69230769230769\n";
constexpr const char* kVerticalGround =
    "point X[m] Y[m] Z[m]\n1 -900 1200 0\n2 1100 1200 0\n3 1100 -800 0\n4 -900 -800 0\n5 100 200 0\n6 200 200 200\n"
    "7 100 -300 200\n";

TEST_F(SingleImage, VerticalPhotographInEveryWay) {
  const auto measurements = file("m.txt", kVertical), ground = file("g.txt", kVerticalGround);
  for (const ResectionMethod method : {ResectionMethod::kCollinearity, ResectionMethod::kDlt}) {
    ResectOneOptions options;
    options.method = method;
    options.photo.principal_distance = 150;
    const auto report = resect_from_tables(measurements, ground, options);
    ASSERT_TRUE(report) << report.error().message;
    const auto& exterior = report->images[0].exterior;
    EXPECT_NEAR(value_of(exterior, "X"), 100, 1e-5);
    EXPECT_NEAR(value_of(exterior, "Y"), 200, 1e-5);
    EXPECT_NEAR(value_of(exterior, "Z"), 1500, 1e-5);
    EXPECT_NEAR(value_of(exterior, "omega"), 0, 1e-6);
    EXPECT_NEAR(value_of(exterior, "kappa"), 0, 1e-6);
    if (method != ResectionMethod::kDlt) continue;
    EXPECT_NEAR(value_of(report->images[0].interior, "c_x"), 150, 1e-5);
    EXPECT_NEAR(value_of(report->images[0].interior, "axes"), 90, 1e-6);
    EXPECT_NE(resection_text(*report).find("omega"), std::string::npos);
    EXPECT_GE(resection_tables(*report).size(), 2u);
  }
}

// The matrix taken apart gives the measurements back, and rays that meet the points, in photographs and in pixels; axes
// that are not square to each other are found as they are.
TEST_F(SingleImage, TheMatrixOfTheDltIsTakenApart) {
  const Eigen::Matrix3d r = rotation_matrix(CardanAngles{0.1, -0.2, 0.6});
  const Eigen::Vector3d centre(20, -30, 900);
  Eigen::Matrix3d k;  // c_x = 150 mm, axes at 89 degrees, principal point 2, -3
  k << -150, 150 * std::tan(M_PI / 180), 2, 0, -151, -3, 0, 0, 1;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 9; ++i) points.emplace_back(180 * (i % 3) - 150, 200 * (i / 3) - 220, 40 * ((5 * i) % 4));
  for (const bool in_mm : {true, false}) {
    std::string measurements = in_mm ? "point x[mm] y[mm]\n" : "point x[px] y[px]\n", ground = "point X Y Z\n";
    std::vector<Eigen::Vector2d> seen;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Vector2d xy = (k * r * (points[i] - centre)).eval().hnormalized();
      if (!in_mm) xy.y() = -xy.y();
      seen.push_back(xy);
      measurements += std::to_string(i) + " " + exact(xy.x()) + " " + exact(xy.y()) + "\n";
      ground += std::to_string(i) + " " + exact(points[i].x()) + " " + exact(points[i].y()) + " " +
                exact(points[i].z()) + "\n";
    }
    ResectOneOptions options;
    options.method = ResectionMethod::kDlt;
    const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options);
    ASSERT_TRUE(report) << report.error().message;
    const ResectionReport::Image& image = report->images[0];
    ASSERT_TRUE(image.parts);
    EXPECT_LT((image.parts->centre - centre).norm(), 1e-4);
    if (in_mm) {
      EXPECT_LT((image.parts->calibration - k).norm(), 1e-4) << image.parts->calibration;
      EXPECT_LT((image.parts->rotation - r).norm(), 1e-7);
      EXPECT_LT((image.parts->axis + r.row(2).transpose()).norm(), 1e-7);  // z of a photograph points backwards
    }
    EXPECT_GT(image.parts->rotation.determinant(), 0.999);
    EXPECT_NEAR(value_of(image.interior, "axes"), in_mm ? 89 : 91, 1e-5);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d h =
          image.parts->calibration * (image.parts->rotation * points[i] + image.parts->translation);
      EXPECT_LT((h.hnormalized() - seen[i]).norm(), 1e-7);
      ASSERT_TRUE(report->marks[i].ray);
      EXPECT_NEAR(report->marks[i].ray->dot((points[i] - centre).normalized()), 1, 1e-12);
    }
    const std::string text = resection_text(*report);
    EXPECT_NE(text.find("the matrix taken apart"), std::string::npos) << text;
    EXPECT_EQ(resection_tables(*report).back().name, "rays.txt");
  }
}

TEST_F(SingleImage, TwoImagesAtOnceAreADoubleImageResection) {
  std::string measurements = kVertical;
  for (const std::string_view line : lines_of(kVertical))
    if (line.starts_with("A ")) measurements += "B" + std::string(line.substr(1)) + "\n";
  ResectOneOptions options;
  options.photo.principal_distance = 150;
  const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", kVerticalGround), options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(resection_text(*report).find("double-image resection by collinearity"), 0u) << resection_text(*report);
}

TEST_F(SingleImage, PlaneOfEightParameters) {
  const auto measurements = file("m.txt", "point x[mm] y[mm]\n1 -100 100\n2 100 100\n3 100 -100\n4 -100 -100\n5 0 0\n");
  const auto ground = file("g.txt", "point X Y\n1 -900 1200\n2 1100 1200\n3 1100 -800\n4 -900 -800\n5 100 200\n");
  ResectOneOptions options;
  options.method = ResectionMethod::kPlane;
  const auto unknown = resect_from_tables(measurements, ground, options);
  ASSERT_TRUE(unknown) << unknown.error().message;
  EXPECT_TRUE(unknown->images[0].exterior.empty());
  EXPECT_EQ(unknown->images[0].elements.size(), 8u);
  EXPECT_EQ(unknown->variance.redundancy, 2);
  options.photo.principal_distance = 150;
  const auto known = resect_from_tables(measurements, ground, options);
  ASSERT_TRUE(known);
  EXPECT_NEAR(value_of(known->images[0].exterior, "Z"), 1500, 1e-4);
  options.method = ResectionMethod::kDlt;
  EXPECT_FALSE(resect_from_tables(measurements, ground, options));
}

// Image 4167 of the wall pair: two poses, five metres apart.
TEST_F(SingleImage, ThreePointsListAllSolutionsAndOneIsChosenByNearness) {
  const auto measurements = file("m.txt",
                                 "point x[px] y[px]\nStone-6 643.530 231.456\nStone-7 1267.055 735.920\n"
                                 "Grille 318.472 768.087\n");
  const auto ground = file("g.txt",
                           "point X[m] Y[m] Z[m]\nStone-6 0.150698 1.108183 0.773465\n"
                           "Stone-7 0.256396 2.353188 2.238878\nGrille 1.402075 2.194546 0.403830\n");
  ResectOneOptions options;
  options.photo.principal_distance = 2112.218;
  options.photo.principal_point = "856.867,577.6137";
  const Eigen::Vector3d centres[] = {{5.2, 1.5, 2.1}, {0.8, -2.5, 2.0}};
  for (const Eigen::Vector3d& centre : centres) {
    options.near = exact(centre.x()) + "," + exact(centre.y()) + "," + exact(centre.z());
    const auto report = resect_from_tables(measurements, ground, options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->variance.redundancy, 0);
    EXPECT_EQ(report->images[0].solutions.size(), 2u);
    EXPECT_NEAR(value_of(report->images[0].exterior, "X"), centre.x(), 0.1);
    EXPECT_NE(resection_text(*report).find("three points have 2 poses"), std::string::npos);
  }
}

TEST_F(SingleImage, AWrongMeasurementIsNamedAndLeftOut) {
  std::string text = kVertical;
  text.replace(text.find("A 6 11.538"), 10, "A 6 12.538");
  const auto measurements = file("m.txt", text), ground = file("g.txt", kVerticalGround);
  ResectOneOptions options;
  options.photo.principal_distance = 150;
  options.sigma = 0.01;
  const auto named = resect_from_tables(measurements, ground, options);
  ASSERT_TRUE(named);
  EXPECT_NE(resection_text(*named).find("point 6 in A contradicts"), std::string::npos) << resection_text(*named);
  options.reject = true;
  const auto rejected = resect_from_tables(measurements, ground, options);
  ASSERT_TRUE(rejected);
  EXPECT_TRUE(rejected->marks[5].is_rejected);
  EXPECT_NEAR(rejected->marks[5].misfit.x(), 1, 1e-3);
  options.reject = false;
  options.least_median = true;
  const auto robust = resect_from_tables(measurements, ground, options);
  ASSERT_TRUE(robust);
  EXPECT_TRUE(robust->marks[5].is_rejected);
}

TEST_F(SingleImage, StationFromDirections) {
  std::string text = "point direction[deg]\n";
  const std::vector<Eigen::Vector2d> points{{0, 1000}, {900, 800}, {1000, -200}, {-700, 300}};
  std::string ground = "point X[m] Y[m]\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d d = points[i] - Eigen::Vector2d(100, 50);
    text += std::to_string(i) + " " + exact(std::atan2(d.x(), d.y()) * 180 / M_PI - 30) + "\n";
    ground += std::to_string(i) + " " + exact(points[i].x()) + " " + exact(points[i].y()) + "\n";
  }
  ResectOneOptions options;
  options.method = ResectionMethod::kStation;
  const auto report = resect_from_tables(file("m.txt", text), file("g.txt", ground), options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(value_of(report->images[0].exterior, "X"), 100, 1e-6);
  EXPECT_NEAR(value_of(report->images[0].exterior, "orientation"), 30, 1e-8);
}

TEST_F(SingleImage, BadTablesAreRefused) {
  const auto good = file("g.txt", kVerticalGround);
  ResectOneOptions options;
  EXPECT_FALSE(resect_from_tables(file("m.txt", kVertical), good, options));  // no principal distance
  options.photo.principal_distance = 150;
  EXPECT_FALSE(resect_from_tables(file("m.txt", "point x[mm] y[mm]\n1 0 0\n2 1 1\n"), good, options));
  EXPECT_FALSE(resect_from_tables(file("m.txt", "point x[mm] y[mm]\n1 0 0\n1 1 1\n"), good, options));
  EXPECT_FALSE(resect_from_tables(file("m.txt", "point x[mm] y[mm] sigma\n1 0 0 0\n"), good, options));
  EXPECT_FALSE(resect_from_tables(file("m.txt", "point x[mm]\n1 0\n"), good, options));
  EXPECT_FALSE(intersect_from_tables(folder_ / "none", folder_ / "none", {}));
  EXPECT_FALSE(convert_rotation("1,2", {}));
  EXPECT_FALSE(convert_rotation("0,0,0,0", {.from = RotationForm::kQuaternion}));
  EXPECT_FALSE(convert_rotation("1,0,0,0,1,0,0,0,-1", {.from = RotationForm::kMatrix}));
}

TEST_F(SingleImage, RotationInEveryForm) {
  const auto report = convert_rotation("0.3,-0.4,0.7", {.unit = AngleUnit::kRadian});
  ASSERT_TRUE(report);
  EXPECT_NEAR(report->matrix(0, 1), 0.5274258682, 1e-10);  // Mussio D.8
  EXPECT_NE(rotation_text(*report).find("quaternion"), std::string::npos);
}

// Surveyed point 9 of the exercises: (265516.276, 6239996.187, 87.62). The results that their authors print are wrong
// by 50-70 m, because units and the principal point are left out. Coordinates there are relative to the principal
// point, y up, f = 8.865 mm = 3678.42 px.
TEST_F(SingleImage, SurveyedPointOfTheExercisesByTwoToFourImages) {
  if (!std::filesystem::exists(exercises())) GTEST_SKIP() << "no shared data";
  for (const int count : {2, 3, 4}) {
    const std::string name = "inter/inputInter0" + std::to_string(count) + ".txt";
    const std::string text = read_file(exercises() / name).value();
    std::string measurements = "image point x[px] y[px]\n", orientation = "image X Y Z omega phi kappa\n";
    for (const std::string_view line : lines_of(text)) {
      const auto words = words_of(line);
      if (words.size() < 9) continue;
      // Columns of the file: x is a column from the left, y is minus a row from the top.
      measurements +=
          std::string(words[0]) + " 9 " + std::string(words[1]) + " " + exact(-*finite_number(words[2])) + "\n";
      orientation += std::string(words[0]);
      for (std::size_t k = 3; k < 9; ++k) orientation += " " + std::string(words[k]);
      orientation += "\n";
    }
    IntersectTableOptions options;
    options.photo.principal_distance = 8.865 / 0.00241;
    options.photo.principal_point = "2737.24,1839.91";
    options.ground = file("g.txt", "point X Y Z\n9 265516.276 6239996.187 87.62\n");
    const auto report = intersect_from_tables(file("m.txt", measurements), file("o.txt", orientation), options);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(report->points[0].is_found);
    EXPECT_EQ(report->points[0].redundancy, 2 * count - 3);
    EXPECT_LT(report->points[0].off_ground.cwiseAbs().maxCoeff(), 0.5) << report->points[0].off_ground.transpose();
  }
}

// Image 121 of the exercises; recomputed: omega -10.731, phi 0.324, kappa -177.159, centre -49652.05 -3758661.01
// 140.36.
TEST_F(SingleImage, ImageOfTheExercisesIsResected) {
  if (!std::filesystem::exists(exercises())) GTEST_SKIP() << "no shared data";
  const std::string text = read_file(exercises() / "resec/resecResc121.inp").value();
  std::string measurements = "point x[px] y[px]\n", ground = "point X Y Z\n";
  for (const std::string_view line : lines_of(text)) {
    const auto words = words_of(line);
    if (words.size() < 6) continue;
    measurements += std::string(words[0]) + " " + std::string(words[1]) + " " + std::string(words[2]) + "\n";
    ground += std::string(words[0]) + " " + std::string(words[3]) + " " + std::string(words[4]) + " " +
              std::string(words[5]) + "\n";
  }
  ResectOneOptions options;
  options.photo.principal_distance = 8.865 / 0.00241;
  options.photo.principal_point = "2737.24,1839.91";
  const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options);
  ASSERT_TRUE(report) << report.error().message;
  const auto& exterior = report->images[0].exterior;
  EXPECT_NEAR(value_of(exterior, "X"), -49652.05, 0.05);
  EXPECT_NEAR(value_of(exterior, "Y"), -3758661.01, 0.05);
  EXPECT_NEAR(value_of(exterior, "Z"), 140.36, 0.05);
  EXPECT_NEAR(value_of(exterior, "omega"), -10.731, 0.01);
  EXPECT_NEAR(value_of(exterior, "kappa"), -177.159, 0.01);
}

}  // namespace
}  // namespace collinea
