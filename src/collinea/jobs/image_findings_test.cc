// SPDX-License-Identifier: Apache-2.0
// Findings of single images: each fires on a made case, and none on a good one.
#include "collinea/jobs/internal/image_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/interior.h"
#include "collinea/jobs/internal/codes_for_tests.h"
#include "collinea/jobs/intersection.h"
#include "collinea/jobs/resection.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kSigma_mm = 0.005;

class ImageFindings : public ::testing::Test {
 protected:
  ImageFindings() { options_.photo.principal_distance = 150; }
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  // A photograph of these points from `centre`, c = 150 mm, with noise of 5 um that the table states as `stated`.
  [[nodiscard]] Codes resected(const std::vector<Vector3d>& points, const Vector3d& centre, double stated = kSigma_mm,
                               const Vector2d& wrong_mm = {0, 0}) {
    Random random(4);
    const Eigen::Matrix3d r = rotation_matrix(CardanAngles{0.02, -0.03, 0.6});
    std::string measurements = "point x[mm] y[mm] sigma[mm]\n", ground = "point X Y Z\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d seen = r * (points[i] - centre);
      Vector2d xy = -150 * seen.head<2>() / seen.z() + kSigma_mm * Vector2d(random.normal(), random.normal());
      if (i == 2) xy += wrong_mm;
      const std::string name = std::to_string(i);
      measurements += name + " " + exact(xy.x()) + " " + exact(xy.y()) + " " + exact(stated) + "\n";
      ground += name + " " + exact(points[i].x()) + " " + exact(points[i].y()) + " " + exact(points[i].z()) + "\n";
    }
    const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options_);
    EXPECT_TRUE(report) << report.error().message << " " << centre.transpose();
    if (!report) return {"none"};
    findings_ = report->findings;
    text_ = resection_text(*report);
    return codes_of(findings_);
  }
  static std::vector<Vector3d> spread(int count = 12) {
    Random random(9);
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i)
      points.emplace_back(random.uniform(-400, 400), random.uniform(-400, 400), random.uniform(0, 150));
    return points;
  }

  ResectOneOptions options_;
  std::vector<Finding> findings_;
  std::string text_;
  TestFolder folder_;
};

TEST_F(ImageFindings, AGoodResectionHasNone) {
  EXPECT_EQ(resected(spread(), {20, -30, 900}), Codes{});
  EXPECT_EQ(text_.find("findings"), std::string::npos) << text_;
}

TEST_F(ImageFindings, MeasurementsOfAResectionAgainstEachOtherAndTheirSigmas) {
  EXPECT_EQ(resected(spread(), {20, -30, 900}, kSigma_mm, {0.1, 0}),
            (Codes{"measurement_contradicts", "residuals_large"}));
  EXPECT_EQ(first_of(findings_, FindingCode::kMeasurementContradicts).subjects[0].name, "2");
  EXPECT_NE(text_.find("findings\n  wrong: "), std::string::npos) << text_;
  EXPECT_EQ(resected(spread(), {20, -30, 900}, 10 * kSigma_mm), Codes{"residuals_small"});
  options_.reject = true;
  EXPECT_EQ(resected(spread(), {20, -30, 900}, kSigma_mm, {0.1, 0}), Codes{"measurements_rejected"});
  EXPECT_EQ(first_of(findings_, FindingCode::kMeasurementsRejected).severity, Severity::kNote);
}

// Three points have up to four poses; an approximate centre decides between them.
TEST_F(ImageFindings, ThreePointsLeaveThePoseOpen) {
  const std::vector<Vector3d> three{{-400, -300, 0}, {420, -280, 20}, {10, 390, -10}};
  const Codes open = resected(three, {20, -30, 900});
  EXPECT_TRUE(open.contains("nothing_checks"));
  ASSERT_TRUE(open.contains("solutions_open")) << text_;
  options_.near = "20,-30,900";
  const Codes chosen = resected(three, {20, -30, 900});
  EXPECT_TRUE(chosen.contains("solution_chosen") && !chosen.contains("solutions_open"));
}

