// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/plan/precision.h"
#include "collinea/plan/rules_of_thumb.h"
#include "collinea/plan/test_flight.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Run kSerial;

// A small site, so that a block is adjusted in a few milliseconds.
struct Survey {
  FlightPlan plan;
  std::vector<PlannedPoint> points;
  MeasurementOptions measurements;
};

Survey small_survey(const std::string& control = "corners_middle") {
  LayoutOptions layout;
  layout.control = control;
  Survey survey;
  survey.plan = plan_flight(small_flight(), {}).value();
  survey.points = lay_out(layout, survey.plan).value();
  survey.measurements = small_measurements();
  return survey;
}

Precision precision_of(const Survey& survey) {
  return predicted(planned_block(survey.plan, survey.points, survey.measurements).value(), kSerial).value();
}

TEST(FlightPlan, OverlapsAreThoseAskedForAndTheBorderIsReached) {
  FlightOptions flight;
  flight.east_m = 300;
  flight.north_m = 200;
  const FlightPlan plan = plan_flight(flight, {}).value();
  EXPECT_NEAR(plan.height_m, 0.02 * 12.29 / 17.3 * 5280, 1e-9);
  EXPECT_NEAR(plan.base_m, 0.2 * 3956 * 0.02, 1e-9);
  EXPECT_NEAR(plan.spacing_m, 0.3 * 5280 * 0.02, 1e-9);
  double west = 1e9, east = -1e9, south = 1e9, north = -1e9;
  for (std::size_t i = 0; i < plan.images.size(); ++i) {
    const Vector3d& at = plan.images[i].centre;
    EXPECT_NEAR(at.z(), plan.height_m, 1e-9);
    west = std::min(west, at.x()), east = std::max(east, at.x());
    south = std::min(south, at.y()), north = std::max(north, at.y());
    if (i > 0 && plan.images[i].strip == plan.images[i - 1].strip) {
      EXPECT_NEAR((at - plan.images[i - 1].centre).norm(), plan.base_m, 1e-9);
    }
  }
  // On the border or up to half a step beyond it; strips along the longer side.
  EXPECT_LE(west, 1e-6);
  EXPECT_GE(west, -plan.base_m / 2);
  EXPECT_GE(east, 300 - 1e-6);
  EXPECT_LE(east, 300 + plan.base_m / 2);
  EXPECT_LE(south, 1e-6);
  EXPECT_GE(south, -plan.spacing_m / 2);
  EXPECT_GE(north, 200 - 1e-6);
  EXPECT_LE(north, 200 + plan.spacing_m / 2);
}

TEST(FlightPlan, StripsOfATurnedSiteAreAsLongAsTheSite) {
  const double rotation = 0.4;
  MapArea area;
  for (const Vector2d& p : {Vector2d(0, 0), Vector2d(400, 0), Vector2d(400, 100), Vector2d(0, 100)})
    area.emplace_back(500000 + std::cos(rotation) * p.x() - std::sin(rotation) * p.y(),
                      5e6 + std::sin(rotation) * p.x() + std::cos(rotation) * p.y());
  FlightOptions rotated, straight;
  straight.east_m = 400;
  straight.north_m = 100;
  const FlightPlan a = plan_flight(rotated, area).value(), b = plan_flight(straight, {}).value();
  EXPECT_EQ(a.images.size(), b.images.size());
  EXPECT_EQ(a.strips, b.strips);
  EXPECT_NEAR(a.path_m, b.path_m, 1e-6);
  EXPECT_NEAR(size_m2(a.area), 40000, 1e-3);
}

TEST(FlightPlan, CrossStripsAreSquareToTheOthersAndHigher) {
  FlightOptions flight = small_flight();
  flight.cross_strips = 2;
  const FlightPlan plan = plan_flight(flight, {}).value();
  EXPECT_EQ(plan.cross_strips, 2);
  for (const PlannedImage& image : plan.images)
    if (image.cross) {
      EXPECT_NEAR(image.centre.z(), 1.15 * plan.height_m, 1e-9);
      EXPECT_NEAR(std::sin(image.heading_rad - plan.heading_rad) * std::sin(image.heading_rad - plan.heading_rad), 1,
                  1e-12);
    }
}

