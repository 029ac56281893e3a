// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/control_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Fields = std::vector<std::string_view>;

tl::unexpected<Error> bad_line(int line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

std::string utm_code(std::string_view zone_text, bool south) {
  const auto zone = integer(zone_text);
  if (!zone || *zone < 1 || *zone > 60) return {};
  const std::string digits = std::to_string(*zone);
  return std::string(south ? "EPSG:327" : "EPSG:326") + (digits.size() < 2 ? "0" : "") + digits;
}

// "WGS84 UTM 17N", "WGS 84 / UTM zone 17 S"
std::string crs_of_utm_words(std::string text) {
  for (const std::string_view noise : {"wgs84", "wgs 84", "wgs_84", "utm", "zone", "/"}) {
    const auto at = text.find(noise);
    if (at == std::string::npos && (noise == "utm")) return {};
    if (at != std::string::npos) text.replace(at, noise.size(), " ");
  }
  std::string rest;
  for (const std::string_view word : words_of(text)) rest += word;
  if (rest.size() < 2 || (rest.back() != 'n' && rest.back() != 's')) return {};
  return utm_code(std::string_view(rest).substr(0, rest.size() - 1), rest.back() == 's');
}

// UTM on WGS84 has a code of its own, which carries more (a name, an area of use) than the string does.
std::string crs_of_proj_string(std::string_view text) {
  bool utm = false, wgs84 = false, south = false, typed = false, plain = true;
  std::string_view zone;
  for (const std::string_view word : words_of(text)) {
    utm |= word == "+proj=utm";
    wgs84 |= word == "+datum=WGS84" || word == "+ellps=WGS84";
    south |= word == "+south";
    typed |= word == "+type=crs";
    plain &= !word.starts_with("+towgs84") && !word.starts_with("+nadgrids") && !word.starts_with("+geoidgrids") &&
             !word.starts_with("+to_meter") && (!word.starts_with("+units") || word == "+units=m");
    if (word.starts_with("+zone=")) zone = word.substr(6);
  }
  if (utm && wgs84 && plain)
    if (const std::string code = utm_code(zone, south); !code.empty()) return code;
  return std::string(text) + (typed ? "" : " +type=crs");
}

bool is_geographic(const std::string& crs) {
  return crs == "EPSG:4326" || crs == "EPSG:4979" || crs.find("+proj=longlat") != std::string::npos ||
         crs.find("+proj=latlong") != std::string::npos || crs.find("+proj=lonlat") != std::string::npos;
}

/// Collects rows into points and observations.
class Collector {
 public:
  explicit Collector(const ControlDefaults& defaults) : defaults_(defaults) {}

  Result<> add_point(int line, ControlFilePoint point) {
    if (!by_name_.emplace(point.name, file_.points.size()).second)
      return bad_line(line, "point " + point.name + " is given twice");
    file_.points.push_back(std::move(point));
    return {};
  }

  Result<> add_covariance(int line, const Fields& f) {
    if (f.size() != 8)
      return bad_line(line, "a covariance row needs: covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2");
    const auto known = by_name_.find(std::string(f[1]));
    if (known == by_name_.end()) return bad_line(line, "there is no point " + std::string(f[1]) + " above this line");
    if (!with_covariance_.insert(known->first).second)
      return bad_line(line, "the covariance of " + known->first + " is given twice");
    ControlFilePoint& point = file_.points[known->second];
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    std::size_t next = 2;
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column, ++next) {
        if (f[next].empty()) continue;
        const auto value = finite_number(f[next]);
        if (!value) return bad_line(line, "\"" + std::string(f[next]) + "\" is not a covariance");
        covariance(row, column) = covariance(column, row) = *value;
      }
    for (int axis = 0; axis < 3; ++axis) {
      const bool surveyed = std::isfinite(point.position_in_map[axis]) && covariance(axis, axis) > 0;
      if (!surveyed && !covariance.row(axis).isZero(0))
        return bad_line(line, "covariances of an axis that has no coordinate, or no variance above 0");
      point.sigma_m[axis] = surveyed ? std::sqrt(covariance(axis, axis)) : kInfinity;
    }
    point.correlation = correlation_of(covariance);
    if (!survey_weight(point.sigma_m, point.correlation))
      return bad_line(line, "this is no covariance of " + point.name + ": it has to be positive definite");
    return {};
  }

  // A row of OpenDroneMap: the point may have been there before. x, y, z: NaN where missing.
  Result<> add_row(int line, const Eigen::Vector3d& position, std::string_view name, ControlFileObservation seen) {
    std::array<double, 3> key;
    for (int i = 0; i < 3; ++i) key[std::size_t(i)] = std::isnan(position[i]) ? kInfinity : position[i];
    if (name.empty()) {
      auto known = by_position_.find(key);
      if (known == by_position_.end()) {
        std::string made;
        do made = "gcp" + std::to_string(++unnamed_);
        while (by_name_.contains(made));
        COLLINEA_TRY(add_new(line, key, made));
        known = by_position_.find(key);
      }
      seen.point = file_.points[known->second].name;
    } else {
      seen.point = std::string(name);
      const auto known = by_name_.find(seen.point);
      if (known == by_name_.end()) {
        COLLINEA_TRY(add_new(line, key, seen.point));
      } else if (keys_[known->second] != key) {
        return bad_line(line, "point " + seen.point + " had other coordinates before");
      }
    }
    add_observation(std::move(seen));
    return {};
  }

  void add_observation(ControlFileObservation seen) {
    const bool copied_line = !known_.emplace(seen.point, seen.file, seen.pixel.x(), seen.pixel.y()).second;
    if (!copied_line) file_.observations.push_back(std::move(seen));
  }

  Result<ControlFile> finish(std::string crs) {
    if (file_.points.empty()) return fail(Errc::kBadFormat, "no control point found");
    for (const auto& seen : file_.observations)
      if (!by_name_.contains(seen.point))
        return bad_line(seen.line, "image row of a point " + seen.point + " that no point row gives");
    fill_missing_axes();
    file_.crs = std::move(crs);
    return std::move(file_);
  }

 private:
  Result<> add_new(int line, const std::array<double, 3>& key, const std::string& name) {
    ControlFilePoint point{name, {key[0], key[1], key[2]}, {}, ControlRole::kControl};
    point.sigma_m = {defaults_.sigma_plan_m, defaults_.sigma_plan_m, defaults_.sigma_height_m};
    for (int i = 0; i < 3; ++i)
      if (key[std::size_t(i)] == kInfinity) point.sigma_m[i] = kInfinity;
    by_position_.emplace(key, file_.points.size());
    keys_.push_back(key);
    return add_point(line, std::move(point));
  }

  void fill_missing_axes() {
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0;
      int known = 0;
      for (const auto& point : file_.points)
        if (std::isfinite(point.position_in_map[axis])) {
          sum += point.position_in_map[axis];
          ++known;
        }
      for (auto& point : file_.points)
        if (!std::isfinite(point.position_in_map[axis])) {
          point.position_in_map[axis] = known ? sum / known : 0;
          point.sigma_m[axis] = kInfinity;
        }
    }
  }

  ControlDefaults defaults_;
  ControlFile file_;
  std::map<std::string, std::size_t> by_name_;
  std::map<std::array<double, 3>, std::size_t> by_position_;  // infinity where missing: NaN has no order
  std::vector<std::array<double, 3>> keys_;
  std::set<std::tuple<std::string, std::string, double, double>> known_;  // observations
  std::set<std::string> with_covariance_;
  int unnamed_ = 0;
};

