// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/adjustment_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/block/gnss_vector.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/adjustment_words.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr std::string_view kHead = R"(collinea-adjustment 1
# Measurements and all that is known beforehand, for collinea adjust --import. Metres, pixels, degrees.
# A name with blanks stands in double quotes; - means not given; a # begins a remark.
#   option NAME VALUE                            how it is to be adjusted, as the option --name of adjust does
#   georeference CRS LATITUDE LONGITUDE HEIGHT   position of the frame (x east, y north, z up) on the Earth
#   deflection NORTH EAST                        of the plumb line from the ellipsoid's normal ["]
#   camera NAME WIDTH HEIGHT MODEL [sigmas_after_correction]    size [px]; MODEL: brown or brown_of_measured
#   parameter CAMERA WHICH VALUE HOW [GIVEN]     HOW: fixed, free, or the standard deviation of GIVEN (else of VALUE)
#   image NAME CAMERA
#   pose IMAGE X Y Z OMEGA PHI KAPPA [fixed]     projection centre [m] and angles [deg]
#   taken IMAGE TIME                             when, "2024:05:17 10:31:08.25"
#   position IMAGE X Y Z SX SY SZ                measured position and its standard deviations [m]
#   attitude IMAGE OMEGA PHI KAPPA SX SY SZ      measured attitude; standard deviations about the axes of the frame [deg]
#   lever_arm CAMERA X Y Z SX SY SZ              from the projection centre to the antenna: right, down, forward [m]
#   boresight CAMERA SX SY SZ                    attitudes are off by a turn about the axes of the camera [deg]
#   track NUMBER SX SY SZ DX DY DZ               positions with a shift [m] and a drift in time in common
#   on_track IMAGE NUMBER TIME                   time: from the middle of the track
#   time_offset CAMERA S                         positions are measured later than images [s]
#   velocity IMAGE X Y Z                         of the antenna [m/s]
#                                                their standard deviations: 0 exact or none, - not known
#   control NAME X Y Z SX SY SZ                  surveyed point [m]; standard deviation 0: fixed
#   check NAME X Y Z SX SY SZ                    surveyed point that is only compared [m]
#   control_correlation NAME XY XZ YZ            of its coordinates
#   control_in_map, check_in_map                 the same by easting, northing and height of the georeference's CRS
#                                                a point that is only measured in images, two at least, needs no line
#   ground KIND FROM TO VALUE SIGMA ROLE [SETUP INSTRUMENT_HEIGHT TARGET_HEIGHT]
#                                                measured between control points; KIND: distance, height_difference [m],
#                                                direction, zenith_angle, azimuth [deg]; ROLE: control or check;
#                                                heights [m]
#   vector AXES FROM TO DX DY DZ XX XY XZ YY YZ ZZ ROLE [FROM_HEIGHT TO_HEIGHT]
#                                                of GNSS, with its covariance [m2]; AXES: geocentric, local (east, north,
#                                                up at FROM) or frame; heights of the antennas [m]
#   lies_on SHAPE NAME POINT SIGMA ROLE [AXIS]   SHAPE: plane, line, height; AXIS of a line: sideways, upwards, or both
#   point NUMBER X Y Z                           tie point, approximately [m]
#   measured_control IMAGE NAME COLUMN ROW SIGMA, measured_tie IMAGE NUMBER COLUMN ROW SIGMA
#                                                [px] from the upper-left corner of the image; behind SIGMA may stand
#                                                that of the row, and the correlation of column and row
)";

