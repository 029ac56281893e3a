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

Result<> write_frame_list(const std::filesystem::path& project, const FramesRecord& record) {
  if (record.frames.empty()) return {};
  TextTable table;
  table.columns = {{"name", ""},      {"origin_e", "m"}, {"origin_n", "m"}, {"origin_h", "m"},
                   {"right_e", "1"},  {"right_n", "1"},  {"right_h", "1"},  {"up_e", "1"},
                   {"up_n", "1"},     {"up_h", "1"},     {"normal_e", "1"}, {"normal_n", "1"},
                   {"normal_h", "1"}, {"width", "m"},    {"height", "m"},   {"depth", "m"}};
  for (const FrameRecord& frame : record.frames) {
    std::vector<std::string> row = {frame.name};
    for (const double along : frame.origin) row.push_back(fmt::format("{:.4f}", along));
    for (const Eigen::Vector3d& axis : {frame.right, frame.up, frame.normal})
      for (const double along : axis) row.push_back(fmt::format("{:.9f}", along));
    for (const double length : {frame.width_m, frame.height_m, frame.depth_m})
      row.push_back(fmt::format("{:.4f}", length));
    table.rows.push_back(std::move(row));
  }
  return write_file(project / "products" / "frames" / "frames.txt", text_of(table));
}

}  // namespace collinea
