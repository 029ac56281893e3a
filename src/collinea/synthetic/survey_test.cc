// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/survey.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

// A small block with coarse pixels: the geometry of a large one at a fraction of its cost.
SurveyOptions small_survey() {
  SurveyOptions o;
  o.gsd_m = 0.2;
  o.camera.width_px = 512;
  o.camera.height_px = 384;
  return o;
}

const Truth& survey() {
  static const Truth truth = *make_survey(small_survey());
  return truth;
}
const Truth& facade() {
  static const Truth truth = *make_facade({.stations = 5, .camera = {.width_px = 512, .height_px = 384}});
  return truth;
}

TEST(Survey, HasTheImagesAskedFor) {
  EXPECT_EQ(survey().block.images.size(), 24u);
  for (int images : {2, 5, 12, 17, 40}) {
    SurveyOptions o = small_survey();
    o.images = images;
    o.control_points = o.check_points = 0;
    const auto truth = make_survey(o);
    ASSERT_TRUE(truth) << truth.error().message;
    EXPECT_EQ(int(truth->block.images.size()), images);
  }
}

TEST(Survey, TheSameOptionsGiveTheSameTruth) {
  collinea::Run two;
  two.threads = 2;
  const Truth again = *make_survey(small_survey(), two);
  for (const auto& [id, pose] : oriented_images(survey().block))
    EXPECT_EQ(pose.translation, pose_of(again.block, id).translation);
  for (const auto& [id, mark] : survey().marks_in_world) EXPECT_EQ(mark, again.marks_in_world.at(id));
  EXPECT_EQ(survey().scene.solids().size(), again.scene.solids().size());
}

TEST(Survey, NeighboursOverlapAsPlanned) {
  SurveyOptions o = small_survey();
  o.attitude_jitter_deg = o.position_jitter_m = 0;
  o.camera.k1 = o.camera.k2 = o.camera.k3 = o.camera.p1 = o.camera.p2 = 0;
  o.relief_m = 0;
  o.building_area_m2 = 0;
  const Truth truth = *make_survey(o);
  const auto position = [&](std::uint32_t i) { return centre_of(pose_of(truth.block, ImageId{i})); };
  EXPECT_NEAR((position(1) - position(0)).norm(), 0.25 * 384 * 0.2, 1e-9);
  EXPECT_NEAR(position(6).x() - position(0).x(), 0.35 * 512 * 0.2, 1e-9);
  EXPECT_NEAR(position(0).z(), 0.2 * 0.67 * 512, 1e-9);
}

// A ray and its projection are inverse to rounding: 1e-10 in the image plane (the promise of normalized) is 1e-7 px
// here; the cast adds 1e-9 m.
void expect_rays_come_back(const Truth& truth) {
  Random random(1);
  for (const auto& [id, pose] : oriented_images(truth.block))
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector2d pixel(random.uniform(0, 512), random.uniform(0, 384));
      const auto hit = shown_at(truth, id, pixel);
      if (!hit) continue;
      const auto back = seen_at(truth, id, hit->point);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - pixel).norm(), 1e-6);
    }
}
TEST(Survey, WhatAPixelShowsIsSeenAtThatPixel) { expect_rays_come_back(survey()); }
TEST(Facade, WhatAPixelShowsIsSeenAtThatPixel) { expect_rays_come_back(facade()); }

TEST(Survey, EveryPixelShowsGround) {
  for (const auto& [id, pose] : oriented_images(survey().block))
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {512, 0}, {0, 384}, {512, 384}})
      EXPECT_TRUE(shown_at(survey(), id, corner));
}

TEST(Survey, PointsBehindARoofAreNotSeen) {
  Random random(2);
  int hidden = 0;
  for (const auto& [id, pose] : oriented_images(survey().block))
    for (int i = 0; i < 200; ++i) {
      const auto hit = shown_at(survey(), id, {random.uniform(20, 490), random.uniform(20, 360)});
      ASSERT_TRUE(hit);
      if (hit->solid < 0) continue;
      const Eigen::Vector3d ray = (hit->point - centre_of(pose)).normalized();  // on through the house to the ground
      const Eigen::Vector3d on_ground =
          hit->point -
          ray * ((hit->point.z() - survey().scene.terrain_height(hit->point.x(), hit->point.y())) / ray.z());
      EXPECT_FALSE(seen_at(survey(), id, on_ground));
      ++hidden;
    }
  EXPECT_GT(hidden, 50);
}

