// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/point_buckets.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <system_error>

namespace collinea {
namespace {

constexpr std::size_t kReadAtOnce = 65536;   // points
constexpr double kMoreThanExpected = 1.125;  // points do not lie evenly in their squares

bool within(const GridPoint& p, const CellWindow& window) {
  return p.column >= double(window.column) && p.row >= double(window.row) &&
         p.column < double(window.column + window.width) && p.row < double(window.row + window.height);
}

}  // namespace

PointBuckets::PointBuckets(std::filesystem::path scratch, int cells, std::size_t memory_bytes)
    : scratch_(std::move(scratch)), cells_(cells), memory_bytes_(memory_bytes) {}

PointBuckets::~PointBuckets() {
  std::error_code ignored;
  for (const auto& [square, bucket] : buckets_)
    if (!bucket.in_file.empty()) std::filesystem::remove(file_of(square), ignored);
}

std::filesystem::path PointBuckets::file_of(const Square& square) const {
  return scratch_ / ("points_" + std::to_string(square.column) + "_" + std::to_string(square.row) + ".bin");
}

Result<> PointBuckets::add(std::span<const GridPoint> points) {
  Square last{};
  Bucket* bucket = nullptr;
  for (const GridPoint& p : points) {
    const Square square{floor_div(std::int64_t(std::floor(p.column)), cells_),
                        floor_div(std::int64_t(std::floor(p.row)), cells_)};
    if (!bucket || square != last) {
      bucket = &buckets_[square];
      last = square;
    }
    ++bucket->count;
    const std::size_t room = bucket->in_memory.capacity();
    bucket->in_memory.push_back(p);
    kept_ += bucket->in_memory.capacity() - room;
  }
  return bytes_in_memory() > memory_bytes_ ? spill() : Result<>{};
}

// Rows outside the bucket belong to its first or last band.
int PointBuckets::band_of(const Square& square, double row) const {
  const double within = std::floor(row) - double(square.row * cells_);
  return int(std::clamp(within * kBands / cells_, 0.0, double(kBands - 1)));
}

PointBuckets::Piece PointBuckets::sort_into_bands(const Square& square, std::vector<GridPoint>& points) const {
  Piece piece;
  for (const GridPoint& p : points) ++piece.begin[std::size_t(band_of(square, p.row)) + 1];
  for (std::size_t band = 0; band < kBands; ++band) piece.begin[band + 1] += piece.begin[band];
  std::vector<GridPoint> sorted(points.size());
  std::array<std::uint32_t, kBands + 1> next = piece.begin;
  for (const GridPoint& p : points) sorted[next[std::size_t(band_of(square, p.row))]++] = p;
  points.swap(sorted);
  return piece;
}

Result<> PointBuckets::spill() {
  COLLINEA_TRY(scratch_.make());
  for (auto& [square, bucket] : buckets_) {
    if (bucket.in_memory.empty()) continue;
    std::ofstream file(file_of(square), bucket.in_file.empty() ? std::ios::binary : std::ios::binary | std::ios::app);
    Piece piece = sort_into_bands(square, bucket.in_memory);
    if (!bucket.in_file.empty()) piece.first = bucket.in_file.back().first + bucket.in_file.back().begin.back();
    bucket.in_file.push_back(piece);  // a file that breaks off is removed, too
    file.write(reinterpret_cast<const char*>(bucket.in_memory.data()),
               std::streamsize(bucket.in_memory.size() * sizeof(GridPoint)));
    if (!file.flush()) return cannot_write(file_of(square));
    std::vector<GridPoint>().swap(bucket.in_memory);  // "= {}" would keep the memory
  }
  kept_ = 0;
  return {};
}

Result<> PointBuckets::finish() {
  const bool any =
      std::any_of(buckets_.begin(), buckets_.end(), [](const auto& b) { return !b.second.in_file.empty(); });
  return any ? spill() : Result<>{};
}

void PointBuckets::drop(const Square& square) {
  const auto found = buckets_.find(square);
  if (found == buckets_.end()) return;
  std::error_code ignored;
  if (!found->second.in_file.empty()) std::filesystem::remove(file_of(square), ignored);
  kept_ -= found->second.in_memory.capacity();
  buckets_.erase(found);
}

double PointBuckets::expected_points(const Square& square, const Bucket& bucket, const CellWindow& window) const {
  const auto part = [&](std::int64_t of_bucket, std::int64_t first, int size) {
    const std::int64_t begin = std::max(of_bucket * cells_, first),
                       end = std::min((of_bucket + 1) * cells_, first + std::int64_t(size));
    return double(end - begin) / cells_;
  };
  return double(bucket.count) * part(square.column, window.column, window.width) *
         part(square.row, window.row, window.height);
}

Result<> PointBuckets::read_bucket(const Square& square, const Bucket& bucket, const CellWindow& window,
                                   std::vector<GridPoint>& to) const {
  const auto keep = [&](std::span<const GridPoint> points) {
    std::copy_if(points.begin(), points.end(), std::back_inserter(to),
                 [&](const GridPoint& p) { return within(p, window); });
  };
  if (!bucket.in_file.empty()) {
    const auto from = std::size_t(band_of(square, double(window.row))),
               end = std::size_t(band_of(square, double(window.row + window.height - 1))) + 1;
    std::ifstream file(file_of(square), std::ios::binary);
    std::vector<GridPoint> points;
    for (const Piece& piece : bucket.in_file) {
      file.seekg(std::streamoff((piece.first + piece.begin[from]) * sizeof(GridPoint)));
      for (std::size_t left = piece.begin[end] - piece.begin[from]; left > 0; left -= points.size()) {
        points.resize(std::min(left, kReadAtOnce));
        if (!file.read(reinterpret_cast<char*>(points.data()), std::streamsize(points.size() * sizeof(GridPoint))))
          return fail(Errc::kBadFormat, "cannot read back " + file_of(square).string());
        keep(points);
      }
    }
  }
  keep(bucket.in_memory);
  return {};
}

Result<std::vector<GridPoint>> PointBuckets::points_in(const CellWindow& window) const {
  std::vector<const std::pair<const Square, Bucket>*> touched;
  const std::int64_t first_column = floor_div(window.column, cells_), first_row = floor_div(window.row, cells_);
  const std::int64_t last_column = floor_div(window.column + window.width - 1, cells_);
  const std::int64_t last_row = floor_div(window.row + window.height - 1, cells_);
  double expected = 0;
  for (std::int64_t row = first_row; row <= last_row; ++row) {
    for (std::int64_t column = first_column; column <= last_column; ++column) {
      const auto found = buckets_.find({column, row});
      if (found == buckets_.end()) continue;
      touched.push_back(&*found);
      expected += expected_points(found->first, found->second, window);
    }
  }
  std::vector<GridPoint> points;
  points.reserve(std::size_t(kMoreThanExpected * expected));  // growing would take three times as much for a moment
  for (const auto* bucket : touched) COLLINEA_TRY(read_bucket(bucket->first, bucket->second, window, points));
  return points;
}

}  // namespace collinea
