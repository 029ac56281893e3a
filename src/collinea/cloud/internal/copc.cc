// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/internal/copc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/base/packed.h"
#include "collinea/base/parallel.h"

namespace collinea {
namespace {

constexpr int kGridBits = 7;                   // the grid over a node has 128 cells along each axis
constexpr std::size_t kPiecePoints = 1 << 15;  // read at once from disk
constexpr std::size_t kMostParts = 64;         // that wait, each with an open file
constexpr int kPositionBits = 31;              // of a coordinate within the cube
constexpr int kLastLevel = 30;                 // keys are 32-bit numbers
constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

using Position = std::array<std::uint32_t, 3>;  // in 2^31 parts of the cube's side

std::int32_t coordinate(const char* record, std::size_t axis) {
  return Unpacker(std::string_view(record + 4 * axis, 4)).get<std::int32_t>();
}

CopcKey child_of(const CopcKey& key, std::size_t octant) {
  CopcKey child{key.level + 1, {}};
  for (std::size_t i = 0; i < 3; ++i) child.position[i] = 2 * key.position[i] + std::int32_t(octant >> i & 1);
  return child;
}

std::size_t octant_of(const Position& position, int level) {
  const int shift = kPositionBits - 1 - level;
  return (position[0] >> shift & 1) | (position[1] >> shift & 1) << 1 | (position[2] >> shift & 1) << 2;
}

}  // namespace

// --- what a node keeps -----------------------------------------------------------------------------------------------

// The point nearest to the middle of each cell of a node's grid, of those offered; the first of equally near ones.
class CopcStream::Sieve {
 public:
  void offer(const Position& position, int level, std::uint64_t index) {
    const auto [cell, rank] = cell_of(position, level, index);
    if (best_[cell] == kEmpty) touched_.push_back(cell);
    best_[cell] = std::min(best_[cell], rank);
  }
  [[nodiscard]] bool keeps(const Position& position, int level, std::uint64_t index) const {
    const auto [cell, rank] = cell_of(position, level, index);
    return best_[cell] == rank;
  }
  void clear() {
    for (const std::uint32_t cell : touched_) best_[cell] = kEmpty;
    touched_.clear();
  }

 private:
  struct Cell {
    std::uint32_t number;
    std::uint64_t rank;  // upper 24 bits: squared distance from the middle; then the index
  };
  static Cell cell_of(const Position& position, int level, std::uint64_t index) {
    constexpr int kDistanceBits = 11;
    const int below = kPositionBits - kGridBits - level;  // bits within a cell
    const int kept = std::min(below, kDistanceBits);
    std::uint32_t number = 0;
    std::uint64_t squared = 0;
    for (const std::uint32_t along : position) {
      number = number << kGridBits | (along >> below & ((1u << kGridBits) - 1));
      const auto inside = std::int64_t(along >> (below - kept) & ((1u << kept) - 1));
      const std::int64_t off = 2 * inside + 1 - (std::int64_t{1} << kept);
      squared += std::uint64_t(off * off);
    }
    return {number, squared << 40 | index};
  }

  std::vector<std::uint64_t> best_ = std::vector<std::uint64_t>(std::size_t{1} << (3 * kGridBits), kEmpty);
  std::vector<std::uint32_t> touched_;
};

// --- the tree --------------------------------------------------------------------------------------------------------

CopcStream::CopcStream(std::filesystem::path path, const LazLayout& layout, const Run& run, const CopcSizes& sizes,
                       RecordSpool all)
    : path_(std::move(path)),
      layout_(layout),
      run_(run),
      sizes_(sizes),
      all_(std::make_unique<RecordSpool>(std::move(all))) {
  lowest_.fill(std::numeric_limits<std::int32_t>::max());
  highest_.fill(std::numeric_limits<std::int32_t>::min());
}

Result<CopcStream> CopcStream::create(const std::filesystem::path& file, const LazLayout& layout, const Run& run,
                                      const CopcSizes& sizes) {
  COLLINEA_TRY(RecordSpool all, RecordSpool::create(file));
  return CopcStream(file, layout, run, sizes, std::move(all));
}

Result<> CopcStream::add(std::string_view records) {
  if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
  const std::size_t size = layout_.record_bytes();
  COLLINEA_CHECK(records.size() % size == 0);
  for (std::size_t at = 0; at < records.size(); at += size)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t along = coordinate(records.data() + at, i);
      lowest_[i] = std::min(lowest_[i], along);
      highest_[i] = std::max(highest_[i], along);
    }
  points_ += records.size() / size;
  all_->append(records);
  return {};
}

