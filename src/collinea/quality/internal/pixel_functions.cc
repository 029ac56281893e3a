// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/pixel_functions.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea::bundle {
namespace {

constexpr std::array<std::array<int, 2>, 4> kWaves = {{{1, 0}, {0, 1}, {1, -1}, {1, 1}}};
constexpr int kGrid = 13;          // positions on a side on which a set is fitted by the functions
constexpr double kSpanned = 1e-9;  // [px] of one

}  // namespace

PixelFunctions::PixelFunctions(bool with_gruen) {
  for (int x = 0; x <= 4; ++x)
    for (int y = 0; y <= 4; ++y)
      if (with_gruen || x + y <= 3 || (x <= 2 && y <= 2)) powers_.push_back({x, y});
  count_ = static_cast<int>(powers_.size() + 2 * kWaves.size());
}

int PixelFunctions::number_of(int a, int b) const {
  return static_cast<int>(std::ranges::find(powers_, std::array{a, b}) - powers_.begin());
}

void PixelFunctions::at(const ImageExtent& size, const double* pixel, double* out) const {
  const double x = 2 * pixel[0] / size.width_px - 1, y = 2 * pixel[1] / size.height_px - 1;
  double xs[5] = {1, x, x * x, x * x * x, x * x * x * x}, ys[5] = {1, y, y * y, y * y * y, y * y * y * y};
  for (const auto& [a, b] : powers_) *out++ = xs[a] * ys[b];
  constexpr double kPi = std::numbers::pi;
  const double cx = std::cos(kPi * x), sx = std::sin(kPi * x), cy = std::cos(kPi * y), sy = std::sin(kPi * y);
  const double cosine[4] = {cx, cy, cx * cy + sx * sy, cx * cy - sx * sy};
  const double sine[4] = {sx, sy, sx * cy - cx * sy, sx * cy + cx * sy};
  for (std::size_t w = 0; w < kWaves.size(); ++w) *out++ = cosine[w];
  for (std::size_t w = 0; w < kWaves.size(); ++w) *out++ = sine[w];
}

std::optional<Eigen::MatrixXd> PixelFunctions::combination_of(AdditionalSet set, const ImageExtent& size) const {
  const auto parameters = static_cast<Eigen::Index>(count_of(set));
  Eigen::MatrixXd functions(kGrid * kGrid, count_), column(kGrid * kGrid, parameters), row(kGrid * kGrid, parameters);
  std::vector<double> values(static_cast<std::size_t>(count_));
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Eigen::Vector2d pixel(size.width_px * (i % kGrid) / (kGrid - 1), size.height_px * (i / kGrid) / (kGrid - 1));
    at(size, pixel.data(), values.data());
    functions.row(i) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), count_);
    AdditionalEffect effect;
    additional_effect(set, size, pixel, effect);
    column.row(i) = Eigen::Map<const Eigen::RowVectorXd>(effect.column.data(), parameters);
    row.row(i) = Eigen::Map<const Eigen::RowVectorXd>(effect.row.data(), parameters);
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(functions);
  Eigen::MatrixXd combination(2 * count_, parameters);
  combination.topRows(count_) = qr.solve(column);
  combination.bottomRows(count_) = qr.solve(row);
  const double left = (functions * combination.topRows(count_) - column).cwiseAbs().maxCoeff() +
                      (functions * combination.bottomRows(count_) - row).cwiseAbs().maxCoeff();
  if (!(left < kSpanned)) return std::nullopt;
  return combination;
}

}  // namespace collinea::bundle
