// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/tensor_patch.h"

#include <algorithm>
#include <array>

#include "collinea/feature/internal/sift_kernels.h"

namespace collinea {
namespace {

constexpr int kMiddle = 3;
constexpr std::size_t kChannels = 3;

}  // namespace

TensorPatch::TensorPatch(std::vector<float> taps, GradientMask mask, CornerMeasure measure, float parameter)
    : taps_(std::move(taps)),
      mask_(mask),
      measure_(measure),
      parameter_(parameter),
      radius_(int(taps_.size()) - 1),
      stride_(std::size_t(2 * radius_ + 5 + 2 * kRowSlack)) {
  const std::size_t rows = std::size_t(2 * radius_ + 5);
  grey_.assign(rows * stride_ + 2 * kRowSlack, 0);
  products_.assign(kChannels * stride_ + 2 * kRowSlack, 0);
  along_.assign(kChannels * rows * (kMiddle + kRowSlack) + 2 * kRowSlack, 0);
  across_.assign(kChannels * (kMiddle + kRowSlack) + 2 * kRowSlack, 0);
}

void TensorPatch::take(const GreyImage& image, int column, int row) {
  const int reach = this->reach();
  for (int dy = -reach; dy <= reach; ++dy) {
    const std::uint8_t* from = image.row(row + dy) + column - reach;
    std::copy(from, from + 2 * reach + 1, grey_.begin() + std::ptrdiff_t(index(-reach, dy)));
  }
}

float TensorPatch::strongest() {
  const int width = 2 * radius_ + kMiddle;  // of the products, as many rows of them
  const std::size_t step = kMiddle + kRowSlack, plane = std::size_t(width) * step;
  for (int i = 0; i < width; ++i) {
    const int dy = i - radius_ - 1;
    const auto grey = [&](int y) { return grey_.data() + index(-radius_ - 1, y); };
    float* const products = products_.data();
    gradient_products(grey(dy - 1), grey(dy), grey(dy + 1), width, mask_, products, products + stride_,
                      products + 2 * stride_);
    for (std::size_t c = 0; c < kChannels; ++c)
      filter_along_row(products + c * stride_ + radius_, kMiddle, taps_.data(), radius_,
                       along_.data() + c * plane + std::size_t(i) * step);
  }
  std::vector<const float*> rows(std::size_t(2 * radius_ + 1));
  float most = 0;
  for (int y = 0; y < kMiddle; ++y) {
    for (std::size_t c = 0; c < kChannels; ++c) {
      for (std::size_t j = 0; j < rows.size(); ++j) rows[j] = along_.data() + c * plane + (std::size_t(y) + j) * step;
      filter_across_rows(rows.data(), kMiddle, taps_.data(), radius_, across_.data() + c * step);
    }
    float* const a = across_.data();
    corner_response(a, a + step, a + 2 * step, kMiddle, measure_, parameter_, a);
    most = std::max(most, *std::max_element(a, a + kMiddle));
  }
  return most;
}

}  // namespace collinea
