// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/window_fit.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kWeightOfHalf = 0.6;  // standard deviation of the Gaussian weights, of the half width
using Coefficients = Eigen::Matrix<float, kWindowColumns, 1>;

ColumnMatrix products_of(const std::vector<float>& forms) {
  Eigen::Matrix<float, kWindowColumns, kWindowColumns> out;
  forms_products(forms.data(), int(forms.size() / kWindowColumns), out.data());
  return out.cast<double>();
}

}  // namespace

std::optional<WindowFit> WindowFit::of(const GreyImage& image, const Eigen::Vector2d& position_px, int window_px,
                                       bool gaussian) {
  if (!(position_px.minCoeff() >= 0 && position_px.x() < image.width && position_px.y() < image.height))
    return std::nullopt;
  WindowFit fit;
  fit.side_ = window_px;
  fit.padded_ = (window_px * window_px + kPointGroup - 1) / kPointGroup * kPointGroup;
  fit.data_.assign(kRows * std::size_t(fit.padded_), 0);
  const int half = window_px / 2;
  const Eigen::Vector2d middle = position_px.array().floor() + 0.5;
  float *u = fit.row(kU), *v = fit.row(kV), *weight = fit.row(kFirstWeight);
  for (int k = 0; k < fit.count(); ++k) {
    const int x = k % window_px - half, y = k / window_px - half;
    u[k] = float(x);
    v[k] = float(y);
    const double square = double(x * x + y * y) / double(half * half);
    weight[k] = gaussian ? float(std::exp(-0.5 * square / (kWeightOfHalf * kWeightOfHalf))) : 1;
  }
  float* grey = fit.row(kTemplate);
  if (!sample_spline(image, {middle, Eigen::Matrix2d::Identity()}, u, v, fit.padded_, grey, fit.row(kTemplateX),
                     fit.row(kTemplateY)))
    return std::nullopt;
  double sum = 0, weights = 0;
  for (int k = 0; k < fit.count(); ++k) {
    sum += double{weight[k]} * grey[k];
    weights += weight[k];
    u[k] += float(middle.x() - position_px.x());
    v[k] += float(middle.y() - position_px.y());
  }
  fit.mean_ = sum / weights;
  for (int k = 0; k < fit.padded_; ++k) grey[k] -= float(fit.mean_);
  std::copy_n(weight, fit.padded_, fit.row(kWeight));
  fit.weigh_columns();
  return fit;
}

void WindowFit::weigh_columns() {
  const float *u = row(kU), *v = row(kV), *w = row(kWeight), *x = row(kTemplateX), *y = row(kTemplateY),
              *grey = row(kTemplate);
  float* column = row(kColumns);
  weights_ = 0;
  const std::size_t n = std::size_t(padded_);
  for (std::size_t k = 0; k < n; ++k) {
    const float wx = w[k] * x[k], wy = w[k] * y[k];
    column[k] = wx;
    column[n + k] = wy;
    column[2 * n + k] = wx * u[k];
    column[3 * n + k] = wx * v[k];
    column[4 * n + k] = wy * u[k];
    column[5 * n + k] = wy * v[k];
    column[6 * n + k] = -w[k] * grey[k];
    column[7 * n + k] = -w[k];
    weights_ += w[k];
  }
  float* one = row(kScratch);
  normal_.col(0) = products(x);
  normal_.col(1) = products(y);
  normal_.col(2) = products(x, u);
  normal_.col(3) = products(x, v);
  normal_.col(4) = products(y, u);
  normal_.col(5) = products(y, v);
  normal_.col(6) = -products(grey);
  std::fill_n(one, n, 1.0F);
  normal_.col(7) = -products(one);
}

ColumnVector WindowFit::products(const float* values) {
  float out[kWindowColumns];
  column_products(row(kColumns), values, padded_, out);
  return Eigen::Map<const Coefficients>(out).cast<double>();
}
ColumnVector WindowFit::products(const float* slope, const float* by) {
  float* scratch = row(kScratch);
  for (int k = 0; k < padded_; ++k) scratch[k] = slope[k] * by[k];
  return products(scratch);
}