void expect_marks_are_measured_where_they_are(const Truth& truth, double sigma_px) {
  double squares = 0;
  for (const ControlObservation& seen : truth.block.control_observations) {
    const Eigen::Vector3d& mark = truth.marks_in_world.at(seen.point);
    const auto pixel = seen_at(truth, seen.image, mark, 15);
    ASSERT_TRUE(pixel);
    EXPECT_LT((shown_at(truth, seen.image, *pixel)->point - mark).norm(), 1e-6);
    squares += (seen.pixel - *pixel).squaredNorm() / sigma_px / sigma_px;
  }
  // Chi-squared: mean 2 a point, standard deviation 2 / sqrt(n); four of them.
  const double n = double(truth.block.control_observations.size());
  EXPECT_NEAR(squares / n, 2, 8 / std::sqrt(n));
  EXPECT_GE(n, 3.0 * double(truth.marks_in_world.size()));
}
TEST(Survey, MarksAreMeasuredWhereTheyAreSeen) {
  EXPECT_EQ(survey().block.control.size(), 18u);
  expect_marks_are_measured_where_they_are(survey(), 0.25);
}
TEST(Facade, MarksAreMeasuredWhereTheyAreSeen) {
  EXPECT_EQ(facade().block.control.size(), 12u);
  expect_marks_are_measured_where_they_are(facade(), 0.25);
}

// 60 marks: the mean of a chi-squared with 3 degrees of freedom has the standard deviation sqrt(6/60); four of them.
TEST(Survey, SurveyedCoordinatesHaveTheirSigma) {
  SurveyOptions o = small_survey();
  o.control_points = 20;
  o.check_points = 40;
  const Truth truth = *make_survey(o);
  double sum = 0;
  for (const auto& [id, point] : truth.block.control) {
    const Eigen::Vector3d error = point.position_in_map - truth.frame.map_from_local(truth.marks_in_world.at(id));
    sum += error.cwiseQuotient(point.sigma_m).squaredNorm();
    EXPECT_LT((truth.frame.map_from_local(point.position_in_world) - point.position_in_map).norm(), 1e-6);
  }
  EXPECT_NEAR(sum / 60, 3, 4 * std::sqrt(6 / 60.0));
  EXPECT_EQ(truth.block.control.at(ControlId{19}).role, ControlRole::kControl);
  EXPECT_EQ(truth.block.control.at(ControlId{20}).role, ControlRole::kCheck);
}

TEST(Survey, ExactMeasurementsAreStatedWithASigmaThatCanBeUsed) {
  SurveyOptions o = small_survey();
  o.control_sigma_plan_m = o.control_sigma_height_m = o.measurement_sigma_px = 0;
  o.receiver.gps_sigma_plan_m = o.receiver.gps_sigma_height_m = 0;
  const Truth truth = *make_survey(o);
  ASSERT_FALSE(truth.block.control_observations.empty());
  for (const auto& [id, point] : truth.block.control) {
    EXPECT_LT((point.position_in_map - truth.frame.map_from_local(truth.marks_in_world.at(id))).norm(), 1e-9);
    EXPECT_GE(point.sigma_m.minCoeff(), 0.0001);
  }
  for (const auto& seen : truth.block.control_observations) EXPECT_GE(seen.sigma_px, 0.001);
  for (const auto& [id, image] : truth.block.images) {
    EXPECT_LT((image.position->position_in_world - centre_of(pose_of(truth.block, id))).norm(), 1e-9);
    EXPECT_GE(image.position->sigma_m.minCoeff(), 0.001);
  }
}

