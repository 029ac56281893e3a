// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/geopackage.h"

#include <cpl_string.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <set>

#include "collinea/vector/internal/folded_name.h"
#include "collinea/vector/internal/layer_style.h"
#include "collinea/vector/internal/vector_file.h"

namespace collinea {
namespace {

struct FeatureDestroyer {
  void operator()(void* feature) const { OGR_F_Destroy(feature); }
};

OGRwkbGeometryType geometry_type(const VectorLayer& layer) {
  const OGRwkbGeometryType type = layer.kind == VectorKind::kPoint  ? wkbPoint
                                  : layer.kind == VectorKind::kLine ? wkbLineString
                                                                    : wkbPolygon;
  return layer.flat ? type : OGR_GT_SetZ(type);
}

OGRFieldType field_type(VectorType type) {
  return type == VectorType::kReal ? OFTReal : type == VectorType::kInteger ? OFTInteger64 : OFTString;
}

class CreationOptions {
 public:
  CreationOptions() = default;
  CreationOptions(const CreationOptions&) = delete;
  CreationOptions& operator=(const CreationOptions&) = delete;
  ~CreationOptions() { CSLDestroy(list_); }
  void set(const char* name, const std::string& value) { list_ = CSLSetNameValue(list_, name, value.c_str()); }
  [[nodiscard]] char** list() const { return list_; }

