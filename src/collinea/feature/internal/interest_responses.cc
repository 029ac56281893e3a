// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/interest_responses.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "collinea/feature/internal/interest_kernels.h"
#include "collinea/feature/internal/interest_window.h"
#include "collinea/feature/internal/separable_rows.h"

namespace collinea {
namespace {

constexpr float kRounding_grey = 1e-3f;  // of sums of floats: responses of blobs below it are none

GradientMask mask_of(InterestOperator method) {
  return method == InterestOperator::kKovesi ? GradientMask::kPrewitt : GradientMask::kCentral;
}

CornerMeasure measure_of(InterestOperator method) {
  switch (method) {
    case InterestOperator::kNoble:
    case InterestOperator::kKovesi:
      return CornerMeasure::kNoble;
    case InterestOperator::kShiTomasi:
      return CornerMeasure::kSmallerEigenvalue;
    case InterestOperator::kFoerstner:
      return CornerMeasure::kRoundNoble;
    default:
      return CornerMeasure::kHarris;
  }
}

using Rows = std::span<float* const>;
float parameter_of(const InterestOptions& o) {
  return static_cast<float>(o.method == InterestOperator::kFoerstner ? o.least_roundness : o.harris_k);
}

void tensor_responses(const ImageStrip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const std::vector<float> window = gaussian_window(o.sigma_px, window_radius(o));
  const float parameter = parameter_of(o);
  FloatRows grey(strip.image, strip.begin, strip.width);
  SeparableRows(strip.width, strip.image.height, std::vector(3, SeparableFilter{window, window}))
      .run(
          [&](int y, Rows rows) {
            const float *above = grey.row(y - 1), *middle = grey.row(y), *below = grey.row(y + 1);
            gradient_products(above, middle, below, strip.width, mask_of(o.method), rows[0], rows[1], rows[2]);
          },
          [&](int y, Rows rows) {
            corner_response(rows[0], rows[1], rows[2], strip.width, measure_of(o.method), parameter, rows[0]);
            sink(y, rows[0]);
          });
}

// Sums of squared differences for the shifts (1, 0), (0, 1), (1, 1), (-1, 1); the opposite shifts have the sums of the
// pixel that they lead to.
void moravec_responses(const ImageStrip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const std::vector<float> window = box_window(window_radius(o));
  FloatRows grey(strip.image, strip.begin, strip.width);
  std::vector<std::vector<float>> before(3, std::vector<float>(static_cast<std::size_t>(strip.width) + 2 * kRowSlack));
  std::vector<float> least(before[0].size()), right(before[0].size());
  SeparableRows(strip.width, strip.image.height, std::vector(4, SeparableFilter{window, window}))
      .run(
          [&](int y, Rows rows) {
            const float *at = grey.row(y), *below = grey.row(y + 1);
            squared_differences(at + 1, at, strip.width, rows[0]);
            squared_differences(below, at, strip.width, rows[1]);
            squared_differences(below + 1, at, strip.width, rows[2]);
            squared_differences(below - 1, at, strip.width, rows[3]);
          },
          [&](int y, Rows rows) {
            const auto width = static_cast<std::size_t>(strip.width);
            std::copy_n(rows[0], width, right.begin() + 1);
            std::copy_n(rows[0], width, least.begin());
            lower_to(right.data(), strip.width, least.data());
            for (std::size_t k = 1; k < 4; ++k) lower_to(rows[k], strip.width, least.data());
            lower_to(before[0].data() + 1, strip.width, least.data());  // (0, -1)
            lower_to(before[1].data(), strip.width, least.data());      // (-1, -1): of the pixel to the left
            lower_to(before[2].data() + 2, strip.width, least.data());  // (1, -1): of the pixel to the right
            for (std::size_t k = 1; k < 4; ++k) std::copy_n(rows[k], width, before[k - 1].begin() + 1);
            sink(y, least.data());
          });
}

// sigma^2 times the Laplacian of the blurred image, or the difference of two blurs; as sizes.
void blob_responses(const ImageStrip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const int radius = window_radius(o);
  const bool is_log = o.method == InterestOperator::kLog;
  const std::vector<float> fine = gaussian_window(o.sigma_px, radius);
  const std::vector<float> other =
      is_log ? gaussian_curvature(o.sigma_px, radius) : gaussian_window(kDogRatio * o.sigma_px, radius);
  std::vector<SeparableFilter> filters = {{other, is_log ? fine : other}, {fine, is_log ? other : fine}};
  const float factor = is_log ? static_cast<float>(o.sigma_px * o.sigma_px) : 1.0f, sign = is_log ? 1.0f : -1.0f;
  FloatRows grey(strip.image, strip.begin, strip.width);
  SeparableRows(strip.width, strip.image.height, std::move(filters))
      .run(
          [&](int y, Rows rows) {
            for (float* row : rows) std::copy_n(grey.row(y), strip.width, row);
          },
          [&](int y, Rows rows) {
            for (int x = 0; x < strip.width; ++x) {
              const float size = std::abs(factor * (rows[0][x] + sign * rows[1][x]));
              rows[0][x] = size > kRounding_grey ? size : 0;
            }
            sink(y, rows[0]);
          });
}

}  // namespace

TensorPatch tensor_patch_of(const InterestOptions& o) {
  return {gaussian_window(o.sigma_px, window_radius(o)), mask_of(o.method), measure_of(o.method), parameter_of(o)};
}

void interest_responses(const ImageStrip& strip, const InterestOptions& o, const ResponseSink& sink) {
  if (o.method == InterestOperator::kMoravec)
    moravec_responses(strip, o, sink);
  else if (is_blob(o.method))
    blob_responses(strip, o, sink);
  else
    tensor_responses(strip, o, sink);
}

}  // namespace collinea
