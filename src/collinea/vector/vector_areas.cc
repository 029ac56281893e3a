// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/vector_areas.h"

#include <cpl_conv.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include "collinea/vector/internal/vector_file.h"

namespace collinea {
namespace {

struct FeatureDestroyer {
  void operator()(void* feature) const { OGR_F_Destroy(feature); }
};
struct GeometryDestroyer {
  void operator()(void* geometry) const { OGR_G_DestroyGeometry(geometry); }
};
using Geometry = std::unique_ptr<void, GeometryDestroyer>;

std::string name_of(OGRSpatialReferenceH srs) {
  if (!srs) return "none";
  const char *name = OSRGetName(srs), *authority = OSRGetAuthorityName(srs, nullptr),
             *code = OSRGetAuthorityCode(srs, nullptr);
  std::string text = name ? name : "unnamed";
  if (authority && code) text += " (" + std::string(authority) + ":" + code + ")";
  return text;
}

// In a GeoPackage every layer has a CRS; that of a layer without one is called "Undefined ...".
bool is_undefined(OGRSpatialReferenceH srs) {
  if (!srs || OSRIsLocal(srs)) return true;
  const char* name = OSRGetName(srs);
  return name && std::string(name).starts_with("Undefined");
}

Result<> check_crs(OGRSpatialReferenceH found, const std::string& wkt) {
  const GdalSrs wanted(wkt.empty() ? nullptr : OSRNewSpatialReference(wkt.c_str()));
  if (is_undefined(wanted.get()) && is_undefined(found)) return {};
  const char* const options[] = {"CRITERION=EQUIVALENT", "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  if (!is_undefined(wanted.get()) && !is_undefined(found) && OSRIsSameEx(found, wanted.get(), options)) return {};
  return fail(Errc::kBadInput, "its CRS is " + name_of(found) + ", the map's is " + name_of(wanted.get()) +
                                   ": save it in the CRS of the map");
}

Result<MapRing> ring_of(OGRGeometryH ring) {
  MapRing positions;
  for (int i = 0; i < OGR_G_GetPointCount(ring); ++i) {
    positions.emplace_back(OGR_G_GetX(ring, i), OGR_G_GetY(ring, i));
    if (!positions.back().allFinite()) return fail(Errc::kBadInput, "has coordinates that are not numbers");
  }
  if (positions.size() > 1 && positions.front() == positions.back()) positions.pop_back();
  if (positions.size() < 3) return fail(Errc::kBadInput, "has an outline of fewer than three points");
  return positions;
}

// Adds the polygons of a geometry without curves.
Result<> add_parts(OGRGeometryH geometry, const NamedArea& like, std::vector<NamedArea>& areas) {
  const OGRwkbGeometryType type = wkbFlatten(OGR_G_GetGeometryType(geometry));
  if (type == wkbMultiPolygon || type == wkbGeometryCollection) {
    for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
      COLLINEA_TRY(add_parts(OGR_G_GetGeometryRef(geometry, i), like, areas));
    return {};
  }
  if (type != wkbPolygon) return fail(Errc::kBadInput, std::string("is no polygon but ") + OGRGeometryTypeToName(type));
  NamedArea area = like;
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i) {
    COLLINEA_TRY(MapRing ring, ring_of(OGR_G_GetGeometryRef(geometry, i)));
    area.rings.push_back(std::move(ring));
  }
  if (!area.rings.empty()) areas.push_back(std::move(area));
  return {};
}

Result<> add_feature(OGRFeatureH feature, int field, std::vector<NamedArea>& areas) {
  if (!OGR_F_IsFieldSetAndNotNull(feature, field) || *OGR_F_GetFieldAsString(feature, field) == 0)
    return fail(Errc::kBadInput, "names no photograph");
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
  if (!geometry || OGR_G_IsEmpty(geometry)) return fail(Errc::kBadInput, "has no polygon");
  const Geometry straight(OGR_G_GetLinearGeometry(geometry, 0, nullptr));
  if (!straight) return fail(Errc::kBadInput, "has curves that cannot be made straight");
  const std::size_t before = areas.size();
  const NamedArea like{OGR_F_GetFID(feature), OGR_F_GetFieldAsString(feature, field), {}};
  COLLINEA_TRY(add_parts(straight.get(), like, areas));
  if (areas.size() == before) return fail(Errc::kBadInput, "has no polygon");
  if (!OGR_G_IsValid(straight.get()))
    return fail(Errc::kBadInput,
                "has a broken outline (it crosses itself, or a hole lies outside): mend it with "
                "\"Fix geometries\" of QGIS");
  return {};
}

OGRLayerH layer_with(void* dataset, const std::string& field) {
  for (int i = 0; i < GDALDatasetGetLayerCount(dataset); ++i) {
    const OGRLayerH layer = GDALDatasetGetLayer(dataset, i);
    if (OGR_FD_GetFieldIndex(OGR_L_GetLayerDefn(layer), field.c_str()) >= 0) return layer;
  }
  return nullptr;
}

}  // namespace

Result<std::vector<NamedArea>> read_areas(const std::filesystem::path& path, const std::string& field,
                                          const std::string& wkt) {
  set_up_gdal();
  const GdalErrors errors;
  const auto within = [&](Error error) { return std::move(error).within(path.string()); };
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) return fail(Errc::kNotFound, path.string() + " does not exist");
  const GdalDataset file(GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!file) return errors.error(Errc::kBadFormat, path.string() + " is no vector file that can be read");
  const OGRLayerH layer = layer_with(file.get(), field);
  if (!layer) return fail(Errc::kBadInput, path.string() + ": no layer has a field \"" + field + "\"");
  const int index = OGR_FD_GetFieldIndex(OGR_L_GetLayerDefn(layer), field.c_str());
  if (auto checked = check_crs(OGR_L_GetSpatialRef(layer), wkt); !checked)
    return tl::unexpected(within(std::move(checked).error()));
  std::vector<NamedArea> areas;
  OGR_L_ResetReading(layer);
  while (const std::unique_ptr<void, FeatureDestroyer> feature{OGR_L_GetNextFeature(layer)}) {
    const std::string number = std::to_string(OGR_F_GetFID(feature.get()));
    if (auto added = add_feature(feature.get(), index, areas); !added)
      return fail(added.error().code, path.string() + ": feature " + number + " " + added.error().message);
  }
  if (errors.any()) return errors.error(Errc::kBadFormat, path.string() + " is damaged");
  return areas;
}

}  // namespace collinea
