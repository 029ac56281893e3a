// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/block/block.h"

namespace collinea {

/// Cells of the tables of both pages. A value that is not known is a dash.
[[nodiscard]] std::string cell(double value, int decimals);
[[nodiscard]] std::string text_cell(std::string_view text, std::string_view style = "l");
/// A signed difference; marked when it exceeds three of its standard deviations.
[[nodiscard]] std::string difference_cell(double value, double sigma, int decimals);

/// A text as a field of a table of commas (RFC 4180), in quotes: names may hold commas and quotes.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace collinea