TEST(FlightPlan, WhatCannotBeFlownIsStated) {
  const auto error = [](auto change, const MapArea& area = {}) {
    FlightOptions flight = small_flight();
    change(flight);
    const auto plan = plan_flight(flight, area);
    return plan ? std::string() : plan.error().message;
  };
  EXPECT_NE(error([](FlightOptions& o) { o.east_m.reset(); }).find("corners"), std::string::npos);
  EXPECT_NE(error([](FlightOptions& o) { o.east_m = 1e5, o.north_m = 1e5; }).find("20000"), std::string::npos);
  EXPECT_NE(error([](FlightOptions& o) { o.tilt_deg = 60; }).find("tilt_deg"), std::string::npos);
  EXPECT_NE(error([](FlightOptions& o) { o.gsd_m = -1; }).find("gsd_m"), std::string::npos);
  EXPECT_NE(error([](FlightOptions& o) { o.east_m.reset(), o.north_m.reset(); }, {{0, 0}, {5, 5}, {9, 9}})
                .find("enclose nothing"),
            std::string::npos);
  EXPECT_NE(error([](FlightOptions&) {}, {{0, 0}, {50, 0}, {0, 50}}).find("not both"), std::string::npos);
}

TEST(FlightPlan, AreasAreReadWithTitleAndComments) {
  const MapArea area = parse_area("# a site\neasting, northing, note\n0,0,corner\n10, 0\n10, 10\n0, 0\n").value();
  ASSERT_EQ(area.size(), 3u);
  EXPECT_EQ(area[1], Vector2d(10, 0));
  EXPECT_EQ(parse_area("0 0\n5 0\n5 5\n0 5").value().size(), 4u);
  EXPECT_NE(parse_area("0, 0\n5, x\n").error().message.find("line 2"), std::string::npos);
  EXPECT_FALSE(parse_area("0, 0\n5, 5\n"));
  EXPECT_FALSE(parse_area(""));
}

TEST(ControlLayout, WordsGiveTheirPoints) {
  const FlightPlan plan = plan_flight(small_flight(), {}).value();
  LayoutOptions layout;
  const auto count = [&](const char* word) {
    layout.control = word;
    return lay_out(layout, plan).value().size();
  };
  EXPECT_EQ(count("none"), 0u);
  EXPECT_EQ(count("corners"), 4u);
  EXPECT_EQ(count("corners_middle"), 5u);
  layout.control_points = 6;
  EXPECT_EQ(count("grid"), 6u);
  const auto points = lay_out(layout, plan).value();
  for (const PlannedPoint& point : points) EXPECT_TRUE(is_inside(plan.area, point.position));
  layout.control = "everywhere";
  EXPECT_NE(lay_out(layout, plan).error().message.find("everywhere"), std::string::npos);
}

TEST(ControlLayout, CornersOfASlantedSiteLieInIt) {
  FlightOptions flight = small_flight();
  flight.east_m.reset(), flight.north_m.reset();
  const FlightPlan plan = plan_flight(flight, {{0, 0}, {120, 10}, {60, 90}}).value();
  LayoutOptions layout;
  layout.control = "corners";
  const auto points = lay_out(layout, plan).value();
  for (const PlannedPoint& point : points) EXPECT_TRUE(is_inside(plan.area, point.position));
}

// The sigmas are those that the adjustment of the block with its errors gives: the design hardly changes with these,
// most where poses and camera are weak.
TEST(Precision, IsThatOfAdjustingTheSimulatedBlock) {
  const Precision planned = precision_of(small_survey());
  PlannedBlock noisy = with_errors(planned.planned, 5);
  const Examined adjusted = examine(noisy.block, noisy.scope, noisy.options, kSerial).value();
  EXPECT_EQ(adjusted.redundancy, planned.adjusted.redundancy);
  EXPECT_NEAR(adjusted.sigma0, 1, 4 / std::sqrt(2.0 * double(adjusted.redundancy)));
  ASSERT_EQ(adjusted.control.size(), planned.adjusted.control.size());
  for (std::size_t i = 0; i < adjusted.control.size(); ++i) {
    const Vector3d now = adjusted.control[i].covariance_m2->diagonal().cwiseSqrt(),
                   then = planned.adjusted.control[i].covariance_m2->diagonal().cwiseSqrt();
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(now[axis] / then[axis], 1, 0.05);
  }
  for (const auto& [id, covariance] : adjusted.pose_covariance)
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(std::sqrt(covariance(k, k) / planned.adjusted.pose_covariance.at(id)(k, k)), 1, 0.1);
}

