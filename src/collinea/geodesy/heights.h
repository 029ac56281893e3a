// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// What heights may count from, in words: "ellipsoidal" (WGS84); a vertical CRS, "EPSG:5773"; or the name of a file
/// with a grid of geoid heights over the ellipsoid (GTX, GeoTIFF, as PROJ reads them).
///
/// The CRS of a map with these heights in place of its own. A CRS with a grid of one's own is written
/// "EPSG:32633+geoid:/data/geoid.gtx". Errors: a CRS that is none, no vertical CRS, a file that is not there.
[[nodiscard]] Result<std::string> with_heights(const std::string& crs, const std::string& heights);

/// True when a CRS says what its heights are; those of others are ellipsoidal.
[[nodiscard]] Result<bool> says_heights(const std::string& crs);

}  // namespace collinea
