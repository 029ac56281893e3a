// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// The camera of a survey.
struct SurveyCamera {
  int width_px = 2048, height_px = 1536;
  std::optional<double> focal_px = {};
  CameraModel camera_model = Brown{};
  double k1 = -0.055, k2 = 0.028, k3 = -0.008, k4 = 0.0012, p1 = 0.0007, p2 = -0.0004;
  double principal_x_px = 6.5, principal_y_px = -9.2;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SurveyCamera;
    visit(Field{"width_px", &O::width_px, "px", "width of the images", 64, 20000});
    visit(Field{"height_px", &O::height_px, "px", "height of the images", 64, 20000});
    visit(Field{"focal_px", &O::focal_px, "px",
                "focal length; nothing: of the width 0.67 from the air, 0.78 before a wall", 10, 100000});
    visit(Field{"camera_model", &O::camera_model, "", "projection"});
    visit(Field{"k1", &O::k1, "1", "radial distortion", -0.5, 0.5});
    visit(Field{"k2", &O::k2, "1", "radial distortion", -0.5, 0.5});
    visit(Field{"k3", &O::k3, "1", "radial distortion", -0.5, 0.5});
    visit(Field{"k4", &O::k4, "1", "radial distortion, of kannala_brandt only", -0.5, 0.5});
    visit(Field{"p1", &O::p1, "1", "decentring distortion, not of kannala_brandt", -0.05, 0.05});
    visit(Field{"p2", &O::p2, "1", "decentring distortion, not of kannala_brandt", -0.05, 0.05});
    visit(Field{"principal_x_px", &O::principal_x_px, "px", "principal point, right of the middle", -500, 500});
    visit(Field{"principal_y_px", &O::principal_y_px, "px", "principal point, below the middle", -500, 500});
  }
};

/// What becomes of the light on its way into the file.
struct SurveyLight {
  double exposure_sigma = 0.1, vignetting = 0.25, noise_grey = 1.5, blur_px = 0.6;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SurveyLight;
    visit(Field{"exposure_sigma", &O::exposure_sigma, "1", "standard deviation of the exposure, relative", 0, 0.5});
    visit(Field{"vignetting", &O::vignetting, "1", "share of the light lost in the corners", 0, 0.9});
    visit(Field{"noise_grey", &O::noise_grey, "grey", "standard deviation of the image noise", 0, 50});
    visit(Field{"blur_px", &O::blur_px, "px", "standard deviation of the blur", 0, 5});
  }
};

/// The GNSS receiver of a survey.
struct SurveyReceiver {
  bool gps = true;
  double gps_sigma_plan_m = 1.5, gps_sigma_height_m = 2.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SurveyReceiver;
    visit(Field{"gps", &O::gps, "1", "write positions, of an aerial block attitudes too, into the photographs"});
    visit(Field{"gps_sigma_plan_m", &O::gps_sigma_plan_m, "m", "error of the written east and north", 0, 100});
    visit(Field{"gps_sigma_height_m", &O::gps_sigma_height_m, "m", "error of the written height", 0, 100});
  }
};

/// Where on Earth a made-up world lies.
struct SurveySite {
  std::string crs = "EPSG:32633";
  double latitude_deg = 48.2, longitude_deg = 15.63, ground_height_m = 310;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SurveySite;
    visit(Field{"crs", &O::crs, "1", "coordinate reference system of the map"});
    visit(Field{"latitude_deg", &O::latitude_deg, "deg", "origin of the world frame", -89, 89});
    visit(Field{"longitude_deg", &O::longitude_deg, "deg", "origin of the world frame", -180, 180});
    visit(Field{"ground_height_m", &O::ground_height_m, "m", "ellipsoidal height of the origin, on the ground", -500,
                9000});
  }
};

}  // namespace collinea