// The cube begins at the lowest corner of the cloud, half a unit of the coordinates before it, so that no point lies on
// a side and a flat cloud is not cut along its height at the first level.
void CopcStream::enclose(const Eigen::Vector3d& scale, const Eigen::Vector3d& offset) {
  if (points_ == 0) lowest_ = highest_ = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = Eigen::Index(i);
    side_ = std::max(side_, (double(highest_[i]) - double(lowest_[i]) + 1) * scale[axis]);
    corner_[axis] = offset[axis] + (double(lowest_[i]) - 0.5) * scale[axis];
  }
  parts_per_unit_ = std::ldexp(1.0, kPositionBits) / side_ * scale;
  while (side_ > std::ldexp(scale.minCoeff(), kGridBits + single_level_)) ++single_level_;
  single_level_ = std::min(single_level_, kPositionBits - kGridBits + 1);
}

std::array<std::uint32_t, 3> CopcStream::position_of(const char* record) const {
  Position position;
  for (std::size_t i = 0; i < 3; ++i) {
    const double units = double(coordinate(record, i)) - double(lowest_[i]) + 0.5;
    position[i] = std::uint32_t(units * parts_per_unit_[Eigen::Index(i)]);
  }
  return position;
}

bool CopcStream::divisible(const CopcKey& key, std::uint64_t points) const {
  return points > sizes_.leaf_points && key.level < kLastLevel;
}

// Points at a single position cannot be told apart by a grid: a node then takes the first ones that came.
template <class Sieved>
bool CopcStream::keeps(const CopcKey& key, std::uint64_t index, const Sieved& sieved) const {
  return key.level >= single_level_ ? index < sizes_.leaf_points : sieved();
}

CopcStream::Packed CopcStream::pack(const CopcKey& key, std::string_view records) const {
  return {key, records.size() / layout_.record_bytes(), compress_laz_chunk(records, layout_)};
}

// A branch of the tree in memory, parents before children.
std::vector<CopcStream::Packed> CopcStream::pack_branch(const CopcKey& key, std::string_view records) const {
  const std::size_t size = layout_.record_bytes();
  const auto record = [&](std::uint32_t i) { return records.substr(i * size, size); };
  std::vector<Position> positions(records.size() / size);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = position_of(records.data() + i * size);

  struct Open {
    CopcKey key;
    std::vector<std::uint32_t> points;
  };
  std::vector<Open> open(1);
  open[0].key = key;
  for (std::uint32_t i = 0; i < positions.size(); ++i) open[0].points.push_back(i);
  std::unique_ptr<Sieve> sieve;
  std::vector<Packed> packed;
  while (!open.empty()) {
    const Open node = std::move(open.back());
    open.pop_back();
    const int level = node.key.level;
    const bool divided = divisible(node.key, node.points.size());
    if (divided && !sieve) sieve = std::make_unique<Sieve>();
    if (divided && level < single_level_)
      for (std::size_t n = 0; n < node.points.size(); ++n) sieve->offer(positions[node.points[n]], level, n);
    std::string kept;
    std::array<std::vector<std::uint32_t>, 8> handed_down;
    for (std::size_t n = 0; n < node.points.size(); ++n) {
      const std::uint32_t i = node.points[n];
      if (!divided || keeps(node.key, n, [&] { return sieve->keeps(positions[i], level, n); }))
        kept += record(i);
      else
        handed_down[octant_of(positions[i], level)].push_back(i);
    }
    if (divided) sieve->clear();
    packed.push_back(pack(node.key, kept));
    for (std::size_t octant = 8; octant-- > 0;)
      if (!handed_down[octant].empty()) open.push_back({child_of(node.key, octant), std::move(handed_down[octant])});
  }
  return packed;
}

