// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/disparity_measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/last_rows.h"

namespace collinea::dense {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kSide = 2 * kMeasureReach + 1;
constexpr int kBandRows = 64;  // a band of rows is one item of work

void for_bands(const Run& run, int height, const std::function<void(int, int)>& work) {
  const int bands = (height + kBandRows - 1) / kBandRows;
  parallel_for(run, std::size_t(bands),
               [&](std::size_t i) { work(int(i) * kBandRows, std::min(int(i + 1) * kBandRows, height)); });
}

// The windows of one band, row after row.
class Band {
 public:
  Band(const GreyImage& left, const GreyImage& right, const FloatImage& surface, const FloatImage& found,
       const Acceptance& acceptance)
      : left_(left),
        right_(right),
        surface_(surface),
        found_(found),
        acceptance_(acceptance),
        stride_(left.width + 2 * kMeasureReach + 2 * kRowSlack) {
    memory_.resize(std::size_t(stride_) * (kSide + 1) * 5);
    sums_.resize(std::size_t(stride_) * 12);
    other_.resize(std::size_t(right.width + kRowSlack + 3));
    quads_.resize(std::size_t(right.width + kRowSlack));
    own_.resize(std::size_t(left.width + kRowSlack));
    depth_.resize(std::size_t(left.width + kRowSlack));
    before_.resize(std::size_t(left.width + kRowSlack));
    for (auto& row : out_) row.resize(std::size_t(left.width + kRowSlack));
    for (int i = 0; i <= kSide; ++i) rows_[std::size_t(i)] = row_in(i);
    std::int32_t* at = sums_.data();
    const auto next = [&] { return std::exchange(at, at + stride_); };
    columns_.left = next(), columns_.left_left = next(), columns_.missing = next();
    for (std::size_t t = 0; t < kMeasureTrials; ++t)
      columns_.right[t] = next(), columns_.right_right[t] = next(), columns_.left_right[t] = next();
  }

  void measure(int begin, int end, DisparityMap& result) {
    const int width = left_.width + 2 * kMeasureReach;
    for (int y = begin - kMeasureReach; y < end + kMeasureReach; ++y) {
      const int row = y - begin + kMeasureReach;
      TrialRow& entering = rows_[std::size_t(row % (kSide + 1))];
      warp(std::clamp(y, 0, left_.height - 1), entering);
      const TrialRow* leaving = row >= kSide ? &rows_[std::size_t((row + 1) % (kSide + 1))] : nullptr;
      slide(entering, leaving, width, columns_);
      if (row >= kSide - 1) finish(y - kMeasureReach, result);
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
    other_[0] = other[0];
    std::copy_n(other, right_.width, other_.begin() + 1);
    std::fill_n(other_.begin() + 1 + right_.width, 2, other[right_.width - 1]);
    pack_quads(other_.data() + 1, right_.width, quads_.data());
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

  void finish(int y, DisparityMap& result) {
    std::copy_n(surface_.row(y), left_.width, depth_.begin());
    std::copy_n(found_.row(y), left_.width, before_.begin());
    const MeasuredRow row{depth_.data(), out_[0].data(), out_[1].data(), out_[2].data()};
    find_peaks(columns_, left_.width, row);
    accept_row(before_.data(), acceptance_, left_.width, row);
    std::copy_n(row.disparity, left_.width, result.disparity.row(y));
    std::copy_n(row.sigma, left_.width, result.sigma.row(y));
  }

  const GreyImage& left_;
  const GreyImage& right_;
  const FloatImage& surface_;
  const FloatImage& found_;
  const Acceptance& acceptance_;
  int stride_;
  std::vector<std::int32_t> memory_, sums_, quads_;
  std::vector<std::uint8_t> own_, other_;
  std::vector<float> depth_, before_;
  std::array<std::vector<float>, 3> out_;
  std::array<TrialRow, kSide + 1> rows_;
  ColumnSums columns_;
};

// The smooth surface, row after row.
class SmoothBand {
 public:
  SmoothBand(const FloatImage& found, float reach)
      : found_(found), reach_(reach), values_(found.width, 4, 0), medians_(found.width, 8, 0) {
    smooth_.resize(std::size_t(found.width + kRowSlack));
  }

  void smooth(int begin, int end, FloatImage& result) {
    const int width = found_.width, last = found_.height - 1;
    int filled = std::max(begin - 3, 0), median = std::max(begin - 2, 0);  // the next ones
    for (int y = begin; y < end; ++y) {
      for (; median <= std::min(y + 2, last); ++median) {
        for (; filled <= std::min(median + 1, last); ++filled) fill(filled);
        median_row({values_.row(std::max(median - 1, 0)), values_.row(median), values_.row(std::min(median + 1, last))},
                   width, medians_.row(median));
        medians_.repeat_border(median);
      }
      std::array<const float*, 5> rows;
      for (int j = 0; j < 5; ++j) rows[std::size_t(j)] = medians_.row(std::clamp(y + j - 2, 0, last));
      mean_within_row(rows, reach_, width, smooth_.data());
      std::copy_n(smooth_.begin(), width, result.row(y));
    }
  }

 private:
  void fill(int y) {
    float* row = values_.row(y);
    fill_row(found_.row(y), found_.width, row);
    if (std::isnan(row[0])) std::fill_n(row, found_.width, 0.0f);  // nothing in it
    values_.repeat_border(y);
  }

  const FloatImage& found_;
  float reach_;
  LastRows values_, medians_;
  std::vector<float> smooth_;
};

}  // namespace

void fill_row(const float* found, int width, float* filled) {
  for (int x = 0; x < width;) {
    if (!std::isnan(found[x])) {
      filled[x] = found[x];
      ++x;
      continue;
    }
    int end = x + 1;
    while (end < width && std::isnan(found[end])) ++end;
    const float before = x > 0 ? found[x - 1] : kNaN, after = end < width ? found[end] : kNaN;
    std::fill(filled + x, filled + end, std::fmin(before, after));
    x = end;
  }
}

DisparityMap measure(const GreyImage& left, const GreyImage& right, const FloatImage& surface, const FloatImage& found,
                     const Acceptance& acceptance, const Run& run) {
  DisparityMap result{FloatImage(left.width, left.height), FloatImage(left.width, left.height)};
  for_bands(run, left.height,
            [&](int begin, int end) { Band(left, right, surface, found, acceptance).measure(begin, end, result); });
  return result;
}

FloatImage smooth_surface(const FloatImage& found, float reach, const Run& run) {
  FloatImage result(found.width, found.height);
  for_bands(run, found.height, [&](int begin, int end) { SmoothBand(found, reach).smooth(begin, end, result); });
  return result;
}

}  // namespace collinea::dense
