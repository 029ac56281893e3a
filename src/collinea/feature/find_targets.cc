// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/feature/target.h"

#include "collinea/feature/edges.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kSmoothPx = 1.5;      // before corners are looked for
constexpr double kEllipseRmsPx = 0.3;  // of the points of an edge
constexpr double kArc = 0.9;           // of an ellipse that has points

struct Corner {
  Vector2d at;
  float strength;
};

// How much a pixel looks like the middle of a target: depth of the saddle; smaller eigenvalue of the structure tensor.
FloatImage interest_of(const FloatImage& image, TargetKind kind, int radius_px) {
  const FloatImage smooth = smoothed(image, kSmoothPx);
  FloatImage out(image.width, image.height), xx = out, xy = out, yy = out;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const auto at = [&](int dx, int dy) { return smooth.at(x + dx, y + dy); };
      if (kind == TargetKind::kChequerboard) {
        const float a = at(1, 0) + at(-1, 0) - 2 * at(0, 0), b = at(0, 1) + at(0, -1) - 2 * at(0, 0);
        const float c = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 4;
        out.at(x, y) = std::max(0.f, c * c - a * b);
        continue;
      }
      const float gx = (at(1, 0) - at(-1, 0)) / 2, gy = (at(0, 1) - at(0, -1)) / 2;
      xx.at(x, y) = gx * gx;
      xy.at(x, y) = gx * gy;
      yy.at(x, y) = gy * gy;
    }
  if (kind == TargetKind::kChequerboard) return out;
  const double window = radius_px / 2.0;
  xx = smoothed(xx, window);
  xy = smoothed(xy, window);
  yy = smoothed(yy, window);
  for (std::size_t i = 0; i < out.data.size(); ++i) {
    const float a = xx.data[i], b = yy.data[i], c = xy.data[i];
    out.data[i] = (a + b) / 2 - std::sqrt((a - b) * (a - b) / 4 + c * c);
  }
  return out;
}

// Maxima within 7 x 7 pixels, the strongest first.
std::vector<Corner> maxima_of(const FloatImage& interest, float least, std::size_t most) {
  std::vector<Corner> out;
  constexpr int kReach = 3;
  for (int y = kReach; y < interest.height - kReach; ++y)
    for (int x = kReach; x < interest.width - kReach; ++x) {
      const float here = interest.at(x, y);
      if (here < least) continue;
      bool is_largest = true;
      for (int dy = -kReach; dy <= kReach && is_largest; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const float other = interest.at(x + dx, y + dy);
          const bool is_before = dy < 0 || (dy == 0 && dx < 0);
          if (other > here || (is_before && other == here)) is_largest = false;
        }
      if (is_largest) out.push_back({Vector2d(x + 0.5, y + 0.5), here});
    }
  std::stable_sort(out.begin(), out.end(), [](const Corner& a, const Corner& b) { return a.strength > b.strength; });
  if (out.size() > most) out.resize(most);
  return out;
}

std::vector<Target> circles_among(const FloatImage& image, const EdgeMap& edges) {
  std::vector<Target> out;
  for (const EdgeChain& chain : edges.chains) {
    if (!chain.is_closed) continue;
    const auto ellipse = fit_ellipse(edges.points_of(chain), edges.along_px);
    if (!ellipse || ellipse->quality.rms_px > kEllipseRmsPx || ellipse->arc_rad < kArc * 2 * std::numbers::pi) continue;
    if (auto target = measure_circle(image, ellipse->ellipse)) out.push_back(std::move(*target));
  }
  return out;
}

}  // namespace

std::vector<Target> find_targets(const FloatImage& image, const EdgeMap& edges, TargetKind kind,
                                 const TargetSearch& search) {
  std::vector<Target> found;
  if (kind == TargetKind::kCircle) {
    found = circles_among(image, edges);
  } else {
    const double slope = search.least_contrast / 10;  // of a blurred border of that contrast, at least
    const auto least = float(kind == TargetKind::kChequerboard ? slope * slope / 4 : slope * slope / 20);
    for (const Corner& corner : maxima_of(interest_of(image, kind, search.radius_px), least, 5 * search.most))
      if (auto target = measure_target(image, kind, corner.at, search.radius_px)) found.push_back(std::move(*target));
  }
  const double full = kind == TargetKind::kChequerboard ? 2 : 1;  // its contrast counts from the middle
  std::erase_if(found, [&](const Target& t) {
    const double contrast = full * std::abs(t.contrast());
    return contrast < search.least_contrast || t.sigma_grey > search.largest_residual * contrast;
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const Target& a, const Target& b) { return a.sigma_px() < b.sigma_px(); });
  std::vector<Target> out;  // one at each position
  for (Target& t : found) {
    const bool is_new = std::none_of(out.begin(), out.end(), [&](const Target& o) { return (o.at - t.at).norm() < 2; });
    if (is_new && out.size() < search.most) out.push_back(std::move(t));
  }
  return out;
}

}  // namespace collinea
