// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/project/project.h"

namespace collinea {

/// What an oriented block is written as.
enum class ExportFormat { kColmap, kBundler, kOpk, kPatb, kBingo, kTiePoints, kLas, kLaz, kCopc, kPly, kXyz };
inline constexpr Word<ExportFormat> kExportFormatWords[] = {
    {ExportFormat::kColmap, "colmap", "text and binary model"},
    {ExportFormat::kBundler, "bundler"},
    {ExportFormat::kOpk, "opk", "omega, phi, kappa"},
    {ExportFormat::kPatb, "patb", "image coordinates and control"},
    {ExportFormat::kBingo, "bingo", "the same, with cameras and orientations"},
    {ExportFormat::kTiePoints, "tie_points", "PLY"},
    {ExportFormat::kLas, "las", "dense cloud"},
    {ExportFormat::kLaz, "laz", "the same, compressed"},
    {ExportFormat::kCopc, "copc", "the same, in an octree"},
    {ExportFormat::kPly, "ply", "the same in the local frame"},
    {ExportFormat::kXyz, "xyz", "the same as text"},
};
[[nodiscard]] constexpr std::span<const Word<ExportFormat>> words(ExportFormat) { return kExportFormatWords; }

struct ExportOptions {
  ExportFormat format = ExportFormat::kColmap;
  std::optional<double> tile_m = {}, spacing_m = {};
  std::optional<std::filesystem::path> area = {};
  double pixel_um = 4;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ExportOptions;
    visit(Field{"format", &O::format, "", "what for"});
    visit(Field{"tile_m", &O::tile_m, "m",
                "of a cloud: cut it into squares of the map so large, a file each; nothing: one file", 1e-6, 1e9});
    visit(Field{"spacing_m", &O::spacing_m, "m", "of a cloud: one point in each cube so large; nothing: all points",
                1e-6, 1e6});
    visit(Field{"area", &O::area, "",
                "of a cloud: only what lies within this outline: a file with easting and northing of its corners"}
              .leads_to(PathKind::kFile));
    visit(Field{"pixel_um", &O::pixel_um, "um", "of patb and bingo: size of a pixel, which the images do not tell",
                0.01, 1000});
  }
};

/// Writes the oriented block for other programs: a COLMAP model in the local world frame; bundle.out and list.txt for
/// Bundler, likewise; omega, phi, kappa in the map; image coordinates and control for PATB
/// (block.im, block.con) or BINGO (image.dat, geoin.dat, itera.dat), freed from distortion; tie points; or the dense
/// cloud with the edits by hand that are in force, in the form asked for whatever the project's is: in the map (LAS,
/// LAZ, COPC, text) or in the local frame (PLY), with `area` what lies in it, with `spacing_m` the first point of each
/// cube (some 60 bytes of memory for each), with `tile_m` cut into squares of the map, one file each, listed in
/// tiles.csv. Errors: not oriented yet, options, disk.
[[nodiscard]] Result<> export_block(Project& project, const std::filesystem::path& folder,
                                    const ExportOptions& options);

}  // namespace collinea