// --- OpenDroneMap ----------------------------------------------------------------------------------------------------

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

Result<ControlFile> parse_odm(const std::vector<std::string_view>& lines, const ControlDefaults& defaults) {
  Collector collector(defaults);
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
        return bad_line(line, "not a coordinate system (\"EPSG:32633\", \"WGS84 UTM 33N\", \"+proj=...\")");
    } else {
      return bad_line(line, "not of the form: x y z column row image [name]");
    }
    first = false;
  }
  return collector.finish(std::move(crs));
}

// --- our CSV ---------------------------------------------------------------------------------------------------------

constexpr std::string_view kMark = "# collinea control";

// A point without any coordinate has no number either, but no words in their place.
bool is_title(const Fields& fields) {
  const bool numbers =
      std::any_of(fields.begin() + 1, fields.end(), [](std::string_view f) { return number(f).has_value(); });
  const auto first = fields.begin() + std::min<std::ptrdiff_t>(2, std::ssize(fields)),
             last = fields.begin() + std::min<std::ptrdiff_t>(8, std::ssize(fields));
  return !numbers && std::any_of(first, last, [](std::string_view f) { return !f.empty(); });
}

Result<ControlFilePoint> csv_point(int line, const Fields& f, const ControlDefaults& defaults) {
  if (f.size() < 5) return bad_line(line, "a point row needs: point, id, easting, northing, height");
  if (f.size() > 9) return bad_line(line, "too many fields (decimal commas?)");
  if (f[1].empty()) return bad_line(line, "the point has no id");
  ControlFilePoint point{std::string(f[1]), {}, {}, ControlRole::kControl};
  point.sigma_m = {defaults.sigma_plan_m, defaults.sigma_plan_m, defaults.sigma_height_m};
  const auto field = [&](std::size_t i) { return i < f.size() ? f[i] : std::string_view{}; };
  const bool any_sigma = !field(5).empty() || !field(6).empty() || !field(7).empty();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string_view coordinate = f[2 + i], sigma = field(5 + i);
    const auto value = number(coordinate);
    if (!coordinate.empty() && (!value || std::isinf(*value)))
      return bad_line(line, "\"" + std::string(coordinate) + "\" is not a coordinate");
    const bool surveyed = value && std::isfinite(*value);
    const auto sigma_value = number(sigma);
    if (!sigma.empty() && (!sigma_value || !(*sigma_value > 0)))
      return bad_line(line, "\"" + std::string(sigma) + "\" is not a standard deviation: a number above 0, or inf");
    const auto axis = Eigen::Index(i);
    point.position_in_map[axis] = surveyed ? *value : kInfinity;
    if (any_sigma) point.sigma_m[axis] = sigma_value.value_or(kInfinity);
    if (!surveyed) point.sigma_m[axis] = kInfinity;
  }
  const std::string role = lower(field(8));
  if (role != "" && role != "control" && role != "check")
    return bad_line(line, "role \"" + std::string(field(8)) + "\" is neither control nor check");
  if (role == "check") point.role = ControlRole::kCheck;
  return point;
}

