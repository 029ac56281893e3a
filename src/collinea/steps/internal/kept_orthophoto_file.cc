// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/kept_orthophoto_file.h"

#include <memory>
#include <mutex>

#include "collinea/base/file.h"
#include "collinea/store/packed_fields.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

fs::path kept_file(const fs::path& project) { return project / "ortho" / "kept.bin"; }

struct Kept {
  std::string inputs;
  std::uint64_t image_hash = 0, source_hash = 0;  ///< of the files
  KeptOrthophoto orthophoto;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("inputs", &Kept::inputs);
    visit("image_hash", &Kept::image_hash);
    visit("source_hash", &Kept::source_hash);
    visit("orthophoto", &Kept::orthophoto);
  }
};

/// The pixels of an orthophoto on disk.
class Pixels {
 public:
  Pixels(GeoTiffReader image, GeoTiffReader source) : image_(std::move(image)), source_(std::move(source)) {}

  Result<OrthoTile> read(const CellArea& area) {
    const std::lock_guard lock(mutex_);
    COLLINEA_TRY(auto rgba, image_.read_byte(area.column, area.row, area.width, area.height));
    COLLINEA_TRY(const auto source, source_.read_float(area.column, area.row, area.width, area.height));
    OrthoTile tile{std::move(rgba), Raster<std::uint16_t>(area.width, area.height), {}, {}};
    for (std::size_t i = 0; i < source.data.size(); ++i) tile.source.data[i] = std::uint16_t(source.data[i]);
    return tile;
  }

 private:
  std::mutex mutex_;
  GeoTiffReader image_, source_;
};

}  // namespace

Result<> write_kept(const fs::path& project, const std::string& inputs, const OrthoFiles& files,
                    const KeptOrthophoto& kept) {
  Kept all{inputs, 0, 0, kept};
  COLLINEA_TRY(all.image_hash, hash_of_file(files.image));
  COLLINEA_TRY(all.source_hash, hash_of_file(files.source));
  Packer packer;
  packer.put(layout<Kept>());
  pack(packer, all);
  std::error_code error;
  fs::create_directories(kept_file(project).parent_path(), error);
  if (error)
    return fail(Errc::kBadInput, "cannot make " + kept_file(project).parent_path().string() + ": " + error.message());
  return write_file(kept_file(project), packer.bytes());
}

std::optional<EarlierOrthophoto> read_kept(const fs::path& project, const std::string& inputs,
                                           const OrthoFiles& files) {
  if (!is_there(files.image) || !is_there(files.source)) return std::nullopt;
  const auto bytes = read_file(kept_file(project));
  if (!bytes) return std::nullopt;
  Unpacker unpacker(*bytes);
  Kept all;
  if (unpacker.get<std::uint64_t>() != layout<Kept>() || !unpack(unpacker, all) || unpacker.left() > 0)
    return std::nullopt;
  if (all.inputs != inputs || hash_of_file(files.image) != all.image_hash ||
      hash_of_file(files.source) != all.source_hash)
    return std::nullopt;
  auto image = GeoTiffReader::open(files.image), source = GeoTiffReader::open(files.source);
  if (!image || !source) return std::nullopt;
  const auto pixels = std::make_shared<Pixels>(*std::move(image), *std::move(source));
  return EarlierOrthophoto{std::move(all.orthophoto), [pixels](const CellArea& area) { return pixels->read(area); }};
}

}  // namespace collinea
