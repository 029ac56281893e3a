// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace collinea {
namespace {

// Bytes of the UTF-8 sequence that starts here; 0 when it is broken.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80                      ? 1
                             : byte(0) >= 0xc2 && byte(0) < 0xe0 ? 2
                             : byte(0) >= 0xe0 && byte(0) < 0xf0 ? 3
                             : byte(0) >= 0xf0 && byte(0) < 0xf5 ? 4
                                                                 : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return length;
}

std::string points_text(std::span<const Eigen::Vector2d> points) {
  std::string text;
  for (const auto& p : points) fmt::format_to(std::back_inserter(text), "{:.1f},{:.1f} ", p.x(), p.y());
  return text;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const char c = text[0];
    if (length == 0 || (length == 1 && ((c >= 0 && c < 32) || c == 127)))
      result += c == '\n' || c == '\t' ? " " : "\xef\xbf\xbd";
    else if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return result;
}

std::string number_text(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

Svg::Svg(double width, double height, std::string_view label) {
  body_ = fmt::format(
      "<svg viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n",
      width, height, escaped(label));
}

void Svg::line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style) {
  fmt::format_to(std::back_inserter(body_), "<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", style, a.x(),
                 a.y(), b.x(), b.y());
}

void Svg::path(std::span<const Eigen::Vector2d> points, std::string_view style) {
  fmt::format_to(std::back_inserter(body_), "<polyline class=\"{}\" points=\"{}\"/>\n", style, points_text(points));
}

void Svg::polygon(std::span<const Eigen::Vector2d> points, std::string_view style) {
  fmt::format_to(std::back_inserter(body_), "<polygon class=\"{}\" points=\"{}\"/>\n", style, points_text(points));
}

void Svg::circle(const Eigen::Vector2d& centre, double radius, std::string_view style, std::string_view title) {
  fmt::format_to(std::back_inserter(body_), "<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\">", style,
                 centre.x(), centre.y(), radius);
  if (!title.empty()) body_ += "<title>" + escaped(title) + "</title>";
  body_ += "</circle>\n";
}

void Svg::rectangle(double x, double y, double width, double height, std::string_view style, std::string_view fill) {
  fmt::format_to(std::back_inserter(body_),
                 "<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"", style, x, y, width,
                 height);
  if (!fill.empty()) fmt::format_to(std::back_inserter(body_), " fill=\"{}\"", fill);
  body_ += "/>\n";
}

void Svg::image_at(double width, double height, std::string_view address) {
  body_ +=
      fmt::format("<image x=\"0\" y=\"0\" width=\"{:.1f}\" height=\"{:.1f}\" href=\"{}\"/>\n", width, height, address);
}

void Svg::area(std::string_view outline, std::string_view fill) {
  fmt::format_to(std::back_inserter(body_), "<path fill=\"{}\" d=\"{}\"/>\n", fill, outline);
}

void Svg::arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view style) {
  line(from, to, style);
  const Eigen::Vector2d shaft = to - from;
  if (!(shaft.norm() > 2)) return;
  const Eigen::Vector2d along = shaft.normalized() * std::min(6.0, 0.4 * shaft.norm()), across(-along.y(), along.x());
  const std::array<Eigen::Vector2d, 3> head = {to - along + 0.45 * across, to, to - along - 0.45 * across};
  path(head, style);
}

void Svg::text(const Eigen::Vector2d& at, std::string_view text, std::string_view anchor, std::string_view style) {
  fmt::format_to(std::back_inserter(body_),
                 "<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", style, at.x(), at.y(),
                 anchor, escaped(text));
}

void Svg::vertical_text(const Eigen::Vector2d& at, std::string_view text) {
  fmt::format_to(
      std::back_inserter(body_),
      "<text class=\"label\" text-anchor=\"middle\" transform=\"translate({:.1f} {:.1f}) rotate(-90)\">{}</text>\n",
      at.x(), at.y(), escaped(text));
}

std::string Svg::finish() const { return body_ + "</svg>"; }

double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0})
    if (value >= factor * power) return factor * power;
  return power;
}

double round_above(double value) {
  const double below = round_below(value);
  const double power = std::pow(10, std::floor(std::log10(below) + 1e-9));
  double above = below;
  for (const double factor : {2.0, 5.0, 10.0})
    if (above < value * (1 - 1e-9)) above = factor * power;
  return above;
}

std::vector<double> multiples(double step, double low, double high) {
  std::vector<double> values;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) values.push_back(i * step);
  return values;
}

std::vector<double> ticks(double low, double high, int most) {
  if (!(high > low) || !std::isfinite(high - low)) return {};
  return multiples(round_above((high - low) / most), low, high);
}

std::string tick_text(double value, double step) {
  const int decimals = step >= 1 || !(step > 0) ? 0 : int(std::ceil(-std::log10(step) - 1e-9));
  return number_text(value, std::min(decimals, 8));
}

void draw_axes(Svg& svg, const Axis& x, const Axis& y, std::string_view x_title, std::string_view y_title) {
  const double left = x.pixel_low, right = x.pixel_high, bottom = y.pixel_low, top = y.pixel_high;
  const auto x_ticks = ticks(x.low, x.high, 8), y_ticks = ticks(y.low, y.high, 5);
  const auto step_of = [](const std::vector<double>& t) { return t.size() > 1 ? t[1] - t[0] : 1.0; };
  for (const double value : y_ticks) {
    svg.line({left, y(value)}, {right, y(value)}, "grid");
    svg.text({left - 6, y(value) + 4}, tick_text(value, step_of(y_ticks)), "end");
  }
  for (const double value : x_ticks) {
    svg.line({x(value), bottom}, {x(value), bottom + 4}, "axis");
    svg.text({x(value), bottom + 17}, tick_text(value, step_of(x_ticks)), "middle");
  }
  svg.line({left, bottom}, {right, bottom}, "axis");
  svg.text({(left + right) / 2, bottom + 34}, x_title, "middle");
  svg.vertical_text({left - 46, (top + bottom) / 2}, y_title);
}

}  // namespace collinea