Result<ControlFileObservation> csv_observation(int line, const Fields& f, const ControlDefaults& defaults) {
  if (f.size() < 5) return bad_line(line, "an image row needs: image, id, file, x_px, y_px");
  if (f.size() > 6) return bad_line(line, "too many fields (decimal commas?)");
  if (f[1].empty() || f[2].empty()) return bad_line(line, "an image row needs the id of a point and a file");
  const auto x_px = finite_number(f[3]), y_px = finite_number(f[4]);
  if (!x_px || !y_px) return bad_line(line, "x_px and y_px must be numbers");
  ControlFileObservation seen{std::string(f[1]), std::string(f[2]), {*x_px, *y_px}, defaults.sigma_px, line};
  if (f.size() > 5 && !f[5].empty()) {
    const auto sigma_px = finite_number(f[5]);
    if (!sigma_px || !(*sigma_px > 0)) return bad_line(line, "sigma_px must be a number above 0");
    seen.sigma_px = *sigma_px;
  }
  return seen;
}

Result<ControlFile> parse_csv(const std::vector<std::string_view>& lines, const ControlDefaults& defaults) {
  Collector collector(defaults);
  std::string crs;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = int(i) + 1;
    const std::string_view text = trimmed(lines[i]);
    if (lower(text).starts_with(kMark)) {
      const auto comma = text.find(',');
      if (comma != std::string_view::npos) crs = normalised_crs(text.substr(comma + 1));
      if (comma != std::string_view::npos && crs.empty()) return bad_line(line, "not a coordinate system");
    }
    if (text.empty() || text.starts_with('#')) continue;
    const Fields fields = fields_of(text, ',');
    const std::string kind = lower(fields[0]);
    if (kind != "point" && kind != "image" && kind != "covariance")
      return bad_line(line, "a row starts with point, image or covariance");
    if (is_title(fields)) continue;
    if (kind == "covariance") {
      COLLINEA_TRY(collector.add_covariance(line, fields));
    } else if (kind == "point") {
      COLLINEA_TRY(ControlFilePoint point, csv_point(line, fields, defaults));
      COLLINEA_TRY(collector.add_point(line, std::move(point)));
    } else {
      COLLINEA_TRY(ControlFileObservation seen, csv_observation(line, fields, defaults));
      collector.add_observation(std::move(seen));
    }
  }
  return collector.finish(std::move(crs));
}

