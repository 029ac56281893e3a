// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "collinea/store/project_store.h"

namespace collinea {

/// A file that a step makes for the user. Closed: each has one row in product_words.cc (file, name, content).
enum class ProductFile : std::uint8_t {
  kCloudLas,
  kCloudLaz,
  kCloudCopc,
  kCloudPly,
  kSurface,
  kSurfaceSigma,
  kSurfaceRelativeSigma,
  kSurfaceState,
  kSurfaceCount,
  kSurfaceHillshade,
  kTerrain,
  kTerrainSigma,
  kTerrainRelativeSigma,
  kTerrainState,
  kTerrainHillshade,
  kContoursGeoPackage,
  kContoursDxf,
  kOrthophoto,
  kOrthophotoSource,
};
inline constexpr std::size_t kProductFiles = static_cast<std::size_t>(ProductFile::kOrthophotoSource) + 1;

/// Where the file lies, relative to the project folder: "products/dsm.tif".
[[nodiscard]] std::string_view path_of(ProductFile product);

/// "Surface model, standard deviations".
[[nodiscard]] std::string_view name_of(ProductFile product);

/// What is in it, by what the steps recorded: "cells of 0.03 m, 4021 x 3877", "1,234,567 points, LAS 1.4 in the map,
/// with sigmas".
[[nodiscard]] std::string content_of(ProductFile product, std::span<const StepRecord> steps);

}  // namespace collinea
