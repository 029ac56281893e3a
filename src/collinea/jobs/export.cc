// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "collinea/base/file.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/edit/read_work.h"
#include "collinea/io/bingo.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/opk.h"
#include "collinea/io/patb.h"
#include "collinea/io/text.h"
#include "collinea/jobs/marking_project.h"
#include "collinea/radiometry/tie_point_colours.h"
#include "collinea/raster/image_file.h"
#include "collinea/report/finding_words.h"
#include "collinea/steps/cloud_pieces.h"

namespace collinea {
namespace {

Result<> export_colmap(const Project& project, const std::filesystem::path& folder, const Block& block) {
  for (const ColmapEncoding encoding : {ColmapEncoding::kText, ColmapEncoding::kBinary}) {
    const auto findings = write_colmap(folder, block, encoding);
    if (!findings) return tl::unexpected(findings.error());
    if (encoding == ColmapEncoding::kText)
      for (const Finding& finding : *findings) project.run.say("note: " + sentence_of(finding, block));
  }
  return {};
}

Result<> export_bundler(const Project& project, const std::filesystem::path& folder, const Block& block) {
  COLLINEA_TRY(const auto findings, write_bundler(folder, block));
  for (const Finding& finding : findings) project.run.say("note: " + sentence_of(finding, block));
  return {};
}

Result<> export_tie_points(const std::filesystem::path& folder, const Block& block) {
  std::map<PointId, std::size_t> images;
  for (const Observation& seen : block.observations) ++images[seen.point];
  const auto byte = [](std::size_t count) { return static_cast<std::uint8_t>(std::min<std::size_t>(count, 255)); };
  std::vector<CloudPoint> cloud;
  for (const auto& [id, point] : block.points)
    cloud.push_back({.position = point.position_in_world, .colour = point.colour, .images = byte(images[id])});
  COLLINEA_TRY(PlyWriter writer, PlyWriter::create(folder / "tie_points.ply", kTiePointsComment));
  writer.write(cloud);
  return writer.finish();
}

using Tile = std::pair<std::int64_t, std::int64_t>;  // column east, row north, from the origin of the map

// A point on the border belongs to the tile that begins there, whatever its last digit.
Tile tile_of(const CloudPoint& point, double tile_m) {
  constexpr double kRounding_m = 1e-6;
  const auto number = [&](double along) { return std::int64_t(std::floor((along + kRounding_m) / tile_m)); };
  return {number(point.position.x()), number(point.position.y())};
}

// Tiles are named after their south-western corner.
std::string tile_name(const Tile& tile, double tile_m) {
  return fmt::format("cloud_{}_{}", exact(double(tile.first) * tile_m), exact(double(tile.second) * tile_m));
}

// The cloud as edits by hand have it, piece by piece.
template <class Take>
Result<> for_each_edited_piece(const Project& project, const CloudEdits& edits, const Take& take) {
  return for_each_piece(project.cloud(), project.run, [&](std::vector<CloudPoint>& points) {
    edits.apply(points);
    return take(points);
  });
}

// So many tiles at once, each with its file, and the cloud read as often as that takes: no cloud has too many tiles.
Result<> write_tiles(const Project& project, const CloudEdits& edits, const std::filesystem::path& folder,
                     LasWriter::Options options, const std::map<Tile, std::uint64_t>& counts, double tile_m) {
  constexpr std::size_t kAtOnce = 64;
  const Eigen::Vector3d lowest = options.lowest, highest = options.highest;
  options.run.threads = 1;  // so many writers, each with what its threads wait for
  for (auto first = counts.begin(); first != counts.end();) {
    std::map<Tile, LasWriter> writers;
    for (; first != counts.end() && writers.size() < kAtOnce; ++first) {
      const auto& [east, north] = first->first;
      const Eigen::Vector2d corner(double(east) * tile_m, double(north) * tile_m);
      options.lowest.head<2>() = corner.cwiseMax(lowest.head<2>());
      options.highest.head<2>() = (corner.array() + tile_m).matrix().cwiseMin(highest.head<2>());
      COLLINEA_TRY(LasWriter writer,
                   LasWriter::create(folder / las_file_name(tile_name(first->first, tile_m), options.form), options));
      writers.emplace(first->first, std::move(writer));
    }
    auto written = for_each_edited_piece(project, edits, [&](std::vector<CloudPoint>& points) -> Result<> {
      std::map<Tile, std::vector<CloudPoint>> parts;
      for (const CloudPoint& point : points)
        if (const Tile tile = tile_of(point, tile_m); writers.contains(tile)) parts[tile].push_back(point);
      for (const auto& [tile, part] : parts) COLLINEA_TRY(writers.at(tile).write(part));
      return {};
    });
    if (!written) return written;
    for (auto& [tile, writer] : writers) COLLINEA_TRY(writer.finish());
  }
  std::string list = "file,west,south,east,north,points\n";
  for (const auto& [tile, points] : counts) {
    const double west = double(tile.first) * tile_m, south = double(tile.second) * tile_m;
    list += fmt::format("{},{},{},{},{},{}\n", las_file_name(tile_name(tile, tile_m), options.form), exact(west),
                        exact(south), exact(west + tile_m), exact(south + tile_m), points);
  }
  return write_file(folder / "tiles.csv", list);
}

Result<> export_cloud(const Project& project, const std::filesystem::path& folder, LasForm form,
                      std::optional<double> tile_m) {
  if (!is_there(project.cloud()))
    return fail(Errc::kNotFound, "there is no cloud yet: collinea densify " + project.folder.string());
  COLLINEA_TRY(const LasReader reader, LasReader::open(project.cloud()));
  const LasHeader& header = reader.header();
  LasWriter::Options options{header.lowest, header.highest, header.wkt};
  options.form = form;
  options.run = project.run;
  COLLINEA_TRY(const CloudEdits edits, read_cloud_edits(project));
  if (!tile_m) {
    COLLINEA_TRY(LasWriter writer, LasWriter::create(folder / las_file_name("cloud", form), options));
    auto written =
        for_each_edited_piece(project, edits, [&](std::vector<CloudPoint>& points) { return writer.write(points); });
    return written ? writer.finish() : written;
  }
  constexpr std::size_t kMostTiles = 1'000'000;
  std::map<Tile, std::uint64_t> counts;
  auto counted = for_each_edited_piece(project, edits, [&](std::vector<CloudPoint>& points) -> Result<> {
    for (const CloudPoint& point : points) ++counts[tile_of(point, *tile_m)];
    if (counts.size() > kMostTiles)
      return fail(Errc::kBadInput, "the tiles are too small: there would be a million", {"tile_m"_option});
    return {};
  });
  return counted ? write_tiles(project, edits, folder, options, counts, *tile_m) : counted;
}

std::optional<LasForm> cloud_form_of(ExportFormat format) {
  if (format == ExportFormat::kLas) return LasForm::kLas;
  if (format == ExportFormat::kLaz) return LasForm::kLaz;
  if (format == ExportFormat::kCopc) return LasForm::kCopc;
  return std::nullopt;
}

bool has_colours(ExportFormat format) {
  return format == ExportFormat::kColmap || format == ExportFormat::kBundler || format == ExportFormat::kPly;
}

PixelSource pixels_of(const Project& project, const Block& block) {
  return [&](ImageId image, int shrink) { return read_colour(project.image_file(block.images.at(image)), shrink); };
}

// Times sigma0; none of a block that was not adjusted.
std::map<ImageId, PoseCovariance> covariances_of_poses(const Project& project) {
  std::map<ImageId, PoseCovariance> scaled;
  const auto covariances = project.store.read_covariances();
  const auto adjusted = project.store.read_outcome<AdjustmentRecord>();
  if (!covariances || !adjusted) return scaled;
  const double scale = sigma_scale(std::optional(*adjusted));
  for (const auto& [image, covariance] : covariances->poses) scaled[image] = scale * scale * covariance;
  return scaled;
}

}  // namespace

Result<> export_block(Project& project, const std::filesystem::path& folder, const ExportOptions& options) {
  COLLINEA_TRY(validate(options));
  const std::optional<LasForm> cloud = cloud_form_of(options.format);
  if (options.tile_m && !cloud)
    return fail(Errc::kBadInput, "tiles are of clouds: las, laz or copc", {"tile_m"_option, "format"_option});
  COLLINEA_TRY(Block block, project.store.read_block());
  if (oriented_images(block).empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + project.folder.string());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  if (cloud) return export_cloud(project, folder, *cloud, options.tile_m);
  if (has_colours(options.format)) COLLINEA_TRY(colour_tie_points(pixels_of(project, block), block, project.run));
  switch (options.format) {
    case ExportFormat::kColmap:
      return export_colmap(project, folder, block);
    case ExportFormat::kBundler:
      return export_bundler(project, folder, block);
    case ExportFormat::kOpk:
      return write_opk(folder / "orientation.opk", block, covariances_of_poses(project));
    case ExportFormat::kPatb:
      return write_patb(folder / "block.im", block, options.pixel_um);
    case ExportFormat::kBingo:
      return write_bingo(folder / "image.dat", block, options.pixel_um);
    default:
      return export_tie_points(folder, block);
  }
}

}  // namespace collinea
