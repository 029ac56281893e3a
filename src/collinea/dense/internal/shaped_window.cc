// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/shaped_window.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/dense/internal/row_sample.h"

namespace collinea {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr double kLevel = 0.01;      // gradients below are none: a tenth of a pixel over half a window
constexpr double kLeastScale = 0.3;  // of the resampled columns
constexpr int kIterations = 12;
constexpr int kAlike_px = 3;  // within which errors of grey values are taken as alike
constexpr double kSettled_px = 0.003, kFarthest_px = 1, kLimit = 1;

// The pattern round a pixel whose middle shows that surface, for windows that are squares of the other image, where
// columns differ by (1 - gradient.x) u - gradient.y v.
std::optional<WindowPattern> pattern_of(const GreyImage& image, const Eigen::Vector2i& pixel, int half,
                                        const PatternShape& shape, bool is_level) {
  return is_level ? WindowPattern::of(image, pixel, half) : WindowPattern::of(image, pixel, half, shape);
}

// Normal equations of offset, gain, and the plane of a window, and what they are made of, row by row.
struct PlaneFit {
  std::vector<Vector5d> rows;
  std::vector<double> values;
  Matrix5d normal = Matrix5d::Zero();
  Vector5d right_side = Vector5d::Zero();
  double squares = 0, sum = 0;
  int count = 0;

  void add(double left, const RowSample& right, double u, double v) {
    const Vector5d row((Vector5d() << 1, right.value, -right.slope, -right.slope * u, -right.slope * v).finished());
    rows.push_back(row);
    values.push_back(left);
    normal += row * row.transpose();
    right_side += left * row;
    squares += left * left;
    sum += left;
    ++count;
  }
};

// Variance of an unknown that is the sum of weights h times grey values, whose errors are alike within kAlike_px:
// grain, optics and resampling make neighbours so. With r the residuals,
//     sum over lags of  mean(r_i r_i+lag)  sum(h_i h_i+lag),
// and no less than errors of single pixels would make it.
double alike_variance(const std::vector<double>& h, const std::vector<double>& r, int side, double single) {
  double sum = 0;
  for (int dv = 0; dv <= kAlike_px; ++dv)
    for (int du = dv == 0 ? 0 : -kAlike_px; du <= kAlike_px; ++du) {
      double weights = 0, residuals = 0;
      for (int v = 0; v + dv < side; ++v)
        for (int u = std::max(0, -du); u < std::min(side, side - du); ++u) {
          const std::size_t i = std::size_t(v * side + u), j = std::size_t((v + dv) * side + u + du);
          weights += h[i] * h[j];
          residuals += r[i] * r[j];
        }
      const double pairs = double(side - dv) * (side - std::abs(du));
      sum += (dv == 0 && du == 0 ? 1 : 2) * weights * residuals / pairs;
    }
  return std::max(sum, single);
}

// Standard deviation of the disparity of a fit.
double sigma_of(const PlaneFit& fit, const Vector5d& found, const Vector5d& by, int side, double residual) {
  std::vector<double> h, r;
  for (std::size_t i = 0; i < fit.rows.size(); ++i) {
    h.push_back(by.dot(fit.rows[i]));
    r.push_back(fit.values[i] - found.dot(fit.rows[i]));
  }
  const double single = residual / (fit.count - 5) * by[2];
  return std::sqrt(alike_variance(h, r, side, single)) / found[1];
}

std::optional<PlaneFit> fit_of(const GreyImage& left, int half, const GreyImage& right, const LevelPoint& at) {
  const int x = int(at.left_px.x()), y = int(at.left_px.y()), row = y + int(std::lround(at.row_px));
  if (x < half || y < half || x + half >= left.width || y + half >= left.height || row < half ||
      row + half >= right.height)
    return std::nullopt;
  PlaneFit fit;
  const std::size_t side = 2 * std::size_t(half) + 1;
  fit.rows.reserve(side * side);
  fit.values.reserve(side * side);
  for (int v = -half; v <= half; ++v)
    for (int u = -half; u <= half; ++u) {
      const double column = x + 0.5 + u - at.disparity_px - at.gradient.x() * u - at.gradient.y() * v;
      const auto found = row_sample(right.row(row + v), right.width, column);
      const int grey = left.at(x + u, y + v);
      if (!found || grey == 0) return std::nullopt;
      fit.add(grey, *found, u, v);
    }
  return fit;
}

}  // namespace

