// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// The inner loops of semi-global matching of a rectified pair. Label k of column x of the left image is column
// x - (low + k) of the right one. Rows of the right image are kept from right to left, so that the labels of one
// pixel are neighbours in memory.
namespace collinea::dense {

/// Labels of a pixel are padded to a multiple of this.
inline constexpr int kLabelUnit = 32;
/// Elements before the path costs of a pixel, a whole cache line; the last is a guard, as is the first of the next
/// pixel's.
inline constexpr int kPathGuard = 64;

/// Half the window of the census.
inline constexpr int kCensusReach = 2;
/// What census_row may read and write beyond `width`.
inline constexpr int kCensusSlack = 64;
/// Bytes of a census: its 24 bits, and one that is 255 where the window is not all there.
inline constexpr int kCensusBytes = 4;

/// The census of a row, byte by byte: kCensusBytes rows of bytes.
template <class Byte>
using CensusRows = std::array<Byte*, kCensusBytes>;

/// For each of the 24 pixels around one in a window of 5 x 5 whether it is darker. `rows`: the five rows around it,
/// readable from -kCensusReach on; when they are `mirrored`, running from right to left, the bits are the same.
void census_row(const std::uint8_t* const* rows, int width, bool mirrored, const CensusRows<std::uint8_t>& census);

/// Costs of a row of `width` pixels: costs[x * stride + k] = twice the number of bits in which left[x] differs from
/// right[width - 1 - x + k]; `chance` where a window is not all there; 255 for labels <= k < stride. `stride`: a
/// multiple of kLabelUnit; right is readable to width + stride.
void census_costs(const CensusRows<const std::uint8_t>& left, const CensusRows<const std::uint8_t>& right, int width,
                  int labels, int stride, int chance, std::uint8_t* costs);

/// What a jump of disparity costs on the way into each pixel of a row: toll of a jump[x * 4 + p], p = from the side,
/// and from the three pixels of the row before it (behind, straight, ahead in the direction of the sweep). It is
/// max(kLeastJump, kJumpScale / (kGreyOfJump + difference of grey values)), rounded down. Rows are readable from column
/// -1 to width + kCensusSlack, `jumps` writable to 4 (width + kCensusSlack).
inline constexpr int kLeastJump = 10, kJumpScale = 400, kGreyOfJump = 12;
void jump_row(const std::uint8_t* here, const std::uint8_t* before, int sense, int width, std::uint8_t* jumps);

/// Path costs that leave the pixels of one row along three directions, and their minima. Column -1 and `width` are
/// outside the image: nothing has been paid there.
struct PathRow {
  std::uint8_t* costs;     ///< of column x, direction p: costs + offset(x, p, stride)
  std::uint8_t* smallest;  ///< of column x, direction p: smallest[(x + 1) * 4 + 1 + p]

  static std::size_t offset(int x, int p, int stride) {
    return std::size_t((x + 1) * 3 + p) * std::size_t(stride + kPathGuard) + kPathGuard;
  }
};

/// What is found at a pixel when all directions are summed.
struct Best {
  std::uint16_t label, before, at, after;  ///< the label with the least sum; the sums around it (65535: no such label)
};

/// One row of the sweep over a tile `width` columns wide. sense +1: downwards, columns ascending; -1: upwards,
/// descending. Along each of four directions p (from the side, and the three pixels of the row before),
///   toll[k] = min(arriving[k], arriving[k +- 1] + small, least + large[p]) - least,    leaving[k] = cost[k] + toll[k]
/// and what decides in the end is the sum of all eight: 8 cost[k] + the tolls. A toll is no more than `large`, so that
/// the sum of four fits into a byte when large < 64.
struct RowOfSweep {
  int sense = 1;
  int width = 0, labels = 0, stride = 0;
  const std::uint8_t* costs = nullptr;  ///< of column x, label k: [(x - costs_from) * stride + k]
  int costs_from = 0;
  const std::uint8_t* small = nullptr;  ///< by column
  const std::uint8_t* large = nullptr;  ///< by column and direction: [x * 4 + p], p = side, oblique behind, straight,
                                        ///< oblique ahead
  PathRow before{}, now{};
  std::uint8_t* side = nullptr;  ///< path costs along the row: two buffers of stride + 2 kPathGuard, ends guarded
  std::uint8_t side_smallest = 0;
  std::uint8_t* tolls = nullptr;  ///< [x * stride + k]; sums over the four directions, written downwards, read upwards
  // upwards only:
  std::uint16_t* sums = nullptr;         ///< room for `stride`
  Best* best = nullptr;                  ///< by column
  std::uint16_t* right_sum = nullptr;    ///< [width - 1 - x + k]: the least sum of that pixel of the right image,
  std::uint16_t* right_label = nullptr;  ///< and its label; width + stride elements, sums set to 65535 before
};

/// Columns [from, to) in the order of the sweep (0 is where the row begins). cost + large < 255 everywhere, but for the
/// costs of padded labels, which are 255.
void sweep_columns(RowOfSweep& row, int from, int to);

/// What the sweep upwards has found along a row of a tile.
struct FoundRow {
  const std::uint8_t* left = nullptr;  ///< grey values by column
  const Best* best = nullptr;          ///< likewise
  const std::uint16_t* right_label =
      nullptr;  ///< as RowOfSweep::right_label, `right_size` elements, readable to one more
  int width = 0, right_size = 0;
  int low = 0;                         ///< disparity of label 0
  int first_right = 0, end_right = 0;  ///< columns the right image has, counted from that of the tile
  int max_apart = 0;                   ///< of the label found from the right
};

/// Disparities: low + label, at the parabola through the three sums; NaN where the left image is 0, the right one has
/// no such column, or what is found from there is more than max_apart away. Columns are readable and writable to
/// width + kCensusSlack.
void disparities_of_row(const FoundRow& row, float* disparity);

}  // namespace collinea::dense
