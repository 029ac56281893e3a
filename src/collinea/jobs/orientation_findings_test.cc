// SPDX-License-Identifier: Apache-2.0
// Findings of pairs, triplets, models and uncalibrated images: each fires on a made case, and none on a good one.
#include "collinea/jobs/internal/orientation_findings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/epipolar/survey_for_tests.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/text.h"
#include "collinea/jobs/absolute.h"
#include "collinea/jobs/factorise.h"
#include "collinea/jobs/internal/codes_for_tests.h"
#include "collinea/jobs/relative.h"
#include "collinea/jobs/triplet.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kSigma_mm = 0.005;

class OrientationFindings : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  TestFolder folder_;
};

// A pair with c = 153 mm and a base of 1, noise of 5 um; points 3 and so on are wrong in y of the second image.
class PairFindingsOf : public OrientationFindings {
 protected:
  [[nodiscard]] Codes oriented(const std::vector<Vector3d>& points, double stated = kSigma_mm, int wrong = 0) {
    Random random(3);
    const Rigid3 motion = motion_of(DependentElements{1, 0.03, -0.02, 0.011, -0.013, 0.02});
    std::string text = "point x_left[mm] y_left[mm] x_right[mm] y_right[mm] sigma[mm]\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d one = points[i].hnormalized(), two = (motion * points[i]).hnormalized();
      const auto noise = [&] { return kSigma_mm * random.normal(); };
      const double off = i >= 3 && i < 3 + static_cast<std::size_t>(wrong) ? 0.3 : 0;
      text += "P" + std::to_string(i);
      for (const double v : {153 * one.x() + noise(), -153 * one.y() + noise(), 153 * two.x() + noise(),
                             -153 * two.y() + noise() + off, stated})
        text += " " + exact(v);
      text += "\n";
    }
    options_.photo.principal_distance = 153;
    options_.out = folder_ / "out";
    const auto report = orient_pair(file("pair.txt", text), options_);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    text_ = relative_text(*report);
    return codes_of(findings_);
  }
  static std::vector<Vector3d> spread(int count, double flatness = 1) {
    Random random(5);
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i)
      points.emplace_back(random.uniform(-0.2, 1.2), random.uniform(-1, 1), 1.6 + flatness * random.uniform(-0.4, 0.4));
    return points;
  }

  RelativePairOptions options_;
  std::vector<Finding> findings_;
  std::string text_;
};

TEST_F(PairFindingsOf, AGoodPairHasNone) {
  EXPECT_EQ(oriented(spread(24)), Codes{}) << text_;
  EXPECT_EQ(read_file(folder_ / "out" / "findings.json").value(), "{\n  \"findings\": []\n}\n");
}

TEST_F(PairFindingsOf, FewPointsAndFive) {
  EXPECT_EQ(oriented(spread(8)), Codes{"few_points"});
  EXPECT_TRUE(oriented(spread(5)).contains("nothing_checks"));
}

TEST_F(PairFindingsOf, MeasurementsAgainstEachOtherAndTheirSigmas) {
  EXPECT_EQ(oriented(spread(24), kSigma_mm, 1), Codes{"measurements_rejected"});
  EXPECT_EQ(findings_[0].severity, Severity::kNote);
  EXPECT_EQ(findings_[0].subjects, std::vector<Subject>{Subject::point("P3")});
  EXPECT_EQ(oriented(spread(24), kSigma_mm, 6), Codes{"measurements_rejected"});
  EXPECT_EQ(findings_[0].severity, Severity::kWeak);
  options_.adjustment.rejection = PairRejection::kNone;
  EXPECT_EQ(oriented(spread(24), kSigma_mm, 1), (Codes{"measurement_contradicts", "residuals_large"}));
  EXPECT_EQ(oriented(spread(24), 0.1), Codes{"residuals_small"});
}

// Points in a plane; and left and right exchanged, which puts all points behind.
TEST_F(PairFindingsOf, AWeakGeometryIsNamed) {
  EXPECT_EQ(oriented(spread(24, 0)), Codes{"pair_geometry"});
  EXPECT_EQ(first_of(findings_, FindingCode::kPairGeometry).detail, "plane");
}

