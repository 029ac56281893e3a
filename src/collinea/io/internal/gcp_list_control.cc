// SPDX-License-Identifier: Apache-2.0
// OpenDroneMap's gcp_list.txt. The first line is the CRS ("EPSG:32617", "WGS84 UTM 17N", "+proj=utm ..."), then
//     x y z column row image [name]
// between white space (or tabs, when names hold blanks), commas or semicolons. A height that was not surveyed is NaN,
// or an empty field between tabs, commas or semicolons. A whole file may be without z; where some rows have it and
// others one number less, any number may be the one that is missing, and reading on would move the others to wrong
// columns. Rows with one name, or without names with one x y z, are one point. In files in degrees (EPSG:4326) x is the
// longitude and y the latitude.
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/io/control_file.h"
#include "collinea/io/internal/control_collector.h"
#include "collinea/io/internal/control_formats.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Fields = std::vector<std::string_view>;

// x y z column row image [name], or without z; nothing when the line is not such a row.
struct OdmRow {
  Eigen::Vector3d position;
  Eigen::Vector2d pixel;
  std::string_view file, name;
  bool has_z = true;  ///< a column of its own, if only for NaN
};

std::optional<OdmRow> odm_row(const Fields& f) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto is_empty_z = [&](std::size_t i) { return i == 2 && f[i].empty(); };
  std::size_t numbers = 0;
  while (numbers < f.size() && (number(f[numbers]) || is_empty_z(numbers))) ++numbers;
  if (numbers > 5) {  // an image may be called "7", but then a point is not called "a.jpg"
    const auto dot = f.size() > 6 ? f[6].rfind('.') : std::string_view::npos;
    if ((numbers > 6 && f.size() > numbers) || (dot != std::string_view::npos && !number(f[6].substr(dot + 1))))
      return std::nullopt;
    numbers = 5;
  }
  if (numbers < 4 || f.size() <= numbers) return std::nullopt;
  const bool has_z = numbers == 5;
  OdmRow row{{*number(f[0]), *number(f[1]), has_z ? number(f[2]).value_or(nan) : nan},
             {number(f[numbers - 2]).value_or(nan), *number(f[numbers - 1])},
             f[numbers],
             f.size() > numbers + 1 ? f[numbers + 1] : std::string_view{},
             has_z};
  if (!std::isfinite(row.position.x()) || !std::isfinite(row.position.y()) || !row.pixel.allFinite() ||
      std::isinf(row.position.z()) || row.file.empty())
    return std::nullopt;
  return row;
}

std::optional<OdmRow> odm_row(std::string_view line) {
  bool has_empty_field = false;
  if (line.find('\t') != std::string_view::npos) {  // names may hold blanks then
    const Fields fields = fields_of(line, '\t');
    if (const auto row = odm_row(fields)) return row;
    for (const std::string_view field : fields) has_empty_field |= field.empty();
  }
  const auto row = odm_row(words_of(line));
  if (row && !row->has_z && has_empty_field) return std::nullopt;  // the field is what is missing, and not z
  if (row) return row;
  for (const char separator : {',', ';'})
    if (const auto separated = odm_row(fields_of(line, separator))) return separated;
  return std::nullopt;
}

/// Rows with and without z, as far as they were read.
class ColumnsOfFile {
 public:
  Result<> take(int line, bool has_z) {
    (has_z ? with_z_ : without_z_) = line;
    if (with_z_ == 0 || without_z_ == 0) return {};
    return bad_control_line(without_z_, "4 numbers in front of the image, where line " + std::to_string(with_z_) +
                                            " has 5: one is missing (a height that was not surveyed is written NaN)");
  }

 private:
  int with_z_ = 0, without_z_ = 0;  // the last line of each
};

Result<ControlFile> parse_gcp_list(std::string_view file, const ControlDefaults& defaults) {
  const std::vector<std::string_view> lines = lines_of(file);
  ControlCollector collector(defaults);
  ColumnsOfFile columns;
  std::string crs;
  bool first = true;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = int(i) + 1;
    const std::string_view text = trimmed(lines[i]);
    if (text.empty() || text.starts_with('#')) continue;
    const auto row = odm_row(text);
    if (row) {
      COLLINEA_TRY(columns.take(line, row->has_z));
      ControlFileObservation seen{{}, std::string(row->file), row->pixel, defaults.sigma_px, line};
      COLLINEA_TRY(collector.add_row(line, row->position, row->name, std::move(seen)));
    } else if (first) {
      crs = normalised_crs(text);
      if (crs.empty())
        return bad_control_line(line, "not a coordinate system (\"EPSG:32633\", \"WGS84 UTM 33N\", \"+proj=...\")" +
                                          separator_hint(text, ' '));
    } else {
      return bad_control_line(line, "not of the form: x y z column row image [name]" + separator_hint(text, ' '));
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
