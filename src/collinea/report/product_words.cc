// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/product_words.h"

#include <fmt/format.h>

#include <locale>

#include "collinea/base/words.h"

namespace collinea {
namespace {

// What a product was made with, ahead of what is always in it.
enum class Figures : std::uint8_t { kNone, kPoints, kSurfaceCells, kTerrainCells, kOrthoCells, kContours };

struct ProductRow {
  ProductFile product;
  std::string_view path, name;
  Figures figures;
  std::string_view content;
};

constexpr ProductRow kProducts[] = {
    {ProductFile::kCloudLas, "products/cloud.las", "Point cloud", Figures::kPoints,
     ", LAS 1.4 in the map, with sigmas"},
    {ProductFile::kCloudLaz, "products/cloud.laz", "Point cloud", Figures::kPoints,
     ", LAZ 1.4 in the map, with sigmas"},
    {ProductFile::kCloudCopc, "products/cloud.copc.laz", "Point cloud", Figures::kPoints,
     ", COPC 1.0 (LAZ 1.4) in the map, with sigmas"},
    {ProductFile::kCloudPly, "products/cloud.ply", "Point cloud", Figures::kPoints,
     ", PLY in the local frame, with normals"},
    {ProductFile::kSurface, "products/dsm.tif", "Surface model", Figures::kSurfaceCells, ""},
    {ProductFile::kSurfaceSigma, "products/dsm_sigma.tif", "Surface model, standard deviations", Figures::kNone, "m"},
    {ProductFile::kSurfaceRelativeSigma, "products/dsm_sigma_relative.tif",
     "Surface model, relative standard deviations", Figures::kNone, "m, against heights around"},
    {ProductFile::kSurfaceState, "products/dsm_state.tif", "Surface model, state", Figures::kNone,
     "0 nothing, 1 measured, 2 interpolated"},
    {ProductFile::kSurfaceCount, "products/dsm_count.tif", "Surface model, count", Figures::kNone,
     "points that made a cell"},
    {ProductFile::kSurfaceHillshade, "products/dsm_hillshade.tif", "Surface model, hillshade", Figures::kNone,
     "light from the north-west"},
    {ProductFile::kTerrain, "products/dtm.tif", "Terrain model", Figures::kTerrainCells, ""},
    {ProductFile::kTerrainSigma, "products/dtm_sigma.tif", "Terrain model, standard deviations", Figures::kNone, "m"},
    {ProductFile::kTerrainRelativeSigma, "products/dtm_sigma_relative.tif",
     "Terrain model, relative standard deviations", Figures::kNone, "m, against heights around"},
    {ProductFile::kTerrainState, "products/dtm_state.tif", "Terrain model, state", Figures::kNone,
     "0 nothing, 1 ground as measured, 2 interpolated"},
    {ProductFile::kTerrainHillshade, "products/dtm_hillshade.tif", "Terrain model, hillshade", Figures::kNone,
     "light from the north-west"},
    {ProductFile::kContoursGeoPackage, "products/contours.gpkg", "Contours", Figures::kContours, ", GeoPackage"},
    {ProductFile::kContoursDxf, "products/contours.dxf", "Contours", Figures::kContours, ", DXF"},
    {ProductFile::kOrthophoto, "products/ortho.tif", "Orthophoto", Figures::kOrthoCells, ", Cloud-Optimised GeoTIFF"},
    {ProductFile::kOrthophotoSource, "products/ortho_source.tif", "Orthophoto, sources", Figures::kNone,
     "index of the leading photograph"},
};
static_assert(is_in_order(kProducts, kProductFiles, &ProductRow::product));

const ProductRow& row_of(ProductFile product) { return kProducts[static_cast<std::size_t>(product)]; }

struct Thousands : std::numpunct<char> {
  char do_thousands_sep() const override { return ','; }
  std::string do_grouping() const override { return "\3"; }
};

std::string cells_text(const auto& raster) {
  return fmt::format("cells of {:.3g} m, {} x {}", raster.cell_m, raster.width, raster.height);
}

std::string figures_text(Figures figures, std::span<const StepRecord> steps) {
  switch (figures) {
    case Figures::kNone:
      return "";
    case Figures::kPoints:
      return fmt::format(std::locale(std::locale::classic(), new Thousands), "{:L} points",
                         outcome_in<DensifyRecord>(steps).points);
    case Figures::kSurfaceCells:
      return cells_text(outcome_in<SurfaceRecord>(steps));
    case Figures::kTerrainCells:
      return cells_text(outcome_in<TerrainRecord>(steps));
    case Figures::kOrthoCells:
      return cells_text(outcome_in<OrthoRecord>(steps));
    case Figures::kContours:
      return fmt::format("every {:.4g} m, with heights", outcome_in<TerrainRecord>(steps).contour_m);
  }
  return "";
}

}  // namespace

std::string_view path_of(ProductFile product) { return row_of(product).path; }
std::string_view name_of(ProductFile product) { return row_of(product).name; }

std::string content_of(ProductFile product, std::span<const StepRecord> steps) {
  const ProductRow& row = row_of(product);
  return figures_text(row.figures, steps).append(row.content);
}

}  // namespace collinea
