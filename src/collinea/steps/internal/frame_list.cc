// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/frame_list.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/base/file.h"
#include "collinea/io/text_table.h"

namespace collinea {

bool is_frame_name(std::string_view name) {
  const auto is_of_it = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, is_of_it);
}

namespace {

constexpr const char* kList = "frames.txt";
constexpr const char* kFiles[] = {"dsm.tif",       "dsm_sigma.tif",    "dsm_sigma_relative.tif",
                                  "dsm_state.tif", "dsm_count.tif",    "dsm_hillshade.tif",
                                  "ortho.tif",     "ortho_source.tif", "seamlines.gpkg"};
constexpr const char* kContours[] = {"contours.gpkg", "contours.dxf"};
constexpr const char* kDrawing = "elevation.pdf";

}  // namespace

std::vector<std::string> frame_files(const FramesRecord& record) {
  const std::string folder = "products/frames/";
  std::vector<std::string> files;
  for (const FrameRecord& frame : record.frames) {
    for (const char* file : kFiles) files.push_back(folder + frame.name + "/" + file);
    if (frame.contour_m > 0)
      for (const char* file : kContours) files.push_back(folder + frame.name + "/" + file);
    if (frame.scale > 0) files.push_back(folder + frame.name + "/" + kDrawing);
  }
  if (!record.frames.empty()) files.push_back(folder + kList);
  return files;
}

Result<> remove_frames(const std::filesystem::path& project) {
  namespace fs = std::filesystem;
  const fs::path folder = frames_folder(project);
  std::vector<fs::path> planes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.is_directory(none) && is_there(entry.path() / kFiles[0])) planes.push_back(entry.path());
  for (const fs::path& plane : planes) {
    for (const char* file : kContours) COLLINEA_TRY(remove_file(plane / file));
    COLLINEA_TRY(remove_file(plane / kDrawing));
    for (std::size_t i = std::size(kFiles); i-- > 0;)
      COLLINEA_TRY(remove_file(plane / kFiles[i]));  // that which tells last
    fs::remove(plane, none);                         // stays when it holds anything else
  }
  COLLINEA_TRY(remove_file(folder / kList));
  fs::remove(folder, none);
  return {};
}

Result<> write_frame_list(const std::filesystem::path& project, const FramesRecord& record) {
  if (record.frames.empty()) return {};
  TextTable table;
  const char* m = record.metric ? "m" : "1";  // without a scale: units of the block
  table.columns = {{"name", ""},      {"origin_e", m},  {"origin_n", m},   {"origin_h", m},
                   {"right_e", "1"},  {"right_n", "1"}, {"right_h", "1"},  {"up_e", "1"},
                   {"up_n", "1"},     {"up_h", "1"},    {"normal_e", "1"}, {"normal_n", "1"},
                   {"normal_h", "1"}, {"width", m},     {"height", m},     {"depth", m}};
  for (const FrameRecord& frame : record.frames) {
    std::vector<std::string> row = {frame.name};
    for (const double along : frame.origin) row.push_back(fmt::format("{:.4f}", along));
    for (const Eigen::Vector3d& axis : {frame.right, frame.up, frame.normal})
      for (const double along : axis) row.push_back(fmt::format("{:.9f}", along));
    for (const double length : {frame.width_m, frame.height_m, frame.depth_m})
      row.push_back(fmt::format("{:.4f}", length));
    table.rows.push_back(std::move(row));
  }
  return write_file(frames_folder(project) / kList, text_of(table));
}

}  // namespace collinea
