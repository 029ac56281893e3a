// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/surface/internal/gridding.h"
#include "collinea/surface/internal/scratch_folder.h"

namespace collinea {

/// Points sorted into squares of cells, held in memory up to a limit and beyond it in files of a scratch folder, which
/// are removed again at the end. Every point lies in exactly one bucket.
class PointBuckets {
 public:
  static constexpr int kBands = 4;  ///< of a bucket
  struct Square {
    std::int64_t column = 0, row = 0;  ///< of the bucket, in buckets
    friend auto operator<=>(const Square&, const Square&) = default;
  };
  /// Points that went to the file together, sorted by bands of rows so that windows need not read all of them.
  struct Piece {
    std::uint64_t first = 0;                        ///< in the file
    std::array<std::uint32_t, kBands + 1> begin{};  ///< of each band, from `first` on; one more at the end
  };
  struct Bucket {
    std::vector<GridPoint> in_memory;
    std::vector<Piece> in_file;
    std::uint64_t count = 0;
  };

  PointBuckets(std::filesystem::path scratch, int cells, std::size_t memory_bytes);
  ~PointBuckets();
  PointBuckets(const PointBuckets&) = delete;
  PointBuckets& operator=(const PointBuckets&) = delete;

  Result<> add(std::span<const GridPoint> points);
  /// Once all points are there: what is in memory goes to the files, too, when there are any.
  Result<> finish();
  [[nodiscard]] const std::map<Square, Bucket>& buckets() const { return buckets_; }
  void drop(const Square& square);
  /// Bytes of the points in memory, with those reserved for more.
  [[nodiscard]] std::size_t bytes_in_memory() const { return kept_ * sizeof(GridPoint); }

  /// All points within a window. May be called from several threads at once (not while points are added).
  [[nodiscard]] Result<std::vector<GridPoint>> points_in(const CellWindow& window) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(const Square& square) const;
  Result<> spill();
  [[nodiscard]] int band_of(const Square& square, double row) const;
  Piece sort_into_bands(const Square& square, std::vector<GridPoint>& points) const;
  [[nodiscard]] double expected_points(const Square& square, const Bucket& bucket, const CellWindow& window) const;
  Result<> read_bucket(const Square& square, const Bucket& bucket, const CellWindow& window,
                       std::vector<GridPoint>& to) const;

  ScratchFolder scratch_;
  int cells_;
  std::size_t memory_bytes_, kept_ = 0;  // the second: points there is room for
  std::map<Square, Bucket> buckets_;
};

}  // namespace collinea
