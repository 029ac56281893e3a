// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/synthetic/internal/country.h"
#include "collinea/synthetic/internal/survey_parts.h"
#include "collinea/synthetic/internal/truth.h"

namespace collinea {

/// An aerial block over made-up country.
struct SurveyOptions {
  std::optional<int> images = {};
  int strips = 3, images_per_strip = 6, images_per_cross_strip = 3;
  std::optional<int> cross_strips = {};
  std::optional<double> forward_overlap = {}, side_overlap = {};
  double gsd_m = 0.05;
  std::optional<double> height_m = {};
  SurveyCamera camera;
  double attitude_jitter_deg = 1.5, position_jitter_m = 0.8;
  SurveyLight light;
  double white_balance_sigma = 0;
  SurveyReceiver receiver;
  int control_points = 6, check_points = 12;
  double control_sigma_plan_m = 0.01, control_sigma_height_m = 0.015, measurement_sigma_px = 0.25;
  Country country = Country::kVillage;
  std::optional<double> relief_m = {}, building_area_m2 = {};
  SurveySite site;
  int seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SurveyOptions;
    visit(Field{"images", &O::images, "1", "number of images in all; nothing: what the strips give", 2, 100000});
    visit(Field{"strips", &O::strips, "1", "parallel strips", 1, 1000});
    visit(Field{"images_per_strip", &O::images_per_strip, "1", "images in each strip", 1, 1000});
    visit(Field{"cross_strips", &O::cross_strips, "1",
                "strips across the others, flown 15 % higher; nothing: 2, of film 0", 0, 1000});
    visit(Field{"images_per_cross_strip", &O::images_per_cross_strip, "1", "images in each cross strip", 1, 1000});
    visit(Field{"forward_overlap", &O::forward_overlap, "1", "overlap along a strip; nothing: 0.75, of film 0.6", 0.0,
                0.95});
    visit(Field{"side_overlap", &O::side_overlap, "1", "overlap of neighbouring strips; nothing: 0.65, of film 0.3",
                0.0, 0.95});
    visit(Field{"gsd_m", &O::gsd_m, "m", "size of a pixel on the ground; not used when height_m is given", 0.001, 10});
    visit(Field{"height_m", &O::height_m, "m", "flying height above ground; nothing: from gsd_m and the focal length",
                1, 10000});
    visit(Part{&O::camera});
    visit(Field{"attitude_jitter_deg", &O::attitude_jitter_deg, "deg", "standard deviation of the camera's tilts", 0,
                10});
    visit(Field{"position_jitter_m", &O::position_jitter_m, "m", "standard deviation from the planned station", 0, 50});
    visit(Part{&O::light});
    visit(Field{"white_balance_sigma", &O::white_balance_sigma, "1",
                "standard deviation of the exposure of red and of blue by itself, relative", 0, 0.5});
    visit(Part{&O::receiver});
    visit(Field{"control_points", &O::control_points, "1", "survey marks used as control", 0, 10000});
    visit(Field{"check_points", &O::check_points, "1", "survey marks kept for checking", 0, 10000});
    visit(Field{"control_sigma_plan_m", &O::control_sigma_plan_m, "m", "error of surveyed east and north", 0, 10});
    visit(Field{"control_sigma_height_m", &O::control_sigma_height_m, "m", "error of surveyed heights", 0, 10});
    visit(Field{"measurement_sigma_px", &O::measurement_sigma_px, "px", "error of measured image coordinates of marks",
                0, 10});
    visit(Field{"country", &O::country, "", "what is flown over"});
    visit(Field{"relief_m", &O::relief_m, "m",
                "range of terrain heights; nothing: 8 of the village, 12 of the town, 250 of the rocks", 0, 500});
    visit(Field{"building_area_m2", &O::building_area_m2, "m2",
                "land for one building; 0: no buildings; nothing: 1400 in the village, 600 in the town, 60000 in the "
                "rocks",
                0, 1e9});
    visit(Part{&O::site});
    visit(Field{"seed", &O::seed, "1", "all that is random follows from it", 0});
  }
};

/// The survey: scene, exact camera and poses, control. Errors: options out of range, unknown CRS, marks do not fit.
[[nodiscard]] Result<Truth> make_survey(const SurveyOptions& options, const Run& run = {});
/// The same, taken with another camera than that of the options, whose image goes on by `margin_px` beyond its sides.
[[nodiscard]] Result<Truth> make_survey(const SurveyOptions& options, const Camera& camera, double margin_px,
                                        const Run& run);

/// A walk in an arc before a façade, camera in hand and on a pole.
struct FacadeOptions {
  int stations = 12;
  double distance_m = 13, arc_deg = 76;
  double low_m = 1.7, high_m = 5.0;
  SurveyCamera camera;
  double attitude_jitter_deg = 2, position_jitter_m = 0.15;
  SurveyLight light;
  SurveyReceiver receiver{.gps = false, .gps_sigma_plan_m = 3, .gps_sigma_height_m = 5};
  int control_points = 5, check_points = 7;
  double control_sigma_m = 0.003, measurement_sigma_px = 0.25;
  SurveySite site;
  int seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FacadeOptions;
    visit(Field{"stations", &O::stations, "1", "stations along the arc; two images at each, low and high", 2, 1000});
    visit(Field{"distance_m", &O::distance_m, "m", "from the wall", 4, 25});
    visit(Field{"arc_deg", &O::arc_deg, "deg", "opening of the arc", 1, 140});
    visit(Field{"low_m", &O::low_m, "m", "camera height in hand", 0.3, 10});
    visit(Field{"high_m", &O::high_m, "m", "camera height on the pole", 0.3, 20});
    visit(Part{&O::camera});
    visit(
        Field{"attitude_jitter_deg", &O::attitude_jitter_deg, "deg", "standard deviation of the hand's tilts", 0, 10});
    visit(Field{"position_jitter_m", &O::position_jitter_m, "m", "standard deviation from the planned station", 0, 2});
    visit(Part{&O::light});
    visit(Part{&O::receiver});
    visit(Field{"control_points", &O::control_points, "1", "survey marks used as control", 0, 1000});
    visit(Field{"check_points", &O::check_points, "1", "survey marks kept for checking", 0, 1000});
    visit(Field{"control_sigma_m", &O::control_sigma_m, "m", "error of surveyed coordinates", 0, 1});
    visit(Field{"measurement_sigma_px", &O::measurement_sigma_px, "px", "error of measured image coordinates of marks",
                0, 10});
    visit(Part{&O::site});
    visit(Field{"seed", &O::seed, "1", "all that is random follows from it", 0});
  }
};

/// The façade and its images. Errors as for make_survey.
[[nodiscard]] Result<Truth> make_facade(const FacadeOptions& options, const Run& run = {});

}  // namespace collinea
