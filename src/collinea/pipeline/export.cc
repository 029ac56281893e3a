// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/export.h"

#include <algorithm>
#include <map>

#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/file.h"
#include "collinea/io/las.h"
#include "collinea/io/opk.h"
#include "collinea/io/ply.h"
#include "collinea/pipeline/colours.h"

namespace collinea {
namespace {

Result<> export_colmap(const Project& project, const std::filesystem::path& folder, const Block& block) {
  for (const ColmapEncoding encoding : {ColmapEncoding::kText, ColmapEncoding::kBinary}) {
    const auto remarks = write_colmap(folder, block, encoding);
    if (!remarks) return tl::unexpected(remarks.error());
    if (encoding == ColmapEncoding::kText)
      for (const std::string& remark : *remarks) project.run.say("note: " + remark);
  }
  return {};
}

Result<> export_bundler(const Project& project, const std::filesystem::path& folder, const Block& block) {
  COLLINEA_TRY(const auto remarks, write_bundler(folder, block));
  for (const std::string& remark : remarks) project.run.say("note: " + remark);
  return {};
}

Result<> export_tie_points(const std::filesystem::path& folder, const Block& block) {
  std::map<PointId, std::size_t> images;
  for (const Observation& seen : block.observations) ++images[seen.point];
  const auto byte = [](std::size_t count) { return static_cast<std::uint8_t>(std::min<std::size_t>(count, 255)); };
  std::vector<CloudPoint> cloud;
  for (const auto& [id, point] : block.points)
    cloud.push_back({.position = point.position_in_world, .colour = point.colour, .images = byte(images[id])});
  COLLINEA_TRY(PlyWriter writer,
               PlyWriter::create(folder / "tie_points.ply", "collinea tie points, local world frame, metres"));
  writer.write(cloud);
  return writer.finish();
}

Result<> export_cloud(const Project& project, const std::filesystem::path& folder, LasForm form) {
  if (!is_there(project.cloud()))
    return fail(Errc::kNotFound, "there is no cloud yet: collinea densify " + project.folder.string());
  COLLINEA_TRY(LasReader reader, LasReader::open(project.cloud()));
  const LasHeader& header = reader.header();
  LasWriter::Options options{header.lowest, header.highest, header.wkt};
  options.form = form;
  options.run = project.run;
  COLLINEA_TRY(LasWriter writer, LasWriter::create(folder / las_file_name("cloud", form), options));
  constexpr std::size_t kPiece = 100'000;
  for (std::uint64_t done = 0; done < header.points;) {
    COLLINEA_TRY(const std::vector<CloudPoint> points, reader.read(kPiece));
    if (auto written = writer.write(points); !written) return written;
    done += points.size();
    if (project.run.stopped()) return fail(Errc::kCancelled, "stopped");
  }
  return writer.finish();
}

}  // namespace

Result<> export_block(Project& project, const std::filesystem::path& folder, const std::string& format) {
  COLLINEA_TRY(Block block, project.store.read_block());
  if (block.cam_from_world.empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + project.folder.string());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  if (format == "colmap" || format == "bundler" || format == "ply")  // nothing else looks at the colours
    if (auto coloured = colour_tie_points(project, block); !coloured) return coloured;
  if (format == "colmap") return export_colmap(project, folder, block);
  if (format == "bundler") return export_bundler(project, folder, block);
  if (format == "opk") return write_opk(folder / "orientation.opk", block);
  if (format == "ply") return export_tie_points(folder, block);
  if (const auto form = las_form_of(format)) return export_cloud(project, folder, *form);
  return fail(Errc::kBadInput, "--format " + format + ": choose colmap, bundler, opk, ply, las, laz or copc");
}

}  // namespace collinea
