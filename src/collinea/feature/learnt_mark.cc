// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/learnt_mark.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector2d;

// How alike the pixels are to themselves turned by 180 degrees about a position.
double point_symmetry(const GreyImage& scan, const Vector2d& centre, int half) {
  double sum = 0, squares = 0, products = 0;
  int count = 0;
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const double a = bilinear(scan, centre.x() + x, centre.y() + y),
                   b = bilinear(scan, centre.x() - x, centre.y() - y);
      sum += a;
      squares += a * a;
      products += a * b;
      ++count;
    }
  const double mean = sum * sum / count;
  return squares - mean > 1 ? (products - mean) / (squares - mean) : 0;
}

// The position of largest symmetry nearby, refined by a parabola in each direction; nothing where there is none.
std::optional<Vector2d> symmetric_centre(const GreyImage& scan, const Vector2d& pointed, int half) {
  Vector2d best = pointed;
  double most = 0;
  const int reach = std::max(1, half / 4);
  for (int y = -2 * reach; y <= 2 * reach; ++y)
    for (int x = -2 * reach; x <= 2 * reach; ++x) {
      const Vector2d at = pointed + Vector2d(x, y) / 2;
      const double value = point_symmetry(scan, at, half);
      if (value > most) {
        most = value;
        best = at;
      }
    }
  if (most < 0.8) return std::nullopt;
  Vector2d refined = best;
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = Vector2d::Unit(k);
    const double less = point_symmetry(scan, best - step, half), more = point_symmetry(scan, best + step, half);
    const double bend = less - 2 * most + more;
    if (bend < 0) refined[k] += std::clamp((less - more) / (2 * bend), -0.5, 0.5);
  }
  return refined;
}

// By 90 degrees from the column towards the row.
MarkTemplate turned(const MarkTemplate& from) {
  MarkTemplate out = from;
  out.values = FloatImage(from.values.height, from.values.width);
  for (int y = 0; y < from.values.height; ++y)
    for (int x = 0; x < from.values.width; ++x) out.values.at(from.values.height - 1 - y, x) = from.values.at(x, y);
  out.centre = {from.values.height - from.centre.y(), from.centre.x()};
  return out;
}

MarkTemplate mirrored(const MarkTemplate& from) {
  MarkTemplate out = from;
  for (int y = 0; y < from.values.height; ++y)
    for (int x = 0; x < from.values.width; ++x) out.values.at(from.values.width - 1 - x, y) = from.values.at(x, y);
  out.centre.x() = from.values.width - from.centre.x();
  return out;
}

}  // namespace

std::optional<LearntMark> learnt_mark(const GreyImage& scan, const Vector2d& pointed, double size_px) {
  const int half = int(size_px / 2);
  const auto fits = [&](const Vector2d& at) {
    return at.allFinite() && half >= 4 && at.x() >= half + 2 && at.y() >= half + 2 && at.x() + half + 2 <= scan.width &&
           at.y() + half + 2 <= scan.height;
  };
  if (!fits(pointed)) return std::nullopt;
  const auto symmetric = symmetric_centre(scan, pointed, half);
  const bool is_symmetric = symmetric && fits(*symmetric);
  const Vector2d centre = is_symmetric ? *symmetric : pointed;
  const int left = int(std::floor(centre.x())) - half, top = int(std::floor(centre.y())) - half;
  MarkTemplate drawing{FloatImage(2 * half + 1, 2 * half + 1), 1, 0, centre - Vector2d(left, top)};
  float low = 255, high = 0;
  for (int y = 0; y < drawing.values.height; ++y)
    for (int x = 0; x < drawing.values.width; ++x) {
      const float value = drawing.values.at(x, y) = float(scan.at(left + x, top + y));
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (!(high > low)) return std::nullopt;
  return LearntMark{{}, MarkModel{{drawing}}, is_symmetric};
}

std::vector<MarkModel> likenesses(const LearntMark& learnt) {
  std::vector<MarkModel> out{learnt.model};
  if (learnt.is_symmetric || learnt.model.blurred.empty()) return out;
  for (int quarter = 1; quarter < 4; ++quarter) out.push_back({{turned(out.back().blurred.front())}});
  for (int quarter = 0; quarter < 4; ++quarter) out.push_back({{mirrored(out[std::size_t(quarter)].blurred.front())}});
  return out;
}

}  // namespace collinea