// All control within 4 mm of the image and in one height.
TEST_F(ImageFindings, ControlInOnePartOfTheImageIsWeak) {
  std::vector<Vector3d> points = spread();
  for (Vector3d& point : points) point = {point.x() / 40 + 100, point.y() / 40, 0};
  EXPECT_EQ(resected(points, {20, -30, 900}), Codes{"pose_weak"});
}

TEST_F(ImageFindings, ControlOnACircleUnderTheStationIsDangerous) {
  std::vector<Vector3d> points;
  for (const double angle : {0.2, 1.3, 2.4, 3.9, 5.1})
    points.emplace_back(300 * std::cos(angle), 300 * std::sin(angle), 0);
  EXPECT_TRUE(resected(points, {290, 20, 900}).contains("danger_circle"));
  EXPECT_NEAR(first_of(findings_, FindingCode::kDangerCircle).figure(FigureName::kRadius).value_or(0), 300, 1e-6);
  EXPECT_FALSE(resected(spread(), {290, 20, 900}).contains("danger_circle"));
}

TEST_F(ImageFindings, AStationNearTheCircleOfItsPointsAndAPlaneWithoutPrincipalDistance) {
  options_.method = ResectionMethod::kStation;
  const auto of_station = [&](const Vector2d& station, bool adds_centre) {
    std::string measurements = "point direction[gon] sigma[gon]\n", ground = "point X[m] Y[m]\n";
    std::vector<Vector2d> points;
    for (const double angle : {0.2, 1.3, 2.4, 3.9}) points.emplace_back(500 * std::cos(angle), 500 * std::sin(angle));
    if (adds_centre) points.emplace_back(100, -50);
    Random random(6);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d d = points[i] - station;
      measurements +=
          std::to_string(i) + " " + exact(std::atan2(d.x(), d.y()) * 200 / M_PI + 0.002 * random.normal()) + " 0.002\n";
      ground += std::to_string(i) + " " + exact(points[i].x()) + " " + exact(points[i].y()) + "\n";
    }
    const auto report = resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options_);
    EXPECT_TRUE(report);
    return report ? codes_of(report->findings) : Codes{};
  };
  EXPECT_TRUE(of_station({-100, -470}, false).contains("danger_circle"));
  EXPECT_EQ(of_station({-30, 40}, false), Codes{});
  EXPECT_EQ(of_station({-100, -470}, true), Codes{});  // a point off the circle
  options_ = {};
  options_.method = ResectionMethod::kPlane;
  std::vector<Vector3d> plane = spread();
  for (Vector3d& point : plane) point.z() = 0;
  EXPECT_EQ(resected(plane, {20, -30, 900}), Codes{"pose_open"});
  options_.photo.principal_distance = 150;
  EXPECT_EQ(resected(plane, {20, -30, 900}), Codes{});
}

// Points seen by images at these positions looking down, c = 150 mm, noise of 5 um; the table of orientations states
// sigmas of 1 mm and 0.0001 degrees.
struct Survey {
  std::vector<Vector3d> centres{{0, 0, 1000}, {600, 0, 1000}}, points{{100, 200, 0}, {500, -300, 50}, {300, 10, 20}};
  bool has_sigmas = true, states_images = true;
  std::function<void(std::size_t, std::size_t, Vector2d&)> change = [](std::size_t, std::size_t, Vector2d&) {};
};

