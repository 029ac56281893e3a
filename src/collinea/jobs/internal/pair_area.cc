// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_area.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/io/number_rows.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kFewest = 8;  // points: two in each quarter, that say how far the surface reaches
constexpr double kBeyond = 1.0 / 3;
constexpr double kMargin_px = 32;  // windows and searches beside the outermost points

// The rectangle of the left epipolar image that holds the area.
struct Rectangle {
  int x, y, width, height;

  [[nodiscard]] bool holds(const Vector2d& at) const {
    return at.x() >= x && at.y() >= y && at.x() < x + width && at.y() < y + height;
  }
};

Rectangle rectangle_of(const PairArea& area, const ModelOfPair& model) {
  constexpr int kSteps = 32;  // along a side: lenses and rotation bend it
  const Camera& left = model.epipolar.left;
  Vector2d least(left.width_px, left.height_px), most(0, 0);
  for (int k = 0; k < 4 * kSteps; ++k) {
    const double share = double(k % kSteps) / kSteps;
    const Vector2d corners[] = {
        area.least, {area.most.x(), area.least.y()}, area.most, {area.least.x(), area.most.y()}};
    const Vector2d from = corners[k / kSteps], to = corners[(k / kSteps + 1) % 4];
    const Vector2d at = in_epipolar(model.left_camera, model.epipolar.left_from_image, left,
                                    (from + share * (to - from)) / model.shrink);
    if (!at.allFinite()) continue;
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  const int x = std::clamp(int(std::floor(least.x())), 0, left.width_px);
  const int y = std::clamp(int(std::floor(least.y())), 0, left.height_px);
  return {x, y, std::clamp(int(std::ceil(most.x())), x, left.width_px) - x,
          std::clamp(int(std::ceil(most.y())), y, left.height_px) - y};
}

}  // namespace

Result<std::optional<PairArea>> area_of(const PairChainOptions& options, const Camera& left) {
  if (!options.area) return std::optional<PairArea>();
  const auto numbers = parse_numbers(*options.area);
  if (!numbers || numbers->size() != 4)
    return fail(Errc::kBadInput, "the area is not four numbers with commas between", {"area"_option});
  PairArea area{{(*numbers)[0], (*numbers)[1]}, {(*numbers)[2], (*numbers)[3]}};
  if (!((area.most - area.least).minCoeff() > 0))
    return fail(Errc::kBadInput, "the area has no pixels: column and row of its upper-left corner come first",
                {"area"_option});
  area.least = area.least.cwiseMax(0);
  area.most = area.most.cwiseMin(Vector2d(left.width_px, left.height_px));
  if (!((area.most - area.least).minCoeff() > 0))
    return fail(Errc::kBadInput,
                fmt::format("the area lies beyond the left image of {} x {} pixels", left.width_px, left.height_px),
                {"area"_option});
  return std::optional(area);
}

Result<ModelOfPair> cropped_to(const PairArea& area, ModelOfPair model) {
  const Rectangle in_left = rectangle_of(area, model);
  std::vector<LevelPoint> points;
  for (const LevelPoint& point : model.in_epipolar)
    if (in_left.holds(point.left_px)) points.push_back(point);
  if (points.size() < kFewest)
    return fail(Errc::kIllPosed,
                fmt::format("{} homologous points lie in the area, {} are needed: take a larger one, or more points",
                            points.size(), kFewest),
                {"area"_option, "max_points"_option});
  double low = points.front().disparity_px, high = low;
  for (const LevelPoint& point : points) {
    low = std::min(low, point.disparity_px);
    high = std::max(high, point.disparity_px);
  }
  const double beyond = kBeyond * (high - low) + kMargin_px;
  Camera &left = model.epipolar.left, &right = model.epipolar.right;
  const int from = std::clamp(int(std::floor(in_left.x - high - beyond)), 0, right.width_px - 1);
  const int to = std::clamp(int(std::ceil(in_left.x + in_left.width - low + beyond)), from + 1, right.width_px);
  left.params[Camera::kCx] -= in_left.x;
  right.params[Camera::kCx] -= from;
  for (Camera* camera : {&left, &right}) {
    camera->params[Camera::kCy] -= in_left.y;
    camera->height_px = in_left.height;
  }
  left.width_px = in_left.width;
  right.width_px = to - from;
  for (LevelPoint& point : points) {
    point.left_px -= Vector2d(in_left.x, in_left.y);
    point.disparity_px += from - in_left.x;
  }
  model.in_epipolar = std::move(points);
  return model;
}

}  // namespace collinea
