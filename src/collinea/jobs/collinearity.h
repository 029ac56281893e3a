// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/geodesy/heights.h"
#include "collinea/geodesy/refraction_k.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/collinearity_report.h"

namespace collinea {

enum class RefractionBy : std::uint8_t { kNone, kCoefficient, kAtmosphere };
inline constexpr Word<RefractionBy> kRefractionByWords[] = {
    {RefractionBy::kNone, "none", "straight rays"},
    {RefractionBy::kCoefficient, "coefficient", "rays bent to arcs by the coefficient K"},
    {RefractionBy::kAtmosphere, "atmosphere", "the standard atmosphere"}};
[[nodiscard]] constexpr std::span<const Word<RefractionBy>> words(RefractionBy) { return kRefractionByWords; }

struct CollinearityOptions {
  std::optional<double> principal_distance_mm = {};
  HeightsFrom heights;
  RefractionBy refraction = RefractionBy::kNone;
  double refraction_coefficient = kUsualRefractionCoefficient;
  double sigma_height_m = 0;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = CollinearityOptions;
    visit(Field{"principal_distance_mm", &O::principal_distance_mm, "mm", "principal distance of the photographs", 1e-6,
                1e9});
    visit(Field{"heights", &O::heights, "",
                "what columns H count from: a vertical CRS such as EPSG:5773, or the file of a geoid grid (GTX, "
                "GeoTIFF); columns h are ellipsoidal"});
    visit(Field{"refraction", &O::refraction, "", "what bends the rays"});
    visit(Field{"refraction_coefficient", &O::refraction_coefficient, "1", "K, for refraction by it", -1, 1});
    visit(Field{"sigma_height_m", &O::sigma_height_m, "m",
                "standard deviation of the height of the camera over the ground, for that of refraction", 0, 1e5});
  }
};

/// Where geodetic points are seen (collinearity of geodesy/geodetic_collinearity.h; Mussio 1.3.6-1.3.7). Points: point
/// latitude longitude and h (ellipsoidal) or H with heights or a column N (undulation), sigma_plan, sigma_h. Images:
/// image, the same, omega phi kappa against east, north and up at the centre, sigma_omega ... Errors: files, columns,
/// no principal distance, heights that nothing brings to the ellipsoid.
[[nodiscard]] Result<CollinearityReport> collinearity_of_tables(const std::filesystem::path& points,
                                                                const std::filesystem::path& orientation,
                                                                const CollinearityOptions& options);

struct RefractionOptions {
  PhotoOptions photo;
  RefractionBy refraction = RefractionBy::kAtmosphere;
  double refraction_coefficient = kUsualRefractionCoefficient;
  std::optional<double> camera_height_m = {};
  double ground_height_m = 0;
  double sigma_height_m = 0;
  double sigma = 0;
  std::string attitude = "0,0,0";

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RefractionOptions;
    visit(Part{&O::photo});
    visit(Field{"refraction", &O::refraction, "", "by what coordinates are corrected"});
    visit(Field{"refraction_coefficient", &O::refraction_coefficient, "1", "K of the first formula", -1, 1});
    visit(Field{"camera_height_m", &O::camera_height_m, "m",
                "height of the projection centre above the sea, where the table has no column camera_height", -1e4,
                1e7});
    visit(Field{"ground_height_m", &O::ground_height_m, "m",
                "height of the ground above the sea, where the table has no column ground_height", -1e4, 1e7});
    visit(Field{"sigma_height_m", &O::sigma_height_m, "m",
                "standard deviation of the height of the camera over the ground", 0, 1e5});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of an image coordinate where the table states none, in its unit", 0, 1e6});
    visit(Field{"attitude", &O::attitude, "deg", "omega,phi,kappa of the image against the level"});
  }
};

/// Refraction of the image points of a table (point x y, sigma, camera_height, ground_height), by both formulas with
/// their standard deviations (Mussio 2.5.1-2.5.2), and corrected coordinates. Errors: file, columns, no principal
/// distance, no height of the camera.
[[nodiscard]] Result<RefractionReport> refraction_of_table(const std::filesystem::path& measurements,
                                                           const RefractionOptions& options);

}  // namespace collinea