 private:
  char** list_ = nullptr;
};

OGRLayerH made_layer(void* dataset, const VectorLayer& layer, void* srs) {
  CreationOptions options;
  if (!layer.description.empty()) options.set("DESCRIPTION", layer.description);
  if (!layer.indexed) options.set("SPATIAL_INDEX", "NO");
  const OGRLayerH made = GDALDatasetCreateLayer(dataset, layer.name.c_str(), srs, geometry_type(layer), options.list());
  for (std::size_t i = 0; made && i < layer.fields.size(); ++i) {
    const OGRFieldDefnH field = OGR_Fld_Create(layer.fields[i].name.c_str(), field_type(layer.fields[i].type));
    const OGRErr failed = OGR_L_CreateField(made, field, TRUE);
    OGR_Fld_Destroy(field);
    if (failed != OGRERR_NONE) return nullptr;
  }
  return made;
}

void set_value(OGRFeatureH feature, int field, const VectorValue& value) {
  if (const double* real = std::get_if<double>(&value); real && std::isfinite(*real))
    OGR_F_SetFieldDouble(feature, field, *real);
  else if (const std::int64_t* whole = std::get_if<std::int64_t>(&value))
    OGR_F_SetFieldInteger64(feature, field, *whole);
  else if (const std::string* text = std::get_if<std::string>(&value))
    OGR_F_SetFieldString(feature, field, text->c_str());
  else
    OGR_F_SetFieldNull(feature, field);
}

void add_positions(OGRGeometryH line, const std::vector<Eigen::Vector3d>& positions, bool flat) {
  for (const Eigen::Vector3d& position : positions)
    flat ? OGR_G_AddPoint_2D(line, position.x(), position.y())
         : OGR_G_AddPoint(line, position.x(), position.y(), position.z());
}

bool add_ring(OGRGeometryH polygon, std::vector<Eigen::Vector3d> positions, bool flat) {
  const OGRGeometryH ring = OGR_G_CreateGeometry(wkbLinearRing);
  if (!positions.empty()) positions.push_back(positions.front());
  add_positions(ring, positions, flat);
  return OGR_G_AddGeometryDirectly(polygon, ring) == OGRERR_NONE;
}

// The feature takes what it is given.
bool set_positions(OGRFeatureH feature, const VectorLayer& layer, const VectorRow& row) {
  const OGRGeometryH geometry = OGR_G_CreateGeometry(geometry_type(layer));
  bool added = true;
  if (layer.kind == VectorKind::kPolygon) {
    added = add_ring(geometry, row.positions, layer.flat);
    for (const auto& hole : row.holes) added = added && add_ring(geometry, hole, layer.flat);
  } else {
    add_positions(geometry, row.positions, layer.flat);
  }
  return OGR_F_SetGeometryDirectly(feature, geometry) == OGRERR_NONE && added;
}

bool add_rows(OGRLayerH made, const VectorLayer& layer) {
  const bool begun = OGR_L_StartTransaction(made) == OGRERR_NONE;
  for (const VectorRow& row : layer.rows) {
    COLLINEA_CHECK(row.values.size() == layer.fields.size());
    const std::unique_ptr<void, FeatureDestroyer> feature(OGR_F_Create(OGR_L_GetLayerDefn(made)));
    for (std::size_t i = 0; i < row.values.size(); ++i) set_value(feature.get(), int(i), row.values[i]);
    if (!set_positions(feature.get(), layer, row) || OGR_L_CreateFeature(made, feature.get()) != OGRERR_NONE)
      return false;
  }
  return !begun || OGR_L_CommitTransaction(made) == OGRERR_NONE;
}

// The table that QGIS looks for styles in: its columns, and what is the same in every row.
struct StyleColumn {
  const char* name;
  OGRFieldType type;
  const char* value;  // nullptr: of the layer
};
constexpr StyleColumn kStyleColumns[] = {{"f_table_catalog", OFTString, ""},
                                         {"f_table_schema", OFTString, ""},
                                         {"f_table_name", OFTString, nullptr},
                                         {"f_geometry_column", OFTString, nullptr},
                                         {"styleName", OFTString, "collinea"},
                                         {"styleQML", OFTString, nullptr},
                                         {"styleSLD", OFTString, ""},
                                         {"useAsDefault", OFTInteger, "1"},
                                         {"description", OFTString, ""},
                                         {"owner", OFTString, ""},
                                         {"ui", OFTString, ""},
                                         {"update_time", OFTDateTime, "2000/01/01 00:00:00"}};

OGRLayerH made_style_table(void* dataset) {
  CreationOptions options;
  options.set("FID", "id");
  const OGRLayerH made = GDALDatasetCreateLayer(dataset, "layer_styles", nullptr, wkbNone, options.list());
  for (const StyleColumn& column : kStyleColumns) {
    if (!made) break;
    const OGRFieldDefnH field = OGR_Fld_Create(column.name, column.type);
    if (column.type == OFTInteger) OGR_Fld_SetSubType(field, OFSTBoolean);
    const OGRErr failed = OGR_L_CreateField(made, field, TRUE);
    OGR_Fld_Destroy(field);
    if (failed != OGRERR_NONE) return nullptr;
  }
  return made;
}

bool add_style(OGRLayerH table, const VectorLayer& layer, const std::string& geometry_column) {
  const std::unique_ptr<void, FeatureDestroyer> feature(OGR_F_Create(OGR_L_GetLayerDefn(table)));
  const std::string of_layer[] = {layer.name, geometry_column, qml_of(layer)};
  std::size_t next = 0;
  for (std::size_t i = 0; i < std::size(kStyleColumns); ++i)
    OGR_F_SetFieldString(feature.get(), int(i),
                         kStyleColumns[i].value ? kStyleColumns[i].value : of_layer[next++].c_str());
  return OGR_L_CreateFeature(table, feature.get()) == OGRERR_NONE;
}

bool add_styles(void* dataset, const std::vector<VectorLayer>& layers) {
  OGRLayerH table = nullptr;
  for (const VectorLayer& layer : layers) {
    if (!layer.style) continue;
    if (!table) table = made_style_table(dataset);
    const OGRLayerH its = GDALDatasetGetLayerByName(dataset, layer.name.c_str());
    if (!table || !its || !add_style(table, layer, OGR_L_GetGeometryColumn(its))) return false;
  }
  return true;
}

Result<> check_names(const std::vector<VectorLayer>& layers) {
  std::set<std::string> names;
  for (const VectorLayer& layer : layers) {
    if (layer.name.empty()) return fail(Errc::kBadInput, "a layer of a GeoPackage has a name");
    if (is_reserved_table(layer.name))
      return fail(Errc::kBadInput, "no layer of a GeoPackage can be called \"" + layer.name +
                                       "\": the format keeps this name for itself");
    if (!names.insert(folded_name(layer.name)).second)
      return fail(Errc::kBadInput, "two layers of a GeoPackage are called \"" + layer.name + "\"");
  }
  return {};
}

}  // namespace

bool is_reserved_table(std::string_view name) {
  const std::string text = folded_name(name);
  return text.starts_with("sqlite_") || text.starts_with("gpkg_") || text.starts_with("rtree_") ||
         text == "layer_styles";
}

Result<> write_geopackage(const std::filesystem::path& path, const std::vector<VectorLayer>& layers,
                          const std::string& wkt) {
  COLLINEA_TRY(check_names(layers));
  set_up_gdal();
  const FixedDate date;
  VectorFile file;
  COLLINEA_TRY(file.create("GPKG", path));
  const GdalErrors errors;
  const GdalSrs srs(wkt.empty() ? nullptr : OSRNewSpatialReference(wkt.c_str()));
  for (const VectorLayer& layer : layers) {
    const OGRLayerH made = made_layer(file.dataset(), layer, srs.get());
    if (!made || !add_rows(made, layer) || errors.any()) return file.not_written(errors);
  }
  if (!add_styles(file.dataset(), layers) || errors.any()) return file.not_written(errors);
  return file.finish();
}

}  // namespace collinea
