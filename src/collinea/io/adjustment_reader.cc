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
#include "collinea/block/world_frame.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/adjustment_instruments.h"
#include "collinea/io/adjustment_line.h"
#include "collinea/io/adjustment_words.h"
#include "collinea/io/observation_order.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Line = AdjustmentLine;

Result<Line> taken_apart(std::size_t number, std::string_view text) {
  Line line{number, {}};
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == ' ' || text[i] == '\t') {
      ++i;
    } else if (text[i] == '#') {
      break;
    } else if (text[i] == '"') {
      std::string word;
      for (++i;; ++i) {
        if (i >= text.size()) return bad_line(number, "a name in quotes does not end; its closing \" is missing");
        if (text[i] == '"' && !(i + 1 < text.size() && text[i + 1] == '"')) break;
        if (text[i] == '"') ++i;
        word += text[i];
      }
      ++i;
      line.words.push_back(std::move(word));
    } else {
      const auto end = std::min(text.find_first_of(" \t", i), text.size());
      line.words.emplace_back(text.substr(i, end - i));
      i = end;
    }
  }
  return line;
}

class Parser {
 public:
  Result<AdjustmentFile> parse(std::string_view text) {
    const std::vector<std::string_view> lines = lines_of(text);
    bool titled = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      COLLINEA_TRY(const Line line, taken_apart(i + 1, lines[i]));
      if (line.words.empty()) continue;
      if (!titled) {
        if (line.words[0] != kAdjustmentTitle)
          return bad_line(line.number, "the file does not begin with \"collinea-adjustment 1\": it is none of ours");
        if (line.words.size() != 2 || line.words[1] != "1")
          return bad_line(line.number,
                          "only version 1 of collinea-adjustment is known here: a newer program is needed");
        titled = true;
        continue;
      }
      if (Result<> taken = take(line); !taken) return tl::unexpected(taken.error());
    }
    if (!titled) return fail(Errc::kBadFormat, "the file is empty: it should begin with \"collinea-adjustment 1\"");
    return finish(lines.size());
  }

 private:
  struct Rule {
    std::string_view keyword, form;
    std::size_t least, most;
    Result<> (Parser::*take)(const Line&);
  };

  Result<> take(const Line& line) {
    static constexpr Rule kRules[] = {
        {"georeference", "CRS LATITUDE LONGITUDE HEIGHT", 4, 4, &Parser::take_georeference},
        {"camera", "NAME WIDTH HEIGHT MODEL [sigmas_after_correction]", 4, 5, &Parser::take_camera},
        {"parameter", "CAMERA WHICH VALUE fixed|free|SIGMA [GIVEN]", 4, 5, &Parser::take_parameter},
        {"image", "NAME CAMERA", 2, 2, &Parser::take_image},
        {"pose", "IMAGE X Y Z OMEGA PHI KAPPA [fixed]", 7, 8, &Parser::take_pose},
        {"taken", "IMAGE TIME", 2, 2, &Parser::take_time},
        {"position", "IMAGE X Y Z SX SY SZ", 7, 7, &Parser::take_position},
        {"attitude", "IMAGE OMEGA PHI KAPPA SX SY SZ", 7, 7, &Parser::take_of_image},
        {"lever_arm", "CAMERA X Y Z SX SY SZ", 7, 7, &Parser::take_of_camera},
        {"boresight", "CAMERA SX SY SZ", 4, 4, &Parser::take_of_camera},
        {"track", "NUMBER SX SY SZ DX DY DZ", 7, 7, &Parser::take_track},
        {"on_track", "IMAGE NUMBER TIME", 3, 3, &Parser::take_of_image},
        {"time_offset", "CAMERA S", 2, 2, &Parser::take_of_camera},
        {"velocity", "IMAGE X Y Z", 4, 4, &Parser::take_of_image},
        {"control", "NAME X Y Z SX SY SZ", 7, 7, &Parser::take_control},
        {"check", "NAME X Y Z SX SY SZ", 7, 7, &Parser::take_control},
        {"control_correlation", "NAME XY XZ YZ", 4, 4, &Parser::take_correlation},
        {"control_in_map", "NAME EASTING NORTHING HEIGHT SX SY SZ", 7, 7, &Parser::take_control},
        {"check_in_map", "NAME EASTING NORTHING HEIGHT SX SY SZ", 7, 7, &Parser::take_control},
        {"lies_on", "plane|line|height NAME POINT SIGMA ROLE [sideways|upwards]", 5, 6, &Parser::take_shape},
        {"ground", "KIND FROM TO VALUE SIGMA ROLE [SETUP INSTRUMENT_HEIGHT TARGET_HEIGHT]", 6, 9, &Parser::take_ground},
        {"point", "NUMBER X Y Z", 4, 4, &Parser::take_point},
        {"measured_control", "IMAGE NAME COLUMN ROW SIGMA", 5, 5, &Parser::take_measured},
        {"measured_tie", "IMAGE NUMBER COLUMN ROW SIGMA", 5, 5, &Parser::take_measured},
    };
    for (const Rule& rule : kRules) {
      if (line.words[0] != rule.keyword) continue;
      if (line.count() < rule.least || line.count() > rule.most)
        return bad_line(line.number, std::string(rule.keyword) + " has " + std::to_string(line.count()) +
                                         " words behind it; expected: " + std::string(rule.keyword) + " " +
                                         std::string(rule.form));
      return (this->*rule.take)(line);
    }
    std::string known;
    for (const Rule& rule : kRules) known += (known.empty() ? "" : ", ") + std::string(rule.keyword);
    return bad_line(line.number, shown(line.words[0]) + " is no keyword; a line begins with one of " + known);
  }

  // Coordinates with standard deviations behind them; what is not given is NaN and infinite.
  static Result<> given3(const Line& line, std::size_t i, Eigen::Vector3d& place, Eigen::Vector3d& sigma) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = Eigen::Index(k);
      const bool no_value = line.words[i + k] == "-";
      COLLINEA_TRY(sigma[axis], deviation(line, i + 3 + k));
      if (no_value && std::isfinite(sigma[axis]))
        return bad_line(line.number,
                        "a coordinate is not given (-), but its standard deviation is: write - for it too");
      place[axis] = std::numeric_limits<double>::quiet_NaN();
      if (!no_value) {
        COLLINEA_TRY(place[axis], finite(line, i + k, "a coordinate"));
      }
    }
    return {};
  }

  Result<ImageId> image_named(const Line& line, const std::string& name) const {
    const auto known = images_.find(name);
    if (known == images_.end())
      return bad_line(line.number, "there is no image " + shown(name) + " above: add a line image " + name + " CAMERA");
    return known->second;
  }

  Result<CameraId> camera_named(const Line& line, const std::string& name) const {
    const auto known = cameras_.find(name);
    if (known == cameras_.end()) return bad_line(line.number, "there is no camera " + shown(name) + " above");
    return known->second;
  }

  Result<> take_of_camera(const Line& line) {
    COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[1]));
    if (line.words[0] == "lever_arm") return instruments_.take_lever_arm(line, camera);
    if (line.words[0] == "boresight") return instruments_.take_boresight(line, camera);
    return instruments_.take_time_offset(line, camera);
  }

  Result<> take_of_image(const Line& line) {
    COLLINEA_TRY(const ImageId image, image_named(line, line.words[1]));
    if (line.words[0] == "attitude") return instruments_.take_attitude(line, image);
    if (line.words[0] == "velocity") return instruments_.take_velocity(line, image);
    return instruments_.take_on_track(line, image);
  }

  Result<> take_track(const Line& line) { return instruments_.take_track(line); }

  Result<> take_time(const Line& line) {
    COLLINEA_TRY(const ImageId image, image_named(line, line.words[1]));
    std::string& taken = file_.block.images[image].taken;
    if (!taken.empty()) return bad_line(line.number, "a second time of " + shown(line.words[1]));
    taken = line.words[2];
    if (taken.empty()) return bad_line(line.number, "a time is missing");
    return {};
  }

  // Shapes of one kind are numbered in the order of the file.
  Result<> take_shape(const Line& line) {
    constexpr GroundKind kKinds[] = {GroundKind::kOnPlane, GroundKind::kOnLine, GroundKind::kAtHeight};
    const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                   [&](GroundKind one) { return line.words[1] == ground_word(std::size_t(one)); });
    if (kind == std::end(kKinds))
      return bad_line(line.number, shown(line.words[1]) + " is no shape; there are: plane line height");
    auto& numbers = shapes_[*kind];
    Ground ground{line.number, line.words[3], line.words[3], {.kind = *kind, .name = line.words[2]}};
    GroundObservation& one = ground.measured;
    one.setup = numbers.try_emplace(line.words[2], std::uint32_t(numbers.size())).first->second;
    COLLINEA_TRY(one.sigma, finite(line, 4, "a standard deviation"));
    if (!(one.sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0");
    if (Result<> role = take_role(line, 5, one); !role) return role;
    const std::string axis = line.count() > 5 ? line.words[6] : "";
    if ((axis != "" && axis != "sideways" && axis != "upwards") || (axis != "" && *kind != GroundKind::kOnLine))
      return bad_line(line.number, "behind the role stands nothing, or of a line sideways or upwards");
    if (axis != "upwards") ground_.push_back(ground);
    ground.measured.axis = 1;
    if (*kind == GroundKind::kOnLine && axis != "sideways") ground_.push_back(ground);
    return {};
  }

  static Result<> take_role(const Line& line, std::size_t i, GroundObservation& one) {
    if (line.words[i] != "control" && line.words[i] != "check")
      return bad_line(line.number, shown(line.words[i]) + " is no role: control or check");
    if (line.words[i] == "check") one.role = ControlRole::kCheck;
    return {};
  }

  Result<> take_georeference(const Line& line) {
    if (file_.block.georeference) return bad_line(line.number, "a second georeference; there can be one");
    Georeference place{.crs = line.words[1]};
    COLLINEA_TRY(place.origin_latitude_deg, finite(line, 2, "a latitude"));
    COLLINEA_TRY(place.origin_longitude_deg, finite(line, 3, "a longitude"));
    COLLINEA_TRY(place.origin_height_m, finite(line, 4, "a height"));
    if (std::abs(place.origin_latitude_deg) > 90 || std::abs(place.origin_longitude_deg) > 360)
      return bad_line(line.number, "no such latitude and longitude: degrees are expected, latitude first");
    file_.block.georeference = std::move(place);
    return {};
  }

  static std::string listed(std::span<const std::string_view> names) {
    std::string text;
    for (const auto one : names) text += " " + std::string(one);
    return text;
  }

  Result<> take_camera(const Line& line) {
    const std::string& name = line.words[1];
    if (cameras_.contains(name)) return bad_line(line.number, "a second camera " + shown(name));
    Camera camera;
    const auto size = [&](std::size_t i) { return integer(line.words[i]).value_or(0); };
    constexpr std::int64_t kWidest = 1'000'000;
    if (size(2) < 1 || size(3) < 1 || size(2) > kWidest || size(3) > kWidest)
      return bad_line(line.number, "width and height of a picture are whole numbers of pixels above 0");
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
    const CameraId id{std::uint32_t(cameras_.size())};
    if (line.count() > 4) {
      const auto set = std::find(kAdditionalNames.begin() + 1, kAdditionalNames.end(), line.words[5]);
      if (set != kAdditionalNames.end()) {
        camera.additional = AdditionalSet(set - kAdditionalNames.begin());
      } else if (line.words[5] == "sigmas_after_correction" && is<BrownOfMeasured>(camera.model)) {
        file_.corrected_cameras.insert(id);
      } else {
        return bad_line(line.number, "behind the model stands nothing, a set of additional parameters (" +
                                         listed(std::span(kAdditionalNames).subspan(1)).substr(1) +
                                         "), or of brown_of_measured sigmas_after_correction");
      }
    }
    cameras_[name] = id;
    file_.block.cameras[id] = camera;
    file_.given_cameras[id] = camera;
    file_.camera_sigmas[id].fill(0);
    return {};
  }

  Result<> take_parameter(const Line& line) {
    COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[1]));
    const Camera& described = file_.block.cameras.at(camera);
    const auto param = param_named(described, line.words[2]);
    if (!param) {
      std::string known;
      for (const int one : params_of(described)) known += " " + param_name(one);
      return bad_line(line.number, shown(line.words[2]) + " is no parameter of this camera; there are:" + known);
    }
    const auto k = std::size_t(*param);
    if (!parameters_.emplace(camera, k).second)
      return bad_line(line.number, line.words[2] + " of camera " + line.words[1] + " is given twice");
    COLLINEA_TRY(const double value, finite(line, 3, "a value"));
    if (k == Camera::kF && !(value > 0)) return bad_line(line.number, "a focal length is above 0 [px]");
    double sigma = 0, given = value;
    if (line.words[4] == "free") {
      sigma = kInfinity;
    } else if (line.words[4] != "fixed") {
      const auto deviation = number(line.words[4]);
      if (!deviation || !(*deviation > 0) || std::isinf(*deviation))
        return bad_line(line.number, shown(line.words[4]) +
                                         " says not how the parameter takes part: fixed, free, or a " +
                                         "standard deviation above 0");
      sigma = *deviation;
    }
    if (line.count() > 4) {
      if (!std::isfinite(sigma) || sigma == 0)
        return bad_line(line.number, "a given value belongs to a standard deviation, not to fixed or free");
      COLLINEA_TRY(given, finite(line, 5, "a given value"));
    }
    file_.block.cameras[camera].params[k] = value;
    file_.given_cameras[camera].params[k] = given;
    file_.camera_sigmas[camera][k] = sigma;
    return {};
  }

  Result<> take_image(const Line& line) {
    COLLINEA_TRY(const CameraId camera, camera_named(line, line.words[2]));
    const ImageId id{std::uint32_t(images_.size())};
    if (line.words[1].empty()) return bad_line(line.number, "an image needs a name");
    if (!images_.emplace(line.words[1], id).second)
      return bad_line(line.number, "a second image " + shown(line.words[1]));
    file_.block.images[id] = {.file = line.words[1], .camera = camera};
    return {};
  }

  Result<> take_pose(const Line& line) {
    COLLINEA_TRY(const ImageId image, image_named(line, line.words[1]));
    COLLINEA_TRY(const Eigen::Vector3d centre, finite3(line, 2, "a coordinate"));
    COLLINEA_TRY(const Eigen::Vector3d angles, finite3(line, 5, "an angle"));
    if (line.count() > 7) {
      if (line.words[8] != "fixed") return bad_line(line.number, "behind kappa stands fixed or nothing");
      file_.held_images.insert(image);
    }
    const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{angles[0], angles[1], angles[2]});
    if (is_oriented(file_.block, image)) return bad_line(line.number, "a second pose of " + shown(line.words[1]));
    set_pose(file_.block, image, {rotation, -(rotation * centre)});
    return {};
  }

  Result<> take_position(const Line& line) {
    COLLINEA_TRY(const ImageId image, image_named(line, line.words[1]));
    if (file_.block.images[image].position)
      return bad_line(line.number, "a second position of " + shown(line.words[1]));
    PositionPrior prior{};
    if (Result<> given = given3(line, 2, prior.position_in_world, prior.sigma_m); !given) return given;
    if (!(prior.sigma_m.minCoeff() > 0))
      return bad_line(line.number,
                      "a measured position has standard deviations above 0; to hold the image, write "
                      "fixed behind its pose");
    file_.block.images[image].position = prior;
    return {};
  }

  Result<> take_control(const Line& line) {
    const std::string& name = line.words[1];
    if (name.empty()) return bad_line(line.number, "a point needs a name");
    ControlPoint point{.name = name,
                       .role = line.words[0].starts_with("check") ? ControlRole::kCheck : ControlRole::kControl,
                       .position_in_map = {},
                       .position_in_world = {},
                       .sigma_m = {}};
    const ControlId id{std::uint32_t(control_.size())};
    if (!control_.emplace(name, id).second) return bad_line(line.number, "a second point " + shown(name));
    if (Result<> given = given3(line, 2, point.position_in_world, point.sigma_m); !given) return given;
    if (line.words[0].ends_with("_in_map")) {
      if (!point.position_in_world.allFinite())
        return bad_line(line.number,
                        "a point of a map needs all three coordinates, at least roughly (- for the standard deviation "
                        "of those that are not given): the height of the frame depends on the place");
      in_map_.emplace_back(line.number, id);
    }
    file_.block.control[id] = std::move(point);
    return {};
  }

  Result<> take_correlation(const Line& line) {
    const auto known = control_.find(line.words[1]);
    if (known == control_.end())
      return bad_line(line.number, "there is no point " + shown(line.words[1]) + " above this line");
    ControlPoint& point = file_.block.control.at(known->second);
    for (std::size_t i = 0; i < 3; ++i) {
      COLLINEA_TRY(point.correlation[Eigen::Index(i)], finite(line, 2 + i, "a correlation"));
    }
    if (!survey_weight(point.sigma_m, point.correlation))
      return bad_line(line.number, "these are the correlations of no covariance: it has to be positive definite");
    return {};
  }

  Result<> take_ground(const Line& line) {
    std::size_t kind = 0;
    constexpr auto kMeasured = std::size_t(GroundKind::kAtHeight);  // what lies on shapes has lines of its own
    while (kind < kMeasured && line.words[1] != ground_word(kind)) ++kind;
    if (kind == kMeasured) {
      std::string known;
      for (std::size_t k = 0; k < kMeasured; ++k) known += " " + ground_word(k);
      return bad_line(line.number, shown(line.words[1]) + " is measured by nobody; there are:" + known);
    }
    if (line.count() != 6 && line.count() != 9)
      return bad_line(line.number,
                      "behind the role stand set-up, height of the instrument and of the target, or nothing");
    Ground ground{line.number, line.words[2], line.words[3], {.kind = GroundKind(kind)}};
    GroundObservation& one = ground.measured;
    const double unit = one.is_angle() ? kDegree : 1;
    COLLINEA_TRY(one.value, finite(line, 4, "a value"));
    COLLINEA_TRY(one.sigma, finite(line, 5, "a standard deviation"));
    if (!(one.sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0");
    if (kind == std::size_t(GroundKind::kDistance) && !(one.value > 0))
      return bad_line(line.number, "a distance is above 0 [m]");
    one.value *= unit, one.sigma *= unit;
    if (Result<> role = take_role(line, 6, one); !role) return role;
    if (ground.from == ground.to) return bad_line(line.number, "a measurement from a point to itself");
    if (line.count() > 6) {
      if (line.words[7] != "-") {
        const auto setup = integer(line.words[7]);
        if (!setup || *setup < 0 || *setup >= std::int64_t(GroundObservation::kNoSetup))
          return bad_line(line.number, shown(line.words[7]) + " is no set-up: a whole number from 0, or -");
        one.setup = std::uint32_t(*setup);
      }
      COLLINEA_TRY(one.instrument_height_m, finite(line, 8, "a height"));
      COLLINEA_TRY(one.target_height_m, finite(line, 9, "a height"));
    }
    if (one.kind == GroundKind::kDirection && one.setup == GroundObservation::kNoSetup)
      return bad_line(line.number, "a direction belongs to a set-up: the instrument's orientation is found for each");
    ground_.push_back(std::move(ground));
    return {};
  }

  static std::optional<PointId> point_numbered(std::string_view word) {
    const auto value = integer(word);
    if (!value || *value < 0 || *value >= std::int64_t(PointId::kNone)) return std::nullopt;
    return PointId{std::uint32_t(*value)};
  }

  Result<> take_point(const Line& line) {
    const auto id = point_numbered(line.words[1]);
    if (!id)
      return bad_line(line.number, shown(line.words[1]) +
                                       " is no number of a tie point: a whole number from 0 is "
                                       "expected; points with names are control or check");
    COLLINEA_TRY(const Eigen::Vector3d place, finite3(line, 2, "a coordinate"));
    if (!file_.block.points.emplace(*id, TiePoint{place, {}}).second)
      return bad_line(line.number, "a second tie point " + line.words[1]);
    return {};
  }

  Result<> take_measured(const Line& line) {
    COLLINEA_TRY(const ImageId image, image_named(line, line.words[1]));
    Eigen::Vector2d pixel;
    COLLINEA_TRY(pixel.x(), finite(line, 3, "a column"));
    COLLINEA_TRY(pixel.y(), finite(line, 4, "a row"));
    COLLINEA_TRY(const double sigma, finite(line, 5, "a standard deviation"));
    if (!(sigma > 0)) return bad_line(line.number, "the standard deviation of a measurement is above 0 [px]");
    if (line.words[0] == "measured_control") {
      measured_.push_back({line.number, image, line.words[2], pixel, sigma});
      return {};
    }
    const auto id = point_numbered(line.words[2]);
    if (!id)
      return bad_line(line.number, shown(line.words[2]) +
                                       " is no number of a tie point: a whole number from 0 is "
                                       "expected; points with names are measured_control");
    ties_.push_back({line.number, {image, *id, 0, pixel, sigma}});
    return {};
  }

  // Control may stand in the file wherever it likes.
  Result<> sort_measured() {
    std::map<std::pair<ControlId, ImageId>, std::size_t> known;
    for (const Measured& one : measured_) {
      const auto control = control_.find(one.point);
      if (control == control_.end())
        return bad_line(one.line, "there is no control or check point " + shown(one.point) + ": add a line control " +
                                      one.point + " X Y Z SX SY SZ");
      if (const auto [before, is_new] = known.emplace(std::pair(control->second, one.image), one.line); !is_new)
        return twice(one.line, one.point, one.image, before->second);
      file_.block.control_observations.push_back({control->second, one.image, one.pixel, one.sigma});
    }
    for (Ground& one : ground_) {
      const auto from = control_.find(one.from), to = control_.find(one.to);
      if (from == control_.end() || to == control_.end())
        return bad_line(one.line, "there is no control or check point " +
                                      shown(from == control_.end() ? one.from : one.to) +
                                      ": add a line control (a point without coordinates has - for all of them)");
      one.measured.from = from->second;
      one.measured.to = to->second;
      file_.block.ground.push_back(one.measured);
    }
    sort_by_point_and_image(ties_, [](const Tie& one) -> const Observation& { return one.seen; });
    for (std::size_t i = 0; i < ties_.size(); ++i) {
      const Observation& seen = ties_[i].seen;
      if (i > 0 && ties_[i - 1].seen.point == seen.point && ties_[i - 1].seen.image == seen.image)
        return twice(ties_[i].line, std::to_string(seen.point.value), seen.image, ties_[i - 1].line);
      file_.block.observations.push_back(seen);
    }
    return {};
  }

  Result<AdjustmentFile> finish(std::size_t lines) {
    if (file_.block.images.empty() || (measured_.empty() && ties_.empty()))
      return bad_line(lines, std::string("the file ends without ") +
                                 (file_.block.images.empty() ? "an image" : "a measurement") +
                                 ": there is nothing to adjust; is it complete?");
    for (const auto& [name, id] : cameras_)
      if (!(file_.block.cameras[id].focal_px() > 0))
        return bad_line(
            lines, "camera " + shown(name) + " has no focal length: add a line parameter " + name + " f VALUE HOW");
    if (Result<> sorted = sort_measured(); !sorted) return tl::unexpected(sorted.error());
    COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(file_.block));
    for (const auto& [line, id] : in_map_) {
      ControlPoint& point = file_.block.control.at(id);
      if (!frame) return bad_line(line, "coordinates of which map? There is no line georeference");
      point.position_in_world = frame->local_from_map(point.position_in_world);
      if (!point.position_in_world.allFinite())
        return bad_line(line, "this place is outside of " + file_.block.georeference->crs);
    }
    file_.instruments = instruments_.found();
    for (auto& [id, control] : file_.block.control)
      control.position_in_map = frame && control.position_in_world.allFinite()
                                    ? frame->map_from_local(control.position_in_world)
                                    : control.position_in_world;
    return std::move(file_);
  }

  struct Measured {
    std::size_t line;
    ImageId image;
    std::string point;
    Eigen::Vector2d pixel;
    double sigma;
  };

  struct Ground {
    std::size_t line;
    std::string from, to;
    GroundObservation measured;
  };

  struct Tie {
    std::size_t line;
    Observation seen;
  };

  [[nodiscard]] tl::unexpected<Error> twice(std::size_t line, const std::string& point, ImageId image,
                                            std::size_t before) const {
    return bad_line(line, "point " + shown(point) + " is measured twice in " +
                              shown(file_.block.images.at(image).file) + ", before in line " + std::to_string(before));
  }

  AdjustmentFile file_;
  std::map<std::string, CameraId> cameras_;
  std::map<std::string, ImageId> images_;
  std::map<std::string, ControlId> control_;
  std::set<std::pair<CameraId, std::size_t>> parameters_;
  std::vector<Measured> measured_;
  std::vector<Ground> ground_;
  InstrumentLines instruments_;
  std::map<GroundKind, std::map<std::string, std::uint32_t>> shapes_;
  std::vector<std::pair<std::size_t, ControlId>> in_map_;  // lines and points
  std::vector<Tie> ties_;
};

}  // namespace

Result<AdjustmentFile> parse_adjustment_file(std::string_view text) { return Parser().parse(text); }

bool is_adjustment_file(std::string_view text) {
  for (const std::string_view line : lines_of(text.substr(0, 4096)))
    if (const auto words = words_of(line); !words.empty() && !words[0].starts_with('#'))
      return words[0] == kAdjustmentTitle;
  return false;
}

}  // namespace collinea