std::string in_quotes(std::string_view name) {
  const bool plain = !name.empty() && name != "-" && name.find_first_of(" \t\"#") == std::string_view::npos;
  if (plain) return std::string(name);
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

// Line breaks in a definition in words (WKT) mean no more than blanks.
std::string on_one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

// A name in quotes may hold blanks and tabs, but not the end of its line.
Result<> check_name(std::string_view what, std::string_view name) {
  std::string without_tabs(name);
  std::erase(without_tabs, '\t');
  if (!has_control_character(without_tabs)) return {};
  return fail(Errc::kUnsupported, "the name of " + std::string(what) + " \"" + escaped_name(name) +
                                      "\" holds a line break or control character, which an adjustment file cannot "
                                      "hold: rename it");
}

Result<> check_names(const Block& block) {
  for (const auto& [id, camera] : block.cameras) COLLINEA_TRY(check_name("camera", camera.name));
  for (const auto& [id, image] : block.images) {
    COLLINEA_TRY(check_name("image", image.file));
    COLLINEA_TRY(check_name("the time of an image", image.taken));
  }
  for (const auto& [id, point] : block.control) COLLINEA_TRY(check_name("control point", point.name));
  for (const GeodeticObservation& one : block.geodetic) COLLINEA_TRY(check_name("shape", one.name));
  return {};
}

std::string words(const Eigen::Vector3d& v) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += std::isfinite(v[i]) ? " " + exact(v[i]) : " -";
  return text;
}

// Names say which line is meant; those that are taken get a number.
template <class Id, class Things, class Name>
std::map<Id, std::string> unique_names(const Things& things, const Name& name_of) {
  std::map<Id, std::string> names;
  std::set<std::string> taken;
  for (const auto& [id, thing] : things) taken.insert(name_of(thing));
  std::set<std::string> used;
  for (const auto& [id, thing] : things) {
    std::string name = name_of(thing);
    for (int n = 2; name.empty() || used.contains(name); ++n) {
      name = name_of(thing) + "#" + std::to_string(n);
      if (taken.contains(name)) name.clear();
    }
    used.insert(name);
    names[id] = in_quotes(name);
  }
  return names;
}

std::string geodetic_line(const GeodeticObservation& one, const std::map<ControlId, std::string>& names) {
  const char* role = one.role == ControlRole::kCheck ? " check" : " control";
  if (one.is_of_shape())
    return "lies_on " + geodetic_word(std::size_t(one.kind)) + " " +
           in_quotes(one.name.empty() ? std::to_string(one.setup + 1) : one.name) + " " + names.at(one.from) + " " +
           exact(one.sigma) + role +
           (one.kind != GeodeticKind::kOnLine ? "\n"
            : one.axis == 0                   ? " sideways\n"
                                              : " upwards\n");
  const double unit = one.is_angle() ? kDegree : 1;
  std::string text = "ground " + geodetic_word(std::size_t(one.kind)) + " " + names.at(one.from) + " " +
                     names.at(one.to) + " " + exact(one.value / unit) + " " + exact(one.sigma / unit) + role;
  if (one.setup != GeodeticObservation::kNoSetup || one.instrument_height_m != 0 || one.target_height_m != 0)
    text += " " + (one.setup == GeodeticObservation::kNoSetup ? "-" : std::to_string(one.setup)) + " " +
            exact(one.instrument_height_m) + " " + exact(one.target_height_m);
  return text + "\n";
}

// The line of a vector, at the first of its parts.
std::string vector_line(const Block& block, std::size_t first, const std::map<ControlId, std::string>& names) {
  const std::vector<std::uint32_t> parts = with_their_vectors(block, static_cast<std::uint32_t>(first));
  if (parts.front() != first || parts.size() != 3) return "";
  const GeodeticObservation& one = block.geodetic[first];
  const GnssVector vector = vector_of({block.geodetic[parts[0]], block.geodetic[parts[1]], block.geodetic[parts[2]]});
  std::string text = std::string("vector ") + (vector.is_local ? "local " : "frame ") + names.at(one.from) + " " +
                     names.at(one.to) + words(vector.vector);
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column) text += " " + exact(vector.covariance_m2(row, column));
  text += one.role == ControlRole::kCheck ? " check" : " control";
  if (one.instrument_height_m != 0 || one.target_height_m != 0)
    text += " " + exact(one.instrument_height_m) + " " + exact(one.target_height_m);
  return text + "\n";
}

