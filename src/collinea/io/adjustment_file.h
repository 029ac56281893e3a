// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/block/instruments.h"

namespace collinea {

/// How it is to be adjusted, where the file says so: an option of the program and its value, as it is typed.
struct AdjustmentFileOption {
  std::string name, value;
  std::size_t line = 0;  ///< of the file; 0: of none
};

/// All that an adjustment starts from: measurements with their standard deviations, what is known of cameras, images
/// and points, and what is fixed. Images without a pose and tie points without coordinates are allowed: they are in
/// block.images and block.observations, but are not oriented and not in block.points.
struct AdjustmentFile {
  Block block;  ///< sigmas of control: 0: fixed, infinite = not given
  std::set<ImageId> fixed_images;
  std::set<CameraId> corrected_cameras;  ///< of BrownOfMeasured: their sigmas hold after the correction
  /// Sigma of each of Camera::params. 0: fixed; a standard deviation: observed; infinite: free.
  std::map<CameraId, std::array<double, Camera::kAllParams>> camera_sigmas;
  std::map<CameraId, Camera> given_cameras;  ///< what was observed of the cameras; block.cameras is where they start
  Instruments instruments;
  std::vector<AdjustmentFileOption> options;  ///< each at most once
};

/// Writes the text format of docs/manual/adjustment-file.md. Numbers read back as the same doubles, but for angles
/// (in degrees): those to 1e-15. Errors: a name with a line break or another control character than a tab.
[[nodiscard]] Result<> write_adjustment_file(const std::filesystem::path& path, const AdjustmentFile& file);
[[nodiscard]] std::string adjustment_file_text(const AdjustmentFile& file);

/// Reads that format, in UTF-8 or UTF-16 with a byte order mark. Ids are given in the order of the file; tie points
/// keep their numbers. Errors name the line, what is wrong in it and what is expected.
[[nodiscard]] Result<AdjustmentFile> parse_adjustment_file(std::string_view text);

/// Whether the text claims to be of that format.
[[nodiscard]] bool is_adjustment_file(std::string_view text);

}  // namespace collinea
