// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/window_kernels.h"

#include <cmath>

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/match/internal/window_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#ifndef COLLINEA_MATCH_SPLINE_VIEW
#define COLLINEA_MATCH_SPLINE_VIEW
namespace collinea {

// An image seen from a pixel of it, so that positions are small numbers: columns and rows from there.
struct SplineView {
  const std::uint8_t* origin;
  int stride;
  int least_column, most_column, least_row, most_row;  // of the pixel before a point
  float x, y, xu, xv, yu, yv;                          // of the point (u, v): x + xu u + xv v, y + yu u + yv v
};

// As spline_weights of spline_window.h.
inline void plain_spline_weights(float t, float* out) {
  const float s = 1 - t, tt = t * t, ss = s * s;
  out[0] = ss * s / 6;
  out[1] = (4 - 6 * tt + 3 * (tt * t)) / 6;
  out[2] = (4 - 6 * ss + 3 * (ss * s)) / 6;
  out[3] = tt * t / 6;
}
inline float square_of(const float* four) {
  return (four[0] * four[0] + four[1] * four[1]) + (four[2] * four[2] + four[3] * four[3]);
}

}  // namespace collinea
#endif

// Products and sums are kept apart (no fused multiply-add), and sums are kept in kPointGroup parts whatever the width
// of the vectors: then every processor gives the same bits.

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using WindowD = hn::CappedTag<float, kPointGroup>;
using WindowDI = hn::RebindToSigned<WindowD>;
using WindowV = hn::Vec<WindowD>;
using WindowVI = hn::Vec<WindowDI>;

struct SplineWeights {
  WindowV value[4], slope[4];
};

// As spline_weights of spline_window.h.
HWY_INLINE SplineWeights spline_weights_of(WindowD d, WindowV t) {
  const WindowV one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f), sixth = hn::Set(d, 1.0f / 6), four = hn::Set(d, 4.0f),
                six = hn::Set(d, 6.0f), three = hn::Set(d, 3.0f);
  const WindowV s = hn::Sub(one, t), tt = hn::Mul(t, t), ss = hn::Mul(s, s), ttt = hn::Mul(tt, t), sss = hn::Mul(ss, s);
  const auto middle = [&](WindowV square, WindowV cube) HWY_ATTR {
    return hn::Mul(sixth, hn::Add(hn::Sub(four, hn::Mul(six, square)), hn::Mul(three, cube)));
  };
  return {{hn::Mul(sixth, sss), middle(tt, ttt), middle(ss, sss), hn::Mul(sixth, ttt)},
          {hn::Sub(hn::Zero(d), hn::Mul(half, ss)), hn::Mul(half, hn::Sub(hn::Mul(three, tt), hn::Mul(four, t))),
           hn::Mul(half, hn::Sub(hn::Mul(four, s), hn::Mul(three, ss))), hn::Mul(half, tt)}};
}

template <int kByte>
HWY_INLINE WindowV grey_of(WindowD d, WindowDI di, WindowVI four) {
  return hn::ConvertTo(d, hn::And(hn::ShiftRight<8 * kByte>(four), hn::Set(di, 255)));
}

HWY_INLINE WindowV sum_of(const WindowV (&weights)[4], const WindowV (&values)[4]) {
  return hn::Add(hn::Add(hn::Mul(weights[0], values[0]), hn::Mul(weights[1], values[1])),
                 hn::Add(hn::Mul(weights[2], values[2]), hn::Mul(weights[3], values[3])));
}

