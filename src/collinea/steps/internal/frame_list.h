// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// Where the products of planes lie: a folder each, of their names.
[[nodiscard]] inline std::filesystem::path frames_folder(const std::filesystem::path& project) {
  return project / "products" / "frames";
}

/// Letters, digits, - and _ of ASCII, at most 64: what a folder may be called anywhere.
[[nodiscard]] bool is_frame_name(std::string_view name);

/// The files of a record below the project folder: without one of them the step is not done.
[[nodiscard]] std::vector<std::string> frame_files(const FramesRecord& record);

/// Removes what the program made of planes; files of people that lie among them stay. Error: something cannot be
/// removed.
[[nodiscard]] Result<> remove_frames(const std::filesystem::path& project);

/// Writes products/frames/frames.txt: where each plane lies, with units; nothing where there is none. Error: disk.
[[nodiscard]] Result<> write_frame_list(const std::filesystem::path& project, const FramesRecord& record);

}  // namespace collinea