bool WindowFit::sample(const GreyImage& image, const WindowPlacement& placement) {
  return sample_spline(image, placement, row(kU), row(kV), padded_, row(kGrey), row(kX), row(kY));
}

double WindowFit::residuals(const WindowLightValues& light) {
  const float *grey = row(kGrey), *reference = row(kTemplate), *w = row(kWeight);
  float* r = row(kResidual);
  const auto gain = float(light.gain), offset = float(light.offset_grey);
  double squares = 0;
  for (int k = 0; k < padded_; ++k) {
    r[k] = grey[k] - gain * reference[k] - offset;
    squares += double{w[k]} * r[k] * r[k];
  }
  return squares;
}

ColumnVector WindowFit::score() { return products(row(kResidual)); }

ColumnMatrix WindowFit::matrix() {
  const float *u = row(kU), *v = row(kV), *x = row(kX), *y = row(kY);
  ColumnMatrix out = normal_;
  out.col(0) = products(x);
  out.col(1) = products(y);
  out.col(2) = products(x, u);
  out.col(3) = products(x, v);
  out.col(4) = products(y, u);
  out.col(5) = products(y, v);
  return out;
}

// Each element of B'W r is a linear form of the pixels: of those of the other image through the weights by which its
// points are made of them, of those of the reference likewise.
WindowFit::Noise WindowFit::noise(const WindowPlacement& placement, double gain) const {
  const float *u = row(kU), *v = row(kV), *w = row(kWeight);
  const auto add = [&](const Eigen::Vector2d& position, const Eigen::Matrix2d& map, const Eigen::Vector2i& frame,
                       std::vector<float>& forms) {
    forms.assign(std::size_t(frame.x()) * std::size_t(frame.y()) * kWindowColumns, 0.0F);
    return add_noise_forms({position, map}, u, v, w, row(kColumns), count(), padded_, frame.x(), forms.data());
  };
  constexpr int kBeyond = 3;  // pixels that a point on the rim is made of, and the fraction of its position
  const double half = side_ / 2 + 0.5;
  const Eigen::Vector2d reach = placement.map.cwiseAbs() * Eigen::Vector2d(half, half);
  const Eigen::Vector2i around = reach.array().ceil().cast<int>() + kBeyond;
  const Eigen::Vector2d fraction = placement.position_px.array() - placement.position_px.array().floor();
  std::vector<float> forms;
  Noise out;
  out.squares = add(around.cast<double>() + fraction, placement.map, 2 * around + Eigen::Vector2i(1, 1), forms);
  out.covariance = products_of(forms);
  const int framed = side_ + 2 * kBeyond;
  const Eigen::Vector2d corner(kBeyond - 0.5 - u[0] + 1, kBeyond - 0.5 - v[0] + 1);
  out.squares += gain * gain * add(corner, Eigen::Matrix2d::Identity(), {framed, framed}, forms);
  out.covariance += gain * gain * products_of(forms);
  return out;
}

double WindowFit::correlation() const {
  const float *grey = row(kGrey), *reference = row(kTemplate), *w = row(kWeight);
  double sum = 0, square = 0, common = 0, sum_reference = 0, square_reference = 0;
  for (int k = 0; k < count(); ++k) {
    const double a = reference[k], b = grey[k], weight = w[k];
    sum += weight * b;
    square += weight * b * b;
    common += weight * a * b;
    sum_reference += weight * a;
    square_reference += weight * a * a;
  }
  const double variance = square - sum * sum / weights_,
               of_reference = square_reference - sum_reference * sum_reference / weights_;
  if (!(variance > 1e-6 * weights_ && of_reference > 1e-6 * weights_)) return 0;
  return (common - sum * sum_reference / weights_) / std::sqrt(variance * of_reference);
}

void WindowFit::reweight(const float* factor) {
  const float* first = row(kFirstWeight);
  float* w = row(kWeight);
  for (int k = 0; k < count(); ++k) w[k] = first[k] * factor[k];
  weigh_columns();
}

}  // namespace collinea
