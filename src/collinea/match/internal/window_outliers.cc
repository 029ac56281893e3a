// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/window_outliers.h"

#include <algorithm>
#include <cmath>

#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr float kSigmaOfMedian = 1.4826F;  // of the absolute value of a normal variable
constexpr float kTukey = 4.685F;           // 95 % of the efficiency of least squares
constexpr float kLeastScale = 0.1F;        // grey: whole numbers smoothed
constexpr double kFalseAlarm = 0.05;       // a window without outliers
constexpr int kMargin = 1;                 // points round one that is out, of which the mean is made

float scale_of(const float* values, std::vector<float>& sorted) {
  for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = std::abs(values[k]);
  const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return std::max(kSigmaOfMedian * *middle, kLeastScale);
}

}  // namespace

void WindowOutliers::begin(const WindowFit& fit) {
  const std::size_t count = std::size_t(fit.count());
  out_of_.assign(count, 0);
  factors_.assign(count, 1);
  means_.assign(count, 0);
  sorted_.assign(count, 0);
  share_used_ = 1;
}

// Residuals and means of their neighbours in units of their standard deviations, the larger of both.
void WindowOutliers::judge(const WindowFit& fit) {
  const float* r = fit.residual();
  const int side = fit.side();
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      float sum = 0;
      int count = 0;
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side - 1); ++i, ++count) sum += r[j * side + i];
      means_[std::size_t(y * side + x)] = sum / float(count);
    }
  const float of_one = scale_of(r, sorted_), of_mean = scale_of(means_.data(), sorted_);
  for (std::size_t k = 0; k < out_of_.size(); ++k)
    out_of_[k] = std::max(std::abs(r[k]) / of_one, std::abs(means_[k]) / of_mean);
}

const float* WindowOutliers::soft(const WindowFit& fit) {
  judge(fit);
  for (std::size_t k = 0; k < factors_.size(); ++k) {
    const float of_limit = out_of_[k] / kTukey, inside = 1 - of_limit * of_limit;
    factors_[k] = of_limit < 1 ? inside * inside : 0;
  }
  return factors_.data();
}

bool WindowOutliers::reject(const WindowFit& fit) {
  judge(fit);
  const int side = fit.side();
  const auto limit = float(normal_limit(kFalseAlarm / (2.0 * fit.count())));  // of two residuals each
  sorted_ = factors_;
  std::fill(factors_.begin(), factors_.end(), 1.0F);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      if (out_of_[std::size_t(y * side + x)] <= limit) continue;
      for (int j = std::max(y - kMargin, 0); j <= std::min(y + kMargin, side - 1); ++j)
        for (int i = std::max(x - kMargin, 0); i <= std::min(x + kMargin, side - 1); ++i)
          factors_[std::size_t(j * side + i)] = 0;
    }
  share_used_ = double(std::count(factors_.begin(), factors_.end(), 1.0F)) / fit.count();
  return factors_ != sorted_;
}

}  // namespace collinea