ShapedMatcher::ShapedMatcher(const GreyImage& left, const Eigen::Vector2i& pixel, int half, const GreyImage& right,
                             const ShapedSearch& search)
    : left_(left),
      right_(right),
      pixel_(pixel),
      half_(half),
      return_px_(search.return_px),
      there_(right, half,
             {int(std::floor(pixel.x() - search.high_px)), int(std::ceil(pixel.x() - search.low_px)),
              pixel.y() - search.rows, pixel.y() + search.rows}),
      back_(left, half,
            {pixel.x() - int(std::ceil((search.high_px - search.low_px) / 2)) - 2,
             pixel.x() + int(std::ceil((search.high_px - search.low_px) / 2)) + 2, pixel.y() - search.rows,
             pixel.y() + search.rows}) {}

std::optional<LevelPoint> ShapedMatcher::match(const Eigen::Vector2d& gradient) const {
  const bool is_level = gradient.cwiseAbs().maxCoeff() < kLevel;
  const double scale = std::max(kLeastScale, 1 - gradient.x()), shear = gradient.y();
  const auto pattern = pattern_of(left_, pixel_, half_, {1 / scale, shear / scale}, is_level);
  const auto found = pattern ? there_.best(*pattern) : std::nullopt;
  if (!found) return std::nullopt;
  const auto returning = pattern_of(right_, found->pixel, half_, {scale, -shear}, is_level);
  const auto back = returning ? back_.best(*returning) : std::nullopt;
  if (!back || (back->pixel - pixel_).cast<double>().norm() > return_px_) return std::nullopt;
  return LevelPoint{pixel_.cast<double>() + Eigen::Vector2d(0.5, 0.5),
                    pixel_.x() - found->position_px.x() + 0.5,
                    found->position_px.y() - 0.5 - pixel_.y(),
                    found->ncc,
                    found->sigma_px,
                    is_level ? Eigen::Vector2d(0, 0) : gradient};
}

std::optional<LevelPoint> measured_match(const GreyImage& left, int half, const GreyImage& right,
                                         const std::optional<LevelPoint>& found, double min_ncc) {
  if (!found || found->ncc < min_ncc) return std::nullopt;
  const auto fitted = fitted_plane(left, half, right, *found);
  return fitted && fitted->ncc >= min_ncc ? fitted : std::nullopt;
}

std::optional<LevelPoint> fitted_plane(const GreyImage& left, int half, const GreyImage& right,
                                       const LevelPoint& start) {
  LevelPoint point = start;
  for (int i = 0; i < kIterations; ++i) {
    const auto fit = fit_of(left, half, right, point);
    if (!fit) return std::nullopt;
    const Eigen::LDLT<Matrix5d> solver(fit->normal);
    const Vector5d found = solver.solve(fit->right_side);
    if (solver.info() != Eigen::Success || !found.allFinite() || !(found[1] > 0)) return std::nullopt;
    const Eigen::Vector3d change = found.tail<3>() / found[1];
    point.disparity_px += change[0];
    point.gradient += change.tail<2>();
    if (std::abs(point.disparity_px - start.disparity_px) > kFarthest_px ||
        point.gradient.cwiseAbs().maxCoeff() > kLimit)
      return std::nullopt;
    if (std::abs(change[0]) > kSettled_px || change.tail<2>().cwiseAbs().maxCoeff() * half > 10 * kSettled_px) continue;
    const double residual = std::max(fit->squares - found.dot(fit->right_side), 0.0);
    const double total = fit->squares - fit->sum * fit->sum / fit->count;
    point.ncc = std::sqrt(std::max(0.0, 1 - residual / total));
    const Vector5d by = solver.solve(Vector5d::Unit(2));
    point.sigma_px = sigma_of(*fit, found, by, 2 * half + 1, residual);
    return point;
  }
  return std::nullopt;
}

}  // namespace collinea
