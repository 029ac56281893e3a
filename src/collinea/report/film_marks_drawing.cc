// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/film_marks_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kPanel_px = 260, kFilm_px = 200;  // a camera with its name; the film within
constexpr double kMark_px = 22, kKind_px = 70;     // a mark on the film, and one of the kinds below
constexpr double kKindsHeight_px = 150;
constexpr int kPanelsInRow = 4;

// Where the axis of a mark that has one looks, to the middle of the film in eighths of a turn, clockwise [deg].
double axis_deg(MarkKind kind, const Vector2d& film_mm) {
  if (kind != MarkKind::kCorner && kind != MarkKind::kNotch) return 0;
  return 45 * std::round(std::atan2(film_mm.y(), -film_mm.x()) / (std::numbers::pi / 4));
}

// A mark about the origin whose axis is x, `size` wide.
std::string shape(MarkKind kind, double size, double line) {
  const double half = size / 2;
  const auto bar = [&](double x, double width, double turned_deg) {
    return fmt::format("<rect x='{:.2f}' y='{:.2f}' width='{:.2f}' height='{:.2f}' transform='rotate({})'/>", x,
                       -line / 2, width, line, turned_deg);
  };
  switch (kind) {
    case MarkKind::kCross:
      return bar(-half, size, 0) + bar(-half, size, 90);
    case MarkKind::kDot:
      return fmt::format("<circle r='{:.2f}'/>", half);
    case MarkKind::kRing:
      return fmt::format("<circle r='{:.2f}' fill='none' stroke='#fff' stroke-width='{:.2f}'/>", half - line / 2, line);
    case MarkKind::kCorner:
      return bar(-line / 2, half + line / 2, 45) + bar(-line / 2, half + line / 2, -45);
    case MarkKind::kNotch:
      return fmt::format("<path d='M0 0L{0:.2f} {0:.2f}H{1:.2f}V-{0:.2f}H{0:.2f}Z'/>", half, 1.3 * half);
  }
  return "";
}

std::string drawn_at(const Vector2d& at, MarkKind kind, double axis, double size, double line) {
  return fmt::format("<g fill='#fff' transform='translate({:.1f} {:.1f}) rotate({:.0f})'>{}</g>\n", at.x(), at.y(),
                     axis, shape(kind, size, line));
}

std::string words_at(double x, double y, std::string_view words, std::string_view look) {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' {}>{}</text>\n", x, y, look, escaped(words));
}

std::string film_of(const FilmCalibration& camera, MarkKind kind, const Vector2d& corner) {
  const double scale = kFilm_px / camera.size_mm.maxCoeff();
  const Vector2d half = scale * camera.size_mm / 2, middle = corner + Vector2d(kPanel_px / 2, 40 + kFilm_px / 2);
  std::string out = fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='#333'/>\n",
                                middle.x() - half.x(), middle.y() - half.y(), 2 * half.x(), 2 * half.y());
  out += words_at(corner.x() + kPanel_px / 2, corner.y() + 28, camera.camera, "text-anchor='middle'");
  const double line = kMark_px * std::clamp(camera.line_mm / camera.mark_size_mm, 0.08, 0.4);
  for (const CalibratedMark& mark : camera.marks) {
    const MarkKind its = mark.kind.value_or(kind);
    const Vector2d at = middle + scale * Vector2d(mark.film_mm.x(), -mark.film_mm.y());
    const Vector2d inwards = at - 22 * (at - middle).normalized();
    out += drawn_at(at, its, axis_deg(its, mark.film_mm), kMark_px, line);
    out += words_at(inwards.x(), inwards.y() + 4, mark.name, "text-anchor='middle' fill='#fc6' font-size='11'");
  }
  return out;
}

std::string kind_at(MarkKind kind, const Vector2d& corner) {
  const Vector2d at = corner + Vector2d(10 + kKind_px / 2, 10 + kKind_px / 2);
  std::string out = fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{}' height='{}' fill='#333'/>\n", corner.x() + 10,
                                corner.y() + 10, kKind_px, kKind_px);
  out += drawn_at(at, kind, 0, 0.7 * kKind_px, 0.08 * kKind_px);
  out += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5' fill='#e33'/>\n", at.x(), at.y());
  return out + words_at(at.x(), corner.y() + 26 + kKind_px, word_of(kind), "text-anchor='middle'");
}

}  // namespace

std::string film_marks_svg(std::span<const FilmCalibration> cameras, MarkKind kind) {
  std::vector<MarkKind> kinds;
  std::string body;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    body += film_of(cameras[i], kind, {kPanel_px * double(i % kPanelsInRow), kPanel_px * double(i / kPanelsInRow)});
    for (const CalibratedMark& mark : cameras[i].marks)
      if (const MarkKind its = mark.kind.value_or(kind); std::ranges::find(kinds, its) == kinds.end())
        kinds.push_back(its);
  }
  std::ranges::sort(kinds);
  const double columns = double(std::min<std::size_t>(cameras.size(), kPanelsInRow));
  const double rows = double((cameras.size() + kPanelsInRow - 1) / kPanelsInRow);
  const double width = std::max(kPanel_px * columns, (kKind_px + 20) * double(kinds.size()));
  for (std::size_t k = 0; k < kinds.size(); ++k)
    body += kind_at(kinds[k], {(kKind_px + 20) * double(k), kPanel_px * rows + 10});
  if (!kinds.empty())
    body += words_at(10, kPanel_px * rows + kKindsHeight_px - 15,
                     "Marks are enlarged; the red dot is what a mark stands for. They may be dark on bright, too.", "");
  const double height = kPanel_px * rows + (kinds.empty() ? 0 : kKindsHeight_px);
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' font-family='sans-serif' "
      "font-size='13'>\n<rect width='{0:.0f}' height='{1:.0f}' fill='white'/>\n{2}</svg>\n",
      width, height, body);
}

}  // namespace collinea
