// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "collinea/base/words.h"
#include "collinea/synthetic/internal/scene.h"

namespace collinea {

/// What lies below an aerial block.
enum class Country : std::uint8_t { kVillage, kTown, kRocks };
inline constexpr Word<Country> kCountryWords[] = {
    {Country::kVillage, "village", "hills, fields, two roads, scattered houses"},
    {Country::kTown, "town", "streets with rows of houses, gardens, trees, mild relief"},
    {Country::kRocks, "rocks", "steep bare rock, rough at all wavelengths down to a metre, strata, few houses"}};
[[nodiscard]] constexpr std::span<const Word<Country>> words(Country) { return kCountryWords; }

/// A piece of country to fly over.
struct CountryOptions {
  Eigen::Vector2d low{-150, -150}, high{150, 150};              ///< corners of the terrain [m]
  double cell_m = 0.25;                                         ///< of the terrain grid
  double relief_m = 8;                                          ///< about the range of terrain heights
  double building_area_m2 = 1400;                               ///< one building on so much land; 0: none
  Eigen::Vector2d built_low{-100, -100}, built_high{100, 100};  ///< buildings (and trees) stand inside
  double sun_azimuth_deg = 155, sun_elevation_deg = 52;
  std::uint64_t seed = 1;
};

/// The grid of a height that is a function of the position, less that at the origin.
[[nodiscard]] Heightfield terrain_of(const CountryOptions& options,
                                     const std::function<double(double x, double y)>& height);

/// Value noise in [-1, 1] with continuous second derivatives: hills without creases.
[[nodiscard]] double smooth_noise(double x, double y, std::uint32_t seed);

/// Rolling hills: five octaves, of a range of about relief_m over 200 m.
[[nodiscard]] double hill_height(double x, double y, double relief_m, std::uint32_t seed);

}  // namespace collinea
