// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/datum_points.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/nearest_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

std::optional<ControlId> control_named(const Block& block, std::string_view name) {
  const auto its = std::find_if(block.control.begin(), block.control.end(),
                                [&](const auto& one) { return one.second.name == name; });
  return its == block.control.end() ? std::nullopt : std::optional(its->first);
}

std::optional<PointId> tie_numbered(const Block& block, std::string_view text) {
  PointId point;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), point.value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && block.points.contains(point) ? std::optional(point) : std::nullopt;
}

Error no_such_point(const Block& block, std::string_view name) {
  std::vector<std::string> known;
  for (const auto& [id, control] : block.control) known.push_back(control.name);
  const bool is_number = std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
  return with_nearest(Error{Errc::kBadInput,
                            "datum points: there is no control point" +
                                std::string(is_number ? " and no tie point" : "") + " \"" + std::string(name) + "\"",
                            {"datum_points"_option}},
                      name, known);
}

}  // namespace

Result<DatumPoints> datum_points_named(const Block& block, std::string_view names) {
  DatumPoints chosen;
  for (const std::string_view name : fields_of(names, ',')) {
    if (name.empty()) continue;
    if (const auto control = control_named(block, name))
      chosen.control.insert(*control);
    else if (const auto tie = tie_numbered(block, name))
      chosen.ties.insert(*tie);
    else
      return tl::unexpected(no_such_point(block, name));
  }
  return chosen;
}

}  // namespace collinea
