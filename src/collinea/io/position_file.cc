// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/position_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "collinea/base/file.h"
#include "collinea/block/image_axes.h"
#include "collinea/io/internal/titled_table.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Three = std::array<const char*, 3>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRadians = std::numbers::pi / 180;

constexpr Three kGeographic = {"latitude_deg", "longitude_deg", "height_m"},
                kInMap = {"easting_m", "northing_m", "height_m"},
                kSigmas = {"sigma_east_m", "sigma_north_m", "sigma_height_m"},
                kAngles = {"omega_deg", "phi_deg", "kappa_deg"}, kOfAircraft = {"yaw_deg", "pitch_deg", "roll_deg"},
                kOfCamera = {"camera_yaw_deg", "camera_pitch_deg", "camera_roll_deg"},
                kAngleSigmas = {"sigma_omega_deg", "sigma_phi_deg", "sigma_kappa_deg"},
                kRotationSigmas = {"sigma_yaw_deg", "sigma_pitch_deg", "sigma_roll_deg"};

tl::unexpected<Error> bad_line(int line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

std::string joined(const Three& names) { return std::string(names[0]) + ", " + names[1] + ", " + names[2]; }

// As EXIF writes it: "2024:05:17 10:31:08.25".
std::optional<std::string> date_and_time(std::string_view text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, read = 0;
  double second = 0;
  const std::string terminated(text);
  if (std::sscanf(terminated.c_str(), "%4d%*1[:-]%2d%*1[:-]%2d%*1[ T]%2d:%2d:%lf%n", &year, &month, &day, &hour,
                  &minute, &second, &read) != 6)
    return std::nullopt;
  const std::string_view rest = trimmed(text.substr(static_cast<std::size_t>(read)));
  if ((!rest.empty() && rest != "Z") || year < 0 || month < 1 || month > 12 || day < 1 || day > 31 || hour < 0 ||
      hour > 23 || minute < 0 || minute > 59 || !(second >= 0 && second < 61))
    return std::nullopt;
  char out[400];
  std::snprintf(out, sizeof out, "%04d:%02d:%02d %02d:%02d:%09.6f", year, month, day, hour, minute, second);
  return out;
}

// Turns about the plumb line, the level axis to the right of the heading and the axis of the roll, as turns about east,
// north and the plumb line. The axis of the roll points to the heading, as far up as `rises_deg`. Upright it says
// nothing of the tilt to the sides, which is taken to be known as well as the pitch.
Eigen::Vector3d rotated(const Eigen::Vector3d& sigma_yaw_pitch_roll, double heading_deg, double rises_deg) {
  const double sine = std::sin(heading_deg * kRadians), cosine = std::cos(heading_deg * kRadians);
  const double up = std::sin(rises_deg * kRadians), ahead = std::cos(rises_deg * kRadians);
  const double pitch = sigma_yaw_pitch_roll[1];
  const double sideways = up == 0 ? sigma_yaw_pitch_roll[2] : std::hypot(ahead * sigma_yaw_pitch_roll[2], up * pitch);
  const double about_plumb =
      up == 0 ? sigma_yaw_pitch_roll[0] : std::hypot(sigma_yaw_pitch_roll[0], up * sigma_yaw_pitch_roll[2]);
  return {std::hypot(sine * sideways, cosine * pitch), std::hypot(cosine * sideways, sine * pitch), about_plumb};
}

// The camera looks down, its upper edge lies in front.
AttitudePrior attitude_of_aircraft(const Eigen::Vector3d& yaw_pitch_roll_deg) {
  const auto about = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kRadians, axis));
  };
  const Eigen::Quaterniond ned_from_body = about(yaw_pitch_roll_deg[0], Eigen::Vector3d::UnitZ()) *
                                           about(yaw_pitch_roll_deg[1], Eigen::Vector3d::UnitY()) *
                                           about(yaw_pitch_roll_deg[2], Eigen::Vector3d::UnitX());
  Eigen::Matrix3d world_from_ned, body_from_cam;
  world_from_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  body_from_cam << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d world_from_cam = world_from_ned * ned_from_body.toRotationMatrix() * body_from_cam;
  return attitude_prior(Eigen::Quaterniond(Eigen::Matrix3d(world_from_cam.transpose())));
}