bool is_csv(const std::vector<std::string_view>& lines) {
  return std::any_of(lines.begin(), lines.end(), [](std::string_view raw) {
    const std::string line = lower(trimmed(raw.substr(0, 64)));
    if (line.starts_with(kMark)) return true;
    const auto comma = line.find(',');
    const std::string_view word = trimmed(std::string_view(line).substr(0, comma));
    return comma != std::string::npos && (word == "point" || word == "image");
  });
}

// Longitude, latitude, height become easting, northing, height in the UTM zone of the first point.
Result<> project_to_utm(ControlFile& control) {
  const auto lat_lon_height = [](const ControlFilePoint& p) {
    return Eigen::Vector3d(p.position_in_map.y(), p.position_in_map.x(), p.position_in_map.z());
  };
  for (const auto& point : control.points)
    if (std::abs(point.position_in_map.y()) > 84 || std::abs(point.position_in_map.x()) > 180)
      return fail(Errc::kBadFormat, "point " + point.name + ": x must be the longitude, y the latitude, in degrees");
  const Eigen::Vector3d origin = lat_lon_height(control.points[0]);
  const std::string crs = utm_crs(origin.x(), origin.y());
  COLLINEA_TRY(const LocalFrame frame, LocalFrame::create(crs, origin.x(), origin.y(), origin.z()));
  for (auto& point : control.points)
    point.position_in_map = frame.map_from_local(frame.local_from_geographic(lat_lon_height(point)));
  control.crs = crs;
  return {};
}

}  // namespace

std::string normalised_crs(std::string_view text) {
  text = trimmed(text);
  const std::string small = lower(text);
  if (small == "wgs84" || small == "wgs 84") return "EPSG:4326";
  if (text.starts_with("+")) return crs_of_proj_string(text);
  if (const auto colon = text.find(':'); colon != std::string_view::npos && colon > 0 && words_of(text).size() == 1) {
    if (small.starts_with("urn:")) return std::string(text);
    std::string code(text);
    for (std::size_t i = 0; i < colon; ++i)
      if (code[i] >= 'a' && code[i] <= 'z') code[i] = char(code[i] - 'a' + 'A');
    return code;
  }
  for (const char* wkt : {"PROJCS[", "PROJCRS[", "COMPD_CS[", "COMPOUNDCRS[", "BOUNDCRS[", "GEOGCS[", "GEOGCRS["})
    if (text.starts_with(wkt)) return std::string(text);
  return crs_of_utm_words(small);
}

Result<ControlFile> parse_control(std::string_view text, const ControlDefaults& defaults) {
  const std::vector<std::string_view> lines = lines_of(text);
  COLLINEA_TRY(ControlFile control, is_csv(lines) ? parse_csv(lines, defaults) : parse_odm(lines, defaults));
  if (is_geographic(control.crs))
    COLLINEA_TRY(project_to_utm(control));
  return control;
}

Result<ControlFile> read_control(const std::filesystem::path& path, const ControlDefaults& defaults) {
  constexpr std::uint64_t kLargest = 64 << 20;
  COLLINEA_TRY(const std::string text, read_file(path, kLargest));
  return parse_control(text, defaults).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

Result<> set_check_points(ControlFile& control, std::span<const std::string> names) {
  for (const std::string& name : names)
    if (std::none_of(control.points.begin(), control.points.end(), [&](const auto& p) { return p.name == name; })) {
      std::string known;
      for (const auto& point : control.points) known += (known.empty() ? "" : ", ") + point.name;
      return fail(Errc::kBadInput, "there is no point \"" + name + "\"; there are: " + known);
    }
  for (auto& point : control.points)
    point.role =
        std::find(names.begin(), names.end(), point.name) != names.end() ? ControlRole::kCheck : ControlRole::kControl;
  return {};
}

}  // namespace collinea
