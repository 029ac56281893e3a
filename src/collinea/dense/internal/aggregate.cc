// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/aggregate.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "collinea/dense/internal/path_kernels.h"
#include "collinea/dense/internal/texture.h"

namespace collinea::dense {
namespace {

constexpr std::uint16_t kNowhere = 0x3FFF;  // path cost of a label the previous pixel does not have
constexpr int kPad = 16;                    // elements readable before and after the path costs of a pixel

// Penalties, on the scale of cost(): 6 per bit of the census. Found by trials on rendered and real images.
constexpr int kSmall = 10, kSmallMore = 45;  // the second where there is no texture
constexpr int kTexture = 8;                  // sum of two gradients that halves it [grey values]
constexpr double kLarge = 100, kLargeLeast = 30;
constexpr double kGreyScale = 12;  // a step of that many grey values halves the penalty of a large change

// The label of `from` that has the same inverse depth as label 0 of `to`, at one pixel.
int shift_between(const Labels& labels, const Cell& to, const Cell& from, int x, int y) {
  const float apart = (labels.base(to, x, y) - labels.base(from, x, y)) / labels.step;
  return int(std::lround(apart + to.first - from.first));
}

// Path costs of one pixel, written again in the labels of another cell; also out[-1] and out[stride].
void carry_over(const std::uint16_t* costs, const Cell& from, const Cell& to, int shift, std::uint16_t* out) {
  std::fill(out - 1, out + to.stride + 1, kNowhere);
  const int begin = std::max(0, -shift), end = std::min(to.labels, from.labels - shift);
  for (int k = begin; k < end; ++k) out[kGuard + k] = costs[kGuard + k + shift];
}

// The path costs of one direction along one row of pixels.
struct RowOfPaths {
  std::vector<std::uint16_t> costs, smallest;
};

class Sweep {
 public:
  Sweep(const Labels& labels, const Volume& volume, const GreyImage& image, const Smoothness& smoothness,
        std::vector<std::uint16_t>& sums)
      : labels_(labels), volume_(volume), image_(image), smoothness_(smoothness), sums_(sums) {
    x0_ = volume.range.column0 * kCell;
    y0_ = volume.range.row0 * kCell;
    x1_ = std::min(volume.range.column1 * kCell, labels.width);
    y1_ = std::min(volume.range.row1 * kCell, labels.height);
  }

  // sense +1: downwards and to the right; -1: the opposite four directions.
  void run(int sense, const std::function<bool()>& stopped) {
    sense_ = sense;
    const int first = sense > 0 ? y0_ : y1_ - 1, end = sense > 0 ? y1_ : y0_ - 1;
    for (int y = first; y != end && !stopped(); y += sense) {
      const int cell_row = y / kCell;
      const bool has_previous = y != first;
      if (!has_previous || (y - sense) / kCell != cell_row) new_layout(cell_row, has_previous, y - sense);
      row(y, cell_row, has_previous);
      for (int d = 0; d < 3; ++d) std::swap(before_[d], now_[d]);
    }
  }

 private:
  std::size_t offset_of(int x) const {
    const int column = x / kCell - volume_.range.column0;
    const Cell& cell = labels_.cell(x / kCell, layout_row_);
    return kPad + row_offset_[std::size_t(column)] + std::size_t(x - cell.left) * std::size_t(cell.stride);
  }

