// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/options.h"
#include "collinea/block/block.h"
#include "collinea/film/ideal_image.h"
#include "collinea/film/scan_orientation.h"
#include "collinea/geodesy/heights.h"

namespace collinea {

/// Projections that a lens can be stated to have.
inline constexpr std::array<CameraModel, 4> kLensModels = {Brown{}, Equidistant{}, Equisolid{}, KannalaBrandt{}};

struct ImportOptions {
  std::optional<std::string> crs;
  std::optional<HeightsFrom> heights, control_heights;
  HeightsFrom gps_heights = HeightSurface::kEllipsoid;
  std::optional<std::filesystem::path> control;
  std::string check;
  std::optional<std::filesystem::path> geodetic;
  std::optional<std::filesystem::path> positions;
  CameraModel camera_model = Brown{};
  std::optional<std::string> camera_params;
  FilmScanOptions film;
  std::optional<double> film_deformation_um = {}, film_correlation_mm = {};
  double gps_sigma_m = 2;
  double gps_sigma_height_m = 4;
  double control_sigma_m = 0.02;
  double control_sigma_px = 0.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ImportOptions;
    visit(Field{"crs", &O::crs, "",
                "projected CRS of the products, EPSG:code (default: that of the control, else the UTM zone)"});
    visit(Field{"heights", &O::heights, "",
                "what heights of the products count from: ellipsoidal | a vertical CRS, EPSG:code | a file with a "
                "geoid grid (default: what the CRS says, else ellipsoidal)"}
              .leads_to(PathKind::kFileOrWord));
    visit(Field{"control_heights", &O::control_heights, "",
                "the same of the control file, where it is another (default: what its CRS says, else that of heights)"}
              .leads_to(PathKind::kFileOrWord));
    visit(Field{"gps_heights", &O::gps_heights, "", "the same of the heights in the photographs"}.leads_to(
        PathKind::kFileOrWord));
    visit(Field{"control", &O::control, "",
                "file of control points, in a format of those that the manual of import lists"}
              .leads_to(PathKind::kFile));
    visit(Field{"check", &O::check, "", "names of control points that are only compared, separated by commas"});
    visit(Field{"geodetic", &O::geodetic, "",
                "file of measurements between control points: distances, height differences, total station; planes, "
                "lines and heights they lie on (CSV)"}
              .leads_to(PathKind::kFile));
    visit(Field{"positions", &O::positions, "",
                "file of positions and attitudes of the photographs, in place of those in their headers (CSV, or .mrk "
                "of an RTK drone)"}
              .leads_to(PathKind::kFile));
    visit(Field{"camera_model", &O::camera_model, "", "projection of the lens"}.one_of(kLensModels));
    visit(Field{"camera_params", &O::camera_params, "px",
                "known camera for all images, fixed: fx,fy,cx,cy[,k1,k2,k3,p1,p2], of kannala_brandt "
                "fx,fy,cx,cy[,k1,k2,k3,k4]; centre of the first pixel is 0.5"});
    visit(Part{&O::film});
    visit(Field{
        "film_deformation_um", &O::film_deformation_um, "um",
        "standard deviation of the local deformation of film, of each coordinate on each scan; 0: none; nothing: by "
        "the residuals of the marks of all scans, then by the adjustment",
        0, 500});
    visit(Field{"film_correlation_mm", &O::film_correlation_mm, "mm",
                "length of its correlation, exp(-d^2 / 2 l^2) at the distance d; nothing: estimated by the adjustment",
                1, 1000});
    visit(Field{"gps_sigma_m", &O::gps_sigma_m, "m",
                "standard deviation of image positions in plan where the file states none", 1e-3});
    visit(Field{"gps_sigma_height_m", &O::gps_sigma_height_m, "m", "the same for heights", 1e-3});
    visit(Field{"control_sigma_m", &O::control_sigma_m, "m",
                "standard deviation of control coordinates where the file states none", 1e-6});
    visit(Field{"control_sigma_px", &O::control_sigma_px, "px",
                "standard deviation of control measurements where the file states none", 1e-3});
  }
};

/// Relative standard deviation of a focal length from the header of an image: EXIF rounds to whole millimetres.
inline constexpr double kExifFocalSigma = 0.05;

/// Scans of film, their interior orientations and the ideal image that all are brought to.
struct ImportedFilm {
  IdealImage ideal;
  std::map<ImageId, ScanOrientation> scans;
};

struct Imported {
  Block block;
  std::optional<ImportedFilm> film = {};
  std::vector<std::string> file_hash;  ///< of each image's bytes, in the order of Block::images
  std::vector<Finding> skipped;        ///< files that did not become part of the block: the first subjects, and why
  std::vector<Finding> findings;       ///< assumed focal lengths, control in no image, ...
};

}  // namespace collinea
