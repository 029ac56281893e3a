// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/project/project.h"

namespace collinea {

/// What an oriented block is written as.
enum class ExportFormat { kColmap, kBundler, kOpk, kPatb, kBingo, kPly, kLas, kLaz, kCopc };
inline constexpr Word<ExportFormat> kExportFormatWords[] = {
    {ExportFormat::kColmap, "colmap", "text and binary model"},
    {ExportFormat::kBundler, "bundler"},
    {ExportFormat::kOpk, "opk", "omega, phi, kappa"},
    {ExportFormat::kPatb, "patb", "image coordinates and control"},
    {ExportFormat::kBingo, "bingo", "the same, with cameras and orientations"},
    {ExportFormat::kPly, "ply", "tie points"},
    {ExportFormat::kLas, "las", "dense cloud"},
    {ExportFormat::kLaz, "laz", "the same, compressed"},
    {ExportFormat::kCopc, "copc", "the same, in an octree"},
};
[[nodiscard]] constexpr std::span<const Word<ExportFormat>> words(ExportFormat) { return kExportFormatWords; }

struct ExportOptions {
  ExportFormat format = ExportFormat::kColmap;
  std::optional<double> tile_m = {};
  double pixel_um = 4;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ExportOptions;
    visit(Field{"format", &O::format, "", "what for"});
    visit(Field{"tile_m", &O::tile_m, "m",
                "of a cloud: cut it into squares of the map so large, a file each; nothing: one file", 1e-6, 1e9});
    visit(Field{"pixel_um", &O::pixel_um, "um", "of patb and bingo: size of a pixel, which the images do not tell",
                0.01, 1000});
  }
};

/// Writes the oriented block for other programs: a COLMAP model in the local world frame; bundle.out and list.txt for
/// Bundler, likewise; omega, phi, kappa in the map; image coordinates and control for PATB
/// (block.im, block.con) or BINGO (image.dat, geoin.dat, itera.dat), freed from distortion; tie points; or the dense
/// cloud in the map with the edits by hand that are in force, in the form asked for whatever the project's is, with
/// `tile_m` cut into squares of the map, one file each, listed in tiles.csv. Errors: not oriented yet, options, disk.
[[nodiscard]] Result<> export_block(Project& project, const std::filesystem::path& folder,
                                    const ExportOptions& options);

}  // namespace collinea
