// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace collinea::fuzz {

/// A reader of files from outside, as the fuzzer and the replay of its corpus call it.
struct Target {
  std::string name;  ///< also of its folder below fuzz/corpus
  /// Whether the reader took the bytes for a valid file. It may refuse them; it must come back, without an exception,
  /// within seconds and a gigabyte.
  bool (*accepts)(std::string_view bytes);
  std::vector<std::string> seeds;  ///< valid files to start from
};

// One family of readers a file; together they are all targets.
[[nodiscard]] std::vector<Target> table_targets();        ///< control, ground, positions, rows of numbers
[[nodiscard]] std::vector<Target> adjustment_targets();   ///< adjustment file, DBAT, PhotoModeler, PATB, BINGO
[[nodiscard]] std::vector<Target> orientation_targets();  ///< COLMAP, Bundler, omega-phi-kappa
[[nodiscard]] std::vector<Target> image_targets();        ///< JPEG, PNG, TIFF and their headers, float TIFF, GeoTIFF
[[nodiscard]] std::vector<Target> cloud_targets();        ///< LAS, LAZ, COPC, PLY
[[nodiscard]] std::vector<Target> project_targets();      ///< project.json, journal, edits, seamlines (GeoPackage)

[[nodiscard]] std::vector<Target> all_targets();

/// Puts the bytes into a file of that name in a folder of this process, which goes at its end.
std::filesystem::path file_of(std::string_view bytes, const std::string& name);
/// That folder.
[[nodiscard]] const std::filesystem::path& folder();
/// All bytes of a file; empty where there is none.
[[nodiscard]] std::string bytes_of(const std::filesystem::path& path);

/// A format of several files is one input: its files in their order behind kCut each, the first without.
inline constexpr std::string_view kCut = "\n@@@@\n";
[[nodiscard]] std::vector<std::string_view> parts_of(std::string_view bytes);

}  // namespace collinea::fuzz
