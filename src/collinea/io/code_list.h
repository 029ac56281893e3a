// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/vector/drawing.h"

namespace collinea {

/// The code list of a drawing as a table (io/text_table.h) with code, layer, kind (point, line, polygon), colour
/// (c00000, red, green and blue; may be missing) and meaning (may be missing):
///
///     code; layer; kind; colour; meaning
///     R1; roof; polygon; c0392b; outline of a roof
///
/// Errors: the table; a code twice, a kind or colour that is none, more than kMostCodes; with their row.
[[nodiscard]] Result<std::vector<DrawingCode>> parse_code_list(std::string_view text);
inline constexpr std::size_t kMostCodes = 2000;

/// The code list that comes with the program.
[[nodiscard]] std::string_view default_code_list();

/// That of a file; of a folder the list in its codes.txt, or else the one that comes with the program. Errors name the
/// file.
[[nodiscard]] Result<std::vector<DrawingCode>> read_code_list(const std::filesystem::path& file);
[[nodiscard]] Result<std::vector<DrawingCode>> code_list_of(const std::filesystem::path& folder);

}  // namespace collinea