TEST(ChoiceFindings, PointsBehindAndSolutionsAlike) {
  RelativeOrientation orientation;
  orientation.used = 20;
  orientation.in_front = 19;
  std::array<RelativeSolution, 4> solutions;
  for (std::size_t k = 0; k < 4; ++k) solutions[k].in_front = k == 0 ? 19 : 1;
  std::vector<Finding> findings;
  add_choice_findings(orientation, solutions, findings);
  EXPECT_EQ(codes_of(findings), Codes{});
  orientation.in_front = 11;
  solutions[0].in_front = solutions[2].in_front = 11;
  add_choice_findings(orientation, solutions, findings);
  EXPECT_EQ(codes_of(findings), (Codes{"points_behind", "solutions_open"}));
  EXPECT_EQ(first_of(findings, FindingCode::kPointsBehind).figure(FigureName::kCount), 9);
  EXPECT_EQ(first_of(findings, FindingCode::kSolutionsOpen).figure(FigureName::kCount), 2);
}

// Three vertical photographs in a row, c = 153 mm, bases 600 m and 480 m.
class TripletFindings : public OrientationFindings {
 protected:
  [[nodiscard]] Codes oriented(int count, double off_mm = 0) {
    Random random(5);
    const OmegaPhiKappa angles[3] = {{0, 0, 0}, {1.2, -0.8, 2.5}, {-0.7, 1.5, -3.0}};
    const Vector3d centres[3] = {{0, 0, 0}, {600, 0, 0}, {1075, 66, 20}};
    std::string text = "image point x[mm] y[mm]\n";
    for (int p = 0; p < count + 6; ++p) {
      const Vector3d point(random.uniform(200, 900), random.uniform(-700, 700), random.uniform(-1100, -900));
      for (int i = 0; i < 3; ++i) {
        const Rigid3 pose{cam_from_world(angles[i]), -(cam_from_world(angles[i]) * centres[i])};
        const Vector2d seen = 153 * (pose * point).hnormalized() + 0.003 * Vector2d(random.normal(), random.normal());
        if (p >= count && i == (p % 2 ? 0 : 2)) continue;  // these are seen in two images
        text += std::string(1, char('A' + i)) + " " + std::to_string(p) + " " +
                exact(seen.x() + (i == 2 && p == 1 ? off_mm : 0)) + " " + exact(-seen.y()) + "\n";
      }
    }
    options_.photo.principal_distance = 153;
    options_.sigma = 0.003;
    const auto report = orient_triplet(file("m.txt", text), options_);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    return codes_of(findings_);
  }
  TripletOptions options_;
  std::vector<Finding> findings_;
};

TEST_F(TripletFindings, FireOnMadeCasesOnly) {
  EXPECT_EQ(oriented(18), Codes{});
  EXPECT_TRUE(oriented(3).contains("few_points"));
  EXPECT_EQ(oriented(18, 0.05), Codes{"measurements_rejected"});
  EXPECT_EQ(findings_[0].subjects, std::vector<Subject>{Subject::point("1")});
  options_.adjustment.rejection = PairRejection::kNone;
  EXPECT_EQ(oriented(18, 0.05), (Codes{"measurement_contradicts", "residuals_large"}));
}

TEST(TripletReportFindings, CombinationsPointsBehindAndWithoutPosition) {
  TripletReport report;
  report.variance = {1, 20, true};
  report.common = 8;
  for (auto& one : report.joined.combinations) one.in_front = 1;
  report.joined.combinations[0].is_joined = report.joined.combinations[5].is_joined = true;
  report.joined.combinations[0].in_front = 8;
  report.joined.chosen = 0;
  EXPECT_EQ(codes_of(triplet_findings(report)), Codes{});
  report.joined.combinations[7].is_joined = true;
  report.joined.combinations[0].in_front = 6;
  report.without_position = {"4"};
  EXPECT_EQ(codes_of(triplet_findings(report)), (Codes{"combinations_open", "points_behind", "rays_without_point"}));
}

