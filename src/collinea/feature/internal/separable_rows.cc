// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/separable_rows.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/result.h"
#include "collinea/feature/internal/sift_kernels.h"

namespace collinea {
namespace {

constexpr int kHeldRows = 4;
constexpr int kBefore = 16;  // floats in front of a row, to keep it aligned

double gaussian(double x, double sigma) { return std::exp(-0.5 * x * x / (sigma * sigma)); }

}  // namespace

std::vector<float> gaussian_window(double sigma_px, int radius_px) {
  double sum = 0;
  for (int j = -radius_px; j <= radius_px; ++j) sum += gaussian(j, sigma_px);
  std::vector<float> taps;
  for (int j = 0; j <= radius_px; ++j) taps.push_back(static_cast<float>(gaussian(j, sigma_px) / sum));
  return taps;
}

std::vector<float> gaussian_curvature(double sigma_px, int radius_px) {
  // Sampled, made free of a mean, and scaled to the second moment of the derivative.
  std::vector<double> values;
  double mean = 0, moment = 0;
  for (int j = 0; j <= radius_px; ++j) {
    values.push_back((j * j / (sigma_px * sigma_px) - 1) * gaussian(j, sigma_px));
    mean += (j == 0 ? 1 : 2) * values.back() / (2 * radius_px + 1);
  }
  for (int j = 0; j <= radius_px; ++j) {
    values[static_cast<std::size_t>(j)] -= mean;
    moment += 2 * j * j * values[static_cast<std::size_t>(j)];
  }
  std::vector<float> taps;
  for (const double value : values) taps.push_back(static_cast<float>(2 * value / moment));
  return taps;
}

std::vector<float> box_window(int radius_px) { return std::vector<float>(static_cast<std::size_t>(radius_px) + 1, 1); }

SeparableRows::SeparableRows(int width, int height, std::vector<SeparableFilter> filters)
    : filters_(std::move(filters)),
      radius_(static_cast<int>(filters_.front().along.size()) - 1),
      width_(width),
      height_(height) {
  for (const SeparableFilter& filter : filters_) {
    COLLINEA_CHECK(static_cast<int>(filter.along.size()) == radius_ + 1 && filter.across.size() == filter.along.size());
    rings_.emplace_back(width, 2 * radius_ + 1);
    padded_.emplace_back(static_cast<std::size_t>(width + 2 * radius_ + 2 * kRowSlack));
  }
  for (std::vector<float>& padded : padded_) source_rows_.push_back(padded.data() + radius_);
}

void SeparableRows::fill(const Source& source, int y) {
  source(y, source_rows_);
  for (std::size_t c = 0; c < filters_.size(); ++c) {
    float* row = source_rows_[c];
    std::fill(padded_[c].data(), row, row[0]);
    std::fill(row + width_, row + width_ + radius_, row[width_ - 1]);
    filter_along_row(row, width_, filters_[c].along.data(), radius_, rings_[c].row(y % rings_[c].height()));
  }
}

void SeparableRows::run(const Source& source, const Sink& sink) {
  std::vector<Plane> out;
  std::vector<float*> out_rows;
  for (std::size_t c = 0; c < filters_.size(); ++c) out_rows.push_back(out.emplace_back(width_, 1).row(0));
  std::vector<const float*> rows(static_cast<std::size_t>(2 * radius_ + 1));
  int filled = 0;
  for (int y = 0; y < height_; ++y) {
    for (; filled < std::min(height_, y + radius_ + 1); ++filled) fill(source, filled);
    for (std::size_t c = 0; c < filters_.size(); ++c) {
      for (int j = -radius_; j <= radius_; ++j)
        rows[static_cast<std::size_t>(radius_ + j)] =
            rings_[c].row(std::clamp(y + j, 0, height_ - 1) % rings_[c].height());
      filter_across_rows(rows.data(), width_, filters_[c].across.data(), radius_, out_rows[c]);
    }
    sink(y, out_rows);
  }
}

FloatRows::FloatRows(const GreyImage& image, int begin, int width)
    : image_(image), begin_(begin), width_(width), ring_(width + 2 * kBefore, kHeldRows), held_(kHeldRows, -1) {}

const float* FloatRows::row(int y) {
  const int at = std::clamp(y, 0, image_.height - 1), slot = at % kHeldRows;
  float* out = ring_.row(slot) + kBefore;
  int& held = held_[static_cast<std::size_t>(slot)];
  if (held == at) return out;
  held = at;
  const std::uint8_t* in = image_.row(at);
  const int first = std::max(-1, -begin_), last = std::min(width_ + 1, image_.width - begin_);
  widen_row(in + begin_ + first, last - first, out + first);
  for (int x = -1; x < first; ++x) out[x] = in[0];
  for (int x = last; x < width_ + 1; ++x) out[x] = in[image_.width - 1];
  return out;
}

}  // namespace collinea