bool has_some(const TitledTable& table, const Three& names) {
  return table.has(names[0]) || table.has(names[1]) || table.has(names[2]);
}
bool has_all(const TitledTable& table, const Three& names) {
  return table.has(names[0]) && table.has(names[1]) && table.has(names[2]);
}

bool is_column(const std::string& name) {
  for (const char* other : {"image", "taken", "sigma_m", "sigma_plan_m", "sigma_attitude_deg"})
    if (name == other) return true;
  for (const Three* three :
       {&kGeographic, &kInMap, &kSigmas, &kAngles, &kOfAircraft, &kOfCamera, &kAngleSigmas, &kRotationSigmas})
    if (std::find(three->begin(), three->end(), name) != three->end()) return true;
  return false;
}

class TableReader {
 public:
  explicit TableReader(TitledTable& table) : table_(table) {}

  Result<> check_titles() const {
    if (!table_.has("image")) return table_.bad_row("the first row must name a column image");
    for (const Three* three : {&kAngles, &kOfAircraft, &kOfCamera})
      if (has_some(table_, *three) && !has_all(table_, *three))
        return table_.bad_row("three columns belong together: " + joined(*three));
    for (const Three* three : {&kGeographic, &kInMap})
      if (table_.has((*three)[0]) != table_.has((*three)[1]))
        return table_.bad_row("columns belong together: " + joined(*three));
    const bool geographic = table_.has(kGeographic[0]), in_map = table_.has(kInMap[0]);
    const bool angles = table_.has(kAngles[0]), rotations = table_.has(kOfAircraft[0]) || table_.has(kOfCamera[0]);
    if (geographic && in_map)
      return table_.bad_row("positions are given by latitude and longitude or by easting and northing, not both");
    if (angles + table_.has(kOfAircraft[0]) + table_.has(kOfCamera[0]) > 1)
      return table_.bad_row("attitudes are given in one form: " + joined(kAngles) + "; " + joined(kOfAircraft) +
                            "; or " + joined(kOfCamera));
    if (!geographic && !in_map && !angles && !rotations)
      return table_.bad_row("no column holds a position (" + joined(kGeographic) + "; " + joined(kInMap) +
                            ") or an attitude (" + joined(kAngles) + ")");
    return check_sigmas(geographic || in_map, angles, rotations);
  }

  Result<> take_row() {
    PositionFileRow row;
    row.image = table_.field("image");
    row.line = table_.line();
    if (row.image.empty()) return table_.bad_row("a row needs the name of an image");
    if (!images_.insert(row.image).second) return table_.bad_row(row.image + " is there twice");
    if (Result<> taken = take_position(row); !taken) return taken;
    if (Result<> taken = take_attitude(row); !taken) return taken;
    if (const std::string_view text = table_.field("taken"); !text.empty()) {
      const auto taken = date_and_time(text);
      if (!taken)
        return table_.bad_row("taken \"" + std::string(text) + "\" is no date and time like 2024:05:17 10:31:08.25");
      row.taken = *taken;
    }
    rows.push_back(std::move(row));
    return {};
  }

  std::vector<PositionFileRow> rows;

 private:
  // Every standard deviation must be of something that the table holds.
  [[nodiscard]] Result<> check_sigmas(bool positions, bool angles, bool rotations) const {
    const auto refuse = [&](std::string_view column) {
      return table_.bad_row("column " + std::string(column) + " is the standard deviation of nothing in this table");
    };
    for (const std::string_view column : {kSigmas[0], kSigmas[1], kSigmas[2], "sigma_m", "sigma_plan_m"})
      if (table_.has(column) && !positions) return refuse(column);
    for (const char* column : kAngleSigmas)
      if (table_.has(column) && !angles) return refuse(column);
    for (const char* column : kRotationSigmas)
      if (table_.has(column) && !rotations) return refuse(column);
    if (table_.has("sigma_attitude_deg") && !angles && !rotations) return refuse("sigma_attitude_deg");
    return {};
  }

