// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "collinea/block/block.h"

namespace collinea {

/// Cells of the tables of both pages. A value that is not known is a dash.
[[nodiscard]] std::string cell(double value, int decimals);
[[nodiscard]] std::string text_cell(std::string_view text, std::string_view style = "l");
/// So many decimals that each of these standard deviations shows two significant digits, but not fewer than `least`:
/// millimetres from the air, micrometres of an object on a table. What is not known and what is below 1e-8 (a hundredth
/// of a micrometre, rounding of what is exact) does not count.
[[nodiscard]] int decimals_for(std::span<const double> sigmas, int least);
[[nodiscard]] int decimals_for(double sigma, int least);
/// A signed difference; marked when it exceeds three of its standard deviations.
[[nodiscard]] std::string difference_cell(double value, double sigma, int decimals);

/// A text as a field of a table of commas (RFC 4180), in quotes: names may hold commas and quotes.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace collinea