// A model at the scale 1 : 2.5 with errors of 1 cm on the ground; point 3 is off by `wrong`.
class ControlFindings : public OrientationFindings {
 protected:
  [[nodiscard]] Codes oriented(const std::vector<Vector3d>& points, double stated = 0.01, double wrong = 0) {
    Random random(2);
    std::string model = "point U V W\n", ground = "point X[m] Y[m] Z[m]\n";
    const Eigen::Quaterniond turn = rotation_by(Vector3d(0, 0, 0.7));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d u = points[i];
      Vector3d x = 2.5 * (turn * u) + Vector3d(100, 200, 50) +
                   0.01 * Vector3d(random.normal(), random.normal(), random.normal());
      if (i == 3) x.x() += wrong;
      model += std::to_string(i) + " " + exact(u.x()) + " " + exact(u.y()) + " " + exact(u.z()) + "\n";
      ground += std::to_string(i) + " " + exact(x.x()) + " " + exact(x.y()) + " " + exact(x.z()) + "\n";
    }
    options_.sigma_ground = stated;
    options_.sigma_model = 1e-4;
    const auto report = orient_absolutely(file("model.txt", model), file("ground.txt", ground), options_);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    text_ = absolute_text(*report);
    return codes_of(findings_);
  }
  static std::vector<Vector3d> spread(int count, double width = 1) {
    Random random(7);
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i)
      points.emplace_back(random.uniform(-20, 20), width * random.uniform(-20, 20), width * random.uniform(-5, 5));
    return points;
  }
  OrientAbsoluteOptions options_;
  std::vector<Finding> findings_;
  std::string text_;
};

TEST_F(ControlFindings, GoodControlHasNone) { EXPECT_EQ(oriented(spread(8)), Codes{}) << text_; }

TEST_F(ControlFindings, LittleControlAndControlNearALine) {
  EXPECT_EQ(oriented(spread(3)), Codes{"control_few"});
  EXPECT_EQ(oriented(spread(8, 0.02)), Codes{"control_on_line"});
}

TEST_F(ControlFindings, ControlThatContradictsIsNamedAndRejected) {
  EXPECT_EQ(oriented(spread(8), 0.01, 0.5), (Codes{"control_contradicts", "residuals_large"}));
  const Finding contradicts = first_of(findings_, FindingCode::kControlContradicts);
  EXPECT_EQ(contradicts.subjects[0].name, "3");
  EXPECT_EQ(contradicts.subjects[0].axis, 0);
  EXPECT_NE(text_.find("Control point 3 contradicts the others in X by"), std::string::npos) << text_;
  EXPECT_EQ(oriented(spread(8), 0.2), Codes{"residuals_small"});
  options_.reject = true;
  EXPECT_EQ(oriented(spread(8), 0.01, 0.5), Codes{"control_rejected"});
  options_.reject = false;
  options_.check = "3";
  EXPECT_EQ(oriented(spread(8), 0.01, 0.5), Codes{"check_point"});
  EXPECT_NEAR(findings_[0].figure(FigureName::kOffset).value_or(0), 0.5, 0.05);
  EXPECT_EQ(oriented(spread(8)), Codes{});
}

// Two points known in full and a height: the model can tilt about their line to either side.
TEST_F(ControlFindings, OrientationsThatFitAsWell) {
  AbsoluteReport report;
  report.full = 5;
  report.variance = {1, 8, true};
  EXPECT_EQ(codes_of(absolute_findings(report, {})), Codes{});
  report.solutions = 2;
  report.variance.redundancy = 0;
  EXPECT_EQ(codes_of(absolute_findings(report, {})), (Codes{"nothing_checks", "solutions_open"}));
}

