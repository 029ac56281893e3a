// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/profile_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/internal/html_page.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 940, kHeight = 420;
constexpr std::array<const char*, 4> kStyles = {"one", "two", "three", "four"};

// A surface is drawn in pieces between the positions where it has no heights.
void draw_surface(Svg& svg, const Profile& profile, const std::vector<HeightSample>& heights, const Axis& x,
                  const Axis& y, const std::string& style) {
  std::vector<Vector2d> line, upper, lower;
  const auto flush = [&] {
    std::reverse(lower.begin(), lower.end());
    upper.insert(upper.end(), lower.begin(), lower.end());
    if (line.size() > 1) {
      svg.polygon(upper, "band " + style);
      svg.path(line, "section " + style);
    }
    line.clear();
    upper.clear();
    lower.clear();
  };
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double height_m = heights[i].height_m, sigma_m = heights[i].sigma_m;
    if (!std::isfinite(height_m)) {
      flush();
      continue;
    }
    const double px = x(profile.distance_m[i]), sigma = std::isfinite(sigma_m) ? sigma_m : 0;
    line.emplace_back(px, y(height_m));
    upper.emplace_back(px, y(height_m + sigma));
    lower.emplace_back(px, y(height_m - sigma));
  }
  flush();
}

}  // namespace

std::string profile_page(const Profile& profile, const std::vector<std::string>& names) {
  double low = 1e300, high = -1e300;
  for (const auto& heights : profile.of)
    for (const HeightSample& one : heights)
      if (std::isfinite(one.height_m)) {
        const double sigma_m = std::isfinite(one.sigma_m) ? one.sigma_m : 0;  // the bands shall not leave the chart
        low = std::min(low, one.height_m - sigma_m);
        high = std::max(high, one.height_m + sigma_m);
      }
  const PageHead head{"Profile", "heights along a line", fmt::format("{:.2f} m", profile.distance_m.back()), ""};
  if (!(low <= high)) return whole_page(head, "<p>No surface has heights along this line.</p>");
  const double margin = std::max(0.05 * (high - low), 0.01);
  const Axis x{0, profile.distance_m.back(), 70, kWidth - 14}, y{low - margin, high + margin, kHeight - 46, 14};
  Svg svg(kWidth, kHeight, "Profile");
  draw_axes(svg, x, y, "distance [m]", "height [m]");
  for (std::size_t s = 0; s < names.size(); ++s) {
    const std::string style = kStyles[s % kStyles.size()];
    draw_surface(svg, profile, profile.of[s], x, y, style);
    svg.line({kWidth - 190, 24 + 18.0 * double(s)}, {kWidth - 160, 24 + 18.0 * double(s)}, "section " + style);
    svg.text({kWidth - 152, 28 + 18.0 * double(s)}, names[s]);
  }
  const double exaggeration = ((kHeight - 60) / (y.high - y.low)) / ((kWidth - 84) / x.high);
  const Vector2d &from = profile.positions.front(), &to = profile.positions.back();
  return whole_page(
      head,
      "<figure>" + svg.finish() +
          fmt::format("<figcaption>From {:.2f}, {:.2f} to {:.2f}, {:.2f}. Heights exaggerated {:.2g} times; bands: "
                      "one standard deviation. The figures are in profile.csv.</figcaption></figure>\n",
                      from.x(), from.y(), to.x(), to.y(), exaggeration));
}

}  // namespace collinea