// The fewest digits that read back as the same number of single precision.
std::string as_single(double value, auto&& read_back, float wanted) {
  for (int digits = 6; digits < 17; ++digits) {
    std::string text = fmt::format("{:.{}g}", value, digits);
    if (read_back(number(text).value_or(0)) == wanted) return text;
  }
  return exact(value);
}

std::string words_behind_sigma(double sigma, const PixelShape& shape) {
  if (shape.is_round()) return "";
  const auto ratio_of = [&](double of_row) { return static_cast<float>(of_row / sigma); };
  std::string text = " " + as_single(sigma * shape.row_over_column, ratio_of, shape.row_over_column);
  if (shape.correlation != 0)
    text += " " + as_single(
                      shape.correlation, [](double value) { return static_cast<float>(value); }, shape.correlation);
  return text;
}

void write_camera(const AdjustmentFile& file, CameraId id, const std::string& name, std::string& text) {
  const Camera& camera = file.block.cameras.at(id);
  text += "\ncamera " + name + " " + std::to_string(camera.width_px) + " " + std::to_string(camera.height_px) + " " +
          std::string(name_of(camera.model)) + (file.corrected_cameras.contains(id) ? " sigmas_after_correction" : "") +
          (camera.additional == AdditionalSet::kNone
               ? "\n"
               : " " + std::string(kAdditionalNames[std::size_t(camera.additional)]) + "\n");
  const auto sigmas = file.camera_sigmas.find(id);
  const auto given = file.given_cameras.find(id);
  for (const int param : params_of(camera)) {
    const auto k = std::size_t(param);
    const double sigma = sigmas == file.camera_sigmas.end() ? 0 : sigmas->second[k];
    const bool weighted = sigma > 0 && std::isfinite(sigma);
    text += "parameter " + name + " " + param_name(param) + " " + exact(camera.params[k]) + " ";
    text += weighted ? exact(sigma) : sigma > 0 ? "free" : "fixed";
    if (weighted && given != file.given_cameras.end() && given->second.params[k] != camera.params[k])
      text += " " + exact(given->second.params[k]);
    text += "\n";
  }
}

void write_instruments(const Instruments& instruments, const std::map<CameraId, std::string>& cameras,
                       const std::map<ImageId, std::string>& images, std::string& text) {
  for (const auto& [id, arm] : instruments.lever_arms)
    text += "lever_arm " + cameras.at(id) + words(arm.antenna_in_cam_m) + words(arm.sigma_m) + "\n";
  for (const auto& [id, sigma_rad] : instruments.boresight_sigma_rad)
    text += "boresight " + cameras.at(id) + words(sigma_rad / kDegree) + "\n";
  for (const auto& [id, sigma_s] : instruments.time_offset_sigma_s)
    text += "time_offset " + cameras.at(id) + (std::isfinite(sigma_s) ? " " + exact(sigma_s) : " -") + "\n";
  for (std::size_t t = 0; t < instruments.position_tracks.size(); ++t) {
    const PositionTrack& track = instruments.position_tracks[t];
    text += "track " + std::to_string(t + 1) + words(track.shift_sigma_m) + words(track.drift_sigma_m) + "\n";
    for (const auto& [id, time] : track.time)
      text += "on_track " + images.at(id) + " " + std::to_string(t + 1) + " " + exact(time) + "\n";
  }
  for (const auto& [id, velocity] : instruments.velocity_m_s)
    text += "velocity " + images.at(id) + words(velocity) + "\n";
}

}  // namespace

namespace {

std::string deflection_line(const Georeference& georeference) {
  if (georeference.deflection_north_rad == 0 && georeference.deflection_east_rad == 0) return "";
  constexpr double kArcsecond = kDegree / 3600;
  return "deflection " + exact(georeference.deflection_north_rad / kArcsecond) + " " +
         exact(georeference.deflection_east_rad / kArcsecond) + "\n";
}

}  // namespace

