// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/block/survey_covariance.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/adjustment_draft.h"
#include "collinea/io/internal/adjustment_line.h"
#include "collinea/io/internal/adjustment_words.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Line = AdjustmentLine;
using Draft = AdjustmentDraft;
using GeodeticLine = AdjustmentDraft::GeodeticLine;

// Coordinates with standard deviations behind them; what is not given is NaN and infinite.
Result<> given3(const Line& line, std::size_t i, Eigen::Vector3d& position, Eigen::Vector3d& sigma) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = Eigen::Index(k);
    const bool no_value = line.words[i + k] == "-";
    COLLINEA_TRY(sigma[axis], deviation(line, i + 3 + k));
    if (no_value && std::isfinite(sigma[axis]))
      return bad_line(line.number, "a coordinate is not given (-), but its standard deviation is: write - for it too");
    position[axis] = std::numeric_limits<double>::quiet_NaN();
    if (!no_value) {
      COLLINEA_TRY(position[axis], finite(line, i + k, "a coordinate"));
    }
  }
  return {};
}

Result<ImageId> image_named(const Line& line, const std::string& name, const Draft& draft) {
  const auto known = draft.images.find(name);
  if (known == draft.images.end())
    return bad_line(line.number, "there is no image " + shown(name) + " above: add a line image " + name + " CAMERA");
  return known->second;
}

Result<CameraId> camera_named(const Line& line, const std::string& name, const Draft& draft) {
  const auto known = draft.cameras.find(name);
  if (known == draft.cameras.end()) return bad_line(line.number, "there is no camera " + shown(name) + " above");
  return known->second;
}

Result<> take_of_camera(const Line& line, Draft& draft) {
  COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[1], draft));
  if (line.words[0] == "lever_arm") return draft.instruments.take_lever_arm(line, camera);
  if (line.words[0] == "boresight") return draft.instruments.take_boresight(line, camera);
  return draft.instruments.take_time_offset(line, camera);
}

Result<> take_of_image(const Line& line, Draft& draft) {
  COLLINEA_TRY(const ImageId image, image_named(line, line.words[1], draft));
  if (line.words[0] == "attitude") return draft.instruments.take_attitude(line, image);
  if (line.words[0] == "velocity") return draft.instruments.take_velocity(line, image);
  return draft.instruments.take_on_track(line, image);
}

Result<> take_track(const Line& line, Draft& draft) { return draft.instruments.take_track(line); }

Result<> take_time(const Line& line, Draft& draft) {
  COLLINEA_TRY(const ImageId image, image_named(line, line.words[1], draft));
  std::string& taken = draft.file.block.images[image].taken;
  if (!taken.empty()) return bad_line(line.number, "a second time of " + shown(line.words[1]));
  taken = line.words[2];
  if (taken.empty()) return bad_line(line.number, "a time is missing");
  return {};
}

Result<> take_role(const Line& line, std::size_t i, GeodeticObservation& one) {
  if (line.words[i] != "control" && line.words[i] != "check")
    return bad_line(line.number, shown(line.words[i]) + " is no role: control or check");
  if (line.words[i] == "check") one.role = ControlRole::kCheck;
  return {};
}

