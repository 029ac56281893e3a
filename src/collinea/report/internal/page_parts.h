// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/io/text_table.h"
#include "collinea/report/internal/figures.h"

namespace collinea {

// Parts that several pages have in common.

/// A JPEG file as the address of an image.
[[nodiscard]] std::string jpeg_address(std::string_view jpeg);
[[nodiscard]] std::string image_element(const Preview& preview, std::string_view name);
/// A line of a list of facts.
[[nodiscard]] std::string fact(std::string_view name, const std::string& value, bool wide = false);
[[nodiscard]] std::string count_text(std::size_t count);  ///< 1,234,567
/// A table without its remarks, the first column to the left.
[[nodiscard]] std::string table_element(const TextTable& table);

}  // namespace collinea