  // Rows of path costs are laid out by the strides of the cells of one row; entering the next, they are written anew.
  void new_layout(int cell_row, bool has_previous, int previous_y) {
    const int old_row = layout_row_;
    const std::vector<std::size_t> old_offset = row_offset_;
    layout_row_ = cell_row;
    row_offset_.clear();
    std::size_t total = 0;
    for (int column = volume_.range.column0; column < volume_.range.column1; ++column) {
      row_offset_.push_back(total);
      total += std::size_t(kCell) * std::size_t(labels_.cell(column, cell_row).stride);
    }
    for (int d = 0; d < 3; ++d) {
      RowOfPaths old;
      std::swap(old, before_[d]);
      for (RowOfPaths* rows : {&before_[d], &now_[d]}) {
        rows->costs.assign(total + 2 * kPad, kNowhere);
        rows->smallest.assign(std::size_t(x1_ - x0_), 0);
      }
      if (!has_previous) continue;
      before_[d].smallest = old.smallest;
      for (int x = x0_; x < x1_; ++x) {
        const Cell& from = labels_.cell(x / kCell, old_row);
        const std::size_t at = kPad + old_offset[std::size_t(x / kCell - volume_.range.column0)] +
                               std::size_t(x - from.left) * std::size_t(from.stride);
        const Cell& to = labels_.cell(x / kCell, cell_row);
        carry_over(old.costs.data() + at, from, to, shift_between(labels_, to, from, x, previous_y),
                   before_[d].costs.data() + offset_of(x));
      }
    }
  }

  std::uint16_t large(int x, int y, int from_x, int from_y) const {
    return smoothness_.large[std::size_t(std::abs(int(image_.at(x, y)) - int(image_.at(from_x, from_y))))];
  }

  void row(int y, int cell_row, bool has_previous) {
    const int first = sense_ > 0 ? x0_ : x1_ - 1, end = sense_ > 0 ? x1_ : x0_ - 1;
    std::uint16_t along_smallest = 0;
    int parity = 0;
    for (int x = first; x != end; x += sense_) {
      const Cell& cell = labels_.cell(x / kCell, cell_row);
      const std::size_t pixel = volume_.offset(x / kCell, cell_row) +
                                std::size_t((y - cell.top) * kCell + x - cell.left) * std::size_t(cell.stride);
      Arriving arriving[4];
      std::uint16_t* leaving[4];
      int count = 0;
      arriving[count] = x == first ? nothing_before() : along(x, y, cell, cell_row, parity, along_smallest);
      leaving[count++] = along_[parity].data() + kPad;
      for (int d = -1; d <= 1; ++d) {
        const int from_x = x - d * sense_;
        const bool starts = !has_previous || from_x < x0_ || from_x >= x1_;
        arriving[count] = starts ? nothing_before() : across(d, x, from_x, y, cell, cell_row);
        leaving[count++] = now_[d + 1].costs.data() + offset_of(x);
      }
      std::uint16_t smallest[4];
      step_paths(volume_.costs.data() + pixel, cell.stride, arriving, count, smoothness_.small.at(x, y), leaving,
                 smallest, sums_.data() + pixel);
      along_smallest = smallest[0];
      for (int d = 0; d < 3; ++d) now_[d].smallest[std::size_t(x - x0_)] = smallest[d + 1];
      parity = 1 - parity;
    }
  }

  // A path that begins here: all labels alike.
  Arriving nothing_before() const { return {zeros_.data() + kPad, 0, 0}; }

  Arriving along(int x, int y, const Cell& cell, int cell_row, int parity, std::uint16_t smallest) {
    const int from_x = x - sense_;
    std::uint16_t* costs = along_[1 - parity].data() + kPad;
    if (from_x / kCell != x / kCell) {
      const Cell& from = labels_.cell(from_x / kCell, cell_row);
      carry_over(costs, from, cell, shift_between(labels_, cell, from, from_x, y), crossing_[3].data() + kPad);
      costs = crossing_[3].data() + kPad;
    }
    costs[-1] = costs[cell.stride] = kNowhere;
    return {costs, smallest, large(x, y, from_x, y)};
  }

  Arriving across(int d, int x, int from_x, int y, const Cell& cell, int cell_row) {
    const RowOfPaths& rows = before_[d + 1];
    const std::uint16_t* costs = rows.costs.data() + offset_of(from_x);
    if (from_x / kCell != x / kCell) {
      const Cell& from = labels_.cell(from_x / kCell, cell_row);
      std::uint16_t* out = crossing_[std::size_t(d + 1)].data() + kPad;
      carry_over(costs, from, cell, shift_between(labels_, cell, from, from_x, y - sense_), out);
      costs = out;
    }
    return {costs, rows.smallest[std::size_t(from_x - x0_)], large(x, y, from_x, y - sense_)};
  }