// Shapes of one kind are numbered in the order of the file.
Result<> take_shape(const Line& line, Draft& draft) {
  constexpr GeodeticKind kKinds[] = {GeodeticKind::kOnPlane, GeodeticKind::kOnLine, GeodeticKind::kAtHeight};
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                 [&](GeodeticKind one) { return line.words[1] == geodetic_word(std::size_t(one)); });
  if (kind == std::end(kKinds))
    return bad_line(line.number, shown(line.words[1]) + " is no shape; there are: plane line height");
  auto& numbers = draft.shapes[*kind];
  GeodeticLine geodetic{line.number, line.words[3], line.words[3], {.kind = *kind, .name = line.words[2]}};
  GeodeticObservation& one = geodetic.measured;
  one.setup = numbers.try_emplace(line.words[2], std::uint32_t(numbers.size())).first->second;
  COLLINEA_TRY(one.sigma, finite(line, 4, "a standard deviation"));
  if (!(one.sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0");
  COLLINEA_TRY(take_role(line, 5, one));
  const std::string axis = line.count() > 5 ? line.words[6] : "";
  if ((axis != "" && axis != "sideways" && axis != "upwards") || (axis != "" && *kind != GeodeticKind::kOnLine))
    return bad_line(line.number, "behind the role stands nothing, or of a line sideways or upwards");
  if (axis != "upwards") draft.geodetic.push_back(geodetic);
  geodetic.measured.axis = 1;
  if (*kind == GeodeticKind::kOnLine && axis != "sideways") draft.geodetic.push_back(geodetic);
  return {};
}

Result<> take_option(const Line& line, Draft& draft) {
  std::string name = line.words[1];
  std::replace(name.begin(), name.end(), '-', '_');  // as it is typed
  auto& options = draft.file.options;
  const auto before = std::find_if(options.begin(), options.end(), [&](const auto& one) { return one.name == name; });
  if (before != options.end())
    return bad_line(line.number, "a second option " + name + ", before in line " + std::to_string(before->line));
  options.push_back({name, line.words[2], line.number});
  return {};
}

Result<> take_georeference(const Line& line, Draft& draft) {
  if (draft.file.block.georeference) return bad_line(line.number, "a second georeference; there can be one");
  Georeference georeference{.crs = line.words[1]};
  COLLINEA_TRY(georeference.origin_latitude_deg, finite(line, 2, "a latitude"));
  COLLINEA_TRY(georeference.origin_longitude_deg, finite(line, 3, "a longitude"));
  COLLINEA_TRY(georeference.origin_height_m, finite(line, 4, "a height"));
  if (std::abs(georeference.origin_latitude_deg) > 90 || std::abs(georeference.origin_longitude_deg) > 360)
    return bad_line(line.number, "no such latitude and longitude: degrees are expected, latitude first");
  draft.file.block.georeference = std::move(georeference);
  return {};
}

Result<> take_deflection(const Line& line, Draft& draft) {
  if (draft.deflection_rad) return bad_line(line.number, "a second deflection");
  Eigen::Vector2d seconds;
  COLLINEA_TRY(seconds[0], finite(line, 1, "a deflection"));
  COLLINEA_TRY(seconds[1], finite(line, 2, "a deflection"));
  if (seconds.cwiseAbs().maxCoeff() > 300)
    return bad_line(line.number, "no plumb line is deflected by more than 300 seconds of arc");
  draft.deflection_rad = {line.number, seconds * (kDegree / 3600)};
  return {};
}

std::string listed(std::span<const std::string_view> names) {
  std::string text;
  for (const auto one : names) text += " " + std::string(one);
  return text;
}

Result<> take_camera(const Line& line, Draft& draft) {
  const std::string& name = line.words[1];
  if (draft.cameras.contains(name)) return bad_line(line.number, "a second camera " + shown(name));
  Camera camera;
  const auto size = [&](std::size_t i) { return integer(line.words[i]).value_or(0); };
  constexpr std::int64_t kWidest = 1'000'000;
  if (size(2) < 1 || size(3) < 1 || size(2) > kWidest || size(3) > kWidest)
    return bad_line(line.number, "width and height of an image are whole numbers of pixels above 0");
  camera.width_px = int(size(2));
  camera.height_px = int(size(3));
  camera.name = name;
  camera.prior.source = Provenance::kGiven;
  camera.params[Camera::kCx] = camera.width_px / 2.0;
  camera.params[Camera::kCy] = camera.height_px / 2.0;
  const auto model = model_named(line.words[4]);
  if (!model)
    return bad_line(line.number, shown(line.words[4]) +
                                     " is no model of cameras; there are:" + listed(std::span(kCameraModelNames)));
  camera.model = *model;
  const CameraId id{std::uint32_t(draft.cameras.size())};
  if (line.count() > 4) {
    const auto set = std::find(kAdditionalNames.begin() + 1, kAdditionalNames.end(), line.words[5]);
    if (set != kAdditionalNames.end()) {
      camera.additional = AdditionalSet(set - kAdditionalNames.begin());
    } else if (line.words[5] == "sigmas_after_correction" && is<BrownOfMeasured>(camera.model)) {
      draft.file.corrected_cameras.insert(id);
    } else {
      return bad_line(line.number, "behind the model stands nothing, a set of additional parameters (" +
                                       listed(std::span(kAdditionalNames).subspan(1)).substr(1) +
                                       "), or of brown_of_measured sigmas_after_correction");
    }
  }
  draft.cameras[name] = id;
  draft.file.block.cameras[id] = camera;
  draft.file.given_cameras[id] = camera;
  draft.file.camera_sigmas[id].fill(0);
  return {};
}

Result<> take_parameter(const Line& line, Draft& draft) {
  COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[1], draft));
  const Camera& described = draft.file.block.cameras.at(camera);
  const auto param = param_named(described, line.words[2]);
  if (!param) {
    std::string known;
    for (const int one : params_of(described)) known += " " + param_name(one);
    return bad_line(line.number, shown(line.words[2]) + " is no parameter of this camera; there are:" + known);
  }
  const auto k = std::size_t(*param);
  if (!draft.parameters.emplace(camera, k).second)
    return bad_line(line.number, line.words[2] + " of camera " + line.words[1] + " is given twice");
  COLLINEA_TRY(const double value, finite(line, 3, "a value"));
  if (k == Camera::kF && !(value > 0)) return bad_line(line.number, "a focal length is above 0 [px]");
  double sigma = 0, given = value;
  if (line.words[4] == "free") {
    sigma = kInfinity;
  } else if (line.words[4] != "fixed") {
    const auto deviation = number(line.words[4]);
    if (!deviation || !(*deviation > 0) || std::isinf(*deviation))
      return bad_line(line.number, shown(line.words[4]) + " says not how the parameter takes part: fixed, free, or a " +
                                       "standard deviation above 0" + number_hint(line.words[4]));
    sigma = *deviation;
  }
  if (line.count() > 4) {
    if (!std::isfinite(sigma) || sigma == 0)
      return bad_line(line.number, "a given value belongs to a standard deviation, not to fixed or free");
    COLLINEA_TRY(given, finite(line, 5, "a given value"));
  }
  draft.file.block.cameras[camera].params[k] = value;
  draft.file.given_cameras[camera].params[k] = given;
  draft.file.camera_sigmas[camera][k] = sigma;
  return {};
}

