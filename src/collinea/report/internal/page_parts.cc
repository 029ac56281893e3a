// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/page_parts.h"

#include <fmt/format.h>

#include <cstdint>

#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k)
      triple = triple << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[triple >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string jpeg_address(std::string_view jpeg) { return "data:image/jpeg;base64," + base64(jpeg); }

std::string image_element(const Preview& preview, std::string_view name) {
  return fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"{}\">", name, preview.width, preview.height,
                     jpeg_address(preview.jpeg));
}

std::string fact(std::string_view name, const std::string& value, bool wide) {
  return fmt::format("<div{}><dt>{}</dt><dd>{}</dd></div>\n", wide ? " class=\"wide\"" : "", name, escaped(value));
}

std::string count_text(std::size_t count) {
  std::string digits = std::to_string(count);
  for (auto at = std::ptrdiff_t(digits.size()) - 3; at > 0; at -= 3) digits.insert(std::size_t(at), 1, ',');
  return digits;
}

std::string table_element(const TextTable& table) {
  std::string html = "<table><thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const TableColumn& column = table.columns[i];
    html += fmt::format("<th{}>{}{}</th>", i == 0 ? " class=\"l\"" : "", escaped(column.name),
                        column.unit.empty() ? "" : " [" + escaped(column.unit) + "]");
  }
  html += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      html += i == 0 ? text_cell(row[i]) : fmt::format("<td>{}</td>", escaped(row[i]));
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

}  // namespace collinea
