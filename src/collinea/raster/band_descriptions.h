// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/file_text.h"

/// What each raster of the program holds, as its TIFF ImageDescription says: what and in which unit
/// (GeoTiffWriter::Options::description).
namespace collinea::band {

inline constexpr FileText kSurfaceHeight = "digital surface model: height [m]";
inline constexpr FileText kTerrainHeight = "digital terrain model: height of the ground [m]";
inline constexpr FileText kHeightSigma = "standard deviation of the height [m]";
inline constexpr FileText kRelativeHeightSigma = "standard deviation of the height against those around it [m]";
inline constexpr FileText kSurfaceState = "0 nothing, 1 measured, 2 interpolated";  ///< as CellState
inline constexpr FileText kTerrainState = "0 nothing, 1 ground as measured, 2 interpolated";
inline constexpr FileText kPointCount = "points that made the cell";
inline constexpr FileText kHillshade = "light from the north-west, 45 degrees high: 1 none to 255 full";
inline constexpr FileText kOrthophoto = "orthophoto: red, green, blue, alpha";
inline constexpr FileText kOrthophotoSource = "number of the leading photograph, 0 none";
inline constexpr FileText kRectified = "rectified plane: red, green, blue, alpha; metres on the plane";
inline constexpr FileText kPlannedSigma =
    "expected standard deviations east, north, height [m], and number of images";  ///< bands, in this order
inline constexpr FileText kHeightDifference = "surface less reference: height [m]";
inline constexpr FileText kTrueSurfaceHeight = "true surface height [m]";
inline constexpr FileText kTrueTerrainHeight = "true terrain height [m]";
inline constexpr FileText kTrueOrthophoto = "true orthophoto";

}  // namespace collinea::band
