// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/io/map_area.h"
#include "collinea/surface/internal/height_samples.h"

namespace collinea {

struct VolumeOptions {
  double sigma_m = 0.03;
  std::optional<double> correlation_m = {};
  double shift_sigma_m = 0;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = VolumeOptions;
    visit(Field{"sigma_m", &O::sigma_m, "m", "standard deviation of heights where no raster beside the surface says it",
                0, 1000});
    visit(Field{"correlation_m", &O::correlation_m, "m",
                "length over which errors of heights are alike; nothing: three cells", 0, 1e4});
    visit(
        Field{"shift_sigma_m", &O::shift_sigma_m, "m",
              "standard deviation of an error that all heights have in common: of the datum, of levels between epochs",
              0, 1000});
  }
};

/// What lies between a surface and its base.
struct Volume {
  double above_m3 = 0, below_m3 = 0;  ///< of the surface over and under the base, both positive
  double area_m2 = 0;                 ///< with heights of both
  double missing_m2 = 0;              ///< of the area without
  /// Standard deviations of above - below: by the errors of heights, by what these have in common (the orientation, and
  /// shift_sigma_m), and by the plane.
  double sigma_heights_m3 = 0, sigma_shift_m3 = 0, sigma_base_m3 = 0;
  /// The plane: height = c0 + c1 (east - middle) + c2 (north - middle).
  std::optional<Eigen::Vector3d> plane;
  Eigen::Vector2d middle{0, 0};
  double rim_rms_m = 0;  ///< of the surface along the border from the plane

  [[nodiscard]] double net_m3() const { return above_m3 - below_m3; }
  [[nodiscard]] double sigma_m3() const;
};

/// Over a level base. `area`: nothing: wherever there are heights. Cells on the border count by the part inside.
/// Errors: files, a raster too large (100 million cells), an area beside it.
[[nodiscard]] Result<Volume> volume_over_level(const SurfaceFiles& surface, double base_m,
                                               const std::optional<MapArea>& area, const VolumeOptions& options,
                                               const Run& run);
/// Over the plane that fits the surface best along the border of the area: what a heap stands on. Also an error: fewer
/// than four cells along the border. The plane shares what the heights have in common, shift_sigma_m too: it goes out.
[[nodiscard]] Result<Volume> volume_over_rim(const SurfaceFiles& surface, const MapArea& area,
                                             const VolumeOptions& options, const Run& run);
/// A surface and the terrain under it are of one orientation when they have the same part in common within this share
/// of its variance.
constexpr double kSameOrientation = 0.01;
/// Over another surface, read between its cells. Errors of the two are independent but for the shift. Only of the
/// surface and the terrain of one survey it goes out, with all that they have in common: two files of one folder whose
/// names differ in nothing but dsm and dtm, and of one orientation (kSameOrientation).
[[nodiscard]] Result<Volume> volume_over_surface(const SurfaceFiles& surface, const SurfaceFiles& base,
                                                 const std::optional<MapArea>& area, const VolumeOptions& options,
                                                 const Run& run);

}  // namespace collinea
