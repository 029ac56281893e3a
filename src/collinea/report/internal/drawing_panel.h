// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <string_view>

#include "collinea/report/internal/svg.h"

namespace collinea {

/// One of several drawings side by side in a picture that stands by itself: what is to be seen in it is widened first,
/// then drawn. Positions have y down.
class DrawingPanel {
 public:
  static constexpr double kSize = 480, kMargin = 40;

  explicit DrawingPanel(double left, double top = 0) : left_(left), top_(top) {}

  void widen(const Eigen::Vector2d& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  [[nodiscard]] double scale() const { return (kSize - 2 * kMargin) / std::max((high_ - low_).maxCoeff(), 1e-9); }
  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& p) const {
    return Eigen::Vector2d(left_ + kMargin, top_ + kMargin) + (p - low_) * scale();
  }
  void dot(const Eigen::Vector2d& p, std::string_view name = "") {
    const Eigen::Vector2d a = at(p);
    body_ += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5' fill='#246'/>\n", a.x(), a.y());
    if (!name.empty())
      body_ += fmt::format("<text x='{:.1f}' y='{:.1f}'>{}</text>\n", a.x() + 5, a.y() - 4, escaped(name));
  }
  void circle(const Eigen::Vector2d& centre, double radius) {
    const Eigen::Vector2d c = at(centre);
    body_ += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}' fill='none' stroke='#b33' stroke-width='1.5'/>\n",
                         c.x(), c.y(), radius * scale());
  }
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* look) {
    const Eigen::Vector2d a = at(from), b = at(to);
    body_ +=
        fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' {}/>\n", a.x(), a.y(), b.x(), b.y(), look);
  }
  void square(const Eigen::Vector2d& p, std::string_view name) {
    const Eigen::Vector2d a = at(p);
    body_ += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='8' height='8' fill='#000'/>\n<text x='{:.1f}' y='{:.1f}'>{}</text>\n",
        a.x() - 4, a.y() - 4, a.x() + 8, a.y() - 6, escaped(name));
  }
  void words(double y, std::string_view text) {
    body_ += fmt::format("<text x='{:.0f}' y='{:.0f}'>{}</text>\n", left_ + 10, top_ + y, escaped(text));
  }
  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  double left_, top_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(1e300), high_ = Eigen::Vector2d::Constant(-1e300);
  std::string body_;
};

/// Panels as a picture of so many columns and rows.
[[nodiscard]] inline std::string drawing_of_panels(int columns, int rows, const std::string& body) {
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' height='{1:.0f}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' fill='#fff'/>\n{2}</svg>\n",
      columns * DrawingPanel::kSize, rows * DrawingPanel::kSize, body);
}

}  // namespace collinea