Result<> take_image(const Line& line, Draft& draft) {
  COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[2], draft));
  const ImageId id{std::uint32_t(draft.images.size())};
  if (line.words[1].empty()) return bad_line(line.number, "an image needs a name");
  if (!draft.images.emplace(line.words[1], id).second)
    return bad_line(line.number, "a second image " + shown(line.words[1]));
  draft.file.block.images[id] = {.file = line.words[1], .camera = camera};
  return {};
}

Result<> take_pose(const Line& line, Draft& draft) {
  COLLINEA_TRY(const ImageId image, image_named(line, line.words[1], draft));
  COLLINEA_TRY(const Eigen::Vector3d centre, finite3(line, 2, "a coordinate"));
  COLLINEA_TRY(const Eigen::Vector3d angles, finite3(line, 5, "an angle"));
  if (line.count() > 7) {
    if (line.words[8] != "fixed") return bad_line(line.number, "behind kappa stands fixed or nothing");
    draft.file.fixed_images.insert(image);
  }
  const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{angles[0], angles[1], angles[2]});
  if (is_oriented(draft.file.block, image)) return bad_line(line.number, "a second pose of " + shown(line.words[1]));
  set_pose(draft.file.block, image, {rotation, -(rotation * centre)});
  return {};
}

Result<> take_position(const Line& line, Draft& draft) {
  COLLINEA_TRY(const ImageId image, image_named(line, line.words[1], draft));
  if (draft.file.block.images[image].position)
    return bad_line(line.number, "a second position of " + shown(line.words[1]));
  PositionPrior prior{};
  COLLINEA_TRY(given3(line, 2, prior.position_in_world, prior.sigma_m));
  if (!(prior.sigma_m.minCoeff() > 0))
    return bad_line(line.number,
                    "a measured position has standard deviations above 0; to hold the image, write "
                    "fixed behind its pose");
  draft.file.block.images[image].position = prior;
  return {};
}

