// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

constexpr std::string_view kTable = "<table", kTableEnd = "</table>", kRow = "<tr", kRowEnd = "</tr>";

std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

// Of the first row: of the heads, where there are any.
std::size_t columns_of(std::string_view table) {
  const auto from = table.find(kRow), to = table.find(kRowEnd);
  if (from == table.npos || to == table.npos || to < from) return 0;
  const std::string_view row = table.substr(from, to - from);
  return std::max(count_of(row, "<th>") + count_of(row, "<th "), count_of(row, "<td>") + count_of(row, "<td "));
}

// How small the type must be on paper (the style sheet): A4 has room for about ten columns of numbers and a name.
const char* style_of(std::size_t columns) {
  return columns > 22 ? "table crowd" : columns > 9 ? "table many" : "table";
}

// A text as a string of a style sheet: whatever could end it is written by its number.
std::string css_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 || std::isalnum(byte) || c == ' ' || c == '.' || c == ',' || c == ':')
      out += c;
    else
      out += fmt::format("\\{:x} ", byte);
  }
  return out + "\"";
}

}  // namespace

std::string with_framed_tables(std::string_view body) {
  std::string out;
  out.reserve(body.size() + body.size() / 50);
  std::size_t done = 0;
  for (auto at = body.find(kTable); at != body.npos; at = body.find(kTable, done)) {
    auto end = body.find(kTableEnd, at);
    end = end == body.npos ? body.size() : end + kTableEnd.size();
    const std::string_view table = body.substr(at, end - at);
    out += body.substr(done, at - done);
    out += fmt::format("<div class=\"{}\">{}</div>", style_of(columns_of(table)), table);
    done = end;
  }
  return out.append(body.substr(done));
}

std::string whole_page(const PageHead& head, std::string_view body) {
  const std::string title = escaped(head.title);
  const std::string sheet = css_string(head.title + ": " + head.kind + ", collinea " COLLINEA_VERSION);
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + title + ": " +
         escaped(head.kind) +
         "</title>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<style>" + kStyleSheet +
         "@page { @bottom-left { content: " + sheet + "; } }\n</style></head>\n<body><main>\n<header><div><h1>" +
         title + "</h1>" + escaped(head.about) + "</div><p>collinea " COLLINEA_VERSION +
         (head.date.empty() ? "" : "<br>" + escaped(head.date)) + "</p></header>\n" + with_framed_tables(body) +
         "</main></body></html>\n";
}

}  // namespace collinea
