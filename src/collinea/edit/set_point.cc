// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/set_point.h"

#include <cmath>
#include <limits>

#include "collinea/edit/internal/words_in.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array<const char*, 3> kCoordinate = {"E", "N", "H"}, kSigma = {"SE", "SN", "SH"};

const std::string& nothing() {
  static const std::string word = "-";
  return word;
}

}  // namespace

Result<ControlRole> role_in(const std::string& word) {
  if (word == "control") return ControlRole::kControl;
  if (word == "check") return ControlRole::kCheck;
  return fail(Errc::kBadInput, "\"" + word + "\" is no role: control or check");
}

std::string word_of_role(ControlRole role) { return role == ControlRole::kControl ? "control" : "check"; }

Result<SetPoint> SetPoint::parse(std::span<const std::string> words) {
  if (words.size() != 5 && words.size() != 8) return wrong_form(kForm);
  SetPoint set{.point = words[0]};
  COLLINEA_TRY(check_name(set.point, "NAME"));
  COLLINEA_TRY(set.role, role_in(words[1]));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const std::string& word = words[2 + axis]; word != nothing()) {
      COLLINEA_TRY(set.position_in_map[axis], number_in(word, kCoordinate[axis]));
    }
  if (words.size() == 5) return set;
  set.sigma_m.emplace();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double& sigma_m = (*set.sigma_m)[static_cast<Eigen::Index>(axis)] = kInfinity;
    const std::string& word = words[5 + axis];
    if (word == nothing()) continue;
    if (!set.position_in_map[axis])
      return fail(Errc::kBadInput,
                  std::string(kSigma[axis]) + ": a standard deviation of a coordinate that is not known");
    COLLINEA_TRY(sigma_m, sigma_in(word, kSigma[axis]));
  }
  return set;
}

std::vector<std::string> SetPoint::words() const {
  std::vector<std::string> words = {point, word_of_role(role)};
  for (const auto& coordinate : position_in_map) words.push_back(coordinate ? exact(*coordinate) : nothing());
  if (sigma_m)
    for (const double sigma : *sigma_m) words.push_back(std::isfinite(sigma) ? exact(sigma) : nothing());
  return words;
}

Result<SetPoint> SetPoint::completed(const EditContext& context, const EditDefaults& defaults) const {
  const auto& control = context.block().control;
  const auto is_it = [&](const auto& known) { return known.second.name == point; };
  if (std::none_of(control.begin(), control.end(), is_it)) COLLINEA_TRY(check_new_name(point, "NAME"));
  SetPoint set = *this;
  if (set.sigma_m) return set;
  set.sigma_m.emplace();
  for (std::size_t axis = 0; axis < 3; ++axis)
    (*set.sigma_m)[static_cast<Eigen::Index>(axis)] = position_in_map[axis] ? defaults.sigma_m : kInfinity;
  return set;
}

Result<> SetPoint::apply(const EditContext& context, EditedPoint& edited) const {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, context.frame());
  ControlPoint set{.name = point, .role = role};
  set.position_in_world = Eigen::Vector3d::Zero();
  set.position_in_map = frame ? frame->map_from_local(set.position_in_world) : set.position_in_world;
  set.sigma_m = sigma_m.value_or(Eigen::Vector3d::Constant(kInfinity));
  bool is_surveyed = false;  // an axis that is not known is that of the origin, near the site
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!position_in_map[axis]) continue;
    is_surveyed = true;
    set.position_in_map[static_cast<Eigen::Index>(axis)] = *position_in_map[axis];
  }
  if (is_surveyed && !frame)
    return fail(Errc::kBadInput,
                "the project has no map that coordinates could be in: import the photographs with its CRS",
                {{"crs", "import"}});
  if (is_surveyed) set.position_in_world = frame->local_from_map(set.position_in_map);
  constexpr double kFarthest_m = 1e6;  // from the origin: no block is as large, exchanged axes are farther
  if (!set.position_in_world.allFinite() || set.position_in_world.norm() > kFarthest_m)
    return fail(Errc::kBadInput, "the position lies " + fixed(kFarthest_m / 1000, 0) +
                                     " km or more from the project: coordinates are easting, northing and height in " +
                                     frame->crs_name());
  edited.point = std::move(set);
  return {};
}

SetPoint set_point_of(const ControlPoint& point) {
  SetPoint set{.point = point.name, .role = point.role, .sigma_m = point.sigma_m};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    if (std::isfinite(point.sigma_m[i])) set.position_in_map[axis] = point.position_in_map[i];
  }
  return set;
}

}  // namespace collinea