bool sample_view(const SplineView& view, const float* u, const float* v, int count, float* grey, float* slope_x,
                 float* slope_y) {
  const WindowD d;
  const WindowDI di;
  const int n = static_cast<int>(hn::Lanes(d));
  const auto* base = reinterpret_cast<const std::int32_t*>(view.origin);
  const WindowVI stride = hn::Set(di, view.stride), one = hn::Set(di, 1);
  for (int i = 0; i < count; i += n) {
    const WindowV ui = hn::LoadU(d, u + i), vi = hn::LoadU(d, v + i);
    const WindowV x =
        hn::Add(hn::Set(d, view.x), hn::Add(hn::Mul(hn::Set(d, view.xu), ui), hn::Mul(hn::Set(d, view.xv), vi)));
    const WindowV y =
        hn::Add(hn::Set(d, view.y), hn::Add(hn::Mul(hn::Set(d, view.yu), ui), hn::Mul(hn::Set(d, view.yv), vi)));
    const WindowV x_low = hn::Floor(x), y_low = hn::Floor(y);
    const WindowVI column = hn::ConvertTo(di, x_low), row = hn::ConvertTo(di, y_low);
    const auto outside =
        hn::Or(hn::Or(hn::Lt(column, hn::Set(di, view.least_column)), hn::Gt(column, hn::Set(di, view.most_column))),
               hn::Or(hn::Lt(row, hn::Set(di, view.least_row)), hn::Gt(row, hn::Set(di, view.most_row))));
    if (!hn::AllFalse(di, outside)) return false;
    const SplineWeights across = spline_weights_of(d, hn::Sub(x, x_low)),
                        down = spline_weights_of(d, hn::Sub(y, y_low));
    WindowVI at = hn::Add(hn::Mul(hn::Sub(row, one), stride), hn::Sub(column, one));
    WindowV values[4], slopes[4];
    for (int j = 0; j < 4; ++j) {
      const WindowVI four = hn::GatherOffset(di, base, at);
      const WindowV pixels[4] = {grey_of<0>(d, di, four), grey_of<1>(d, di, four), grey_of<2>(d, di, four),
                                 grey_of<3>(d, di, four)};
      values[j] = sum_of(across.value, pixels);
      slopes[j] = sum_of(across.slope, pixels);
      at = hn::Add(at, stride);
    }
    hn::StoreU(sum_of(down.value, values), d, grey + i);
    hn::StoreU(sum_of(down.value, slopes), d, slope_x + i);
    hn::StoreU(sum_of(down.slope, values), d, slope_y + i);
  }
  return true;
}

void column_products(const float* columns, const float* values, int count, float* out) {
  const WindowD d;
  const int n = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float sums[kWindowColumns][kPointGroup] = {};
  for (int i = 0; i < count; i += kPointGroup)
    for (int part = 0; part < kPointGroup; part += n) {
      const WindowV value = hn::LoadU(d, values + i + part);
      for (int k = 0; k < kWindowColumns; ++k) {
        const WindowV product = hn::Mul(hn::LoadU(d, columns + std::ptrdiff_t{k} * count + i + part), value);
        hn::Store(hn::Add(hn::Load(d, sums[k] + part), product), d, sums[k] + part);
      }
    }
  for (int k = 0; k < kWindowColumns; ++k) {
    out[k] = 0;
    for (const float sum : sums[k]) out[k] += sum;
  }
}

using FormD = hn::CappedTag<float, kWindowColumns>;

float add_forms(const SplineView& view, const float* u, const float* v, const float* weight, const float* columns,
                int points, int count, float* forms) {
  const FormD d;
  const int n = static_cast<int>(hn::Lanes(d));
  float white = 0;
  for (int k = 0; k < points; ++k) {
    HWY_ALIGN float own[kWindowColumns];
    for (int column = 0; column < kWindowColumns; ++column) own[column] = columns[std::ptrdiff_t{column} * count + k];
    const float x = view.x + (view.xu * u[k] + view.xv * v[k]), y = view.y + (view.yu * u[k] + view.yv * v[k]);
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    float across[4], down[4];
    plain_spline_weights(x - static_cast<float>(column), across);
    plain_spline_weights(y - static_cast<float>(row), down);
    white += weight[k] * (square_of(across) * square_of(down));
    for (int j = 0; j < 4; ++j) {
      float* pixel = forms + (std::ptrdiff_t{row - 1 + j} * view.stride + column - 1) * kWindowColumns;
      for (int i = 0; i < 4; ++i, pixel += kWindowColumns) {
        const auto share = hn::Set(d, down[j] * across[i]);
        for (int part = 0; part < kWindowColumns; part += n)
          hn::StoreU(hn::Add(hn::LoadU(d, pixel + part), hn::Mul(share, hn::Load(d, own + part))), d, pixel + part);
      }
    }
  }
  return white;
}