// One position, one image and the camera of every block: independent, so their chi-squared has the known spread.
TEST(Precision, CoversTheTrueErrorsOfManyBlocks) {
  Survey survey = small_survey("corners");
  survey.measurements.position_sigma_plan_m = 0.05;
  survey.measurements.position_shift_m = 0.1;
  const Precision planned = precision_of(survey);
  constexpr int kBlocks = 150;
  double points = 0, images = 0, cameras = 0;
  int camera_degrees = 0;
  for (int i = 0; i < kBlocks; ++i) {
    PlannedBlock noisy = with_errors(planned.planned, std::uint64_t(1000 + i));
    const Examined adjusted = examine(noisy.block, noisy.scope, noisy.options, kSerial).value();
    ASSERT_TRUE(adjusted.converged);
    const std::size_t which = planned.adjusted.control.size() - 1 - std::size_t(i) % planned.cells.size();
    const ControlDifference& difference = planned.adjusted.control[which];
    const Vector3d error = *adjusted.control[which].position_in_world -
                           planned.planned.block.control.at(difference.point).position_in_world;
    points += error.dot(difference.covariance_m2->ldlt().solve(error));

    auto image = planned.adjusted.pose_covariance.begin();
    std::advance(image, i % int(planned.adjusted.pose_covariance.size()));
    const Rigid3 &truth = pose_of(planned.planned.block, image->first),
                 &found = adjusted.cam_from_world.at(image->first);
    Eigen::Matrix<double, 6, 1> off;
    off.head<3>() = rotation_vector(truth.rotation.conjugate() * found.rotation);
    off.tail<3>() = centre_of(found) - centre_of(truth);
    images += off.dot(image->second.ldlt().solve(off));

    const MatrixPd& covariance = planned.adjusted.camera_covariance.begin()->second;
    const Camera &camera = adjusted.cameras.begin()->second,
                 &true_camera = planned.planned.block.cameras.begin()->second;
    std::vector<int> free;
    for (const int k : params_of(camera))
      if (covariance(k, k) > 0) free.push_back(k);
    camera_degrees = int(free.size());
    const Eigen::MatrixXd its = covariance(free, free);
    const Eigen::VectorXd scale = its.diagonal().cwiseSqrt().cwiseInverse();
    Eigen::VectorXd wrong(camera_degrees);
    for (int k = 0; k < camera_degrees; ++k) {
      const std::size_t p = std::size_t(free[std::size_t(k)]);
      wrong[k] = scale[k] * (camera.params[p] - true_camera.params[p]);
    }
    cameras += wrong.dot(Eigen::MatrixXd(scale.asDiagonal() * its * scale.asDiagonal()).ldlt().solve(wrong));
  }
  // The mean of n chi-squared over d degrees of freedom has the standard deviation sqrt(2 / n d) about 1.
  const auto bound = [](int degrees) { return 4 * std::sqrt(2.0 / (kBlocks * degrees)); };
  EXPECT_NEAR(points / (3 * kBlocks), 1, bound(3));
  EXPECT_NEAR(images / (6 * kBlocks), 1, bound(6));
  EXPECT_EQ(camera_degrees, 8);
  EXPECT_NEAR(cameras / (camera_degrees * kBlocks), 1, bound(camera_degrees));
}

