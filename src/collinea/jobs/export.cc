// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <unordered_set>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/block/world_frame.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/edit/read_work.h"
#include "collinea/geometry/polygon.h"
#include "collinea/io/bingo.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/map_area.h"
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

// One point of each cube of a lattice, the first that comes.
class Thinning {
 public:
  explicit Thinning(std::optional<double> spacing_m) : spacing_m_(spacing_m) {}
  void apply(std::vector<CloudPoint>& points) {
    if (spacing_m_)
      std::erase_if(points, [&](const CloudPoint& point) { return !taken_.insert(cube_of(point)).second; });
  }

 private:
  struct HashOfCube {
    std::size_t operator()(const std::array<std::int32_t, 3>& cube) const {
      std::uint64_t hash = 0;
      for (const std::int32_t along : cube) hash = (hash ^ std::uint32_t(along)) * 0x9E3779B97F4A7C15U + (hash >> 29);
      return std::size_t(hash);
    }
  };
  [[nodiscard]] std::array<std::int32_t, 3> cube_of(const CloudPoint& point) const {
    std::array<std::int32_t, 3> cube;
    for (int axis = 0; axis < 3; ++axis)
      cube[std::size_t(axis)] = std::int32_t(std::int64_t(std::floor(point.position[axis] / *spacing_m_)));
    return cube;
  }
  std::optional<double> spacing_m_;
  std::unordered_set<std::array<std::int32_t, 3>, HashOfCube> taken_;
};

// The cloud as it is wanted: with edits by hand, within an area, thinned. The same points each time it is read.
class WantedCloud {
 public:
  static Result<WantedCloud> of(const Project& project, const ExportOptions& options) {
    if (!is_there(project.cloud()))
      return fail(Errc::kNotFound, "there is no cloud yet: collinea densify " + project.folder.string());
    COLLINEA_TRY(CloudEdits edits, read_cloud_edits(project));
    std::optional<BoundedRing> area;
    if (options.area) {
      COLLINEA_TRY(const std::string text, read_file(*options.area));
      COLLINEA_TRY(MapArea corners, parse_area(text).map_error([&](Error e) {
        return std::move(e).within(options.area->string()).about("area"_option);
      }));
      area.emplace(std::move(corners));
    }
    return WantedCloud(project, std::move(edits), std::move(area), options.spacing_m);
  }

  template <class Take>
  Result<> for_each_piece(const Take& take) const {
    Thinning thinning(spacing_m_);
    return collinea::for_each_piece(project_.cloud(), project_.run, [&](std::vector<CloudPoint>& points) {
      edits_.apply(points);
      if (area_)
        std::erase_if(points, [&](const CloudPoint& point) { return !area_->contains(point.position.head<2>()); });
      thinning.apply(points);
      return take(points);
    });
  }

 private:
  WantedCloud(const Project& project, CloudEdits edits, std::optional<BoundedRing> area,
              std::optional<double> spacing_m)
      : project_(project), edits_(std::move(edits)), area_(std::move(area)), spacing_m_(spacing_m) {}
  const Project& project_;
  CloudEdits edits_;
  std::optional<BoundedRing> area_;
  std::optional<double> spacing_m_;
};