class RayFindings : public ImageFindings {
 protected:
  [[nodiscard]] Codes intersected(const Survey& survey) {
    Random random(3);
    std::string measurements = "image point x[mm] y[mm] sigma[mm]\n",
                orientation = "image X[m] Y[m] Z[m] omega phi kappa";
    if (survey.has_sigmas) orientation += " sigma_X sigma_Y sigma_Z sigma_omega sigma_phi sigma_kappa";
    orientation += "\n";
    for (std::size_t i = 0; i < survey.centres.size(); ++i) {
      const Vector3d& c = survey.centres[i];
      if (survey.states_images || i == 0)
        orientation += "I" + std::to_string(i) + " " + exact(c.x()) + " " + exact(c.y()) + " " + exact(c.z()) +
                       " 0 0 0" + (survey.has_sigmas ? " 0.001 0.001 0.001 0.0001 0.0001 0.0001" : "") + "\n";
      for (std::size_t p = 0; p < survey.points.size(); ++p) {
        const Vector3d d = survey.points[p] - c;
        Vector2d xy = -150 * d.head<2>() / d.z() + kSigma_mm * Vector2d(random.normal(), random.normal());
        survey.change(i, p, xy);
        measurements +=
            "I" + std::to_string(i) + " " + std::to_string(p) + " " + exact(xy.x()) + " " + exact(xy.y()) + " 0.005\n";
      }
    }
    IntersectTableOptions options;
    options.photo.principal_distance = 150;
    const auto report = intersect_from_tables(file("m.txt", measurements), file("o.txt", orientation), options);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    text_ = intersection_text(*report);
    return codes_of(findings_);
  }
};

TEST_F(RayFindings, GoodRaysHaveNone) { EXPECT_EQ(intersected({}), Codes{}) << text_; }

TEST_F(RayFindings, OrientationsWithoutSigmasAreExact) {
  EXPECT_EQ(intersected({.has_sigmas = false}), Codes{"orientations_exact"});
}

TEST_F(RayFindings, OneImageGivesNoDepth) {
  EXPECT_EQ(intersected({.states_images = false}), Codes{"seen_once"});
  EXPECT_EQ(findings_[0].severity, Severity::kWrong);  // of all points
  EXPECT_EQ(findings_[0].subjects.size(), 3u);
}

TEST_F(RayFindings, RaysAtSmallAnglesAndRaysThatMeetBehind) {
  EXPECT_EQ(intersected({.centres = {{0, 0, 1000}, {60, 0, 1000}}}), Codes{"rays_narrow"});
  // The point farthest off: 60 m at a distance of 1117 m, seen at an angle of 0.89.
  EXPECT_NEAR(first_of(findings_, FindingCode::kRaysNarrow).figure(FigureName::kAngle).value_or(0), 2.8, 0.05);
  Survey survey;
  survey.change = [](std::size_t image, std::size_t point, Vector2d& xy) {  // diverging: they meet behind
    if (point == 0) xy.x() = image == 0 ? -60 : 60;
  };
  EXPECT_TRUE(intersected(survey).contains("rays_without_point")) << text_;
}

TEST_F(RayFindings, TwoRaysDoNotTellWhichIsWrongAndThreeDo) {
  Survey survey;
  survey.change = [](std::size_t image, std::size_t point, Vector2d& xy) {
    if (image == 1 && point == 2) xy.y() += 0.2;
  };
  EXPECT_EQ(intersected(survey), (Codes{"rays_miss", "residuals_large"}));
  EXPECT_EQ(first_of(findings_, FindingCode::kRaysMiss).subjects, std::vector<Subject>{Subject::point("2")});
  survey.centres.emplace_back(300, 500, 1000);
  EXPECT_EQ(intersected(survey), (Codes{"measurement_contradicts", "residuals_large"}));
  EXPECT_EQ(findings_[0].subjects[0].name, "2");
}

// The camera of the pair 27/28 of film_pairs, from its certificate, and the first reader's marks of image 27.
constexpr const char* kCamera =
    "camera RC30\nprincipal_distance_mm 153.358\nprincipal_point_mm -0.006 0.006\n"
    "mark 1 -105.997 -105.995\nmark 2 106.004 106.008\nmark 3 -106.000 106.009\nmark 4 106.012 -105.995\n"
    "mark 5 -112.000 0.007\nmark 6 112.006 0.007\nmark 7 0.005 112.007\nmark 8 0.002 -111.998\n";
