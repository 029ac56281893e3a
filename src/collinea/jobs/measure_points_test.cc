// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure_points.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

// A simulated survey, oriented; its check points are what is measured.
struct Surveyed {
  TestFolder folder;
  Block block;
  std::vector<ControlId> points;

  Surveyed() {
    SurveyOptions survey;
    survey.images = 12;
    survey.control_points = 6;
    survey.check_points = 5;
    auto project = open_simulated(folder / "block", survey, {.points_per_image = 120});
    EXPECT_TRUE(project);
    EXPECT_TRUE(bring_up_to(*project, Step::kOrient));
    block = *project->store.read_block();
    for (const auto& [id, point] : block.control)
      if (point.role == ControlRole::kCheck) points.push_back(id);
  }
  [[nodiscard]] const std::string& name(std::size_t i) const { return block.control.at(points[i]).name; }
  // The table of the marks of these points, and further lines.
  [[nodiscard]] std::filesystem::path table(const std::string& more = "") const {
    std::string text = "image point x[px] y[px] sigma[px]\n";
    for (const ControlObservation& seen : block.control_observations)
      if (block.control.at(seen.point).role == ControlRole::kCheck)
        text += fmt::format("{} {} {:.4f} {:.4f} {}\n", block.images.at(seen.image).file,
                            block.control.at(seen.point).name, seen.pixel.x(), seen.pixel.y(), seen.sigma_px);
    EXPECT_TRUE(write_file(folder / "marks.txt", text + more));
    return folder / "marks.txt";
  }
  [[nodiscard]] Result<MeasuredReport> measured(const std::string& figures, const std::string& more = "") const {
    return measure_points(folder / "block", table(more), {.figures = figures}, {});
  }
};

// Check points took no part in the block: their differences are as large as both standard deviations say; four of
// these for fifteen coordinates.
TEST(MeasurePoints, PointsLieWhereTheyWereSurveyed) {
  const Surveyed survey;
  ASSERT_EQ(survey.points.size(), 5u);
  const auto report = survey.measured(fmt::format("distance {0} {1}; height_difference {0} {1}; plan_area {0} {1} {2}",
                                                  survey.name(0), survey.name(1), survey.name(2)));
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->points.size(), 5u);
  EXPECT_FALSE(report->crs.empty());
  std::map<std::string, ControlPoint> surveyed;
  for (const ControlId id : survey.points) surveyed[survey.block.control.at(id).name] = survey.block.control.at(id);
  for (const MeasuredReport::Point& point : report->points) {
    ASSERT_TRUE(point.position) << point.name;
    const ControlPoint& known = surveyed.at(point.name);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = std::hypot(std::sqrt(point.covariance(axis, axis)), known.sigma_m[axis]);
      EXPECT_LT(std::abs((*point.position)[axis] - known.position_in_map[axis]), 4 * sigma) << point.name;
      EXPECT_LT(sigma, 0.2);
    }
    for (const MeasuredReport::Mark& mark : point.marks) {
      EXPECT_TRUE(mark.is_oriented);
      EXPECT_LT(mark.test.w.cwiseAbs().maxCoeff(), 4.5);
    }
  }
  ASSERT_EQ(report->figures.size(), 3u);
  const ControlPoint &a = surveyed.at(survey.name(0)), &b = surveyed.at(survey.name(1));
  const double distance = (a.position_in_world - b.position_in_world).norm();
  const MeasuredFigure &length = *report->figures[0].measured, &rise = *report->figures[1].measured;
  EXPECT_NEAR(length.value, distance, 4 * std::hypot(length.sigma, a.sigma_m.x(), b.sigma_m.x()));
  EXPECT_NEAR(rise.value, b.position_in_map.z() - a.position_in_map.z(),
              4 * std::hypot(rise.sigma, a.sigma_m.z(), b.sigma_m.z()));
  const std::string text = measured_text(*report);
  EXPECT_NE(text.find("5 of 5 points determined"), std::string::npos) << text;
  EXPECT_NE(text.find("plan_area"), std::string::npos);
  EXPECT_EQ(measured_tables(*report).size(), 3u);
}

TEST(MeasurePoints, WhatCannotBeMeasuredIsNamed) {
  const Surveyed survey;
  const std::string image = survey.block.images.begin()->second.file;
  const auto code = [](const auto& result) { return result ? "" : result.error().message; };
  EXPECT_NE(code(survey.measured("", "nowhere.jpg A 1 2 1\n")).find("no image \"nowhere.jpg\""), std::string::npos);
  EXPECT_NE(code(survey.measured("circle A B")).find("no figure is called \"circle\""), std::string::npos);
  EXPECT_NE(code(survey.measured("distance A B")).find("no point \"A\""), std::string::npos);
  EXPECT_NE(code(survey.measured("distance " + survey.name(0))).find("is of 2 points"), std::string::npos);
  EXPECT_NE(code(survey.measured("", image + " A 1 2 0\n")).find("sigma is not above 0"), std::string::npos);
  const auto lone = survey.measured("distance A " + survey.name(0), image + " A 100 200 1\n");
  ASSERT_TRUE(lone);
  EXPECT_FALSE(lone->points.back().position);
  EXPECT_EQ(lone->figures[0].undetermined, "A");
  EXPECT_NE(measured_text(*lone).find("its marks do not determine it"), std::string::npos);
}

// A mark that is off by 20 px is named, with the test that finds it.
TEST(MeasurePoints, AMarkThatContradictsTheOthersIsNamed) {
  Surveyed survey;
  for (ControlObservation& seen : survey.block.control_observations)
    if (seen.point == survey.points[0]) {
      seen.pixel.x() += 20;
      break;
    }
  const auto report = survey.measured("");
  ASSERT_TRUE(report);
  EXPECT_NE(measured_text(*report).find("contradicts the others"), std::string::npos) << measured_text(*report);
}

}  // namespace
}  // namespace collinea
