// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/disparity_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_kernels.h"

namespace collinea::dense {
namespace {

constexpr int kRankReach = 3;
constexpr int kPerGreyValue = 2;

// The pixel, with those beyond the border repeated from it.
std::uint8_t near(const GreyImage& image, int x, int y) {
  return image.at(std::clamp(x, 0, image.width - 1), std::clamp(y, 0, image.height - 1));
}

// Every row with its border repeated, as far as a census window reaches; from right to left when it is mirrored.
struct PaddedRows {
  const GreyImage& image;
  int stride;
  std::vector<std::uint8_t> data;

  PaddedRows(const GreyImage& p, bool mirrored) : image(p), stride(p.width + 2 * kCensusReach) {
    data.resize(std::size_t(stride) * std::size_t(p.height + 2 * kCensusReach) + kCensusSlack);
    for (int y = -kCensusReach; y < p.height + kCensusReach; ++y) {
      const std::uint8_t* row = p.row(std::clamp(y, 0, p.height - 1));
      std::uint8_t* out = data.data() + std::size_t(y + kCensusReach) * std::size_t(stride);
      if (mirrored)
        std::reverse_copy(row, row + p.width, out + kCensusReach);
      else
        std::copy_n(row, p.width, out + kCensusReach);
      std::fill_n(out, kCensusReach, out[kCensusReach]);
      std::fill_n(out + kCensusReach + p.width, kCensusReach, out[kCensusReach + p.width - 1]);
    }
  }
  [[nodiscard]] const std::uint8_t* at(int y) const {
    return data.data() + std::size_t(y + kCensusReach) * std::size_t(stride) + kCensusReach;
  }
};

template <class Byte, class Image_>
CensusRows<Byte> census_rows(Image_& census, int y) {
  CensusRows<Byte> rows;
  for (int i = 0; i < kCensusBytes; ++i) rows[std::size_t(i)] = census.row(y * kCensusBytes + i);
  return rows;
}

GreyImage census_of(const GreyImage& image, bool mirrored, const Run& run) {
  const PaddedRows rows(image, mirrored);
  GreyImage result((image.width + kCensusSlack - 1) / kCensusSlack * kCensusSlack, image.height * kCensusBytes);
  parallel_for(run, std::size_t(image.height), [&](std::size_t row) {
    std::array<const std::uint8_t*, 2 * kCensusReach + 1> around;
    for (int j = 0; j < int(around.size()); ++j) around[std::size_t(j)] = rows.at(int(row) + j - kCensusReach);
    census_row(around.data(), image.width, mirrored, census_rows<std::uint8_t>(result, int(row)));
  });
  return result;
}

GreyImage rank_of(const GreyImage& image, const Run& run) {
  GreyImage result(image.width, image.height);
  parallel_for(run, std::size_t(image.height), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < image.width; ++x) {
      int less = 0;
      for (int dy = -kRankReach; dy <= kRankReach; ++dy)
        for (int dx = -kRankReach; dx <= kRankReach; ++dx) less += near(image, x + dx, y + dy) < image.at(x, y);
      result.at(x, y) = image.at(x, y) ? std::uint8_t(less + 1) : std::uint8_t(0);
    }
  });
  return result;
}

PixelTerm term_of(StereoCost kind) {
  if (kind == StereoCost::kZncc) return PixelTerm::kProduct;
  return kind == StereoCost::kSsd ? PixelTerm::kSquare : PixelTerm::kDifference;
}

std::uint8_t rounded(float cost) { return std::uint8_t(std::clamp(cost, 0.0f, float(kLargestCost)) + 0.5f); }

int reach_of(StereoCost kind) { return kind == StereoCost::kZncc ? 3 : 2; }

void window_sums(const GreyImage& image, int reach, Raster<std::int32_t>& sums, FloatImage& deviations,
                 const Run& run) {
  sums = Raster<std::int32_t>(image.width, image.height);
  deviations = FloatImage(image.width, image.height);
  const int pixels = (2 * reach + 1) * (2 * reach + 1);
  parallel_for(run, std::size_t(image.height), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < image.width; ++x) {
      int sum = 0, squares = 0;
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const int grey = near(image, x + dx, y + dy);
          sum += grey;
          squares += grey * grey;
        }
      sums.at(x, y) = sum;
      deviations.at(x, y) = float(std::sqrt(std::max(0.0, squares - double(sum) * sum / pixels)));
    }
  });
}

}  // namespace