struct Pointing {
  std::string mark;
  double x, y;
};
const std::vector<Pointing> kMarks{{"1", 1347, 19285}, {"2", 19161, 1470},  {"3", 1345, 1471}, {"4", 19163, 19283},
                                   {"5", 843, 10379},  {"6", 19666, 10376}, {"7", 10254, 966}, {"8", 10254, 19789}};

class FilmFindings : public ImageFindings {
 protected:
  [[nodiscard]] Codes oriented(const std::vector<Pointing>& marks, std::optional<double> sigma = {},
                               bool keep_misread = false) {
    std::string text = "image mark x[px] y[px]\n";
    for (const Pointing& mark : marks) text += "27 " + mark.mark + " " + exact(mark.x) + " " + exact(mark.y) + "\n";
    InteriorOptions options{.calibration = file("camera.txt", kCamera)};
    options.sigma = sigma;
    options.keep_misread = keep_misread;
    options.out = folder_ / "out";
    const auto report = interior_orientation(file("marks.txt", text), options, {});
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    text_ = interior_text(*report);
    return codes_of(findings_);
  }
};

TEST_F(FilmFindings, GoodMarksHaveNoneAndTheyAreWritten) {
  EXPECT_EQ(oriented(kMarks), Codes{});
  EXPECT_EQ(read_file(folder_ / "out" / "findings.json").value(), "{\n  \"findings\": []\n}\n");
}

TEST_F(FilmFindings, MarksThatAreMisreadMissingOrUnknown) {
  std::vector<Pointing> marks = kMarks;
  marks[2].x += 40;
  EXPECT_EQ(oriented(marks), Codes{"fiducials_left_out"});
  EXPECT_EQ(findings_[0].subjects, (std::vector<Subject>{Subject::image_named("27"), Subject::mark("3")}));
  EXPECT_NE(text_.find("Of the 8 marks of 27 1 was left out as misread (3)"), std::string::npos) << text_;
  EXPECT_NE(read_file(folder_ / "out" / "findings.json").value().find("\"fiducials_left_out\""), std::string::npos);
  marks = kMarks;
  marks[7].mark = "9";
  EXPECT_EQ(oriented(marks), (Codes{"fiducials_missing", "fiducials_unknown"}));
}

TEST_F(FilmFindings, ReadingsThatDiffer) {
  std::vector<Pointing> marks = kMarks;
  marks.push_back({"3", 1345 + 60, 1471});
  EXPECT_TRUE(oriented(marks).contains("readings_contested"));
  marks.push_back({"3", 1346, 1471});
  EXPECT_EQ(oriented(marks), Codes{"readings_gross"});
}

TEST_F(FilmFindings, TwoMarksCheckNothingAndFourMayContradict) {
  EXPECT_EQ(oriented({kMarks[0], kMarks[1]}), (Codes{"fiducials_missing", "nothing_checks"}));
  std::vector<Pointing> four{kMarks.begin(), kMarks.begin() + 4};
  four[2].y += 300;
  four[3].x += 300;
  EXPECT_TRUE(oriented(four).contains("fiducials_contradict"));
  // Marks that are read to half a pixel, and stated to ten and to a twentieth.
  EXPECT_EQ(oriented(kMarks, 10), Codes{"residuals_small"});
  EXPECT_EQ(oriented(kMarks, 0.05, true), Codes{"fiducials_contradict"});
}

TEST_F(FilmFindings, RowsFromBelow) {
  std::vector<Pointing> marks = kMarks;
  for (Pointing& mark : marks) mark.y = 20480 - mark.y;
  EXPECT_EQ(oriented(marks), Codes{"seen_from_behind"});
}

}  // namespace
}  // namespace collinea
