// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/block/world_frame.h"
#include "collinea/io/internal/adjustment_draft.h"
#include "collinea/io/internal/adjustment_words.h"
#include "collinea/io/internal/observation_order.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Line = AdjustmentLine;
using Draft = AdjustmentDraft;
using Measured = AdjustmentDraft::Measured;
using GeodeticLine = AdjustmentDraft::GeodeticLine;
using Tie = AdjustmentDraft::Tie;

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

[[nodiscard]] tl::unexpected<Error> twice(std::size_t line, const std::string& point, ImageId image, std::size_t before,
                                          const Draft& draft) {
  return bad_line(line, "point " + shown(point) + " is measured twice in " +
                            shown(draft.file.block.images.at(image).file) + ", before in line " +
                            std::to_string(before));
}

// A point that is only measured in images, in two at least, needs no line of its own: it has no coordinates.
void add_marked_points(Draft& draft) {
  std::map<std::string, std::set<ImageId>> images;
  for (const Measured& one : draft.measured)
    if (!draft.control.contains(one.point)) images[one.point].insert(one.image);
  for (const auto& [name, shown_in] : images) {
    if (shown_in.size() < 2) continue;
    const ControlId id{std::uint32_t(draft.control.size())};
    draft.control.emplace(name, id);
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    draft.file.block.control[id] = {.name = name,
                                    .role = ControlRole::kControl,
                                    .position_in_map = Eigen::Vector3d::Constant(kUnknown),
                                    .position_in_world = Eigen::Vector3d::Constant(kUnknown),
                                    .sigma_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())};
  }
}

Result<> add_vector(GeodeticLine& line, std::uint32_t number, Block& block) {
  GnssVector vector = line.vector;
  if (line.is_geocentric) {
    if (!block.georeference)
      return bad_line(line.line, "a geocentric vector needs to know where the frame is: there is no line georeference");
    const Eigen::Matrix3d rotation = world_from_geocentric(*block.georeference);
    vector.vector = rotation * vector.vector;
    vector.covariance_m2 = rotation * vector.covariance_m2 * rotation.transpose();
  }
  line.measured.setup = number;
  const auto parts = observations_of(vector, line.measured);
  if (!parts) return bad_line(line.line, "this is no covariance of a vector: it has to be positive definite [m2]");
  block.geodetic.insert(block.geodetic.end(), parts->begin(), parts->end());
  return {};
}

// Control may stand in the file wherever it likes.
Result<> sort_measured(Draft& draft) {
  add_marked_points(draft);
  std::map<std::pair<ControlId, ImageId>, std::size_t> known;
  for (const Measured& one : draft.measured) {
    const auto control = draft.control.find(one.point);
    if (control == draft.control.end())
      return bad_line(one.line, "there is no control or check point " + shown(one.point) + ": add a line control " +
                                    one.point + " X Y Z SX SY SZ, or measure it in a second image");
    if (const auto [before, is_new] = known.emplace(std::pair(control->second, one.image), one.line); !is_new)
      return twice(one.line, one.point, one.image, before->second, draft);
    draft.file.block.control_observations.push_back({control->second, one.image, one.pixel, one.sigma, one.shape});
  }
  std::uint32_t vectors = 0;
  for (GeodeticLine& one : draft.geodetic) {
    const auto from = draft.control.find(one.from), to = draft.control.find(one.to);
    if (from == draft.control.end() || to == draft.control.end())
      return bad_line(one.line, "there is no control or check point " +
                                    shown(from == draft.control.end() ? one.from : one.to) +
                                    ": add a line control (a point without coordinates has - for all of them), or "
                                    "measure it in two images");
    one.measured.from = from->second;
    one.measured.to = to->second;
    if (one.measured.kind == GeodeticKind::kGnssVector) {
      COLLINEA_TRY(add_vector(one, vectors++, draft.file.block));
    } else {
      draft.file.block.geodetic.push_back(one.measured);
    }
  }
  sort_by_point_and_image(draft.ties, [](const Tie& one) -> const Observation& { return one.seen; });
  for (std::size_t i = 0; i < draft.ties.size(); ++i) {
    const Observation& seen = draft.ties[i].seen;
    if (i > 0 && draft.ties[i - 1].seen.point == seen.point && draft.ties[i - 1].seen.image == seen.image)
      return twice(draft.ties[i].line, std::to_string(seen.point.value), seen.image, draft.ties[i - 1].line, draft);
    draft.file.block.observations.push_back(seen);
  }
  return {};
}

Result<AdjustmentFile> finish(Draft draft, std::size_t lines) {
  if (draft.file.block.images.empty() || (draft.measured.empty() && draft.ties.empty()))
    return bad_line(lines, std::string("the file ends without ") +
                               (draft.file.block.images.empty() ? "an image" : "a measurement") +
                               ": there is nothing to adjust; is it complete?");
  for (const auto& [name, id] : draft.cameras)
    if (!(draft.file.block.cameras[id].focal_px() > 0))
      return bad_line(lines,
                      "camera " + shown(name) + " has no focal length: add a line parameter " + name + " f VALUE HOW");
  if (const auto& given = draft.deflection_rad) {
    auto& frame_given = draft.file.block.georeference;
    if (!frame_given)
      return bad_line(given->first, "a deflection is that from the ellipsoid: there is no line georeference");
    frame_given->deflection_north_rad = given->second[0];
    frame_given->deflection_east_rad = given->second[1];
  }
  COLLINEA_TRY(sort_measured(draft));
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(draft.file.block));
  for (const auto& [line, id] : draft.in_map) {
    ControlPoint& point = draft.file.block.control.at(id);
    if (!frame) return bad_line(line, "coordinates of which map? There is no line georeference");
    point.position_in_world = frame->local_from_map(point.position_in_world);
    if (!point.position_in_world.allFinite())
      return bad_line(line, "this position is outside of " + draft.file.block.georeference->crs);
  }
  draft.file.instruments = draft.instruments.found();
  for (auto& [id, control] : draft.file.block.control)
    control.position_in_map = frame && control.position_in_world.allFinite()
                                  ? frame->map_from_local(control.position_in_world)
                                  : control.position_in_world;
  return std::move(draft.file);
}

}  // namespace

Result<AdjustmentFile> parse_adjustment_file(std::string_view bytes) {
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
  const std::string_view text = converted ? *converted : bytes;
  Draft draft;
  const std::vector<std::string_view> lines = lines_of(text);
  bool titled = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    COLLINEA_TRY(const Line line, taken_apart(i + 1, lines[i]));
    if (line.words.empty()) continue;
    if (!titled) {
      if (line.words[0] != kAdjustmentTitle)
        return bad_line(line.number, "the file does not begin with \"collinea-adjustment 1\": it is none of ours" +
                                         separator_hint(line.words[0], ' '));
      if (line.words.size() != 2 || line.words[1] != "1")
        return bad_line(line.number, "only version 1 of collinea-adjustment is known here: a newer program is needed");
      titled = true;
      continue;
    }
    COLLINEA_TRY(take_adjustment_line(line, draft));
  }
  if (!titled) return fail(Errc::kBadFormat, "the file is empty: it should begin with \"collinea-adjustment 1\"");
  return finish(std::move(draft), lines.size());
}

bool is_adjustment_file(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 4096);
  const auto converted = converted_to_utf8(head);
  for (const std::string_view line : lines_of(converted && *converted ? **converted : head))
    if (const auto words = words_of(line); !words.empty() && !words[0].starts_with('#'))
      return words[0] == kAdjustmentTitle;
  return false;
}

}  // namespace collinea