// Divides what is too large for memory from disk to disk, parents before children: the same tree as in memory.
Result<> CopcStream::divide(const CopcKey& key, std::unique_ptr<RecordSpool> records, Sieve& sieve, OutputFile& file) {
  const std::size_t size = layout_.record_bytes();
  const std::uint64_t points = records->size() / size;
  if (points <= sizes_.branch_points || !divisible(key, points)) {
    points_in_parts_ += points;
    parts_.push_back({key, {}, std::move(records)});
    const bool enough = parts_.size() >= kMostParts ||
                        points_in_parts_ >= 4 * sizes_.branch_points * std::uint64_t(std::max(1, run_.threads));
    return enough ? write_parts(file) : Result<>{};
  }
  const auto for_each = [&](const auto& work) -> Result<> {
    for (std::uint64_t from = 0; from < points; from += kPiecePoints) {
      if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
      const std::uint64_t count = std::min<std::uint64_t>(kPiecePoints, points - from);
      COLLINEA_TRY(const std::string piece, records->read(from * size, count * size));
      for (std::uint64_t i = 0; i < count; ++i) work(std::string_view(piece).substr(i * size, size), from + i);
    }
    return {};
  };
  const bool grid = key.level < single_level_;
  if (grid) {
    auto offered = for_each([&](std::string_view record, std::uint64_t index) {
      sieve.offer(position_of(record.data()), key.level, index);
    });
    if (!offered) return offered;
  }
  std::array<std::unique_ptr<RecordSpool>, 8> children;
  for (auto& child : children) {
    COLLINEA_TRY(RecordSpool spool, RecordSpool::create(path_));
    child = std::make_unique<RecordSpool>(std::move(spool));
  }
  std::string kept;
  auto handed_down = for_each([&](std::string_view record, std::uint64_t index) {
    const Position position = position_of(record.data());
    if (keeps(key, index, [&] { return sieve.keeps(position, key.level, index); }))
      kept += record;
    else
      children[octant_of(position, key.level)]->append(record);
  });
  if (!handed_down) return handed_down;
  if (grid) sieve.clear();
  records.reset();
  points_in_parts_ += kept.size() / size;
  parts_.push_back({key, std::move(kept), nullptr});
  for (std::size_t octant = 0; octant < 8; ++octant) {
    if (children[octant]->size() == 0) continue;
    COLLINEA_TRY(divide(child_of(key, octant), std::move(children[octant]), sieve, file));
  }
  return {};
}

// The parts side by side, then into the file in their order.
Result<> CopcStream::write_parts(OutputFile& file) {
  std::vector<Result<std::vector<Packed>>> packed(parts_.size());
  parallel_for(run_, parts_.size(), [&](std::size_t i) {
    Part& part = parts_[i];
    packed[i] = [&]() -> Result<std::vector<Packed>> {
      if (!part.branch) return std::vector<Packed>{pack(part.key, part.records)};
      COLLINEA_TRY(const std::string records, part.branch->read(0, part.branch->size()));
      return pack_branch(part.key, records);
    }();
    part.branch.reset();
  });
  if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
  for (const auto& branch : packed) {
    if (!branch) return tl::unexpected(branch.error());
    for (const Packed& node : *branch) {
      nodes_.push_back({node.key, {file.size(), node.bytes.size(), node.points}});
      file.write(node.bytes);
    }
  }
  points_written_ += points_in_parts_;
  run_.report("cloud: octree", double(points_written_) / double(std::max<std::uint64_t>(1, points_)));
  parts_.clear();
  points_in_parts_ = 0;
  return {};
}

Result<> CopcStream::finish(OutputFile& file, const Eigen::Vector3d& scale, const Eigen::Vector3d& offset) {
  enclose(scale, offset);
  const std::uint64_t begin = begin_laz_chunks(file);
  if (points_ > 0) {
    Sieve sieve;
    COLLINEA_TRY(divide({}, std::move(all_), sieve, file));
    COLLINEA_TRY(write_parts(file));
  }
  std::vector<LazChunk> chunks;
  for (const CopcNode& node : nodes_) chunks.push_back(node.chunk);
  write_laz_chunk_table(file, begin, chunks, LazChunks::kOfAnySize);
  return {};
}

std::string CopcStream::info(std::uint64_t hierarchy_at) const {
  Packer packer;
  for (int i = 0; i < 3; ++i) packer.put(corner_[i] + side_ / 2);
  packer.put(side_ / 2);
  packer.put(std::ldexp(side_, -kGridBits));
  packer.put(hierarchy_at);
  packer.put(std::uint64_t(hierarchy().size()));
  packer.put_text("", 2 * 8 + 11 * 8);  // times of the first and the last point: there are none; reserved
  return packer.bytes();
}

std::string CopcStream::hierarchy() const {
  Packer packer;
  const auto put = [&](const CopcNode& node) {
    packer.put(node.key.level);
    for (const std::int32_t along : node.key.position) packer.put(along);
    packer.put(node.chunk.at);
    packer.put(std::int32_t(node.chunk.bytes));
    packer.put(std::int32_t(node.chunk.points));
  };
  for (const CopcNode& node : nodes_) put(node);
  if (nodes_.empty()) put({});
  return packer.bytes();
}

}  // namespace collinea
