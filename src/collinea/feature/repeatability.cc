// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/repeatability.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "collinea/feature/internal/scale_space.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr double kBlurOfPixel_px2 = 0.25;  // of a pixel after reduction, beside that of the original: 0.5 px

Vector2d mapped(const Matrix3d& h, const Vector2d& p) { return (h * p.homogeneous()).hnormalized(); }

// An index beyond the border, mirrored at it.
int mirrored(int i, int count) {
  if (count == 1) return 0;
  const int period = 2 * count;
  i = ((i % period) + period) % period;
  return i < count ? i : period - 1 - i;
}

std::array<double, 4> cubic_weights(double t) {
  return {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1, ((-1.5 * t + 2) * t + 0.5) * t,
          (0.5 * t - 0.5) * t * t};
}

double bicubic(const Plane& plane, const Vector2d& p) {
  const double u = p.x() - 0.5, v = p.y() - 0.5;
  const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
  const auto wx = cubic_weights(u - column), wy = cubic_weights(v - row);
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    const float* in = plane.row(mirrored(row - 1 + j, plane.height()));
    double along = 0;
    for (int i = 0; i < 4; ++i) along += wx[static_cast<std::size_t>(i)] * in[mirrored(column - 1 + i, plane.width())];
    sum += wy[static_cast<std::size_t>(j)] * along;
  }
  return sum;
}

std::uint8_t grey(double value) { return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)); }

Matrix3d about(const Vector2d& from, const Vector2d& to, const Eigen::Matrix2d& linear) {
  Matrix3d h = Matrix3d::Identity();
  h.topLeftCorner<2, 2>() = linear;
  h.topRightCorner<2, 1>() = to - linear * from;
  return h;
}

GreyImage resampled(const GreyImage& image, const Matrix3d& from_original, int width, int height, double scale) {
  Plane plane(image.width, image.height);
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, plane.row(y));
  if (scale < 1) plane = blurred(plane, std::sqrt(kBlurOfPixel_px2 * (1 / (scale * scale) - 1)));
  const Matrix3d to_original = from_original.inverse();
  GreyImage out(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out.at(x, y) = grey(bicubic(plane, mapped(to_original, Vector2d(x + 0.5, y + 0.5))));
  return out;
}

bool is_inside(const Vector2d& p, int width, int height, double border) {
  return p.x() >= border && p.y() >= border && p.x() <= width - border && p.y() <= height - border;
}

// Positions of the points whose image through the homography lies in the other image, too.
std::vector<Vector2d> common(std::span<const InterestPoint> points, const Matrix3d& h, std::array<int, 2> size,
                             std::array<int, 2> other, double border) {
  std::vector<Vector2d> out;
  for (const InterestPoint& p : points)
    if (is_inside(p.position_px, size[0], size[1], border) &&
        is_inside(mapped(h, p.position_px), other[0], other[1], border))
      out.push_back(p.position_px);
  return out;
}

}  // namespace

ChangedImage changed(const GreyImage& image, ImageChange change, double amount, std::uint64_t seed) {
  ChangedImage out{.image = image, .from_original = Matrix3d::Identity()};
  const Vector2d middle(0.5 * image.width, 0.5 * image.height);
  if (change == ImageChange::kNoise) {
    Random random(seed);
    for (std::uint8_t& value : out.image.data) value = grey(value + amount * random.normal());
  } else if (change == ImageChange::kRotation) {
    const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(amount * std::numbers::pi / 180).toRotationMatrix();
    out.from_original = about(middle, middle, rotation);
    out.image = resampled(image, out.from_original, image.width, image.height, 1);
  } else {
    const int width = std::max(1, static_cast<int>(std::lround(amount * image.width)));
    const int height = std::max(1, static_cast<int>(std::lround(amount * image.height)));
    out.from_original = about(middle, 0.5 * Vector2d(width, height), amount * Eigen::Matrix2d::Identity());
    out.image = resampled(image, out.from_original, width, height, amount);
  }
  return out;
}

double Repeatability::rate() const {
  const std::size_t fewer = std::min(first, second);
  return fewer > 0 ? static_cast<double>(repeated) / static_cast<double>(fewer) : 0;
}

double Repeatability::rate_of_second() const {
  return second > 0 ? static_cast<double>(repeated) / static_cast<double>(second) : 0;
}

Repeatability repeatability(std::span<const InterestPoint> first, std::span<const InterestPoint> second,
                            const Matrix3d& second_from_first, const CommonPart& part, double tolerance_px) {
  const std::array first_size = {part.first_width, part.first_height},
                   second_size = {part.second_width, part.second_height};
  std::vector<Vector2d> a = common(first, second_from_first, first_size, second_size, part.border_px);
  for (Vector2d& p : a) p = mapped(second_from_first, p);
  const std::vector<Vector2d> b = common(second, second_from_first.inverse(), second_size, first_size, part.border_px);

  // Pairs within the tolerance, by cells of its size.
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells;
  const auto cell = [&](const Vector2d& p) {
    return std::pair(static_cast<int>(std::floor(p.x() / tolerance_px)),
                     static_cast<int>(std::floor(p.y() / tolerance_px)));
  };
  for (std::size_t j = 0; j < b.size(); ++j) cells[cell(b[j])].push_back(j);
  std::vector<std::tuple<double, std::size_t, std::size_t>> close;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto [column, row] = cell(a[i]);
    for (int y = row - 1; y <= row + 1; ++y)
      for (int x = column - 1; x <= column + 1; ++x)
        if (const auto found = cells.find({x, y}); found != cells.end())
          for (const std::size_t j : found->second)
            if (const double distance = (a[i] - b[j]).norm(); distance <= tolerance_px)
              close.emplace_back(distance, i, j);
  }
  std::ranges::sort(close);
  Repeatability result{.first = a.size(), .second = b.size()};
  std::vector<bool> used_a(a.size()), used_b(b.size());
  double squares = 0;
  for (const auto& [distance, i, j] : close) {
    if (used_a[i] || used_b[j]) continue;
    used_a[i] = used_b[j] = true;
    ++result.repeated;
    squares += distance * distance;
  }
  if (result.repeated > 0) result.rms_px = std::sqrt(squares / static_cast<double>(result.repeated));
  return result;
}

}  // namespace collinea
