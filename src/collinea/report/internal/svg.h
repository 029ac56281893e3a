// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace collinea {

/// Text as it may stand in HTML: markup characters escaped, control characters and broken UTF-8 replaced.
[[nodiscard]] std::string escaped(std::string_view text);

/// With a fixed number of decimals; what rounds to zero has no sign.
[[nodiscard]] std::string number_text(double value, int decimals);

/// A drawing for an HTML page. Positions in pixels, x right, y down; looks come from the page's style classes.
class Svg {
 public:
  Svg(double width, double height, std::string_view label);
  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style);
  void path(std::span<const Eigen::Vector2d> points, std::string_view style);  ///< open
  void polygon(std::span<const Eigen::Vector2d> points, std::string_view style);
  void circle(const Eigen::Vector2d& centre, double radius, std::string_view style, std::string_view title = "");
  void rectangle(double x, double y, double width, double height, std::string_view style, std::string_view fill = "");
  void image_at(double width, double height, std::string_view address);  ///< from the upper left corner
  void area(std::string_view outline, std::string_view fill);            ///< `outline` in the language of SVG paths
  void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view style);
  /// `anchor`: start, middle or end.
  void text(const Eigen::Vector2d& at, std::string_view text, std::string_view anchor = "start",
            std::string_view style = "label");
  void vertical_text(const Eigen::Vector2d& at, std::string_view text);  ///< reads upwards, centred
  [[nodiscard]] std::string finish() const;

 private:
  std::string body_;
};

/// A scale of a chart: values to pixels.
struct Axis {
  double low = 0, high = 1;              ///< values
  double pixel_low = 0, pixel_high = 1;  ///< where they are drawn
  [[nodiscard]] double operator()(double value) const {
    return pixel_low + (value - low) / (high - low) * (pixel_high - pixel_low);
  }
};

/// The largest of 1, 2, 5 times a power of ten that is not above `value` (> 0).
[[nodiscard]] double round_below(double value);
/// The smallest of them that is not below `value` (> 0).
[[nodiscard]] double round_above(double value);
/// The multiples of a step in [low, high].
[[nodiscard]] std::vector<double> multiples(double step, double low, double high);
/// Round values in [low, high] at equal steps, at most `most` + 1 of them.
[[nodiscard]] std::vector<double> ticks(double low, double high, int most);
/// As many decimals as a scale with this step needs.
[[nodiscard]] std::string tick_text(double value, double step);

/// Frame, grid lines, tick labels and titles of a chart.
void draw_axes(Svg& svg, const Axis& x, const Axis& y, std::string_view x_title, std::string_view y_title);

}  // namespace collinea