class UncalibratedFindings : public OrientationFindings {
 protected:
  UncalibratedFindings() {
    options_.sigma = 0.3;
    options_.calibration = CalibrationUnknowns::kAll;
  }
  [[nodiscard]] Codes factorised(const SelfCalibrationTruth& truth, int left_out = 0) {
    std::string text = "image point x[px] y[px]\n";
    for (std::size_t i = 0; i < truth.measured.images(); ++i)
      for (Eigen::Index p = i == 0 ? left_out : 0; p < truth.measured.points(); ++p)
        text += "I" + std::to_string(i) + " " + std::to_string(p) + " " + exact(truth.measured.xy[i](0, p)) + " " +
                exact(truth.measured.xy[i](1, p)) + "\n";
    const auto report = factorise_table(file("m.txt", text), options_);
    EXPECT_TRUE(report) << report.error().message;
    if (!report) return {};
    findings_ = report->findings;
    text_ = factorisation_text(*report);
    return codes_of(findings_);
  }
  static SelfCalibrationTruth survey(std::size_t images = 5) {
    return self_calibration_truth({.images = images, .points = 30, .sigma = 0.3, .seed = 4});
  }
  FactoriseOptions options_;
  std::vector<Finding> findings_;
  std::string text_;
};

TEST_F(UncalibratedFindings, AGoodSurveyHasNone) { EXPECT_EQ(factorised(survey()), Codes{}) << text_; }

TEST_F(UncalibratedFindings, PointsNotInAllImagesAndOnesThatContradict) {
  EXPECT_EQ(factorised(survey(), 2), Codes{"not_in_all_images"});
  SelfCalibrationTruth truth = survey();
  truth.measured.xy[2].col(11) += Vector2d(6, -9);
  const Codes named = factorised(truth);
  EXPECT_TRUE(named.contains("measurement_contradicts") && named.contains("residuals_large"));
  options_.reject = true;
  EXPECT_EQ(factorised(truth), Codes{"measurements_rejected"});
}

// The stated camera is square, the true one is not; two images have no Euclidean form.
TEST_F(UncalibratedFindings, CamerasThatAreRefuted) {
  EXPECT_TRUE(factorised(survey(2)).contains("no_euclidean_form"));
  options_.photo.principal_distance = 3000;
  options_.photo.principal_point = "1510,990";
  EXPECT_EQ(factorised(survey()), Codes{"stated_camera_refuted"}) << text_;
  SelfCalibrationTruth two_cameras = survey();
  for (Eigen::Index p = 0; p < two_cameras.measured.points(); ++p)
    two_cameras.measured.xy[3].col(p) =
        1.05 * (two_cameras.measured.xy[3].col(p) - Vector2d(1510, 990)) + Vector2d(1560, 960);
  EXPECT_TRUE(factorised(two_cameras).contains("one_calibration_refuted")) << text_;
}

// The relief is half a hundredth of what it was: near a plane.
TEST_F(UncalibratedFindings, ASceneNearAPlane) {
  SelfCalibrationTruth truth = survey();
  Random random(1);
  const double middle = truth.bundles.points[0].z();
  for (std::size_t i = 0; i < truth.matrices.size(); ++i)
    for (std::size_t p = 0; p < truth.bundles.points.size(); ++p) {
      Vector3d point = truth.bundles.points[p];
      point.z() = middle + 0.005 * (point.z() - middle);
      truth.measured.xy[i].col(Eigen::Index(p)) =
          (truth.matrices[i] * point.homogeneous()).hnormalized() + scene::noise(random, 0.3);
    }
  EXPECT_TRUE(factorised(truth).contains("rank_near_three")) << text_;
}

TEST(FactorisationReportFindings, APoorPrincipalDistanceAndACameraThatFitsNot) {
  FactorisationReport report;
  report.projective.fourth = 0.5;
  report.projective.fifth = 1e-4;
  report.projective_variance = {1, 40, true};
  report.self_calibrated.emplace();
  report.self_calibrated->interior = {{"c_x", "px", 3000, 30.0}};
  report.self_calibrated->variance = {1, 45, true};
  EXPECT_EQ(codes_of(factorisation_findings(report)), Codes{});
  report.self_calibrated->interior[0].sigma = 90;
  report.why_not_calibrated = "nothing fits";
  EXPECT_EQ(codes_of(factorisation_findings(report)), (Codes{"camera_fits_not", "principal_distance_weak"}));
}

}  // namespace
}  // namespace collinea