Result<> take_control(const Line& line, Draft& draft) {
  const std::string& name = line.words[1];
  if (name.empty()) return bad_line(line.number, "a point needs a name");
  ControlPoint point{.name = name,
                     .role = line.words[0].starts_with("check") ? ControlRole::kCheck : ControlRole::kControl,
                     .position_in_map = {},
                     .position_in_world = {},
                     .sigma_m = {}};
  const ControlId id{std::uint32_t(draft.control.size())};
  if (!draft.control.emplace(name, id).second) return bad_line(line.number, "a second point " + shown(name));
  COLLINEA_TRY(given3(line, 2, point.position_in_world, point.sigma_m));
  if (line.words[0].ends_with("_in_map")) {
    if (!point.position_in_world.allFinite())
      return bad_line(line.number,
                      "a point of a map needs all three coordinates, at least roughly (- for the standard deviation "
                      "of those that are not given): the height of the frame depends on the position");
    draft.in_map.emplace_back(line.number, id);
  }
  draft.file.block.control[id] = std::move(point);
  return {};
}

Result<> take_correlation(const Line& line, Draft& draft) {
  const auto known = draft.control.find(line.words[1]);
  if (known == draft.control.end())
    return bad_line(line.number, "there is no point " + shown(line.words[1]) + " above this line");
  ControlPoint& point = draft.file.block.control.at(known->second);
  for (std::size_t i = 0; i < 3; ++i) {
    COLLINEA_TRY(point.correlation[Eigen::Index(i)], finite(line, 2 + i, "a correlation"));
  }
  if (!survey_weight(point.sigma_m, point.correlation))
    return bad_line(line.number, "these are the correlations of no covariance: it has to be positive definite");
  return {};
}