  [[nodiscard]] Result<Eigen::Vector3d> three_in(const Three& names) const {
    Eigen::Vector3d values;
    for (int i = 0; i < 3; ++i) {
      COLLINEA_TRY(values[i], table_.number_in(names[static_cast<std::size_t>(i)]));
    }
    return values;
  }
  // The first of the names that says something of each axis counts.
  [[nodiscard]] Result<Eigen::Vector3d> sigmas(const Three& own, std::string_view of_two,
                                               std::string_view of_all) const {
    COLLINEA_TRY(Eigen::Vector3d values, three_in(own));
    COLLINEA_TRY(const double two, table_.number_in(of_two));
    COLLINEA_TRY(const double all, table_.number_in(of_all));
    for (int i = 0; i < 3; ++i) {
      if (std::isnan(values[i]) && i < 2) values[i] = two;
      if (std::isnan(values[i])) values[i] = all;
      if (values[i] <= 0) return table_.bad_row("a standard deviation must be above 0");
    }
    return values;
  }

  Result<> take_position(PositionFileRow& row) const {
    const bool geographic = table_.has(kGeographic[0]);
    COLLINEA_TRY(const Eigen::Vector3d position, three_in(geographic ? kGeographic : kInMap));
    COLLINEA_TRY(row.sigma_m, sigmas(kSigmas, "sigma_plan_m", "sigma_m"));
    if (position.head<2>().array().isNaN().all()) return {};
    if (!position.head<2>().allFinite()) return table_.bad_row("half a position of " + row.image);
    if (geographic && (std::abs(position[0]) > 90 || std::abs(position[1]) > 360))
      return table_.bad_row("there is no such latitude and longitude");
    (geographic ? row.geographic : row.in_map) = position;
    return {};
  }

  Result<> take_attitude(PositionFileRow& row) const {
    const bool of_camera = table_.has(kOfCamera[0]);
    const Three& names = table_.has(kAngles[0]) ? kAngles : of_camera ? kOfCamera : kOfAircraft;
    COLLINEA_TRY(const Eigen::Vector3d angles, three_in(names));
    COLLINEA_TRY(const double all, table_.number_in("sigma_attitude_deg"));
    COLLINEA_TRY(row.sigma_deg, sigmas(&names == &kAngles ? kAngleSigmas : kRotationSigmas, "", "sigma_attitude_deg"));
    if (angles.array().isNaN().all()) return {};
    if (!angles.allFinite()) return table_.bad_row("only a part of the angles of " + row.image);
    if (&names == &kAngles) {
      row.angles = OmegaPhiKappa{angles[0], angles[1], angles[2]};
      return {};
    }
    row.attitude = of_camera ? AttitudePrior{angles[0], angles[1], angles[2]} : attitude_of_aircraft(angles);
    if (!(row.sigma_deg.array() == all).all())  // one for all: about any axes
      row.sigma_deg = rotated(row.sigma_deg, angles[0], of_camera ? angles[1] : 0);
    return {};
  }

  TitledTable& table_;
  std::set<std::string> images_;
};

// Date and time of a second of a week of GPS.
std::string time_of_gps(long week, double second) {
  const double whole = std::floor(second / 86400);
  const long day_of_gps = 7 * week + static_cast<long>(whole);
  const double of_day = second - 86400 * whole;
  // Days since 1 March of the year 0: years that begin in March have their leap day at the end.
  const long days = day_of_gps + 723125;  // 6 January 1980
  const long era = days / 146097, of_era = days % 146097;
  const long year_of_era = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
  const long of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
  const long month = (5 * of_year + 2) / 153, day = of_year - (153 * month + 2) / 5 + 1;
  const long year = 400 * era + year_of_era + (month >= 10);
  char out[64];
  const int hour = static_cast<int>(of_day / 3600), minute = static_cast<int>(of_day / 60) % 60;
  std::snprintf(out, sizeof out, "%04ld:%02ld:%02ld %02d:%02d:%09.6f", year, month < 10 ? month + 3 : month - 9, day,
                hour, minute, of_day - 3600.0 * hour - 60.0 * minute);
  return out;
}