DisparityCosts::DisparityCosts(const GreyImage& left, const GreyImage& right, StereoCost kind, const Run& run)
    : left_(left), right_(right), kind_(kind) {
  if (kind == StereoCost::kCensus) {
    left_census_ = census_of(left, false, run);
    right_census_ = census_of(right, true, run);
    return;
  }
  const auto planes = [&](const GreyImage& image) {
    return LocalPlanes(kind == StereoCost::kRank ? rank_of(image, run) : image, Similarity::kSad, reach_of(kind), 0,
                       run);
  };
  left_planes_ = planes(left);
  right_planes_ = planes(right);
  if (kind == StereoCost::kZncc) {
    window_sums(left, reach_of(kind), left_sum_, left_deviation_, run);
    window_sums(right, reach_of(kind), right_sum_, right_deviation_, run);
  }
}

void DisparityCosts::row(int y, int x0, int x1, int low, int labels, int stride, std::uint8_t* costs) const {
  if (kind_ != StereoCost::kCensus) return window_row(y, x0, x1, low, labels, stride, costs);
  // element j is column x1 - 1 - low - j of the right image; there is nothing beyond it
  const std::size_t reach = std::size_t(x1 - x0 + stride);
  std::vector<std::uint8_t> memory(kCensusBytes * reach, 255);
  CensusRows<const std::uint8_t> left = census_rows<const std::uint8_t>(left_census_, y), right;
  const int first = right_.width - 1 - (x1 - 1 - low);  // of the mirrored row
  const int begin = std::max(0, -first), end = std::min(int(reach), right_.width - first);
  for (std::size_t i = 0; i < kCensusBytes; ++i) {
    std::uint8_t* bytes = memory.data() + i * reach;
    if (begin < end)
      std::copy_n(right_census_.row(y * kCensusBytes + int(i)) + first + begin, end - begin, bytes + begin);
    left[i] += x0;
    right[i] = bytes;
  }
  census_costs(left, right, x1 - x0, labels, stride, kChanceCost, costs);
}

// Sums down the columns of windows by vectors, then along the row.
void DisparityCosts::window_row(int y, int x0, int x1, int low, int labels, int stride, std::uint8_t* costs) const {
  const int reach = reach_of(kind_), side = 2 * reach + 1;
  std::fill_n(costs, std::size_t(x1 - x0) * std::size_t(stride), std::uint8_t(255));
  std::vector<std::int32_t> columns(std::size_t(x1 - x0 + 2 * reach + kLocalSlack));
  for (int k = 0; k < labels; ++k) {
    const int d = low + k, from = std::clamp(d, x0, x1), to = std::clamp(right_.width + d, from, x1);
    const auto cost_at = [&](int x) -> std::uint8_t& {
      return costs[std::size_t(x - x0) * std::size_t(stride) + std::size_t(k)];
    };
    for (int x = x0; x < from; ++x) cost_at(x) = kChanceCost;
    for (int x = to; x < x1; ++x) cost_at(x) = kChanceCost;
    if (from >= to) continue;
    std::fill(columns.begin(), columns.end(), 0);
    for (int j = -reach; j <= reach; ++j) {
      PixelRows rows;
      rows.left[0] = left_planes_->row(0, y + j) + from;
      rows.right[0] = right_planes_->row(0, y + j) + (from - d);
      slide_columns(term_of(kind_), rows, nullptr, to - from + 2 * reach, columns.data());
    }
    std::int32_t sum = 0;
    for (int i = 0; i < side - 1; ++i) sum += columns[std::size_t(i)];
    for (int x = from; x < to; ++x) {
      sum += columns[std::size_t(x - from + side - 1)];
      cost_at(x) = rounded(window_cost(x, x - d, y, sum));
      sum -= columns[std::size_t(x - from)];
    }
  }
}

float DisparityCosts::window_cost(int x, int other, int y, int sum) const {
  if (left_.at(x, y) == 0 || right_.at(other, y) == 0) return kChanceCost;
  const int side = 2 * reach_of(kind_) + 1;
  const float mean = float(sum) / float(side * side);
  if (kind_ != StereoCost::kZncc) return kPerGreyValue * (kind_ == StereoCost::kSsd ? std::sqrt(mean) : mean);
  const double covariance = sum - double(left_sum_.at(x, y)) * right_sum_.at(other, y) / double(side * side);
  const float scale = left_deviation_.at(x, y) * right_deviation_.at(other, y);
  return scale > 0 ? kChanceCost * (1 - float(covariance / scale)) : kChanceCost;
}

}  // namespace collinea::dense
