// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/dxf.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <span>
#include <string>
#include <string_view>

#include "collinea/base/file.h"

namespace collinea {
namespace {

constexpr int kPolylineOf3d = 8, kClosed = 1, kVertexOf3d = 32;

// Pairs of a line with a group code and one with its value.
class Drawing {
 public:
  void pair(int code, std::string_view value) {
    text_ += std::to_string(code) + "\n";
    text_ += value;
    text_ += "\n";
  }
  void number(int code, double value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, 6).ptr;
    pair(code, std::string_view(digits, std::size_t(end - digits)));
  }
  void position(const Eigen::Vector3d& p) {
    for (int k = 0; k < 3; ++k) number(10 * (k + 1), p[k]);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string layer_name(std::string_view name) {
  std::string out;
  for (const char c : name)
    out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '$' ? c : '_';
  return out.empty() ? "0" : out;
}

void add_layers(Drawing& drawing, const std::vector<VectorLayer>& layers) {
  drawing.pair(0, "SECTION");
  drawing.pair(2, "TABLES");
  drawing.pair(0, "TABLE");
  drawing.pair(2, "LAYER");
  drawing.pair(70, std::to_string(layers.size()));
  for (std::size_t i = 0; i < layers.size(); ++i) {
    drawing.pair(0, "LAYER");
    drawing.pair(2, layer_name(layers[i].name));
    drawing.pair(70, "0");
    drawing.pair(62, std::to_string(1 + i % 6));  // red, yellow, green, cyan, blue, magenta
    drawing.pair(6, "CONTINUOUS");
  }
  drawing.pair(0, "ENDTAB");
  drawing.pair(0, "ENDSEC");
}

void add_polyline(Drawing& drawing, const std::string& layer, std::span<const Eigen::Vector3d> positions,
                  bool is_closed) {
  if (is_closed && positions.size() > 1 && positions.front() == positions.back())
    positions = positions.first(positions.size() - 1);
  if (positions.size() < 2) return;
  drawing.pair(0, "POLYLINE");
  drawing.pair(8, layer);
  drawing.pair(66, "1");
  drawing.position(Eigen::Vector3d::Zero());
  drawing.pair(70, std::to_string(kPolylineOf3d + (is_closed ? kClosed : 0)));
  for (const Eigen::Vector3d& p : positions) {
    drawing.pair(0, "VERTEX");
    drawing.pair(8, layer);
    drawing.position(p);
    drawing.pair(70, std::to_string(kVertexOf3d));
  }
  drawing.pair(0, "SEQEND");
  drawing.pair(8, layer);
}

void add_row(Drawing& drawing, const VectorLayer& layer, const std::string& name, const VectorRow& row) {
  if (layer.kind == VectorKind::kPoint) {
    if (row.positions.empty()) return;
    drawing.pair(0, "POINT");
    drawing.pair(8, name);
    drawing.position(row.positions.front());
    return;
  }
  const bool is_closed = layer.kind == VectorKind::kPolygon;
  add_polyline(drawing, name, row.positions, is_closed);
  for (const auto& hole : row.holes) add_polyline(drawing, name, hole, true);
}

}  // namespace

Result<> write_dxf(const std::filesystem::path& path, const std::vector<VectorLayer>& layers) {
  Drawing drawing;
  drawing.pair(0, "SECTION");
  drawing.pair(2, "HEADER");
  drawing.pair(9, "$ACADVER");
  drawing.pair(1, "AC1009");
  drawing.pair(0, "ENDSEC");
  add_layers(drawing, layers);
  drawing.pair(0, "SECTION");
  drawing.pair(2, "ENTITIES");
  for (const VectorLayer& layer : layers)
    for (const VectorRow& row : layer.rows) add_row(drawing, layer, layer_name(layer.name), row);
  drawing.pair(0, "ENDSEC");
  drawing.pair(0, "EOF");
  return write_file(path, drawing.text());
}

}  // namespace collinea
