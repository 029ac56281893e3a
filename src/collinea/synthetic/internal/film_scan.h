// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/block/ray_bend.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/camera/film_transformation.h"
#include "collinea/math/random.h"
#include "collinea/raster/raster.h"
#include "collinea/synthetic/render.h"

namespace collinea {

/// What becomes of film until it is a file.
struct ScanWear {
  double film_difference_ppm = 250, film_shear_ppm = 80, film_local_um = 4;
  double scan_turn_deg = 0.3;
  double grain_grey = 5;
  int scratches = 6, dust = 40;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ScanWear;
    visit(Field{"film_difference_ppm", &O::film_difference_ppm, "ppm",
                "standard deviation of the film's shrinkage along each axis", 0, 5000});
    visit(Field{"film_shear_ppm", &O::film_shear_ppm, "ppm", "standard deviation of its shear", 0, 5000});
    visit(Field{"film_local_um", &O::film_local_um, "um",
                "standard deviation of local deformation, smooth over some centimetres, of each coordinate", 0, 200});
    visit(
        Field{"scan_turn_deg", &O::scan_turn_deg, "deg", "standard deviation of the film's turn on the scanner", 0, 2});
    visit(Field{"grain_grey", &O::grain_grey, "grey",
                "standard deviation of the grain in middle grey, of pixels of 15 um; it falls as they grow", 0, 50});
    visit(Field{"scratches", &O::scratches, "1", "scratches of a scan", 0, 1000});
    visit(Field{"dust", &O::dust, "1", "grains of dust on a scan", 0, 10000});
  }
};

/// The way from film to scan: an affinity on top of a smooth local deformation.
struct FilmScan {
  int width = 0, height = 0;  ///< [px]
  FilmTransformation affine;

  /// A wave of displacement.
  struct Wave {
    Eigen::Vector2d amplitude_mm, per_mm;
    double phase_rad = 0;
  };
  std::array<Wave, 4> waves{};

  [[nodiscard]] Eigen::Vector2d displacement_mm(const Eigen::Vector2d& film_mm) const;
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& film_mm) const;
  /// By fixed point, to 1e-9 mm.
  [[nodiscard]] Eigen::Vector2d film_of(const Eigen::Vector2d& pixel) const;
};

/// A scan of film of that calibration with chance wear.
[[nodiscard]] FilmScan worn_scan(const FilmCalibration& calibration, double pixel_mm, const ScanWear& wear,
                                 Random random);

/// Whether the film shows the scene there, not frame, marks or margin.
[[nodiscard]] bool shows_scene(const FilmCalibration& calibration, const Eigen::Vector2d& film_mm);
/// The light that the film lets through where it does not: marks, data strip, frame; beyond the film the scanner's.
[[nodiscard]] float frame_light(const FilmCalibration& calibration, const Eigen::Vector2d& film_mm, std::uint32_t seed);

/// Where the pixels of a scan look: straight rays to what the photograph shows bent. Position on the film and direction
/// are exact on a lattice of 16 px and linear between, good to 1e-3 px.
class FilmRays final : public PixelRays {
 public:
  /// `film_camera_mm`: of film_camera().
  FilmRays(const FilmCalibration& calibration, const FilmScan& scan, const Camera& film_camera_mm, const RayBend& bend,
           const Run& run);

  [[nodiscard]] Eigen::Vector3d direction(int column, int row, double dx, double dy) const override;
  [[nodiscard]] double focal_px() const override { return focal_px_; }
  [[nodiscard]] Eigen::Vector2d film_mm(double x, double y) const { return between(x, y).head<2>(); }

 private:
  [[nodiscard]] Eigen::Vector4d between(double x, double y) const;

  const FilmCalibration& calibration_;
  double focal_px_;
  int columns_;
  std::vector<Eigen::Vector4d> lattice_;  // film x, y [mm], direction X/Z, Y/Z
};

/// Standard deviation of the grain in pixels of that size: granularity times the root of the area is constant (Selwyn
/// 1935).
[[nodiscard]] double grain_of_pixel(const ScanWear& wear, double pixel_mm);

/// Grain, correlated over neighbours: of one row, standard deviation 1.
void grain_of_row(std::uint64_t seed, std::uint64_t item, int row, int width, std::vector<float>& out);

/// Draws scratches and dust.
void wear_out(GreyImage& scan, const ScanWear& wear, Random random);

}  // namespace collinea
