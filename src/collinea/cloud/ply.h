// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/base/result.h"
#include "collinea/cloud/internal/cloud_point.h"

namespace collinea {

/// What the clouds of the program say of themselves, for people: their frame.
inline constexpr FileText kLocalCloudComment = "collinea, local world frame: x east, y north, z up";
inline constexpr FileText kLeftCameraCloudComment = "collinea, frame of the left camera: x right, y down, z forward";
inline constexpr FileText kPairCloudComment = "collinea, world frame of the orientation";
inline constexpr FileText kTiePointsComment = "collinea tie points, local world frame, metres";

/// Writes points as binary little-endian PLY: x y z (double), nx ny nz (float), red green blue (uchar), sigma_m
/// (float), images, classification (uchar). Point by point; the file appears under its name only by finish().
class PlyWriter {
 public:
  /// `comment`: one line for people, such as the CRS.
  static Result<PlyWriter> create(const std::filesystem::path& path, const std::string& comment = "");
  void write(std::span<const CloudPoint> points);
  Result<> finish();

 private:
  PlyWriter(OutputFile file, std::string comment) : file_(std::move(file)), comment_(std::move(comment)) {}
  [[nodiscard]] std::string header() const;  // as long whatever the number of points

  OutputFile file_;
  std::string comment_;
  std::uint64_t points_ = 0;
};

/// The vertices of a PLY file, text or binary, by the names of PlyWriter; properties it does not know are passed over.
/// Errors: not PLY, damaged, truncated, lists before or among the vertices.
[[nodiscard]] Result<std::vector<CloudPoint>> read_ply(const std::filesystem::path& path);

/// The same, from bytes in memory.
[[nodiscard]] Result<std::vector<CloudPoint>> parse_ply(std::string_view bytes);

}  // namespace collinea
