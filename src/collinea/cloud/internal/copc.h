// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/record_spool.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/cloud/internal/laz.h"

namespace collinea {

/// A node of the octree: at level l the cube of the cloud is cut into 2^l parts along each axis.
struct CopcKey {
  std::int32_t level = 0;
  std::array<std::int32_t, 3> position{};  ///< along x, y, z, from 0
};

struct CopcNode {
  CopcKey key;
  LazChunk chunk;
};

/// How large the nodes become, and the pieces worked on in memory; the latter does not change the file.
struct CopcSizes {
  std::uint64_t leaf_points = 100'000;    ///< that a node holds undivided
  std::uint64_t branch_points = 1 << 20;  ///< that are sorted in memory
};

/// Takes the records of a cloud and writes them as the nodes of a Cloud Optimised Point Cloud (COPC 1.0, Hobu 2021): a
/// LAZ file, one chunk for each node. A node that holds more than 100,000 points keeps, of every cell of a grid of
/// 128^3 over it, the point nearest to the cell's middle, and hands the others down: points are seen evenly at every
/// level, no point is there twice, nothing is lost. Within a node the points keep their order. docs/theory/laz.md.
///
/// The records lie in files without a name beside the product, up to twice the size of the cloud as LAS. In memory: for
/// each thread a million records and what is made of them, about 100 MB. The bytes written do not depend on
/// run.threads.
class CopcStream {
 public:
  static Result<CopcStream> create(const std::filesystem::path& file, const LazLayout& layout, const Run& run,
                                   const CopcSizes& sizes = {});

  Result<> add(std::string_view records);  ///< errors: run was stopped
  /// Chunks and chunk table, from where the points begin; coordinates are offset + scale times what the records hold.
  /// Errors: run was stopped, the disk is full.
  Result<> finish(OutputFile& file, const Eigen::Vector3d& scale, const Eigen::Vector3d& offset);

  /// Contents of the records "copc" 1 and "copc" 1000, the latter when it begins at `hierarchy_at` of the file.
  [[nodiscard]] std::string info(std::uint64_t hierarchy_at) const;
  [[nodiscard]] std::string hierarchy() const;

 private:
  struct Part {  // of the tree, to be written: a node whose records are chosen, or a whole branch
    CopcKey key;
    std::string records;
    std::unique_ptr<RecordSpool> branch;
  };
  struct Packed {  // a node, compressed
    CopcKey key;
    std::uint64_t points;
    std::string bytes;
  };
  class Sieve;

  CopcStream(std::filesystem::path path, const LazLayout& layout, const Run& run, const CopcSizes& sizes,
             RecordSpool all);
  void enclose(const Eigen::Vector3d& scale, const Eigen::Vector3d& offset);
  [[nodiscard]] std::array<std::uint32_t, 3> position_of(const char* record) const;
  template <class Sieved>
  [[nodiscard]] bool keeps(const CopcKey& key, std::uint64_t index, const Sieved& sieved) const;
  [[nodiscard]] bool divisible(const CopcKey& key, std::uint64_t points) const;
  Result<> divide(const CopcKey& key, std::unique_ptr<RecordSpool> records, Sieve& sieve, OutputFile& file);
  Result<> write_parts(OutputFile& file);
  [[nodiscard]] std::vector<Packed> pack_branch(const CopcKey& key, std::string_view records) const;
  [[nodiscard]] Packed pack(const CopcKey& key, std::string_view records) const;

  std::filesystem::path path_;
  LazLayout layout_;
  Run run_;
  CopcSizes sizes_;
  std::unique_ptr<RecordSpool> all_;
  std::uint64_t points_ = 0;
  std::array<std::int32_t, 3> lowest_{}, highest_{};  // of the records
  Eigen::Vector3d corner_ = Eigen::Vector3d::Zero();  // of the cube, its lowest
  Eigen::Vector3d parts_per_unit_ = Eigen::Vector3d::Zero();
  double side_ = 0;       // of the cube [m]
  int single_level_ = 0;  // from here on a cell of the grid holds a single position
  std::vector<Part> parts_;
  std::uint64_t points_in_parts_ = 0, points_written_ = 0;
  std::vector<CopcNode> nodes_;
};

}  // namespace collinea
