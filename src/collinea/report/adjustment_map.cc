// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/internal/adjustment_products.h"
#include "collinea/report/internal/map_view.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Something with a covariance, to be drawn.
struct Marked {
  enum Kind { kTie, kControl, kCheck, kStation } kind;
  Vector3d position_m;
  Matrix3d covariance_m2;
  std::string name;
};

// As many tie points as can be told from each other: of each square of a grid that of the middle standard deviation.
std::vector<Marked> few_points(const std::vector<ProductPoint>& points) {
  constexpr int kAcross = 14;
  std::vector<const ProductPoint*> known;
  Vector2d low = Vector2d::Constant(1e300), high = -low;
  for (const ProductPoint& point : points)
    if (point.covariance_m2.allFinite() && point.position_m.allFinite()) {
      known.push_back(&point);
      low = low.cwiseMin(point.position_m.head<2>());
      high = high.cwiseMax(point.position_m.head<2>());
    }
  if (known.empty()) return {};
  const double side = std::max((high - low).maxCoeff(), 1e-9) / kAcross;
  std::map<std::pair<int, int>, std::vector<const ProductPoint*>> squares;
  for (const ProductPoint* point : known) {
    const Vector2d at = (point->position_m.head<2>() - low) / side;
    squares[{int(at.x()), int(at.y())}].push_back(point);
  }
  std::vector<Marked> chosen;
  for (auto& [square, its] : squares) {
    const auto middle = its.begin() + std::ptrdiff_t(its.size() / 2);
    std::nth_element(its.begin(), middle, its.end(), [](const ProductPoint* a, const ProductPoint* b) {
      return std::pair(a->covariance_m2.trace(), a->point) < std::pair(b->covariance_m2.trace(), b->point);
    });
    chosen.push_back({Marked::kTie, (*middle)->position_m, (*middle)->covariance_m2, ""});
  }
  return chosen;
}

// The length of which most standard deviations stay below: a few wild ones shall not make all others vanish.
double common_sigma(const std::vector<Marked>& marks) {
  std::vector<double> sigmas;
  for (const Marked& mark : marks) {
    const double sigma = std::sqrt(mark.covariance_m2.diagonal().maxCoeff());
    if (std::isfinite(sigma)) sigmas.push_back(sigma);
  }
  if (sigmas.empty()) return 0;
  std::sort(sigmas.begin(), sigmas.end());
  return sigmas[(sigmas.size() - 1) * 9 / 10];
}

// An ellipse beyond this would hide the others, or run out of the map.
constexpr double kCommon_px = 20, kLargest = 5;  // the common one; times that

bool fits(const Marked& mark, double px_per_m) {
  return std::sqrt(mark.covariance_m2.diagonal().maxCoeff()) * px_per_m <= kLargest * kCommon_px;
}

void draw_mark(Svg& svg, const Vector2d& at, const Marked& mark, double px_per_m, bool crowded) {
  constexpr std::array<const char*, 4> kStyles = {"ellipse tie", "ellipse", "ellipse checked", "ellipse tie"};
  if (fits(mark, px_per_m)) {
    draw_ellipse(svg, at, mark.covariance_m2.topLeftCorner<2, 2>(), px_per_m, kStyles[mark.kind]);
    draw_height_bar(svg, at, std::sqrt(mark.covariance_m2(2, 2)), px_per_m, "height_bar");
  } else {
    svg.circle(at, 9, "more", mark.name);
  }
  if (mark.kind == Marked::kControl) draw_triangle(svg, at, "control");
  if (mark.kind == Marked::kCheck) svg.circle(at, 6, "check", mark.name);
  svg.circle(at, crowded ? 1 : 1.6, "station", mark.name);
  if (mark.kind == Marked::kControl || mark.kind == Marked::kCheck)
    svg.text(at + Vector2d(9, 14), mark.name, "start", "label halo");
}

std::string map_of(const std::vector<Marked>& marks, const std::string& label, const std::string& unit) {
  constexpr double kMostHeight = 560;
  const double common = common_sigma(marks);
  if (!(common > 0)) return "";
  MapBounds bounds;
  for (const Marked& mark : marks) bounds.add(mark.position_m.head<2>());
  MapView view = bounds.view(kMapWidth, kMostHeight);
  view.footer = 30;
  const double px_per_m = kCommon_px / common;
  Svg svg(view.width, view.height + view.footer, label);
  for (const Marked& mark : marks) draw_mark(svg, view(mark.position_m), mark, px_per_m, marks.size() > 300);
  const double length = round_below(common), px = length * px_per_m;
  const Vector2d corner(view.width - 290, view.height + view.footer - 24);
  svg.rectangle(corner.x() - 30, corner.y() - 24, 310, 46, "paper");
  draw_ellipse(svg, corner, length * length * Eigen::Matrix2d::Identity(), px_per_m, "ellipse");
  svg.text(corner + Vector2d(px + 8, 4), "plan, " + scale_text(length, unit));
  draw_height_bar(svg, corner + Vector2d(150, 0), length, px_per_m, "height_bar");
  svg.text(corner + Vector2d(160, 4), "height, " + scale_text(length, unit));
  draw_scale_and_north(svg, view, unit);
  return svg.finish();
}

}  // namespace

std::string precision_section(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::vector<Marked> ground = few_points(products.points), stations;
  for (const ProductControl& its : products.control)
    if (its.position_m.allFinite() && its.covariance_m2.allFinite())
      ground.push_back({its.difference->used ? Marked::kControl : Marked::kCheck, its.position_m, its.covariance_m2,
                        report.block.control.at(its.difference->point).name});
  for (const ProductImage& image : products.images)
    if (image.covariance_m2.allFinite())
      stations.push_back(
          {Marked::kStation, image.centre_m, image.covariance_m2, report.block.images.at(image.image).file});
  // A model that nothing gives a size has no metres.
  const std::string unit =
      products.crs.empty() && products.control.empty() && report.adjusted.rank_defect > 0 ? "units" : "m";
  const std::string points = map_of(ground, "Precision of points", unit),
                    images = map_of(stations, "Precision of projection centres", unit);
  if (points.empty() && images.empty()) return "";
  std::string html = "<section><h2>Precision over the block</h2>\n";
  if (!points.empty())
    html +=
        "<figure class=\"map\"><h3>Points on the ground</h3>" + points +
        "<figcaption>Ellipses in plan and bars in height: one standard deviation (39 % and 68 % of all errors), in the "
        "scale "
        "of the legend. Triangles: control; circles: check points, without the error of their survey; the others: tie "
        "points, one of middling precision from each square of a grid. Dashed: more than five times as large as "
        "most.</figcaption></figure>\n";
  if (!images.empty())
    html += "<figure class=\"map\"><h3>Projection centres</h3>" + images +
            "<figcaption>The same of the images, in a scale of their own.</figcaption></figure>\n";
  return html + "</section>\n";
}

}  // namespace collinea
