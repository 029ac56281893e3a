// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/code_list.h"

#include <set>
#include <string>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/io/text_table.h"

namespace collinea {
namespace {

constexpr FileText kDefault =
    R"(# What is drawn on which layer: own lists stand in codes.txt of a project, in this form.
code; layer; kind; colour; meaning
B; building; polygon; c0392b; outline of a building at the ground
R; roof; polygon; e67e22; surface of a roof
RL; roof; line; e67e22; ridge, eaves or verge
RD; road; line; 5d6d7e; edge of a road
RC; road; line; 5d6d7e; kerb
PA; path; line; a04000; path
W; water; polygon; 2471a3; standing water
WL; water; line; 2471a3; bank or axis of running water
WA; wall; line; 7b241c; wall
FE; fence; line; 7d6608; fence
BT; breakline; line; 6c3483; top of a slope
BB; breakline; line; 6c3483; foot of a slope
VE; vegetation; polygon; 1e8449; edge of trees or shrubs
TR; tree; point; 196f3d; tree
MH; manhole; point; 1b2631; manhole or gully
PO; pole; point; 1b2631; pole, mast or lamp
SP; height; point; 000000; spot height
X; other; line; c00000; anything else
)";

Result<DrawingCode> code_in(const TextTable& table, const std::vector<std::string>& row) {
  const auto word = [&](const char* name) {
    const auto column = table.find(name);
    return column && row[*column] != "-" ? row[*column] : std::string();
  };
  DrawingCode code{.code = word("code"), .layer = word("layer"), .meaning = word("meaning")};
  if (code.code.empty() || code.layer.empty()) return fail(Errc::kBadFormat, "code or layer is missing");
  const auto kind = from_word<VectorKind>(word("kind"));
  if (!kind) return fail(Errc::kBadFormat, "\"" + word("kind") + "\" is no kind: it is point, line or polygon");
  code.kind = *kind;
  if (const std::string text = word("colour"); !text.empty()) {
    const auto colour = colour_in(text[0] == '#' ? text : "#" + text);  // a # begins a remark, even within a line
    if (!colour) return fail(Errc::kBadFormat, "\"" + text + "\" is no colour such as c00000");
    code.colour = *colour;
  }
  return code;
}

}  // namespace

Result<std::vector<DrawingCode>> parse_code_list(std::string_view text) {
  COLLINEA_TRY(const TextTable table, parse_text_table(text));
  for (const char* column : {"code", "layer", "kind"})
    if (const auto words = table.words(column); !words) return tl::unexpected(words.error());
  if (table.rows.size() > kMostCodes)
    return fail(Errc::kBadFormat, "a code list has at most " + std::to_string(kMostCodes) + " codes");
  std::vector<DrawingCode> codes;
  std::set<std::string> known;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::string row = "row " + std::to_string(i + 1);
    COLLINEA_TRY(DrawingCode code,
                 code_in(table, table.rows[i]).map_error([&](Error e) { return std::move(e).within(row); }));
    if (!known.insert(code.code).second) return fail(Errc::kBadFormat, row + ": code " + code.code + " stands twice");
    codes.push_back(std::move(code));
  }
  return codes;
}

std::string_view default_code_list() { return kDefault; }

Result<std::vector<DrawingCode>> read_code_list(const std::filesystem::path& file) {
  COLLINEA_TRY(const std::string text, read_file(file));
  return parse_code_list(text).map_error([&](Error e) { return std::move(e).within(file.string()); });
}

Result<std::vector<DrawingCode>> code_list_of(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "codes.txt";
  return is_there(file) ? read_code_list(file) : parse_code_list(default_code_list());
}

}  // namespace collinea
