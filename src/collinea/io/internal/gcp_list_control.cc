// SPDX-License-Identifier: Apache-2.0
// OpenDroneMap's gcp_list.txt. The first line is the CRS ("EPSG:32617", "WGS84 UTM 17N", "+proj=utm ..."), then
//     x y z column row image [name]
// between white space (or tabs, when names hold blanks); z may be NaN or left out. Rows with one name, or without names
// with one x y z, are one point. In files in degrees (EPSG:4326) x is the longitude and y the latitude.
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/io/control_file.h"
#include "collinea/io/internal/control_collector.h"
#include "collinea/io/internal/control_formats.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Fields = std::vector<std::string_view>;

// x y z column row image [name], or without z; nothing when the line is not such a row.
struct OdmRow {
  Eigen::Vector3d position;
  Eigen::Vector2d pixel;
  std::string_view file, name;
};

std::optional<OdmRow> odm_row(const Fields& f) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::size_t numbers = 0;
  while (numbers < f.size() && number(f[numbers])) ++numbers;
  if (numbers > 5) numbers = 5;  // an image may be called "7"
  if (numbers < 4 || f.size() <= numbers) return std::nullopt;
  const bool has_z = numbers == 5;
  OdmRow row{{*number(f[0]), *number(f[1]), has_z ? *number(f[2]) : nan},
             {*number(f[numbers - 2]), *number(f[numbers - 1])},
             f[numbers],
             f.size() > numbers + 1 ? f[numbers + 1] : std::string_view{}};
  if (!std::isfinite(row.position.x()) || !std::isfinite(row.position.y()) || !row.pixel.allFinite() ||
      std::isinf(row.position.z()) || row.file.empty())
    return std::nullopt;
  return row;
}

std::optional<OdmRow> odm_row(std::string_view line) {
  if (line.find('\t') != std::string_view::npos)  // names may hold blanks then
    if (const auto row = odm_row(fields_of(line, '\t'))) return row;
  if (const auto row = odm_row(words_of(line))) return row;
  return odm_row(fields_of(line, ','));
}

Result<ControlFile> parse_gcp_list(std::string_view file, const ControlDefaults& defaults) {
  const std::vector<std::string_view> lines = lines_of(file);
  ControlCollector collector(defaults);
  std::string crs;
  bool first = true;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = int(i) + 1;
    const std::string_view text = trimmed(lines[i]);
    if (text.empty() || text.starts_with('#')) continue;
    const auto row = odm_row(text);
    if (row) {
      ControlFileObservation seen{{}, std::string(row->file), row->pixel, defaults.sigma_px, line};
      COLLINEA_TRY(collector.add_row(line, row->position, row->name, std::move(seen)));
    } else if (first) {
      crs = normalised_crs(text);
      if (crs.empty())
        return bad_control_line(line, "not a coordinate system (\"EPSG:32633\", \"WGS84 UTM 33N\", \"+proj=...\")");
    } else {
      return bad_control_line(line, "not of the form: x y z column row image [name]");
    }
    first = false;
  }
  return collector.finish(std::move(crs));
}

// Whatever no other format takes: the error then tells what was expected.
bool takes_what_is_left(std::string_view) { return true; }

}  // namespace

ControlFormat gcp_list_control() { return {"OpenDroneMap's `gcp_list.txt`", takes_what_is_left, parse_gcp_list}; }

}  // namespace collinea
