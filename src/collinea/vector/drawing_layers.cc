// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "collinea/base/file_text.h"
#include "collinea/vector/drawing.h"
#include "collinea/vector/geopackage.h"
#include "collinea/vector/internal/folded_name.h"

namespace collinea {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr FileText kVertices = "vertices of all features with their standard deviations";
constexpr const char* kAxes[] = {"e", "n", "h"};

/// Names that differ from each other and from those that files keep for themselves.
class FreeNames {
 public:
  explicit FreeNames(std::initializer_list<const char*> taken) : taken_(taken.begin(), taken.end()) {}
  std::string take(const std::string& wanted) {
    std::string name = wanted;
    for (int i = 2; !taken_.insert(folded_name(name)).second; ++i) name = wanted + "_" + std::to_string(i);
    return name;
  }

 private:
  std::set<std::string> taken_;
};

std::vector<Eigen::Vector3d> positions_of(const DrawnFeature& feature) {
  std::vector<Eigen::Vector3d> positions;
  for (const DrawnVertex& vertex : feature.vertices) positions.push_back(vertex.position);
  return positions;
}

// The largest of all vertices; NaN where one has none.
Eigen::Vector3d largest_sigma(const DrawnFeature& feature) {
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
  for (const DrawnVertex& vertex : feature.vertices) {
    const auto sigma = vertex.sigma_m();
    if (!sigma) return Eigen::Vector3d::Constant(kNaN);
    largest = largest.cwiseMax(*sigma);
  }
  return largest;
}

// One word where all vertices have the same source.
std::string source_of(const DrawnFeature& feature) {
  std::set<std::string> sources;
  for (const DrawnVertex& vertex : feature.vertices) sources.emplace(word_of(vertex.source));
  std::string text;
  for (const std::string& source : sources) text += (text.empty() ? "" : " ") + source;
  return text;
}

VectorStyle style_of(const DrawingLayer& layer) { return {.colour = layer.colour, .width_mm = 0.4}; }

VectorLayer table_of(const std::vector<const DrawnFeature*>& features, const DrawingLayer& layer, VectorKind kind,
                     const std::string& name) {
  VectorLayer table{.name = name, .kind = kind, .fields = {}, .rows = {}, .style = style_of(layer)};
  FreeNames names{"fid", "geom"};
  for (const char* field : {"feature", "layer", "source"})
    table.fields.push_back({names.take(field), VectorType::kText});
  for (const char* axis : kAxes) table.fields.push_back({names.take(std::string("sigma_") + axis + "_m")});
  std::set<std::string> attributes;
  for (const DrawnFeature* feature : features)
    for (const auto& [attribute, value] : feature->attributes) attributes.insert(attribute);
  for (const std::string& attribute : attributes) table.fields.push_back({names.take(attribute), VectorType::kText});
  for (const DrawnFeature* feature : features) {
    VectorRow row{positions_of(*feature), {feature->id, feature->layer, source_of(*feature)}};
    const Eigen::Vector3d sigma = largest_sigma(*feature);
    for (int axis = 0; axis < 3; ++axis) row.values.emplace_back(sigma[axis]);
    for (const std::string& attribute : attributes) {
      const auto value = feature->attributes.find(attribute);
      row.values.push_back(value == feature->attributes.end() ? VectorValue() : VectorValue(value->second));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

VectorLayer vertex_table(const Drawing& drawing) {
  VectorLayer table{.name = "vertices",
                    .kind = VectorKind::kPoint,
                    .fields = {{"feature", VectorType::kText},
                               {"layer", VectorType::kText},
                               {"vertex", VectorType::kInteger},
                               {"source", VectorType::kText}},
                    .rows = {},
                    .description = kVertices};
  for (const char* axis : kAxes) table.fields.push_back({std::string("sigma_") + axis + "_m"});
  for (const char* pair : {"en", "eh", "nh"}) table.fields.push_back({std::string("covariance_") + pair + "_m2"});
  for (const DrawnFeature& feature : drawing.features)
    for (std::size_t i = 0; i < feature.vertices.size(); ++i) {
      const DrawnVertex& vertex = feature.vertices[i];
      const Eigen::Vector3d sigma = vertex.sigma_m().value_or(Eigen::Vector3d::Constant(kNaN));
      const Eigen::Matrix3d c = vertex.covariance_m2.value_or(Eigen::Matrix3d::Constant(kNaN));
      table.rows.push_back({{vertex.position},
                            {feature.id, feature.layer, std::int64_t(i + 1), std::string(word_of(vertex.source)),
                             sigma.x(), sigma.y(), sigma.z(), c(0, 1), c(0, 2), c(1, 2)}});
    }
  return table;
}

// Of each layer and kind that has features.
struct Drawn {
  DrawingLayer layer;
  VectorKind kind;
  std::vector<const DrawnFeature*> features;
};
std::vector<Drawn> drawn_by_layer(const Drawing& drawing, std::span<const DrawingCode> codes) {
  std::vector<Drawn> all;
  for (const DrawingLayer& layer : layers_of(drawing, codes))
    for (const VectorKind kind : {VectorKind::kPoint, VectorKind::kLine, VectorKind::kPolygon}) {
      Drawn drawn{layer, kind, {}};
      for (const DrawnFeature& feature : drawing.features)
        if (feature.layer == layer.name && feature.kind == kind) drawn.features.push_back(&feature);
      if (!drawn.features.empty()) all.push_back(std::move(drawn));
    }
  return all;
}

}  // namespace

std::vector<VectorLayer> vector_layers(const Drawing& drawing, std::span<const DrawingCode> codes) {
  std::vector<VectorLayer> tables;
  FreeNames names{"vertices"};
  for (const Drawn& one : drawn_by_layer(drawing, codes)) {
    const std::string name = one.layer.name + "_" + std::string(word_of(one.kind));
    tables.push_back(
        table_of(one.features, one.layer, one.kind, names.take(is_reserved_table(name) ? "layer_" + name : name)));
  }
  tables.push_back(vertex_table(drawing));
  return tables;
}

std::vector<VectorLayer> plain_layers(const Drawing& drawing, std::span<const DrawingCode> codes) {
  std::vector<VectorLayer> layers;
  for (const Drawn& one : drawn_by_layer(drawing, codes)) {
    VectorLayer layer{.name = one.layer.name, .kind = one.kind, .fields = {}, .rows = {}, .style = style_of(one.layer)};
    for (const DrawnFeature* feature : one.features) layer.rows.push_back({positions_of(*feature), {}});
    layers.push_back(std::move(layer));
  }
  return layers;
}

}  // namespace collinea
