// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/internal/layer_style.h"

#include <sstream>

#include "collinea/base/file_text.h"

namespace collinea {
namespace {

constexpr FileText kDocumentType = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n";

std::string number(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

std::string colour(const VectorStyle& style, int opacity) {
  std::string text;
  for (const std::uint8_t part : style.colour) text += std::to_string(part) + ",";
  return text + std::to_string(opacity);
}

std::string property(const char* key, const std::string& value) {
  return std::string("<prop k=\"") + key + "\" v=\"" + value + "\"/>";
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

struct Symbol {
  const char *type, *layer;
  std::string properties;
};

Symbol symbol_of(VectorKind kind, const VectorStyle& style) {
  const std::string line = colour(style, 255), width = number(style.width_mm);
  if (kind == VectorKind::kPoint)
    return {"marker", "SimpleMarker",
            property("name", "circle") + property("color", line) + property("outline_color", line) +
                property("outline_width", width) + property("outline_width_unit", "MM") +
                property("size", number(style.size_mm)) + property("size_unit", "MM")};
  if (kind == VectorKind::kLine)
    return {"line", "SimpleLine",
            property("line_color", line) + property("line_width", width) + property("line_width_unit", "MM") +
                property("line_style", "solid")};
  return {"fill", "SimpleFill",
          property("color", colour(style, style.fill_opacity)) + property("style", "solid") +
              property("outline_color", line) + property("outline_width", width) +
              property("outline_width_unit", "MM") + property("outline_style", "solid")};
}

}  // namespace

std::string qml_of(const VectorLayer& layer) {
  const VectorStyle& style = *layer.style;
  const Symbol symbol = symbol_of(layer.kind, style);
  std::string text = kDocumentType;
  text += std::string("<qgis version=\"3.0.0\" labelsEnabled=\"") + (style.label.empty() ? "0" : "1") + "\">\n";
  text += "<renderer-v2 type=\"singleSymbol\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\"><symbols>";
  text += std::string("<symbol type=\"") + symbol.type + "\" name=\"0\" alpha=\"1\" clip_to_extent=\"1\">";
  text += std::string("<layer class=\"") + symbol.layer + "\" pass=\"0\" locked=\"0\" enabled=\"1\">";
  text += symbol.properties + "</layer></symbol></symbols></renderer-v2>\n";
  if (!style.label.empty())
    text += "<labeling type=\"simple\"><settings><text-style fieldName=\"" + escaped(style.label) +
            "\" isExpression=\"0\" fontSize=\"8\" fontSizeUnit=\"Point\" textColor=\"" + colour(style, 255) +
            "\"/></settings></labeling>\n";
  return text + "</qgis>\n";
}

}  // namespace collinea
