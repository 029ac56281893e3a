// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/surface/profile.h"
#include "collinea/surface/volume.h"

namespace collinea {

/// Bases of a volume that follow from the surface itself.
enum class VolumeBase { kRim };
inline constexpr Word<VolumeBase> kVolumeBaseWords[] = {{VolumeBase::kRim, "rim"}};
[[nodiscard]] constexpr std::span<const Word<VolumeBase>> words(VolumeBase) { return kVolumeBaseWords; }

/// What a surface is measured against.
struct MeasureVolumeOptions {
  WordOr<VolumeBase, double, std::filesystem::path> base = VolumeBase::kRim;
  std::optional<std::filesystem::path> area, output;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MeasureVolumeOptions;
    visit(Field{"base", &O::base, "",
                "what the surface stands on: rim (the plane that fits it along the border of the area) | a height in "
                "metres | the file of another surface"}
              .leads_to(PathKind::kFileOrWord));
    visit(Field{"area", &O::area, "", "file with the corners of the area: easting, northing in each line"}.leads_to(
        PathKind::kFile));
    visit(Field{"output", &O::output, "", "JSON file for the figures"}.leads_to(PathKind::kOutput));
  }
};

struct MeasuredVolume {
  Volume volume;
  bool sigmas_assumed = false;  ///< no raster beside the surface states the standard deviations of its heights
};

/// The volume between a surface (GeoTIFF; its standard deviations in NAME_sigma beside it) and a base; written as JSON
/// where asked for. Errors: files, options, an area beside the surface.
[[nodiscard]] Result<MeasuredVolume> measure_volume(const std::filesystem::path& surface,
                                                    const MeasureVolumeOptions& asked, const VolumeOptions& options,
                                                    const Run& run);

struct ProfileOptions {
  std::string line;
  std::string others;
  std::optional<double> step_m = {};
  double sigma_m = 0.03;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ProfileOptions;
    visit(Field{"line", &O::line, "", "where: east,north,east,north,... or a file with a corner in each line"}.leads_to(
        PathKind::kFileOrWord));
    visit(Field{"others", &O::others, "", "more surfaces along the same line, separated by commas"});
    visit(Field{"step_m", &O::step_m, "m", "between heights; nothing: a cell of the first surface", 1e-4, 1e6});
    visit(Field{"sigma_m", &O::sigma_m, "m", "standard deviation of heights where no raster beside the surface says it",
                0, 1000});
  }
};

/// Heights of surfaces along a line: profile.csv and profile.html in the folder. Errors: files, a line that is none.
[[nodiscard]] Result<Profile> draw_profile(const std::filesystem::path& surface, const ProfileOptions& options,
                                           const std::filesystem::path& folder, const Run& run);

}  // namespace collinea