TEST(Survey, WrittenPositionsHaveTheirSigma) {
  SurveyOptions o = small_survey();
  o.images = 150;
  o.control_points = o.check_points = 0;
  o.building_area_m2 = 0;
  const Truth truth = *make_survey(o);
  double plan = 0, height = 0;
  for (const auto& [id, image] : truth.block.images) {
    const auto& prior = *image.position;
    const Eigen::Vector3d error =
        truth.frame.local_from_geographic({prior.latitude_deg, prior.longitude_deg, prior.height_m}) -
        centre_of(pose_of(truth.block, id));
    EXPECT_LT((error + centre_of(pose_of(truth.block, id)) - prior.position_in_world).norm(), 1e-6);
    plan += error.head<2>().squaredNorm() / (1.5 * 1.5);
    height += error.z() * error.z() / (2.5 * 2.5);
  }
  EXPECT_NEAR(plan / 150, 2, 4 * std::sqrt(4 / 150.0));
  EXPECT_NEAR(height / 150, 1, 4 * std::sqrt(2 / 150.0));
}

TEST(Survey, GimbalAnglesTellTheHeading) {
  for (const auto& [id, image] : survey().block.images) {
    const Eigen::Matrix3d rotation = pose_of(survey().block, id).rotation.toRotationMatrix();
    const double heading = image.attitude->heading_deg / 57.29577951308232;
    EXPECT_GT(-rotation.row(1).dot(Eigen::RowVector3d(std::sin(heading), std::cos(heading), 0)), std::cos(0.12));
    EXPECT_NEAR(image.attitude->pitch_deg, -90, 9);
    EXPECT_EQ(image.attitude->roll_deg, 0);
  }
}

TEST(Survey, ObservationsAreProjectionsPlusNoise) {
  const Block block =
      *observations_only(survey(), {.points_per_image = 60, .noise_px = 0.4, .found_share = 0.7, .seed = 3}, {});
  std::map<ImageId, int> count;
  std::map<PointId, int> rays;
  double squares = 0;
  for (const Observation& o : block.observations) {
    ++count[o.image];
    ++rays[o.point];
    const auto exact = seen_at(survey(), o.image, block.points.at(o.point).position_in_world);
    ASSERT_TRUE(exact);
    squares += (o.pixel - *exact).squaredNorm() / 0.16;
  }
  const double n = double(block.observations.size());
  EXPECT_NEAR(squares / n, 2, 8 / std::sqrt(n));
  EXPECT_EQ(count.size(), 24u);
  for (const auto& [image, observations] : count) EXPECT_GE(observations, 60);
  EXPECT_EQ(rays.size(), block.points.size());
  for (const auto& [point, number] : rays) EXPECT_GE(number, 2);
  EXPECT_TRUE(std::is_sorted(block.observations.begin(), block.observations.end(), [](const auto& a, const auto& b) {
    return std::pair(a.point, a.image) < std::pair(b.point, b.image);
  }));
}

TEST(Survey, ObservationsDoNotDependOnThreads) {
  collinea::Run two;
  two.threads = 2;
  const ObservationOptions options{.points_per_image = 30, .noise_px = 0.4, .seed = 3};
  const Block a = *observations_only(survey(), options, {}), b = *observations_only(survey(), options, two);
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) EXPECT_EQ(a.observations[i].pixel, b.observations[i].pixel);
}

TEST(Survey, NonsenseIsRefusedInWords) {
  SurveyOptions o = small_survey();
  o.forward_overlap = 2;
  EXPECT_FALSE(make_survey(o));
  o = small_survey();
  o.site.crs = "EPSG:4326";
  EXPECT_FALSE(make_survey(o));
  o = small_survey();
  o.camera.focal_px = 60;  // sees beyond the horizon
  EXPECT_FALSE(make_survey(o));
  o = small_survey();
  o.camera.camera_model = Equidistant{};
  o.camera.focal_px = 0.3 * o.camera.width_px;
  EXPECT_NE(make_survey(o).error().message.find("80 degrees"), std::string::npos);
}

}  // namespace
}  // namespace collinea