std::string adjustment_file_text(const AdjustmentFile& file) {
  const Block& block = file.block;
  std::string text(kHead);
  if (!file.options.empty()) text += "\n";
  for (const AdjustmentFileOption& one : file.options) text += "option " + one.name + " " + in_quotes(one.value) + "\n";
  if (const auto& georeference = block.georeference)
    text += "\ngeoreference " + in_quotes(on_one_line(georeference->crs)) + " " +
            exact(georeference->origin_latitude_deg) + " " + exact(georeference->origin_longitude_deg) + " " +
            exact(georeference->origin_height_m) + "\n" + deflection_line(*georeference);
  const auto cameras = unique_names<CameraId>(block.cameras, [](const Camera& camera) { return camera.name; });
  const auto images = unique_names<ImageId>(block.images, [](const Image& image) { return image.file; });
  const auto control = unique_names<ControlId>(block.control, [](const ControlPoint& point) { return point.name; });
  for (const auto& [id, name] : cameras) write_camera(file, id, name, text);
  text += "\n";
  for (const auto& [id, image] : block.images) {
    text += "image " + images.at(id) + " " + cameras.at(image.camera) + "\n";
    if (const std::optional<Rigid3> pose = find_pose(block, id)) {
      const OmegaPhiKappa angles = omega_phi_kappa(pose->rotation);
      text += "pose " + images.at(id) + words(centre_of(*pose)) +
              words({angles.omega_deg, angles.phi_deg, angles.kappa_deg}) +
              (file.fixed_images.contains(id) ? " fixed\n" : "\n");
    }
    if (!image.taken.empty()) text += "taken " + images.at(id) + " " + in_quotes(image.taken) + "\n";
    if (image.position)
      text += "position " + images.at(id) + words(image.position->position_in_world) + words(image.position->sigma_m) +
              "\n";
    if (const auto given = file.instruments.attitudes.find(id); given != file.instruments.attitudes.end()) {
      const OmegaPhiKappa angles = omega_phi_kappa(given->second.cam_from_world);
      text += "attitude " + images.at(id) + words({angles.omega_deg, angles.phi_deg, angles.kappa_deg}) +
              words(given->second.sigma_rad / kDegree) + "\n";
    }
  }
  write_instruments(file.instruments, cameras, images, text);
  text += "\n";
  for (const auto& [id, point] : block.control) {
    text += (point.role == ControlRole::kCheck ? "check " : "control ") + control.at(id) +
            words(point.position_in_world) + words(point.sigma_m) + "\n";
    if (!point.correlation.isZero(0)) text += "control_correlation " + control.at(id) + words(point.correlation) + "\n";
  }
  for (std::size_t i = 0; i < block.geodetic.size(); ++i)
    text += block.geodetic[i].kind == GeodeticKind::kGnssVector ? vector_line(block, i, control)
                                                                : geodetic_line(block.geodetic[i], control);
  for (const auto& [id, point] : block.points)
    text += "point " + std::to_string(id.value) + words(point.position_in_world) + "\n";
  text += "\n";
  const auto measured = [&](const char* how, ImageId image, const std::string& point, const Eigen::Vector2d& pixel,
                            double sigma, const PixelShape& shape) {
    text += how + images.at(image) + " " + point + " " + exact(pixel.x()) + " " + exact(pixel.y()) + " " +
            exact(sigma) + words_behind_sigma(sigma, shape) + "\n";
  };
  for (const ControlObservation& seen : block.control_observations)
    measured("measured_control ", seen.image, control.at(seen.point), seen.pixel, seen.sigma_px, seen.shape);
  for (const Observation& seen : block.observations)
    measured("measured_tie ", seen.image, std::to_string(seen.point.value), seen.pixel, seen.sigma_px, seen.shape);
  return text;
}

Result<> write_adjustment_file(const std::filesystem::path& path, const AdjustmentFile& file) {
  COLLINEA_TRY(check_names(file.block));
  return write_file(path, adjustment_file_text(file));
}

}  // namespace collinea
