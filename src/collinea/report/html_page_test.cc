// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/html_page.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "collinea/base/source_tree.h"

namespace collinea {
namespace {

std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

std::string table(int columns) {
  std::string html = "<table><thead><tr><th class=\"l\">name</th>";
  for (int i = 1; i < columns; ++i) html += "<th></th>";
  return html + "</tr></thead><tbody>\n<tr><td>1</td></tr>\n</tbody></table>";
}

TEST(HtmlPage, EveryTableStandsInAFrameBySizeOfWhatItHolds) {
  const std::string body = "<p>a</p>" + table(3) + "<p>b</p>" + table(12) + table(40) +
                           "<table class=\"pairs\"><tbody>" +
                           "<tr><td class=\"l\">a</td><td>b</td></tr></tbody></table><p>c</p>";
  const std::string framed = with_framed_tables(body);
  EXPECT_EQ(framed, "<p>a</p><div class=\"table\">" + table(3) + "</div><p>b</p><div class=\"table many\">" +
                        table(12) + "</div><div class=\"table crowd\">" + table(40) + "</div><div class=\"table\">" +
                        "<table class=\"pairs\"><tbody><tr><td class=\"l\">a</td><td>b</td></tr></tbody></table></div>"
                        "<p>c</p>");
  EXPECT_EQ(with_framed_tables(""), "");
}

// What makes the tables fit: their frames scroll, cells break lines, and on paper heads come again.
TEST(HtmlPage, CellsBreakLinesAndFramesScrollAndPaperIsA4) {
  const std::string style = kStyleSheet;
  for (const char* rule : {".table { overflow-x: auto;", ".table { overflow: visible; }", "@page {\n  size: A4;",
                           "thead { display: table-header-group; }", "tr { break-inside: avoid; }"})
    EXPECT_EQ(count_of(style, rule), 1u) << rule;
  std::istringstream lines(style);
  for (std::string line; std::getline(lines, line);) {
    const bool of_cells = line.starts_with("td") || line.starts_with("th") || line.find(" td") != line.npos;
    EXPECT_FALSE(of_cells && line.find("nowrap") != line.npos) << line;
  }
}

TEST(HtmlPage, ATitleCannotLeaveItsPlace) {
  const std::string page = whole_page({"a\"b</style><b>\\", "plan", "Plan", ""}, "<p>body</p>");
  EXPECT_EQ(count_of(page, "</style"), 1u);
  EXPECT_EQ(count_of(page, "<b>"), 0u);
  EXPECT_EQ(count_of(page, "content: \"a\\22 b\\3c \\2f style"), 1u) << page;
}

// Only so are all pages framed.
TEST(HtmlPage, NoOtherSourceBeginsAPage) {
  int pages = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(source_tree()) / "src/collinea")) {
    if (entry.path().extension() != ".cc" || entry.path().filename().string().ends_with("_test.cc")) continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    if (text.str().find("DOCTYPE html") == std::string::npos) continue;
    ++pages;
    EXPECT_EQ(entry.path().filename(), "html_page.cc");
  }
  EXPECT_EQ(pages, 1);
}

}  // namespace
}  // namespace collinea
