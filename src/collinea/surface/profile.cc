// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/profile.h"

#include <cmath>

namespace collinea {

Result<Profile> profile_along(const std::vector<Eigen::Vector2d>& line, double step_m,
                              std::vector<HeightSamples>& surfaces) {
  double length_m = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length_m += (line[i] - line[i - 1]).norm();
  if (!(length_m > 0)) return fail(Errc::kBadInput, "a profile needs a line of at least two points");
  if (!(length_m / step_m < 1e6))
    return fail(Errc::kBadInput, "a profile of a million steps and more: larger ones are needed");
  Profile profile;
  profile.of.resize(surfaces.size());
  const auto add = [&](double distance_m, const Eigen::Vector2d& position) -> Result<> {
    profile.distance_m.push_back(distance_m);
    profile.positions.push_back(position);
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      COLLINEA_TRY(const HeightSample one, surfaces[s].at(position));
      profile.of[s].push_back(one);
    }
    return {};
  };
  double before_m = 0;
  COLLINEA_TRY(add(0, line[0]));
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Eigen::Vector2d way = line[i] - line[i - 1];
    const int steps = std::max(1, int(std::ceil(way.norm() / step_m - 1e-9)));
    for (int k = 1; k <= steps && way.norm() > 0; ++k) {
      const double share = double(k) / steps;
      COLLINEA_TRY(add(before_m + share * way.norm(), line[i - 1] + share * way));
    }
    before_m += way.norm();
  }
  return profile;
}

}  // namespace collinea
