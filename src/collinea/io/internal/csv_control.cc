// SPDX-License-Identifier: Apache-2.0
// Our CSV. Rows start with a word; rows without any number are titles; # starts a comment:
//     # collinea control, EPSG:32633
//     point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role
//     image, id, file, x_px, y_px, sigma_px
//     image_covariance, id, file, xx_px2, xy_px2, yy_px2
//     covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2
// Role is control (default) or check. Sigmas may all be left out: `defaults`. `inf`, or an empty field beside given
// sigmas, or an empty coordinate, means that the axis was not surveyed; a point may have none of the three, and needs
// no row then if two images show it. sigma_px may be left out. A covariance stands below its point and in place of its
// sigmas; fields of an axis that was not surveyed are empty. Semicolons or tabs may separate in place of commas, in the
// whole file: those behind the word that the first row starts with. A point has 5, 8 or 9 fields: with a number of
// others one is missing, which would move those behind it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "collinea/io/control_file.h"
#include "collinea/io/internal/control_collector.h"
#include "collinea/io/internal/control_formats.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Fields = std::vector<std::string_view>;

constexpr std::string_view kMark = "# collinea control", kSeparators = ",;\t";
constexpr const char* kPointForm = "point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role";

bool is_kind(std::string_view word) {
  return word == "point" || word == "image" || word == "covariance" || word == "image_covariance";
}

// What stands behind the word that a row of ours starts with; nothing when the line is no such row.
std::optional<char> separator_of_row(std::string_view line) {
  const auto end = line.find_first_of(kSeparators);
  if (end == std::string_view::npos || !is_kind(lower(trimmed(line.substr(0, end))))) return std::nullopt;
  return line[end];
}

// Spreadsheets give all rows the length of the longest.
void drop_empty_behind(std::size_t most, Fields& fields) {
  while (fields.size() > most && fields.back().empty()) fields.pop_back();
}

// Whole numbers alone, and standard deviations that no survey has: "546812,31, 5338101,92, 352,18".
bool looks_like_decimal_commas(const Fields& f) {
  bool suspect = false;
  for (std::size_t i = 2; i < 8; ++i) {
    const auto value = integer(f[i]);
    if (!value) return false;
    suspect |= i >= 5 && (*value >= 10 || (f[i].size() > 1 && f[i].starts_with('0')));
  }
  return suspect;
}

// Words in the place of numbers. A point without any coordinate has no number either, but no words in their place.
// Titles stand above all rows of their kind; further down words in the place of numbers are an error of theirs.
bool is_title(const Fields& fields, bool is_first_of_kind) {
  const bool numbers = std::any_of(fields.begin() + 1, fields.end(),
                                   [](std::string_view f) { return number(f).has_value() || has_decimal_comma(f); });
  const auto first = fields.begin() + std::min<std::ptrdiff_t>(2, std::ssize(fields)),
             last = fields.begin() + std::min<std::ptrdiff_t>(8, std::ssize(fields));
  const bool words = std::any_of(first, last, [](std::string_view f) { return !f.empty(); });
  return !numbers && words && (is_first_of_kind || lower(fields[1]) == "id");
}

Result<> check_fields_of_point(int line, const Fields& f) {
  if (f.size() < 5) return bad_control_line(line, "a point row needs: point, id, easting, northing, height");
  if (f.size() > 9) return bad_control_line(line, "too many fields (decimal commas?)");
  if (f.size() == 6 || f.size() == 7)
    return bad_control_line(line, std::to_string(f.size()) + " fields: a point row has 5, 8 or 9 of " + kPointForm +
                                      "; a field that is empty keeps its separator (decimal commas?)");
  if (f.size() >= 8 && looks_like_decimal_commas(f))
    return bad_control_line(line,
                            "whole numbers alone, and standard deviations of metres: decimal commas? Write points");
  return {};
}

