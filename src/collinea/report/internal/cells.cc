// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

constexpr const char* kUnknown = "\xe2\x80\x93";  // a dash

}  // namespace

std::string cell(double value, int decimals) {
  return fmt::format("<td>{}</td>", std::isfinite(value) ? number_text(value, decimals) : kUnknown);
}

int decimals_for(double sigma, int least) {
  constexpr double kLeast = 1e-8;
  if (!std::isfinite(sigma) || !(sigma >= kLeast)) return least;
  return std::max(least, 1 - static_cast<int>(std::floor(std::log10(sigma))));
}

int decimals_for(std::span<const double> sigmas, int least) {
  for (const double sigma : sigmas) least = decimals_for(sigma, least);
  return least;
}

std::string text_cell(std::string_view text, std::string_view style) {
  return fmt::format("<td class=\"{}\">{}</td>", style, escaped(text));
}

std::string difference_cell(double value, double sigma, int decimals) {
  if (!std::isfinite(value)) return cell(value, decimals);
  return fmt::format("<td{}>{:+.{}f}</td>", std::abs(value) > 3 * sigma ? " class=\"bad\"" : "", value, decimals);
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace collinea
