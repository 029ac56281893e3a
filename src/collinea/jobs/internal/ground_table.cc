// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/ground_table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace collinea {

Result<std::map<std::string, GroundTablePoint>> read_ground_table(const std::filesystem::path& path, double sigma_m,
                                                                  bool needs_height) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  COLLINEA_TRY(const auto names, table.words("point").map_error(in_file));
  constexpr std::array<const char*, 3> kNames{"X", "Y", "Z"};
  std::vector<GroundTablePoint> points(names.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = kNames[static_cast<std::size_t>(axis)];
    if (axis < 2 || needs_height) {
      COLLINEA_TRY(table.words(name).map_error(in_file));
    }
    COLLINEA_TRY(const auto values, table.numbers_or(name, "m", std::nan("")).map_error(in_file));
    COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma_" + name, "m", sigma_m).map_error(in_file));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (sigmas[i] < 0)
        return fail(Errc::kBadFormat,
                    fmt::format("{}: sigma_{} of point {} is negative", path.string(), name, names[i]));
      points[i].position[axis] = values[i];
      points[i].sigma[axis] = std::isfinite(values[i]) ? sigmas[i] : std::numeric_limits<double>::infinity();
    }
  }
  std::map<std::string, GroundTablePoint> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!out.emplace(names[i], points[i]).second)
      return fail(Errc::kBadFormat, fmt::format("{}: point {} is there twice", path.string(), names[i]));
  return out;
}

}  // namespace collinea