Result<> take_geodetic(const Line& line, Draft& draft) {
  std::size_t kind = kGeodeticKinds;
  std::string known;
  for (std::size_t k = 0; k < kGeodeticKinds; ++k) {
    if (GeodeticObservation{.kind = GeodeticKind(k)}.is_of_shape()) continue;  // these have lines of their own
    if (GeodeticKind(k) == GeodeticKind::kGnssVector) continue;
    known += " " + geodetic_word(k);
    if (line.words[1] == geodetic_word(k)) kind = k;
  }
  if (kind == kGeodeticKinds) {
    return bad_line(line.number, shown(line.words[1]) + " is measured by nobody; there are:" + known);
  }
  if (line.count() != 6 && line.count() != 9)
    return bad_line(line.number,
                    "behind the role stand set-up, height of the instrument and of the target, or nothing");
  GeodeticLine geodetic{line.number, line.words[2], line.words[3], {.kind = GeodeticKind(kind)}};
  GeodeticObservation& one = geodetic.measured;
  const double unit = one.is_angle() ? kDegree : 1;
  COLLINEA_TRY(one.value, finite(line, 4, "a value"));
  COLLINEA_TRY(one.sigma, finite(line, 5, "a standard deviation"));
  if (!(one.sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0");
  if (kind == std::size_t(GeodeticKind::kDistance) && !(one.value > 0))
    return bad_line(line.number, "a distance is above 0 [m]");
  one.value *= unit, one.sigma *= unit;
  COLLINEA_TRY(take_role(line, 6, one));
  if (geodetic.from == geodetic.to) return bad_line(line.number, "a measurement from a point to itself");
  if (line.count() > 6) {
    if (line.words[7] != "-") {
      const auto setup = integer(line.words[7]);
      if (!setup || *setup < 0 || *setup >= std::int64_t(GeodeticObservation::kNoSetup))
        return bad_line(line.number, shown(line.words[7]) + " is no set-up: a whole number from 0, or -");
      one.setup = std::uint32_t(*setup);
    }
    COLLINEA_TRY(one.instrument_height_m, finite(line, 8, "a height"));
    COLLINEA_TRY(one.target_height_m, finite(line, 9, "a height"));
  }
  if (one.kind == GeodeticKind::kDirection && one.setup == GeodeticObservation::kNoSetup)
    return bad_line(line.number, "a direction belongs to a set-up: the instrument's orientation is found for each");
  draft.geodetic.push_back(std::move(geodetic));
  return {};
}

// vector AXES FROM TO DX DY DZ XX XY XZ YY YZ ZZ ROLE [FROM_HEIGHT TO_HEIGHT]
Result<> take_vector(const Line& line, Draft& draft) {
  const std::string& axes = line.words[1];
  if (axes != "geocentric" && axes != "local" && axes != "frame")
    return bad_line(line.number, shown(axes) + " are no axes of a vector: geocentric, local or frame");
  GeodeticLine geodetic{line.number, line.words[2], line.words[3], {.kind = GeodeticKind::kGnssVector}};
  if (geodetic.from == geodetic.to) return bad_line(line.number, "a measurement from a point to itself");
  geodetic.is_geocentric = axes == "geocentric";
  geodetic.vector.is_local = axes == "local";
  COLLINEA_TRY(geodetic.vector.vector, finite3(line, 4, "a coordinate"));
  std::size_t next = 7;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column, ++next) {
      COLLINEA_TRY(const double value, finite(line, next, "a covariance"));
      geodetic.vector.covariance_m2(row, column) = geodetic.vector.covariance_m2(column, row) = value;
    }
  if (!observations_of(geodetic.vector, {}))
    return bad_line(line.number, "this is no covariance of a vector: it has to be positive definite [m2]");
  COLLINEA_TRY(take_role(line, 13, geodetic.measured));
  if (line.count() == 14)
    return bad_line(line.number, "behind the role stand the heights of both antennas, or nothing");
  if (line.count() > 14) {
    COLLINEA_TRY(geodetic.measured.instrument_height_m, finite(line, 14, "a height"));
    COLLINEA_TRY(geodetic.measured.target_height_m, finite(line, 15, "a height"));
  }
  draft.geodetic.push_back(std::move(geodetic));
  return {};
}

std::optional<PointId> point_numbered(std::string_view word) {
  const auto value = integer(word);
  if (!value || *value < 0 || *value >= std::int64_t(PointId::kNone)) return std::nullopt;
  return PointId{std::uint32_t(*value)};
}

Result<> take_point(const Line& line, Draft& draft) {
  const auto id = point_numbered(line.words[1]);
  if (!id)
    return bad_line(line.number, shown(line.words[1]) +
                                     " is no number of a tie point: a whole number from 0 is "
                                     "expected; points with names are control or check");
  COLLINEA_TRY(const Eigen::Vector3d position, finite3(line, 2, "a coordinate"));
  if (!draft.file.block.points.emplace(*id, TiePoint{position, {}}).second)
    return bad_line(line.number, "a second tie point " + line.words[1]);
  return {};
}

// The standard deviation of the row and the correlation, where they stand behind that of the column.
Result<PixelShape> shape_behind(const Line& line, double sigma) {
  PixelShape shape;
  if (line.count() > 5) {
    COLLINEA_TRY(const double of_row, finite(line, 6, "a standard deviation of the row"));
    shape.row_over_column = static_cast<float>(of_row / sigma);
  }
  if (line.count() > 6) {
    COLLINEA_TRY(const double correlation, finite(line, 7, "a correlation"));
    shape.correlation = static_cast<float>(correlation);
  }
  if (!shape.is_valid())
    return bad_line(line.number,
                    "this is no covariance of a measurement: standard deviations are above 0 [px], the correlation "
                    "is between -1 and 1");
  return shape;
}

Result<> take_measured(const Line& line, Draft& draft) {
  COLLINEA_TRY(const ImageId image, image_named(line, line.words[1], draft));
  Eigen::Vector2d pixel;
  COLLINEA_TRY(pixel.x(), finite(line, 3, "a column"));
  COLLINEA_TRY(pixel.y(), finite(line, 4, "a row"));
  COLLINEA_TRY(const double sigma, finite(line, 5, "a standard deviation"));
  if (!(sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0 [px]");
  COLLINEA_TRY(const PixelShape shape, shape_behind(line, sigma));
  if (line.words[0] == "measured_control") {
    draft.measured.push_back({line.number, image, line.words[2], pixel, sigma, shape});
    return {};
  }
  const auto id = point_numbered(line.words[2]);
  if (!id)
    return bad_line(line.number, shown(line.words[2]) +
                                     " is no number of a tie point: a whole number from 0 is "
                                     "expected; points with names are measured_control");
  draft.ties.push_back({line.number, {image, *id, 0, pixel, sigma, shape}});
  return {};
}

// The separator that the words seem to have in place of blanks.
std::string hint_of(const Line& line) {
  for (const std::string& word : line.words)
    if (std::string hint = separator_hint(word, ' '); !hint.empty()) return hint;
  return {};
}

struct Rule {
  std::string_view keyword, form;
  std::size_t least, most;
  Result<> (*take)(const Line&, Draft&);
};

}  // namespace

Result<> take_adjustment_line(const AdjustmentLine& line, AdjustmentDraft& draft) {
  static constexpr Rule kRules[] = {
      {"option", "NAME VALUE", 2, 2, take_option},
      {"georeference", "CRS LATITUDE LONGITUDE HEIGHT", 4, 4, take_georeference},
      {"deflection", "NORTH EAST", 2, 2, take_deflection},
      {"camera", "NAME WIDTH HEIGHT MODEL [sigmas_after_correction]", 4, 5, take_camera},
      {"parameter", "CAMERA WHICH VALUE fixed|free|SIGMA [GIVEN]", 4, 5, take_parameter},
      {"image", "NAME CAMERA", 2, 2, take_image},
      {"pose", "IMAGE X Y Z OMEGA PHI KAPPA [fixed]", 7, 8, take_pose},
      {"taken", "IMAGE TIME", 2, 2, take_time},
      {"position", "IMAGE X Y Z SX SY SZ", 7, 7, take_position},
      {"attitude", "IMAGE OMEGA PHI KAPPA SX SY SZ", 7, 7, take_of_image},
      {"lever_arm", "CAMERA X Y Z SX SY SZ", 7, 7, take_of_camera},
      {"boresight", "CAMERA SX SY SZ", 4, 4, take_of_camera},
      {"track", "NUMBER SX SY SZ DX DY DZ", 7, 7, take_track},
      {"on_track", "IMAGE NUMBER TIME", 3, 3, take_of_image},
      {"time_offset", "CAMERA S", 2, 2, take_of_camera},
      {"velocity", "IMAGE X Y Z", 4, 4, take_of_image},
      {"control", "NAME X Y Z SX SY SZ", 7, 7, take_control},
      {"check", "NAME X Y Z SX SY SZ", 7, 7, take_control},
      {"control_correlation", "NAME XY XZ YZ", 4, 4, take_correlation},
      {"control_in_map", "NAME EASTING NORTHING HEIGHT SX SY SZ", 7, 7, take_control},
      {"check_in_map", "NAME EASTING NORTHING HEIGHT SX SY SZ", 7, 7, take_control},
      {"lies_on", "plane|line|height NAME POINT SIGMA ROLE [sideways|upwards]", 5, 6, take_shape},
      {"ground", "KIND FROM TO VALUE SIGMA ROLE [SETUP INSTRUMENT_HEIGHT TARGET_HEIGHT]", 6, 9, take_geodetic},
      {"vector", "geocentric|local|frame FROM TO DX DY DZ XX XY XZ YY YZ ZZ ROLE [FROM_HEIGHT TO_HEIGHT]", 13, 15,
       take_vector},
      {"point", "NUMBER X Y Z", 4, 4, take_point},
      {"measured_control", "IMAGE NAME COLUMN ROW SIGMA [SIGMA_ROW [CORRELATION]]", 5, 7, take_measured},
      {"measured_tie", "IMAGE NUMBER COLUMN ROW SIGMA [SIGMA_ROW [CORRELATION]]", 5, 7, take_measured},
  };
  for (const Rule& rule : kRules) {
    if (line.words[0] != rule.keyword) continue;
    if (line.count() < rule.least || line.count() > rule.most)
      return bad_line(line.number, std::string(rule.keyword) + " has " + std::to_string(line.count()) +
                                       " words behind it; expected: " + std::string(rule.keyword) + " " +
                                       std::string(rule.form) + hint_of(line));
    return rule.take(line, draft);
  }
  std::string known;
  for (const Rule& rule : kRules) known += (known.empty() ? "" : ", ") + std::string(rule.keyword);
  return bad_line(line.number,
                  shown(line.words[0]) + " is no keyword" + hint_of(line) + "; a line begins with one of " + known);
}

}  // namespace collinea
