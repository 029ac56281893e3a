// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/dxf.h"

#include <ogr_api.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/vector/drawing.h"
#include "collinea/vector/internal/vector_file.h"

namespace collinea {
namespace {

struct FeatureDestroyer {
  void operator()(void* feature) const { OGR_F_Destroy(feature); }
};

std::string layer_name(std::string_view name) {
  std::string out;
  for (const char c : name)
    out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '$' ? c : '_';
  return out.empty() ? "0" : out;
}

// A style as GDAL reads it.
std::string pen(const LayerColour& colour) { return "PEN(c:" + text_of(colour) + ")"; }

std::string in_xml(std::string_view text) {
  constexpr std::pair<char, const char*> kEntities[] = {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string out;
  for (const char c : text) {
    const auto entity = std::ranges::find(kEntities, c, &std::pair<char, const char*>::first);
    if (entity == std::end(kEntities))
      out += c;
    else
      out += entity->second;
  }
  return out;
}

OGRGeometryH point(const Eigen::Vector3d& position) {
  const OGRGeometryH made = OGR_G_CreateGeometry(wkbPoint25D);
  OGR_G_AddPoint(made, position.x(), position.y(), position.z());
  return made;
}

OGRGeometryH line(const std::vector<Eigen::Vector3d>& positions, bool is_closed) {
  const OGRGeometryH made = OGR_G_CreateGeometry(wkbLineString25D);
  for (const Eigen::Vector3d& p : positions) OGR_G_AddPoint(made, p.x(), p.y(), p.z());
  if (const Eigen::Vector3d& first = positions.front(); is_closed && positions.back() != first)
    OGR_G_AddPoint(made, first.x(), first.y(), first.z());
  return made;
}

// The entity takes the geometry.
bool add_entity(OGRLayerH entities, const VectorLayer& layer, OGRGeometryH geometry) {
  const std::unique_ptr<void, FeatureDestroyer> entity(OGR_F_Create(OGR_L_GetLayerDefn(entities)));
  OGR_F_SetFieldString(entity.get(), OGR_F_GetFieldIndex(entity.get(), "Layer"), layer_name(layer.name).c_str());
  if (layer.style) OGR_F_SetStyleString(entity.get(), pen(layer.style->colour).c_str());
  return OGR_F_SetGeometryDirectly(entity.get(), geometry) == OGRERR_NONE &&
         OGR_L_CreateFeature(entities, entity.get()) == OGRERR_NONE;
}

bool add_row(OGRLayerH entities, const VectorLayer& layer, const VectorRow& row) {
  if (row.positions.empty()) return true;
  if (layer.kind == VectorKind::kPoint) return add_entity(entities, layer, point(row.positions.front()));
  const bool is_closed = layer.kind == VectorKind::kPolygon;
  bool added = row.positions.size() < 2 || add_entity(entities, layer, line(row.positions, is_closed));
  for (const auto& hole : row.holes)
    added = added && (hole.size() < 2 || add_entity(entities, layer, line(hole, true)));
  return added;
}

}  // namespace

Result<> write_dxf(const std::filesystem::path& path, const std::vector<VectorLayer>& layers) {
  set_up_gdal();
  VectorFile file;
  COLLINEA_TRY(file.create("DXF", path));
  {
    const GdalErrors errors;
    const OGRLayerH entities = GDALDatasetCreateLayer(file.dataset(), "entities", nullptr, wkbUnknown, nullptr);
    if (!entities) return file.not_written(errors);
    for (const VectorLayer& layer : layers)
      for (const VectorRow& row : layer.rows)
        if (!add_row(entities, layer, row) || errors.any()) return file.not_written(errors);
  }
  return file.finish();
}

Result<> write_dxf_layers(const std::filesystem::path& path, const std::string& dxf,
                          const std::vector<VectorLayer>& layers, const std::string& wkt) {
  std::set<std::string> names;
  for (const VectorLayer& layer : layers)
    if (!layer.rows.empty()) names.insert(layer_name(layer.name));
  std::string text = "<OGRVRTDataSource>\n";
  for (const std::string& name : names)  // of letters, digits, _, - and $ alone
    text += "  <OGRVRTLayer name=\"" + name + "\">\n    <SrcDataSource relativeToVRT=\"1\">" + in_xml(dxf) +
            "</SrcDataSource>\n    <SrcSQL>SELECT * FROM entities WHERE Layer = '" + name +
            "'</SrcSQL>\n    <LayerSRS>" + in_xml(wkt) + "</LayerSRS>\n  </OGRVRTLayer>\n";
  return write_file(path, text + "</OGRVRTDataSource>\n");
}

}  // namespace collinea
