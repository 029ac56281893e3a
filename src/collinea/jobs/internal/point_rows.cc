// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/point_rows.h"

#include <fmt/format.h>

#include "collinea/io/text_table.h"

namespace collinea {

Result<std::vector<HeightPoint>> read_point_rows(const std::filesystem::path& path) {
  const auto within = [&](Error error) { return std::move(error).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  COLLINEA_TRY(const auto x, table.numbers("X", "m").map_error(within));
  COLLINEA_TRY(const auto y, table.numbers("Y", "m").map_error(within));
  COLLINEA_TRY(const auto z, table.numbers("Z", "m").map_error(within));
  COLLINEA_TRY(const auto sigma, table.numbers_or("sigma_Z", "m", 0).map_error(within));
  std::vector<HeightPoint> points;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (sigma[i] < 0) return fail(Errc::kBadFormat, fmt::format("{}: row {}: a sigma below 0", path.string(), i + 1));
    points.push_back({{x[i], y[i], z[i]}, sigma[i]});
  }
  return points;
}

}  // namespace collinea
