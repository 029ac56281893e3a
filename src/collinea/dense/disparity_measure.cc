// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/disparity_measure.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/dense/measure_kernels.h"

namespace collinea::dense {
namespace {

constexpr int kSide = 2 * kMeasureReach + 1;
constexpr int kBandRows = 64;  // a band of rows is one item of work
constexpr int kBorder = 4;     // columns repeated on either side of a row

// A picture whose rows can be read and written some columns beyond their ends.
class Padded {
 public:
  Padded(int width, int height) : width_(width), height_(height), stride_(width + 2 * kBorder + kRowSlack) {
    data_.resize(std::size_t(stride_) * std::size_t(height));
  }
  [[nodiscard]] float* row(int y) {
    return data_.data() + std::size_t(std::clamp(y, 0, height_ - 1)) * std::size_t(stride_) + kBorder;
  }
  void repeat_border(int y) {
    float* values = row(y);
    std::fill(values - kBorder, values, values[0]);
    std::fill(values + width_, values + width_ + kBorder + kRowSlack, values[width_ - 1]);
  }

 private:
  int width_, height_, stride_;
  std::vector<float> data_;
};

void for_bands(const Run& run, int height, const std::function<void(int, int)>& work) {
  const int bands = (height + kBandRows - 1) / kBandRows;
  parallel_for(run, std::size_t(bands),
               [&](std::size_t i) { work(int(i) * kBandRows, std::min(int(i + 1) * kBandRows, height)); });
}

// The windows of one band, row after row.
class Band {
 public:
  Band(const GreyImage& left, const GreyImage& right, const FloatImage& surface)
      : left_(left), right_(right), surface_(surface), stride_(left.width + 2 * kMeasureReach + 2 * kRowSlack) {
    memory_.resize(std::size_t(stride_) * (kSide + 1) * 5);
    sums_.resize(std::size_t(stride_) * 12);
    quads_.resize(std::size_t(right.width));
    own_.resize(std::size_t(left.width + kRowSlack));
    depth_.resize(std::size_t(left.width + kRowSlack));
    for (auto& row : out_) row.resize(std::size_t(left.width + kRowSlack));
    for (int i = 0; i <= kSide; ++i) rows_[std::size_t(i)] = row_in(i);
    std::int32_t* at = sums_.data();
    const auto next = [&] { return std::exchange(at, at + stride_); };
    columns_.left = next(), columns_.left_left = next(), columns_.missing = next();
    for (std::size_t t = 0; t < kMeasureTrials; ++t)
      columns_.right[t] = next(), columns_.right_right[t] = next(), columns_.left_right[t] = next();
  }

  void measure(int begin, int end, MeasuredDisparities& result) {
    const int width = left_.width + 2 * kMeasureReach;
    for (int y = begin - kMeasureReach; y < end + kMeasureReach; ++y) {
      const int turn = y - begin + kMeasureReach;
      TrialRow& entering = rows_[std::size_t(turn % (kSide + 1))];
      warp(std::clamp(y, 0, left_.height - 1), entering);
      const TrialRow* leaving = turn >= kSide ? &rows_[std::size_t((turn + 1) % (kSide + 1))] : nullptr;
      slide(entering, leaving, width, columns_);
      if (turn >= kSide - 1) finish(y - kMeasureReach, result);
    }
  }

 private:
  TrialRow row_in(int i) {
    std::int32_t* at = memory_.data() + std::size_t(i) * 5 * std::size_t(stride_);
    const std::size_t step = std::size_t(stride_);
    return {at, at + step, {at + 2 * step, at + 3 * step, at + 4 * step}};
  }

  void warp(int y, const TrialRow& row) {
    const std::uint8_t* other = right_.row(y);
    const int last = right_.width - 1;
    for (int i = 0; i <= last; ++i) {
      const std::uint32_t a = other[std::max(i - 1, 0)], b = other[i], c = other[std::min(i + 1, last)],
                          e = other[std::min(i + 2, last)];
      quads_[std::size_t(i)] = std::int32_t(a | b << 8 | c << 16 | e << 24);
    }
    std::copy_n(left_.row(y), left_.width, own_.begin());
    std::copy_n(surface_.row(y), left_.width, depth_.begin());
    TrialRow inner{row.left + kMeasureReach, row.missing + kMeasureReach, {}};
    for (std::size_t t = 0; t < kMeasureTrials; ++t) inner.right[t] = row.right[t] + kMeasureReach;
    warp_row(own_.data(), quads_.data(), right_.width, depth_.data(), left_.width, inner);
    for (std::int32_t* values : {row.left, row.missing, row.right[0], row.right[1], row.right[2]}) {
      std::fill_n(values, kMeasureReach, values[kMeasureReach]);
      std::fill_n(values + kMeasureReach + left_.width, kMeasureReach, values[kMeasureReach + left_.width - 1]);
    }
  }

  void finish(int y, MeasuredDisparities& result) {
    std::copy_n(surface_.row(y), left_.width, depth_.begin());
    find_peaks(columns_, left_.width, {depth_.data(), out_[0].data(), out_[1].data(), out_[2].data()});
    std::copy_n(out_[0].begin(), left_.width, result.disparity.row(y));
    std::copy_n(out_[1].begin(), left_.width, result.sigma.row(y));
    std::copy_n(out_[2].begin(), left_.width, result.correlation.row(y));
  }

  const GreyImage& left_;
  const GreyImage& right_;
  const FloatImage& surface_;
  int stride_;
  std::vector<std::int32_t> memory_, sums_, quads_;
  std::vector<std::uint8_t> own_;
  std::vector<float> depth_;
  std::array<std::vector<float>, 3> out_;
  std::array<TrialRow, kSide + 1> rows_;
  ColumnSums columns_;
};

}  // namespace

MeasuredDisparities measure(const GreyImage& left, const GreyImage& right, const FloatImage& surface, const Run& run) {
  const FloatImage empty(left.width, left.height);
  MeasuredDisparities result{empty, empty, empty};
  for_bands(run, left.height, [&](int begin, int end) { Band(left, right, surface).measure(begin, end, result); });
  return result;
}

FloatImage smoothed(const FloatImage& surface, float reach, const Run& run) {
  const int width = surface.width, height = surface.height;
  Padded values(width, height), medians(width, height);
  for_bands(run, height, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      std::copy_n(surface.row(y), width, values.row(y));
      values.repeat_border(y);
    }
  });
  for_bands(run, height, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      median_row({values.row(y - 1), values.row(y), values.row(y + 1)}, width, medians.row(y));
      medians.repeat_border(y);
    }
  });
  FloatImage result(width, height);
  for_bands(run, height, [&](int begin, int end) {
    std::vector<float> out(std::size_t(width + kRowSlack));
    for (int y = begin; y < end; ++y) {
      mean_within_row({medians.row(y - 2), medians.row(y - 1), medians.row(y), medians.row(y + 1), medians.row(y + 2)},
                      reach, width, out.data());
      std::copy_n(out.begin(), width, result.row(y));
    }
  });
  return result;
}

}  // namespace collinea::dense