// "12	266532.123	[2137]	  -12,N	  3,E	 75,V	47.6,Lat	16.4,Lon	512.9,Ellh	0.014, 0.013,
// 0.029	50,Q"
Result<PositionFileRow> timestamp_row(int line, std::string_view text) {
  std::string spaced(text);
  for (char& c : spaced)
    if (c == ',' || c == '[' || c == ']') c = ' ';
  const auto words = words_of(spaced);
  constexpr std::size_t kLetters[] = {4, 6, 8, 10, 12, 14};
  constexpr const char* kNames[] = {"N", "E", "V", "Lat", "Lon", "Ellh"};
  bool good = words.size() >= 18;
  for (std::size_t i = 0; good && i < std::size(kLetters); ++i) good = words[kLetters[i]] == kNames[i];
  std::array<double, 18> value{};
  for (const std::size_t i : {0, 1, 2, 3, 5, 7, 9, 11, 13, 15, 16, 17}) {
    const auto read = good ? finite_number(words[i]) : std::nullopt;
    good = read.has_value();
    if (good) value[i] = *read;
  }
  if (!good || value[0] < 0 || value[0] > 1e9 || !(value[1] >= 0 && value[1] < 7 * 86400) ||
      !(value[2] >= 0 && value[2] < 1e5) || !(std::abs(value[9]) < 90) || !(std::abs(value[11]) <= 360) ||
      !(value[15] > 0 && value[16] > 0 && value[17] > 0))
    return bad_line(line,
                    "no line of a timestamp file: number, seconds, [week], N, E, V, Lat, Lon, Ellh and three positive "
                    "standard deviations were expected");
  PositionFileRow row;
  row.number = static_cast<int>(value[0]);
  row.line = line;
  row.geographic = Eigen::Vector3d(value[9], value[11], value[13]);  // the offsets are in them
  row.sigma_m = {value[16], value[15], value[17]};                   // the file tells north first
  row.sigma_deg.setConstant(kNaN);
  row.taken = time_of_gps(static_cast<long>(value[2]), value[1]);
  return row;
}

bool is_timestamp_file(const std::vector<std::string_view>& lines) {
  for (const std::string_view line : lines)
    if (!trimmed(line).empty()) return line.find(",Lat") != line.npos && line.find(",Ellh") != line.npos;
  return false;
}

Result<std::vector<PositionFileRow>> timestamp_rows(const std::vector<std::string_view>& lines) {
  std::vector<PositionFileRow> rows;
  std::map<int, int> line_of;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = static_cast<int>(i) + 1;
    const std::string_view content = trimmed(lines[i]);
    if (content.empty() || content.starts_with('#')) continue;
    COLLINEA_TRY(PositionFileRow row, timestamp_row(line, content));
    if (const auto [before, is_new] = line_of.emplace(row.number, line); !is_new)
      return bad_line(line, "exposure " + std::to_string(row.number) + " is there twice, first in line " +
                                std::to_string(before->second));
    rows.push_back(std::move(row));
  }
  return rows;
}

// "# collinea positions, EPSG:32633"
std::string crs_in(std::string_view comment) {
  constexpr std::string_view kMark = "collinea positions";
  const auto at = comment.find(kMark);
  if (at == comment.npos) return "";
  comment.remove_prefix(at + kMark.size());
  return comment.find_first_of(",;\t") == 0 ? std::string(trimmed(comment.substr(1))) : "";
}

}  // namespace

Result<PositionFile> parse_positions(std::string_view bytes) {
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
  const std::string_view text = converted ? *converted : bytes;
  const auto lines = lines_of(text);
  PositionFile file;
  if (is_timestamp_file(lines)) {
    COLLINEA_TRY(file.rows, timestamp_rows(lines));
    return file;
  }
  for (const std::string_view line : lines)
    if (const std::string_view content = trimmed(line); content.starts_with('#') && file.crs.empty())
      file.crs = crs_in(content);
  COLLINEA_TRY(TitledTable table, TitledTable::parse(text, is_column));
  TableReader reader(table);
  if (Result<> checked = reader.check_titles(); !checked) return tl::unexpected(checked.error());
  while (true) {
    COLLINEA_TRY(const bool more, table.next());
    if (!more) break;
    if (Result<> taken = reader.take_row(); !taken) return tl::unexpected(taken.error());
  }
  if (reader.rows.empty()) return fail(Errc::kBadFormat, "no position found");
  file.rows = std::move(reader.rows);
  return file;
}

Result<PositionFile> read_positions(const std::filesystem::path& path) {
  constexpr std::uint64_t kLargest = 256 << 20;
  COLLINEA_TRY(const std::string text, read_file(path, kLargest));
  return parse_positions(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace collinea