Result<ControlFilePoint> csv_point(int line, Fields f, const ControlDefaults& defaults) {
  drop_empty_behind(9, f);
  if (std::all_of(f.begin() + std::min<std::ptrdiff_t>(5, std::ssize(f)), f.end(),
                  [](auto field) { return field.empty(); }))
    drop_empty_behind(5, f);
  COLLINEA_TRY(check_fields_of_point(line, f));
  if (f[1].empty()) return bad_control_line(line, "the point has no id");
  ControlFilePoint point{std::string(f[1]), {}, {}, ControlRole::kControl};
  point.sigma_m = {defaults.sigma_plan_m, defaults.sigma_plan_m, defaults.sigma_height_m};
  const auto field = [&](std::size_t i) { return i < f.size() ? f[i] : std::string_view{}; };
  const bool any_sigma = !field(5).empty() || !field(6).empty() || !field(7).empty();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string_view coordinate = f[2 + i], sigma = field(5 + i);
    const auto value = number(coordinate);
    if (!coordinate.empty() && (!value || std::isinf(*value)))
      return bad_control_line(line,
                              "\"" + std::string(coordinate) + "\" is not a coordinate" + number_hint(coordinate));
    const bool surveyed = value && std::isfinite(*value);
    const auto sigma_value = number(sigma);
    if (!sigma.empty() && (!sigma_value || !(*sigma_value > 0)))
      return bad_control_line(
          line,
          "\"" + std::string(sigma) + "\" is not a standard deviation: a number above 0, or inf" + number_hint(sigma));
    const auto axis = Eigen::Index(i);
    point.position_in_map[axis] = surveyed ? *value : kInfinity;
    if (any_sigma) point.sigma_m[axis] = sigma_value.value_or(kInfinity);
    if (!surveyed) point.sigma_m[axis] = kInfinity;
  }
  const std::string role = lower(field(8));
  if (role != "" && role != "control" && role != "check")
    return bad_control_line(line, "role \"" + std::string(field(8)) + "\" is neither control nor check");
  if (role == "check") point.role = ControlRole::kCheck;
  return point;
}

Result<ControlFileObservation> csv_observation(int line, Fields f, const ControlDefaults& defaults) {
  drop_empty_behind(6, f);
  if (f.size() < 5) return bad_control_line(line, "an image row needs: image, id, file, x_px, y_px");
  if (f.size() > 6) return bad_control_line(line, "too many fields (decimal commas?)");
  if (f[1].empty() || f[2].empty()) return bad_control_line(line, "an image row needs the id of a point and a file");
  const auto x_px = finite_number(f[3]), y_px = finite_number(f[4]);
  if (!x_px || !y_px) return bad_control_line(line, "x_px and y_px must be numbers" + number_hint(x_px ? f[4] : f[3]));
  ControlFileObservation seen{std::string(f[1]), std::string(f[2]), {*x_px, *y_px}, defaults.sigma_px, line};
  if (f.size() > 5 && !f[5].empty()) {
    const auto sigma_px = finite_number(f[5]);
    if (!sigma_px || !(*sigma_px > 0))
      return bad_control_line(line, "sigma_px must be a number above 0" + number_hint(f[5]));
    seen.sigma_px = *sigma_px;
  }
  return seen;
}

Result<ControlFile> parse_csv(std::string_view file, const ControlDefaults& defaults) {
  const std::vector<std::string_view> lines = lines_of(file);
  ControlCollector collector(defaults);
  std::string crs;
  std::optional<char> separator;
  std::set<std::string> kinds;  // that have come so far
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = int(i) + 1;
    const std::string_view text = trimmed(lines[i]);
    if (lower(text).starts_with(kMark)) {
      const auto comma = text.find_first_of(kSeparators);
      if (comma != std::string_view::npos) crs = normalised_crs(text.substr(comma + 1));
      if (comma != std::string_view::npos && crs.empty()) return bad_control_line(line, "not a coordinate system");
    }
    if (text.empty() || text.starts_with('#')) continue;
    if (!separator) separator = separator_of_row(text);
    Fields fields = fields_between(lines[i], separator.value_or(','));
    if (std::all_of(fields.begin(), fields.end(), [](auto field) { return field.empty(); })) continue;
    const std::string kind = lower(fields[0]);
    if (!is_kind(kind))
      return bad_control_line(
          line, "a row starts with point, image or covariance" + separator_hint(text, separator.value_or(',')));
    if (is_title(fields, kinds.insert(kind).second)) continue;
    if (kind == "covariance") {
      drop_empty_behind(8, fields);
      COLLINEA_TRY(collector.add_covariance(line, fields));
    } else if (kind == "image_covariance") {
      drop_empty_behind(6, fields);
      COLLINEA_TRY(collector.add_image_covariance(line, fields));
    } else if (kind == "point") {
      COLLINEA_TRY(ControlFilePoint point, csv_point(line, fields, defaults));
      COLLINEA_TRY(collector.add_point(line, std::move(point)));
    } else {
      COLLINEA_TRY(ControlFileObservation seen, csv_observation(line, fields, defaults));
      COLLINEA_TRY(collector.add_observation(std::move(seen)));
    }
  }
  return collector.finish(std::move(crs));
}

bool is_csv(std::string_view file) {
  const std::vector<std::string_view> lines = lines_of(file);
  return std::any_of(lines.begin(), lines.end(), [](std::string_view raw) {
    const std::string_view line = trimmed(raw.substr(0, 64));
    return lower(line).starts_with(kMark) || separator_of_row(line).has_value();
  });
}

}  // namespace

ControlFormat csv_control() { return {"collinea's CSV", is_csv, parse_csv}; }

}  // namespace collinea
