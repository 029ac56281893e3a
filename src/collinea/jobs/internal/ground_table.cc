// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/ground_table.h"

#include <fmt/format.h>

#include <array>
#include <limits>

namespace collinea {

const GroundTablePoint* GroundTable::find(const std::string& name) const {
  const auto found = index_.find(name);
  return found == index_.end() ? nullptr : &points[found->second];
}

Result<GroundTable> read_ground_table(const std::filesystem::path& path, double sigma_m, bool needs_height) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  GroundTable ground;
  COLLINEA_TRY(ground.table, read_text_table(path));
  const TextTable& table = ground.table;
  COLLINEA_TRY(const auto names, table.words("point").map_error(in_file));
  ground.points.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    ground.points[i].name = names[i];
    if (!ground.index_.emplace(names[i], i).second)
      return fail(Errc::kBadFormat, fmt::format("{}: point {} is there twice", path.string(), names[i]));
  }
  constexpr std::array<const char*, 3> kNames{"X", "Y", "Z"};
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = kNames[static_cast<std::size_t>(axis)];
    if (axis < 2 || needs_height) {
      COLLINEA_TRY(table.words(name).map_error(in_file));
    }
    COLLINEA_TRY(const auto values, table.numbers_or(name, "m", std::nan("")).map_error(in_file));
    COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma_" + name, "m", sigma_m).map_error(in_file));
    ground.states_sigmas |= table.has("sigma_" + name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (sigmas[i] < 0)
        return fail(Errc::kBadFormat,
                    fmt::format("{}: sigma_{} of point {} is negative", path.string(), name, names[i]));
      ground.points[i].position[axis] = values[i];
      ground.points[i].sigma[axis] = std::isfinite(values[i]) ? sigmas[i] : std::numeric_limits<double>::infinity();
    }
  }
  return ground;
}

}  // namespace collinea
