// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/result.h"
#include "collinea/cloud/internal/cloud_point.h"
#include "collinea/cloud/internal/copc.h"
#include "collinea/cloud/internal/laz.h"
#include "collinea/cloud/las_form.h"

namespace collinea {

/// What a LAS file says of itself.
struct LasHeader {
  int minor_version = 4;  ///< 1.<minor>
  int point_format = 7;
  std::uint64_t points = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Constant(0.001), offset = Eigen::Vector3d::Zero();
  Eigen::Vector3d lowest = Eigen::Vector3d::Zero(), highest = Eigen::Vector3d::Zero();  ///< bounds of the points
  std::string wkt;  ///< of the CRS; empty: none stated, or as GeoTIFF keys
  std::string software;
  std::vector<std::string> extra_names;  ///< of extra bytes
};

/// What its file is called by custom: `stem` with .las, .laz or .copc.laz.
[[nodiscard]] std::string las_file_name(std::string_view stem, LasForm form);

/// Writes a LAS 1.4 file (ASPRS 2019), point format 7, point by point: nothing but a small buffer is in memory. Sigma
/// and number of images are extra bytes "sigma_m" (float, kept to 0.4 %) and "images" (unsigned char). The file appears
/// under its name only by finish(). Normals are not written: LAS has no place for them. The records are the same in all
/// forms; COPC is sorted by finish() (see CopcStream for memory and disk).
class LasWriter {
 public:
  struct Options {
    /// Where the points lie, about (their bounds, or a superset): the offset becomes its middle; coordinates are kept
    /// to 0.1 mm below 100 km, to 1 mm below 1000 km, else coarser.
    Eigen::Vector3d lowest = Eigen::Vector3d::Zero(), highest = Eigen::Vector3d::Zero();
    std::string wkt;                ///< of the CRS, WKT1 as LAS asks for (LocalFrame::wkt1); empty: none
    bool extra_bytes = true;        ///< sigma_m and images
    std::optional<LasHeader> like;  ///< scale and offset as there, whatever the bounds: its points stay what they are
    LasForm form = LasForm::kLas;
    Run run = {};  ///< of compression: threads, stop
  };
  static Result<LasWriter> create(const std::filesystem::path& path, const Options& options);

  /// Errors: a point lies so far outside the stated bounds that its coordinates do not fit, or is not finite.
  Result<> write(std::span<const CloudPoint> points);
  Result<> finish();  ///< errors: the disk is full, ...
  [[nodiscard]] const LasHeader& header() const { return header_; }

 private:
  LasWriter(OutputFile file, const Options& options);
  [[nodiscard]] std::string header_bytes() const;

  Result<> write_records(std::string_view records);

  OutputFile file_;
  LasHeader header_;
  bool extra_bytes_;
  std::optional<LazStream> laz_;
  std::optional<CopcStream> copc_;
  std::uint64_t points_at_ = 0, long_records_at_ = 0;
  std::uint32_t records_ = 0, long_records_ = 0;
};

/// Reads LAS 1.0 to 1.4, point formats 0 to 3 and 6 to 8, piece by piece. Colours are taken as 16 bits; of the extra
/// bytes only sigma_m and images are looked at. Compressed files (LAZ) are read when they are of point formats 6 to 8
/// and hold one return for each pulse, as clouds of images do. Errors: not LAS, another compression, damaged,
/// truncated.
class LasReader {
 public:
  static Result<LasReader> open(const std::filesystem::path& path);
  [[nodiscard]] const LasHeader& header() const { return header_; }
  /// The next points, at most `count`; empty at the end.
  Result<std::vector<CloudPoint>> read(std::size_t count);

 private:
  LasReader() = default;
  Result<> read_header();
  Result<> read_records(std::uint64_t at, std::uint32_t count, bool extended);
  void note_extra_bytes(std::string_view descriptors);
  Result<std::string> bytes_at(std::uint64_t offset, std::uint64_t size);
  Result<> find_chunks();
  [[nodiscard]] LazLayout layout() const;
  Result<std::string> records(std::size_t count);  // from next_, at most
  [[nodiscard]] CloudPoint point_of(std::string_view record) const;

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string name_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t file_size_ = 0, points_at_ = 0, next_ = 0;
  std::size_t record_bytes_ = 0, base_bytes_ = 0;
  std::optional<std::size_t> sigma_at_, images_at_;  // within a record
  bool compressed_ = false;
  std::string laz_description_;
  std::vector<LazChunk> chunks_;  // compressed files only
  std::size_t next_chunk_ = 0;
  std::string expanded_;           // the records of the chunk before next_chunk_
  std::size_t expanded_from_ = 0;  // byte of it that is next
  LasHeader header_;
};

}  // namespace collinea
