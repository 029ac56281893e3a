// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "collinea/synthetic/internal/truth.h"
#include "collinea/synthetic/survey.h"

namespace collinea {

/// Makes the survey and writes it to a folder as a customer would hand it over, with the truth beside it:
///   images/IMG_0001.jpg ...   images with EXIF and, for a drone, XMP
///   control.csv               surveyed marks and where they are seen, with realistic errors
///   truth/camera.csv          name, value: every Camera parameter, width_px, height_px
///   truth/poses.csv           file, x, y, z of the centre in the world [m], qw, qx, qy, qz of cam_from_world,
///                             easting, northing, height of the centre on the map [m]
///   truth/marks.csv           id, role, x, y, z in the world, easting, northing, height on the map [m]
///   truth/frame.csv           crs, latitude_deg, longitude_deg, height_m of the origin of the world frame
///   truth/dsm.tif             height of the highest surface at the centre of each cell [m]
///   truth/dtm.tif             height of the terrain under it [m]
///   truth/ortho.tif           its colour under the same light and tone as the images, without lens or exposure
/// World: local metric frame, z up. The rasters lie on the map's grid with cells of a GSD; a façade has none.
/// Images and rasters of an earlier simulation in this folder that the new one does not write are removed.
/// Errors: options, folder not writable, stopped.
[[nodiscard]] Result<> simulate(const SurveyOptions& options, const std::filesystem::path& folder, const Run& run);
[[nodiscard]] Result<> simulate(const FacadeOptions& options, const std::filesystem::path& folder, const Run& run);

/// The parts of it.
[[nodiscard]] Result<> write_images(const Truth& truth, const std::filesystem::path& images, const Run& run);
[[nodiscard]] Result<> write_tables(const Truth& truth, const std::filesystem::path& folder);
/// dsm.tif, dtm.tif and ortho.tif with cells of `cell_m`; nothing to do when the truth has no mapped area.
[[nodiscard]] Result<> write_products(const Truth& truth, const std::filesystem::path& folder, double cell_m,
                                      const Run& run);

struct TrueMark {
  ControlRole role = ControlRole::kControl;
  Eigen::Vector3d position_in_world, position_in_map;  ///< exact [m]
};

/// The truth as it was written, read back.
struct TruthFolder {
  Georeference georeference;
  Camera camera;
  std::map<std::string, Rigid3> cam_from_world;          ///< by file name of the image
  std::map<std::string, Eigen::Vector3d> centre_in_map;  ///< easting, northing, height [m]
  std::map<std::string, TrueMark> marks;                 ///< by name
  std::filesystem::path dsm, dtm, ortho;                 ///< empty when there is none
};

/// `path`: the folder given to simulate, or its truth/ itself. Errors: missing or broken files, with their line.
[[nodiscard]] Result<TruthFolder> read_truth(const std::filesystem::path& path);

}  // namespace collinea
