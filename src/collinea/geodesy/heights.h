// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"
#include "collinea/base/word_or.h"

namespace collinea {

/// A surface that heights may count from, without further knowledge.
enum class HeightSurface { kEllipsoid };
inline constexpr Word<HeightSurface> kHeightSurfaceWords[] = {{HeightSurface::kEllipsoid, "ellipsoidal", "of WGS84"}};
[[nodiscard]] constexpr std::span<const Word<HeightSurface>> words(HeightSurface) { return kHeightSurfaceWords; }

/// What heights count from: "ellipsoidal"; or a vertical CRS, "EPSG:5773"; or the name of a file with a grid of geoid
/// heights over the ellipsoid (GTX, GeoTIFF, as PROJ reads them).
using HeightsFrom = WordOr<HeightSurface, std::string>;

/// The CRS of a map with these heights in place of its own. A CRS with a grid of one's own is written
/// "EPSG:32633+geoid:/data/geoid.gtx". Errors: a CRS that is none, no vertical CRS, a file that is not there.
[[nodiscard]] Result<std::string> with_heights(const std::string& crs, const HeightsFrom& heights);

/// The height of that surface over the ellipsoid of WGS84 at a position, N of h = H + N (Mussio 1.3.7): 0 of the
/// ellipsoid. Errors: as LocalFrame::create(); a position that the grid of the geoid does not reach.
[[nodiscard]] Result<double> undulation_m(const HeightsFrom& heights, double latitude_deg, double longitude_deg);

/// True when a CRS says what its heights are; those of others are ellipsoidal.
[[nodiscard]] Result<bool> states_heights(const std::string& crs);

}  // namespace collinea
