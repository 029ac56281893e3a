// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/dense/depth_map.h"
#include "collinea/dense/level_matching.h"
#include "collinea/dense/stereo.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/film/scan_marks.h"
#include "collinea/match/pair_points.h"
#include "collinea/raster/interpolation.h"
#include "collinea/report/pair_report.h"

namespace collinea {

/// How two images become a surface.
struct PairChainOptions {
  FilmScanOptions film;
  std::optional<std::filesystem::path> camera;
  std::optional<double> principal_distance_px;
  std::optional<std::string> principal_point_px;
  std::optional<Resolution> resolution;
  std::optional<std::string> area;
  Interpolation resampling = Interpolation::kBicubic;
  std::optional<double> base_m;
  std::optional<double> cell_m;
  std::optional<double> wanted_sigma_z_m;
  std::optional<std::filesystem::path> control;
  std::optional<std::filesystem::path> exterior;
  double control_sigma_px = 0.5;
  bool reject_control = false;
  double control_alpha = 0.001;
  bool refine = true;
  PairSurface surface = PairSurface::kLevels;
  std::optional<StereoCost> cost;
  PairPointOptions points;
  RelativeOptions relative;
  LevelOptions levels;

  [[nodiscard]] StereoOptions stereo() const {
    return {.cost = cost.value_or(film.calibration ? StereoCost::kRank : StereoCost::kCensus)};
  }

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PairChainOptions;
    visit(Part{&O::film});
    visit(Field{"camera", &O::camera, "",
                "camera with its lens, as cameras.txt of COLMAP (ID MODEL WIDTH HEIGHT PARAMS...); of two cameras the "
                "second is that of the right photograph"}
              .leads_to(PathKind::kFile));
    visit(Field{"principal_distance_px", &O::principal_distance_px, "px", "of both images, as large as their files", 1,
                1e7});
    visit(Field{"principal_point_px", &O::principal_point_px, "px", "column,row; nothing: the middle of the image"});
    visit(Field{"resolution", &O::resolution, "",
                "at which the images are worked on; nothing: the largest with at most 256 million pixels, of the dense "
                "surface 64"});
    visit(
        Field{"area", &O::area, "px",
              "column,row,column,row: a rectangle of the left image by two corners; the surface of it alone is found, "
              "at full resolution where no other is asked for"});
    visit(Field{"resampling", &O::resampling, "", "how the epipolar images are made"});
    visit(Field{"base_m", &O::base_m, "m", "distance of the projection centres, for the scale", 1e-6, 1e9});
    visit(Field{"cell_m", &O::cell_m, "m",
                "cell of surface model and orthophoto; nothing: the larger of the ground size of a pixel and the mean "
                "distance of points",
                1e-6});
    visit(Field{"wanted_sigma_z_m", &O::wanted_sigma_z_m, "m",
                "standard deviation of heights by matching that is wanted: reported when it is not reached", 1e-6,
                1e6});
    visit(Field{"control", &O::control, "",
                "text table: point X Y Z (- where not known), sigma_X sigma_Y sigma_Z [m], x_left y_left x_right "
                "y_right [px], role (control, or check: only compared), for the absolute orientation"}
              .leads_to(PathKind::kFile));
    visit(Field{"exterior", &O::exterior, "",
                "table of exterior orientations (image X Y Z omega phi kappa, with sigma_ and correlation_ columns "
                "where known) that the "
                "pair is taken to have, in place of control and base: as relative, resection, triplet and pair write"}
              .leads_to(PathKind::kFile));
    visit(Field{"control_sigma_px", &O::control_sigma_px, "px", "of the image coordinates of control", 1e-3, 100});
    visit(Field{"reject_control", &O::reject_control, "",
                "leave out control one by one as long as the largest test w of a coordinate is beyond its limit"});
    visit(Field{"control_alpha", &O::control_alpha, "1", "chance with which a test of control rejects what is right",
                1e-6, 0.5});
    visit(Field{"refine", &O::refine, "", "refine the points by least squares matching, and orient again"});
    visit(Field{"surface", &O::surface, "", "how the surface is found"});
    visit(Field{
        "cost", &O::cost, "",
        "of the dense surface: how unlike two pixels are; nothing: rank of film, whose grain its windows average, "
        "else census"});
    visit(Group{"points", &O::points});
    visit(Group{"relative orientation", &O::relative});
    visit(Group{"levels", &O::levels});
  }
};

}  // namespace collinea