  static constexpr std::size_t kLine = std::size_t(kMaxLabels) + 3 * kStrideUnit + 2 * kPad;
  const Labels& labels_;
  const Volume& volume_;
  const GreyImage& image_;
  const Smoothness& smoothness_;
  std::vector<std::uint16_t>& sums_;
  int x0_, y0_, x1_, y1_;
  int sense_ = 1, layout_row_ = 0;
  std::vector<std::size_t> row_offset_;
  RowOfPaths before_[3], now_[3];  // by direction: from x - sense, x, x + sense ... of the previous row
  std::array<std::vector<std::uint16_t>, 2> along_{std::vector<std::uint16_t>(kLine, kNowhere),
                                                   std::vector<std::uint16_t>(kLine, kNowhere)};
  std::array<std::vector<std::uint16_t>, 4> crossing_{
      std::vector<std::uint16_t>(kLine, kNowhere), std::vector<std::uint16_t>(kLine, kNowhere),
      std::vector<std::uint16_t>(kLine, kNowhere), std::vector<std::uint16_t>(kLine, kNowhere)};
  std::vector<std::uint16_t> zeros_ = std::vector<std::uint16_t>(kLine, 0);
};

}  // namespace

std::array<std::uint8_t, 256> small_for_textures() {
  std::array<std::uint8_t, 256> small;
  for (int texture = 0; texture < 256; ++texture)
    small[std::size_t(texture)] = std::uint8_t(kSmall + kSmallMore * kTexture / (kTexture + texture));
  return small;
}

Smoothness smoothness_for(const GreyImage& image) {
  Smoothness s{texture_around(image), {}};
  const auto small = small_for_textures();
  for (auto& value : s.small.data) value = small[value];
  for (int difference = 0; difference < 256; ++difference)
    s.large[std::size_t(difference)] =
        std::uint16_t(std::max<double>(kLargeLeast, kLarge / (1 + difference / kGreyScale)));
  return s;
}

std::size_t bytes_to_match(const Labels& labels, const CellRange& range) {
  std::size_t elements = 0;
  for (int row = range.row0; row < range.row1; ++row)
    for (int column = range.column0; column < range.column1; ++column)
      elements += std::size_t(kCellPixels) * std::size_t(labels.cell(column, row).stride);
  return elements * (sizeof(std::uint8_t) + sizeof(std::uint16_t));
}

Volume volume_for(const Labels& labels, const CellRange& range) {
  Volume volume{range, {}, {}};
  std::size_t total = 0;
  for (int row = range.row0; row < range.row1; ++row)
    for (int column = range.column0; column < range.column1; ++column) {
      volume.offsets.push_back(total);
      total += std::size_t(kCellPixels) * std::size_t(labels.cell(column, row).stride);
    }
  volume.costs.assign(total, 255);
  return volume;
}

std::vector<std::uint16_t> aggregate(const Labels& labels, const Volume& volume, const GreyImage& image,
                                     const Smoothness& smoothness, const std::function<bool()>& stopped) {
  std::vector<std::uint16_t> sums(volume.costs.size(), 0);
  Sweep sweep(labels, volume, image, smoothness, sums);
  sweep.run(+1, stopped);
  sweep.run(-1, stopped);
  return sums;
}

float winner(const std::uint16_t* sums_of_pixel, int labels) {
  const std::uint16_t* sums = sums_of_pixel + kGuard;
  const int best = first_least(sums_of_pixel, kGuard, kGuard + labels) - kGuard;
  float label = float(best);
  if (best > 0 && best + 1 < labels) {
    const float left = float(sums[best - 1]) - float(sums[best]), right = float(sums[best + 1]) - float(sums[best]);
    if (left + right > 0) label += 0.5f * (left - right) / (left + right);
  }
  return label;
}

}  // namespace collinea::dense