// More information: the covariance of every position shrinks in every direction.
void expect_nowhere_worse(const Precision& more, const Precision& less) {
  ASSERT_EQ(more.cells.size(), less.cells.size());
  double gained = 0;
  for (std::size_t i = 0; i < more.cells.size(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> change(less.cells[i].covariance_m2 -
                                                                more.cells[i].covariance_m2);
    EXPECT_GT(change.eigenvalues()[0], -1e-9 * less.cells[i].covariance_m2.trace());
    gained += change.eigenvalues().sum();
  }
  EXPECT_GT(gained, 0);
}

TEST(Precision, AddingControlMakesNothingWorse) {
  Survey survey = small_survey("corners");
  const Precision four = precision_of(survey);
  survey.points.push_back({"more", ControlRole::kControl, {40, 25}, {0.01, 0.01, 0.015}});
  expect_nowhere_worse(precision_of(survey), four);
}

TEST(Precision, AddingPositionsOrKnowingTheCameraMakesNothingWorse) {
  Survey survey = small_survey("corners");
  const Precision plain = precision_of(survey);
  Survey rtk = survey;
  rtk.measurements.position_sigma_plan_m = 0.02;
  expect_nowhere_worse(precision_of(rtk), plain);
  Survey known = survey;
  known.measurements.calibration = Calibration::kNone;
  expect_nowhere_worse(precision_of(known), plain);
}

TEST(Precision, OneMoreCrossStripMakesTiePointsBetterAndChangesNoneOfThem) {
  FlightOptions flight = small_flight();
  const Survey survey = small_survey("corners");
  flight.cross_strips = 1;
  Survey crossed = survey;
  crossed.plan = plan_flight(flight, {}).value();
  const Precision less = precision_of(survey), more = precision_of(crossed);
  for (const auto& [id, point] : less.planned.block.points) {
    ASSERT_TRUE(more.planned.block.points.contains(id));
    EXPECT_EQ(more.planned.block.points.at(id).position_in_world, point.position_in_world);
  }
  expect_nowhere_worse(more, less);
}

TEST(Precision, OneMorePointGainsWhereItIsPlacedBest) {
  const Survey survey = small_survey("corners");
  const Precision now = precision_of(survey);
  const Vector3d sigma(0.01, 0.01, 0.015);
  const auto one = one_more_point(survey.plan, survey.points, sigma, survey.measurements, now, 1, kSerial).value();
  const auto best = one_more_point(survey.plan, survey.points, sigma, survey.measurements, now, 5, kSerial).value();
  ASSERT_TRUE(one && best && best->position);
  EXPECT_LT(one->area.rms_m.norm(), now.area.rms_m.norm());
  EXPECT_LE(best->area.rms_m.norm(), one->area.rms_m.norm());
  EXPECT_TRUE(is_inside(survey.plan.area, *best->position));
}

TEST(Precision, ABlockWithoutControlSaysThatItHasNoDatum) {
  const Precision free = precision_of(small_survey("none"));
  EXPECT_EQ(free.adjusted.rank_defect, 7);
  ASSERT_FALSE(free.adjusted.weaknesses.empty());
  EXPECT_EQ(free.adjusted.weaknesses[0].code, FindingCode::kNoDatum);
}

TEST(Precision, TheEngineAnswersInSigmasThatWereGiven) {
  const Precision precision = precision_of(small_survey());
  EXPECT_LT(precision.adjusted.sigma0, 1e-9);
  EXPECT_EQ(sigma_scale(precision.adjusted), 1);
  EXPECT_EQ(precision.area.empty, 0u);
  EXPECT_EQ(precision.area.cells, 24u);  // 90 x 60 m in cells of 15 m
  Survey fine = small_survey();
  fine.measurements.sigma_px /= 2;
  fine.measurements.control_sigma_px /= 2;
  for (PlannedPoint& point : fine.points) point.sigma_m /= 2;
  // Halved sigmas of all but the camera, whose first values hardly matter: half the standard deviations.
  EXPECT_NEAR(precision_of(fine).area.rms_m.z() / precision.area.rms_m.z(), 0.5, 0.02);
}

TEST(Precision, PositionsThatOnlyOneImageShowsAreCountedNotMadeUp) {
  FlightOptions flight = small_flight();
  flight.forward_overlap = flight.side_overlap = 0;
  Survey survey = small_survey("none");
  survey.plan = plan_flight(flight, {}).value();
  survey.measurements.position_sigma_plan_m = 0.02;
  survey.measurements.points_per_image = 200;
  const auto planned = planned_block(survey.plan, survey.points, survey.measurements);
  ASSERT_TRUE(planned);
  const auto precision = predicted(*planned, kSerial);
  if (precision) {
    EXPECT_GT(precision->area.empty, 0u);
  } else {
    EXPECT_EQ(precision.error().code, Errc::kIllPosed);
  }
}

TEST(PlannedBlock, ControlOutOfSightAndUnknownWordsAreErrors) {
  Survey survey = small_survey();
  survey.points.push_back({"far", ControlRole::kControl, {5000, 5000}, {0.01, 0.01, 0.01}});
  const auto far = planned_block(survey.plan, survey.points, survey.measurements);
  ASSERT_FALSE(far);
  EXPECT_NE(far.error().message.find("far"), std::string::npos);
  survey = small_survey();
  survey.measurements.map_cell_m = 0.05;
  EXPECT_FALSE(planned_block(survey.plan, survey.points, survey.measurements));
  survey.measurements = small_measurements();
  survey.measurements.position_sigma_height_m = 0.03;  // of positions that are not measured
  EXPECT_FALSE(planned_block(survey.plan, survey.points, survey.measurements));
  survey.measurements.position_sigma_plan_m = 0.02;
  EXPECT_TRUE(planned_block(survey.plan, survey.points, survey.measurements));
}

TEST(FlightPlan, AnAreaTakesNoCornerBesideIt) {
  FlightOptions flight = small_flight();
  flight.east_m = flight.north_m = std::nullopt;
  const MapArea area = {{0, 0}, {90, 0}, {90, 60}};
  EXPECT_TRUE(plan_flight(flight, area));
  flight.west_m = 500000;
  EXPECT_FALSE(plan_flight(flight, area));
}

TEST(Trials, ACameraWithoutUnknownsIsNotCompared) {
  Survey survey = small_survey();
  survey.measurements.calibration = Calibration::kNone;
  const auto trials = tried(precision_of(survey), 2, kSerial);
  ASSERT_TRUE(trials);
  EXPECT_EQ(trials->cameras, 0);
  EXPECT_GT(trials->poses, 0);
}

TEST(Customs, FourPointsInARowAreNotAtTheCorners) {
  const auto corners_occupied = [](const Survey& survey) {
    return customs(survey.plan, small_flight(), survey.points, precision_of(survey)).back().kept;
  };
  Survey survey = small_survey("corners");
  EXPECT_TRUE(corners_occupied(survey));
  for (std::size_t i = 0; i < 4; ++i) survey.points[i].position = {20.0 + 15 * double(i), 30};
  EXPECT_FALSE(corners_occupied(survey));
}

TEST(RulesOfThumb, AreThoseOfTheBook) {
  // An aerial camera at an image scale of 1 : 10000: 6 cm in plan, 0.06 per mille of 1500 m, contours 0.25 per mille.
  FlightOptions flight = small_flight();
  flight.focal_mm = 150;
  flight.sensor_width_mm = 230;
  flight.height_m = 1500;
  flight.east_m = 3000;
  flight.north_m = 2000;
  Survey survey = small_survey();
  survey.plan = plan_flight(flight, {}).value();
  survey.points = lay_out({}, survey.plan).value();
  survey.measurements.map_cell_m = 500;
  const auto rules = rules_of_thumb(survey.plan, flight, survey.measurements, precision_of(survey));
  const auto value = [&](PlanRule of) {
    const auto rule = std::find_if(rules.begin(), rules.end(), [&](const auto& r) { return r.rule == of; });
    return rule == rules.end() ? std::nan("") : rule->value_m;
  };
  EXPECT_NEAR(value(PlanRule::kSignalisedPlan), 0.06, 1e-9);
  EXPECT_NEAR(value(PlanRule::kSignalisedHeight), 0.09, 1e-9);
  EXPECT_NEAR(value(PlanRule::kLinesPlan), 0.45, 1e-9);
  EXPECT_NEAR(value(PlanRule::kContours), 0.375, 1e-9);
  EXPECT_NEAR(value(PlanRule::kManholePlan), std::hypot(0.06, 0.05), 1e-9);
}

// Images that see a position of the middle of a block, so many spacings beside the axis of the middle strip, flown in
// step or with every second strip half a base along; below an image, or between two, of that strip.
int images_that_see(double side_overlap, double spacings, bool in_step, bool is_below_image = true) {
  FlightOptions flight = small_flight();
  flight.forward_overlap = 0.6;
  flight.side_overlap = side_overlap;
  flight.east_m = 300;
  flight.north_m = 300;
  flight.heading_deg = 90;
  flight.relief_m = 0;
  FlightPlan plan = plan_flight(flight, {}).value();
  const int middle = plan.strips / 2;
  Vector2d at(1e9, 0);
  for (const PlannedImage& image : plan.images)
    if (image.strip == middle && std::abs(image.centre.x() - 150) < std::abs(at.x() - 150)) at = image.centre.head<2>();
  if (!in_step)
    for (PlannedImage& image : plan.images)
      if ((image.strip - middle) % 2 != 0) image.centre.x() += plan.base_m / 2;
  at.y() += spacings * plan.spacing_m;
  if (!is_below_image) at.x() += plan.base_m / 2;
  MeasurementOptions measurements = small_measurements();
  measurements.points_per_image = 8;
  const auto planned =
      planned_block(plan, {{"A", ControlRole::kControl, at, Vector3d::Constant(0.02)}}, measurements).value();
  return int(std::ranges::count_if(planned.block.control_observations,
                                   [](const ControlObservation& seen) { return seen.point == ControlId{0}; }));
}

// Mussio D.4 (4.3.4): 60 % along the strip. With 20 % across three images see a point in the middle of a strip, six one
// between strips, five where the strips are not in step. With 60 % across nine, or seven, see one in the middle, and as
// many one that lies at the extreme of a strip (0.35 of the frame from its axis, where three strips show it still;
// seven where it lies below an image of the next strip).
TEST(PlannedBlock, ObservabilityOfMussioD4) {
  EXPECT_EQ(images_that_see(0.2, 0, true), 3);
  EXPECT_EQ(images_that_see(0.2, 0.5, true), 6);
  EXPECT_EQ(images_that_see(0.2, 0.5, false), 5);
  EXPECT_EQ(images_that_see(0.6, 0, true), 9);
  EXPECT_EQ(images_that_see(0.6, 0, false), 7);
  const double extreme = 0.35 / 0.4;
  EXPECT_EQ(images_that_see(0.6, extreme, true), 9);
  EXPECT_EQ(images_that_see(0.6, extreme, false, false), 7);
}

// Karfis R.2, R.3: at c = 153.353 mm and 1 : 6800 the flying height is 1042.8 m and 60 % of 23 cm leave a base of
// 625.6 m (he goes on with 1029 and 582 m, 62.8 %); at 152.52 mm and 1 : 10000 1525 m and 920 m (829 m).
TEST(FlightPlan, HeightAndBaseOfKarfis) {
  const struct {
    double c_mm, scale, height_m, base_m, digit_m;
  } flights[] = {{153.353, 6800, 1042.8, 625.6, 0.1}, {152.52, 10000, 1525, 920, 1}};
  for (const auto& printed : flights) {
    FlightOptions flight;
    flight.focal_mm = printed.c_mm;
    flight.sensor_width_mm = 230;
    flight.width_px = flight.height_px = 11500;
    flight.gsd_m = 20e-6 * printed.scale;
    flight.forward_overlap = 0.6;
    flight.east_m = flight.north_m = 2000;
    const FlightPlan plan = plan_flight(flight, {}).value();
    EXPECT_NEAR(plan.height_m, printed.height_m, printed.digit_m / 2);
    EXPECT_NEAR(plan.base_m, printed.base_m, printed.digit_m / 2);
  }
}

// Bolognesi T11 and the sizes of pixels in his text: distance, and size of a pixel on the object. At 50 m the nadir
// flight has 11.95 mm (11 is printed, 46 m), the beams at 5 m 0.615 mm (0.55 is printed) and at 4.89 m 0.60.
TEST(FlightPlan, PixelSizesOfBolognesiT11) {
  const struct {
    double focal_mm, pixel_mm, gsd_mm, distance_m;
  } printed[] = {{2.742, 0.001566, 12.8, 22.4},  {2.742, 0.001566, 4.0, 7.0},    {2.742, 0.001566, 3.2, 5.6},
                 {2.742, 0.001566, 2.7, 4.7},    {18, 22.3 / 5184, 11.0, 46},    {18, 22.3 / 5184, 11.947, 50.0},
                 {35, 22.3 / 5184, 0.8603, 7.0}, {35, 22.3 / 5184, 0.601, 4.89}, {35, 22.3 / 5184, 0.6145, 5.0}};
  for (const auto& row : printed) {
    FlightOptions flight;
    flight.width_px = 4000;
    flight.height_px = 3000;
    flight.focal_mm = row.focal_mm;
    flight.sensor_width_mm = 4000 * row.pixel_mm;
    flight.gsd_m = 1e-3 * row.gsd_mm;
    flight.east_m = flight.north_m = 10;
    const double digit_m = row.distance_m == 46 ? 1 : row.distance_m == 4.89 ? 0.01 : 0.1;
    EXPECT_NEAR(plan_flight(flight, {}).value().height_m, row.distance_m, digit_m / 2) << row.gsd_mm;
  }
}

}  // namespace
}  // namespace collinea
