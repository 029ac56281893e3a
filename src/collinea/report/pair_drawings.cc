// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/page_parts.h"
#include "collinea/report/internal/pair_drawings.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWidth = 460;
constexpr std::size_t kLines = 12, kMostVectors = 500;
constexpr const char* kStyles[] = {"section", "section two", "section three", "section four"};

// A drawing over an image of a camera.
struct Canvas {
  double scale, height;
  Svg svg;

  Canvas(const Camera& camera, const std::optional<Preview>& photo, const char* name, double below)
      : scale(kWidth / camera.width_px), height(camera.height_px * scale), svg(kWidth, height + below, name) {
    if (photo) svg.image_at(kWidth, height, jpeg_address(photo->jpeg));
    svg.rectangle(0, 0, kWidth, height, "frame");
  }
};

// Every so many of what is used, from the top of the left image to its bottom.
std::vector<std::size_t> chosen_points(const PairOrientation& last) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < last.matched.size(); ++i)
    if (last.orientation.residuals[i].used) used.push_back(i);
  std::stable_sort(used.begin(), used.end(), [&](std::size_t a, std::size_t b) {
    return last.matched[a].left_px.y() < last.matched[b].left_px.y();
  });
  std::vector<std::size_t> chosen;
  const std::size_t count = std::min(kLines, used.size());
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(used[(2 * k + 1) * used.size() / (2 * count)]);
  return chosen;
}

// Where the ray of the other image through a point is seen in this one.
std::vector<Vector2d> line_of(const PairReport& report, int image, const Vector3d& in_left) {
  constexpr int kSteps = 120;
  const Rigid3 motion = [&] {
    Rigid3 made = report.relative->orientation.second_from_first;
    made.translation *= report.relative->base;
    return made;
  }();
  const Vector3d other_centre = image == 0 ? centre_of(motion) : Vector3d::Zero();
  const Camera& camera = report.cameras[std::size_t(image)];
  std::vector<Vector2d> line;
  for (int k = 0; k <= kSteps; ++k) {
    const double share = std::exp(3.0 * k / kSteps - 1.5);  // of the distance of the point, from near to far
    const Vector3d at = other_centre + share * (in_left - other_centre);
    const auto seen = project(camera, image == 0 ? at : motion * at);
    if (seen && inside(camera, *seen)) line.push_back(*seen);
  }
  return line;
}

}  // namespace

std::string epipolar_drawing(const PairReport& report, int image, const std::optional<Preview>& photo) {
  const PairOrientation& last = report.orientations.back();
  Canvas canvas(report.cameras[std::size_t(image)], photo, image == 0 ? "Left photograph" : "Right photograph", 0);
  std::size_t style = 0;
  for (const std::size_t i : chosen_points(last)) {
    const auto& point = report.relative->model.points[i];
    if (!point) continue;
    const Vector3d in_left(point->position.x(), -point->position.y(), -point->position.z());
    std::vector<Vector2d> line = line_of(report, image, in_left);
    for (Vector2d& at : line) at *= canvas.scale;
    const char* name = kStyles[style++ % std::size(kStyles)];
    if (line.size() > 1) canvas.svg.path(line, name);
    const Vector2d at = (image == 0 ? last.matched[i].left_px : last.matched[i].right_px) * last.shrink;
    canvas.svg.circle(at * canvas.scale, 3.5, "control");
  }
  return canvas.svg.finish();
}

std::string parallax_drawing(const PairReport& report, const std::optional<Preview>& photo) {
  const PairOrientation& last = report.orientations.back();
  const RelativeOrientation& orientation = last.orientation;
  const double focal_px = report.cameras[0].focal_px();
  Canvas canvas(report.cameras[0], photo, "Parallaxes left", 34);
  std::vector<double> lengths;
  for (const PairResidual& residual : orientation.residuals)
    if (residual.used) lengths.push_back(2 * focal_px * residual.first.norm());
  if (lengths.empty()) return canvas.svg.finish();
  std::sort(lengths.begin(), lengths.end());
  const double typical = std::max(lengths[lengths.size() * 9 / 10], 1e-6);
  const double drawn_per_px = 26 / typical, longest = 60;
  const std::size_t every = last.matched.size() / kMostVectors + 1;
  for (std::size_t i = 0; i < last.matched.size(); i += every) {
    const PairResidual& residual = orientation.residuals[i];
    const Vector2d at = last.matched[i].left_px * last.shrink * canvas.scale;
    Vector2d vector = 2 * focal_px * drawn_per_px * residual.first;  // both images share a parallax
    if (vector.norm() > longest) vector *= longest / vector.norm();
    canvas.svg.arrow(at, at + vector, residual.used ? "pattern_arrow" : "plan_arrow");
  }
  const double shown = round_below(typical * 1.2);
  const Vector2d key(10, canvas.height + 18);
  canvas.svg.arrow(key, key + Vector2d(shown * drawn_per_px, 0), "pattern_arrow");
  canvas.svg.text(key + Vector2d(shown * drawn_per_px + 8, 4), fmt::format("{:g} px", shown));
  return canvas.svg.finish();
}

}  // namespace collinea