void forms_products(const float* forms, int pixels, float* out) {
  const FormD d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int part = 0; part < kWindowColumns; part += n) {
    auto s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0, s4 = s0, s5 = s0, s6 = s0, s7 = s0;
    for (int pixel = 0; pixel < pixels; ++pixel) {
      const float* form = forms + std::ptrdiff_t{pixel} * kWindowColumns;
      const auto own = hn::LoadU(d, form + part);
      s0 = hn::Add(s0, hn::Mul(own, hn::Set(d, form[0])));
      s1 = hn::Add(s1, hn::Mul(own, hn::Set(d, form[1])));
      s2 = hn::Add(s2, hn::Mul(own, hn::Set(d, form[2])));
      s3 = hn::Add(s3, hn::Mul(own, hn::Set(d, form[3])));
      s4 = hn::Add(s4, hn::Mul(own, hn::Set(d, form[4])));
      s5 = hn::Add(s5, hn::Mul(own, hn::Set(d, form[5])));
      s6 = hn::Add(s6, hn::Mul(own, hn::Set(d, form[6])));
      s7 = hn::Add(s7, hn::Mul(own, hn::Set(d, form[7])));
    }
    const decltype(s0) sums[] = {s0, s1, s2, s3, s4, s5, s6, s7};
    for (int k = 0; k < kWindowColumns; ++k) hn::StoreU(sums[k], d, out + k * kWindowColumns + part);
  }
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(sample_view);
HWY_EXPORT(column_products);
HWY_EXPORT(add_forms);
HWY_EXPORT(forms_products);

namespace {
SplineView view_of(const Eigen::Matrix2d& map, double x, double y) {
  const auto number = [](double value) { return static_cast<float>(value); };
  return {
      nullptr,          0, 0, 0, 0, 0, number(x), number(y), number(map(0, 0)), number(map(0, 1)), number(map(1, 0)),
      number(map(1, 1))};
}
}  // namespace

bool sample_spline(const GreyImage& image, const WindowPlacement& placement, const float* u, const float* v, int count,
                   float* grey, float* slope_x, float* slope_y) {
  const Eigen::Vector2d at = placement.position_px - Eigen::Vector2d(0.5, 0.5);
  if (!(at.minCoeff() >= 0 && at.x() < image.width && at.y() < image.height && placement.map.norm() < 100))
    return false;
  const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
  SplineView view = view_of(placement.map, at.x() - column, at.y() - row);
  view.origin = image.row(row) + column;
  view.stride = image.width;
  view.least_column = 1 - column;
  view.most_column = image.width - 3 - column;
  view.least_row = 1 - row;
  view.most_row = image.height - 3 - row;
  return HWY_DYNAMIC_DISPATCH(sample_view)(view, u, v, count, grey, slope_x, slope_y);
}

void column_products(const float* columns, const float* values, int count, float* out) {
  HWY_DYNAMIC_DISPATCH(column_products)(columns, values, count, out);
}

double add_noise_forms(const WindowPlacement& placement, const float* u, const float* v, const float* weight,
                       const float* columns, int points, int count, int width, float* forms) {
  SplineView view = view_of(placement.map, placement.position_px.x() - 0.5, placement.position_px.y() - 0.5);
  view.stride = width;
  return HWY_DYNAMIC_DISPATCH(add_forms)(view, u, v, weight, columns, points, count, forms);
}

void forms_products(const float* forms, int pixels, float* out) {
  HWY_DYNAMIC_DISPATCH(forms_products)(forms, pixels, out);
}

}  // namespace collinea
#endif  // HWY_ONCE