// So many tiles at once, each with its file, and the cloud read as often as that takes: no cloud has too many tiles.
Result<> write_tiles(const WantedCloud& cloud, const std::filesystem::path& folder, LasWriter::Options options,
                     const std::map<Tile, std::uint64_t>& counts, double tile_m) {
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
    auto written = cloud.for_each_piece([&](std::vector<CloudPoint>& points) -> Result<> {
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

// In the map, in a form of LAS.
Result<> export_las(const Project& project, const WantedCloud& cloud, const std::filesystem::path& folder, LasForm form,
                    std::optional<double> tile_m) {
  COLLINEA_TRY(const LasReader reader, LasReader::open(project.cloud()));
  const LasHeader& header = reader.header();
  LasWriter::Options options{header.lowest, header.highest, header.wkt};
  options.form = form;
  options.run = project.run;
  if (!tile_m) {
    COLLINEA_TRY(LasWriter writer, LasWriter::create(folder / las_file_name("cloud", form), options));
    auto written = cloud.for_each_piece([&](std::vector<CloudPoint>& points) { return writer.write(points); });
    return written ? writer.finish() : written;
  }
  constexpr std::size_t kMostTiles = 1'000'000;
  std::map<Tile, std::uint64_t> counts;
  auto counted = cloud.for_each_piece([&](std::vector<CloudPoint>& points) -> Result<> {
    for (const CloudPoint& point : points) ++counts[tile_of(point, *tile_m)];
    if (counts.size() > kMostTiles)
      return fail(Errc::kBadInput, "the tiles are too small: there would be a million", {"tile_m"_option});
    return {};
  });
  return counted ? write_tiles(cloud, folder, options, counts, *tile_m) : counted;
}

constexpr FileText kTextColumns = "# easting northing height red green blue sigma_m images class\n";

// In the local frame: small numbers, which programs that read them in single precision keep.
Result<> export_dense_ply(const WantedCloud& cloud, const std::filesystem::path& folder, const Block& block) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  COLLINEA_TRY(PlyWriter writer, PlyWriter::create(folder / "cloud.ply", kLocalCloudComment));
  auto written = cloud.for_each_piece([&](std::vector<CloudPoint>& points) -> Result<> {
    std::vector<Eigen::Vector3d> positions;
    for (const CloudPoint& point : points) positions.push_back(point.position);
    if (frame) frame->local_from_map(positions);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].position = positions[i];
    writer.write(points);
    return {};
  });
  return written ? writer.finish() : written;
}

Result<> export_text(const WantedCloud& cloud, const std::filesystem::path& folder) {
  COLLINEA_TRY(OutputFile file, OutputFile::create(folder / "cloud.xyz"));
  file.write(kTextColumns);
  auto written = cloud.for_each_piece([&](std::vector<CloudPoint>& points) -> Result<> {
    std::string lines;
    for (const CloudPoint& p : points)
      fmt::format_to(std::back_inserter(lines), "{:.4f} {:.4f} {:.4f} {} {} {} {:.4g} {} {}\n", p.position.x(),
                     p.position.y(), p.position.z(), p.colour[0], p.colour[1], p.colour[2], p.sigma_m, p.images,
                     p.classification);
    file.write(lines);
    return {};
  });
  return written ? file.finish() : written;
}

std::optional<LasForm> las_form_of(ExportFormat format) {
  if (format == ExportFormat::kLas) return LasForm::kLas;
  if (format == ExportFormat::kLaz) return LasForm::kLaz;
  if (format == ExportFormat::kCopc) return LasForm::kCopc;
  return std::nullopt;
}

bool is_of_cloud(ExportFormat format) {
  return las_form_of(format) || format == ExportFormat::kPly || format == ExportFormat::kXyz;
}

Result<> export_cloud(const Project& project, const std::filesystem::path& folder, const Block& block,
                      const ExportOptions& options) {
  COLLINEA_TRY(const WantedCloud cloud, WantedCloud::of(project, options));
  if (options.format == ExportFormat::kPly) return export_dense_ply(cloud, folder, block);
  if (options.format == ExportFormat::kXyz) return export_text(cloud, folder);
  return export_las(project, cloud, folder, *las_form_of(options.format), options.tile_m);
}

bool has_colours(ExportFormat format) {
  return format == ExportFormat::kColmap || format == ExportFormat::kBundler || format == ExportFormat::kTiePoints;
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
  if (options.tile_m && !las_form_of(options.format))
    return fail(Errc::kBadInput, "tiles are of clouds: las, laz or copc", {"tile_m"_option, "format"_option});
  if ((options.area || options.spacing_m) && !is_of_cloud(options.format))
    return fail(Errc::kBadInput, "an area and a spacing are of clouds: las, laz, copc, ply or xyz",
                {"area"_option, "spacing_m"_option, "format"_option});
  COLLINEA_TRY(Block block, project.store.read_block());
  if (oriented_images(block).empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + project.folder.string());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  if (is_of_cloud(options.format)) return export_cloud(project, folder, block, options);
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
