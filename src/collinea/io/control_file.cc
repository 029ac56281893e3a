// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/control_file.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/io/internal/control_formats.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

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
  for (auto& point : control.points) {
    point.position_in_map = frame.map_from_local(frame.local_from_geographic(lat_lon_height(point)));
    if (!point.position_in_map.allFinite())
      return fail(Errc::kBadFormat, "point " + point.name + " lies too far from point " + control.points[0].name +
                                        " for one map: x must be the longitude, y the latitude, in degrees");
  }
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

Result<ControlFile> parse_control(std::string_view bytes, const ControlDefaults& defaults) {
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
  const std::string_view text = converted ? *converted : bytes;
  const auto formats = control_formats();
  const auto format = std::find_if(formats.begin(), formats.end() - 1,
                                   [&](const ControlFormat& candidate) { return candidate.recognises(text); });
  COLLINEA_TRY(ControlFile control, format->parse(text, defaults));
  if (is_geographic(control.crs)) COLLINEA_TRY(project_to_utm(control));
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
