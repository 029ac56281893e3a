// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/stereo.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "collinea/dense/internal/disparity_kernels.h"
#include "collinea/dense/internal/semi_global.h"
#include "collinea/dense/internal/test_pair.h"
#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

const float kNaN = std::numeric_limits<float>::quiet_NaN();

using test::DisparityErrors;
using test::TestPair;

Result<DisparityMap> matched(const TestPair& pair, const StereoOptions& options = {}, const Run& run = {}) {
  return match_pair(pair.image_of(true), pair.image_of(false), {0, 40}, options, run);
}

TEST(Stereo, APlaneIsFoundToAFractionOfAPixel) {
  for (const double slope : {0.0, 0.08, -0.1}) {
    const TestPair pair{.at_left = slope < 0 ? 25.4 : 12.3, .slope = slope};
    const auto map = matched(pair);
    ASSERT_TRUE(map) << map.error().message;
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_GT(e.measured, 0.97 * e.possible) << slope;
    EXPECT_EQ(e.bad, 0) << slope;
    EXPECT_LT(e.rms, 0.1) << slope;
  }
}

TEST(Stereo, AllCostsFindAPlane) {
  for (const auto& [cost, word, meaning] : kStereoCostWords) {
    const TestPair pair{.slope = 0.05};
    StereoOptions options;
    options.cost = cost;
    const auto map = matched(pair, options);
    ASSERT_TRUE(map) << map.error().message;
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_GT(e.measured, 0.95 * e.possible) << word;
    EXPECT_LT(e.bad, 0.01 * e.measured) << word;
  }
}

TEST(Stereo, WhatOneCameraCannotSeeIsLeftOut) {
  const TestPair pair{.at_left = 10, .square = 24};
  const auto map = matched(pair);
  ASSERT_TRUE(map) << map.error().message;
  const DisparityErrors e = errors_of(pair, *map);
  EXPECT_GT(e.measured, 0.9 * e.possible);
  EXPECT_LT(e.bad, 0.02 * e.measured);
  int hidden = 0, invented = 0;
  for (int y = 38; y < 82; ++y)
    for (int x = 40; x < 80; ++x)
      if (!pair.seen_twice(x, y)) ++hidden, invented += !std::isnan(map->disparity.at(x, y));
  EXPECT_GT(hidden, 500);
  EXPECT_LT(invented, 0.25 * hidden);
}

// A strong edge draws windows beyond it: 37 of the 636 pixels within 3 of the square have its disparity by census, 237
// by zncc, when their grey values are not asked. A twentieth may be left.
TEST(Stereo, RimsOfWhatLiesInFrontAreEmptied) {
  const TestPair pair{.at_left = 10, .square = 24, .brighter = 70};
  for (const StereoCost cost : {StereoCost::kCensus, StereoCost::kZncc}) {
    StereoOptions options;
    options.cost = cost;
    const auto map = matched(pair, options);
    ASSERT_TRUE(map) << map.error().message;
    int beyond = 0, kept = 0, of_square = 0;
    for (int y = 32; y < 88; ++y)
      for (int x = 77; x < 133; ++x) {
        const bool is_its = std::abs(map->disparity.at(x, y) - 24) < 2;
        beyond += is_its && !pair.on_square(x, y);
        const bool inside = x > 80 && x < 129 && y > 35 && y < 84;  // a pixel off its edge
        kept += is_its && inside;
        of_square += inside;
      }
    EXPECT_LT(beyond, 32);
    EXPECT_GT(kept, 0.95 * of_square);
  }
}

// Errors of overlapping windows are alike: of 49 pixels each there are 430, whose root mean square is sure to 3.4 %.
// Four of these. With less noise the floor of the sigmas is too large, with more they are too small
// (docs/theory/dense.md).
TEST(Stereo, SigmasAreTheErrors) {
  for (const double noise : {4.0, 8.0}) {
    const TestPair pair{.slope = 0.03, .noise = noise};
    const auto map = matched(pair, {.max_sigma_px = 1});
    ASSERT_TRUE(map) << map.error().message;
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_NEAR(e.in_sigmas, 1, 0.15) << noise;
  }
}

TEST(Stereo, WithoutTextureThereIsNothing) {
  const auto map = match_pair(GreyImage(120, 60, 1, 90), GreyImage(120, 60, 1, 90), {0, 31}, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_TRUE(
      std::all_of(map->disparity.data.begin(), map->disparity.data.end(), [](float d) { return std::isnan(d); }));
}

// More threads than processors, so that the system stops some of them anywhere in a row; several times.
TEST(Stereo, TheNumberOfThreadsDoesNotMatter) {
  constexpr int kTimes = 20;
  const TestPair pair{.at_left = 10, .square = 24, .noise = 5};
  const auto alone = matched(pair);
  ASSERT_TRUE(alone);
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  for (int i = 0; i < kTimes; ++i) {
    collinea::Run many;
    many.threads = i % 2 ? 3 : 16;
    const auto shared = matched(pair, {}, many);
    ASSERT_TRUE(shared);
    EXPECT_TRUE(
        std::equal(alone->disparity.data.begin(), alone->disparity.data.end(), shared->disparity.data.begin(), same));
    EXPECT_TRUE(std::equal(alone->sigma.data.begin(), alone->sigma.data.end(), shared->sigma.data.begin(), same));
  }
}

TEST(Stereo, TheVectorsOfTheProcessorDoNotMatter) {
  const TestPair pair{.at_left = 10, .square = 24, .noise = 3};
  const auto best = matched(pair);
  ASSERT_TRUE(best);
  for (const std::int64_t target : testing::processor_targets()) {
    const testing::OnTarget chosen(target);
    const auto map = matched(pair);
    ASSERT_TRUE(map);
    for (const auto& [one, other] : {std::pair{&best->disparity, &map->disparity}, {&best->sigma, &map->sigma}})
      for (std::size_t i = 0; i < one->data.size(); ++i)
        if (!std::isnan(one->data[i]) || !std::isnan(other->data[i])) {
          ASSERT_EQ(one->data[i], other->data[i]) << hwy::TargetName(target) << ' ' << i;
        }
  }
}

TEST(Stereo, DisparitiesMayBeNegative) {
  const TestPair pair;
  const auto map = match_pair(pair.image_of(false), pair.image_of(true), {-30, 3}, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  int right = 0;
  for (int x = 20; x < 160; ++x) right += std::abs(map->disparity.at(x, 60) + 12.3) < 0.3;
  EXPECT_GT(right, 130);
}

TEST(Stereo, WhatCannotBeMatchedIsRefused) {
  const GreyImage image(40, 30, 1, 100);
  const auto code = [&](const Result<DisparityMap>& result) { return result ? Errc::kNotFound : result.error().code; };
  EXPECT_EQ(code(match_pair(image, GreyImage(40, 31, 1, 100), {0, 9}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, GreyImage(), {0, 9}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, image, {10, 9}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, image, {0, 2000}, {}, {})), Errc::kBadInput);
  constexpr int kLowest = std::numeric_limits<int>::min(), kHighest = std::numeric_limits<int>::max();
  EXPECT_EQ(code(match_pair(image, image, {kLowest, kHighest}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, image, {kLowest, kLowest + 9}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, image, {40, 49}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_pair(image, image, {0, 9}, {.max_sigma_px = -1}, {})), Errc::kBadInput);
}

// Before it begins, and at any time while three threads are at work on it: it ends, and says that it was stopped unless
// it was done.
TEST(Stereo, StopsWhenItIsTold) {
  const TestPair pair{.width = 400, .height = 300};
  for (const int wait_us : {0, 500, 2000, 8000, 20'000}) {
    std::stop_source stop;
    collinea::Run run;
    run.threads = 3;
    run.stop = stop.get_token();
    if (wait_us == 0) stop.request_stop();
    const std::jthread other([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(wait_us));
      stop.request_stop();
    });
    const auto map = matched(pair, {}, run);
    if (wait_us == 0) {
      EXPECT_FALSE(map);
    }
    if (!map) {
      EXPECT_EQ(map.error().code, Errc::kCancelled);
    }
  }
}

TEST(Stereo, TinyImagesAreNoTrouble) {
  for (const int size : {1, 2, 5}) {
    const GreyImage image(size, size, 1, 100);
    EXPECT_TRUE(match_pair(image, image, {0, 3}, {}, {})) << size;
  }
}

TEST(FillDisparities, TakesTheFartherOfTheTwoSides) {
  FloatImage disparity(5, 2, 1, kNaN);
  disparity.at(0, 0) = 3;
  disparity.at(4, 0) = 7;
  fill_disparities(disparity);
  EXPECT_EQ(disparity.at(2, 0), 3);
  EXPECT_TRUE(std::isnan(disparity.at(2, 1)));
}

}  // namespace

namespace dense {
namespace {

constexpr int kFar = 1 << 20;

// Two rows of random costs, and all that sweep_columns needs to take them one after the other.
struct TwoRows {
  static constexpr int kWidth = 23;
  int labels, stride;
  Random random;
  std::vector<std::uint8_t> costs, small, large, side, tolls;
  std::vector<std::uint8_t> paths[3], smallest[3];  // outside, first row, second row
  std::vector<std::uint16_t> sums, right_sum, right_label;
  std::vector<Best> best;

  explicit TwoRows(int label_count)
      : labels(label_count),
        stride((labels + kLabelUnit - 1) / kLabelUnit * kLabelUnit),
        random{std::uint64_t(labels)},
        costs(std::size_t(2 * kWidth * stride), 255),
        small(std::size_t(kWidth), 0),
        large(std::size_t(4 * kWidth)),
        side(std::size_t(2 * (stride + 2 * kPathGuard))),
        tolls(std::size_t(kWidth * stride)),
        sums(static_cast<std::size_t>(stride)),
        right_sum(std::size_t(kWidth + stride)),
        right_label(right_sum.size()),
        best(static_cast<std::size_t>(kWidth)) {
    for (int i = 0; i < 2 * kWidth; ++i)
      for (int k = 0; k < labels; ++k) costs[std::size_t(i * stride + k)] = std::uint8_t(random.below(49));
    for (auto& value : small) value = std::uint8_t(3 + random.below(16));
    for (auto& value : large) value = std::uint8_t(19 + random.below(20));
    for (int i = 0; i < 3; ++i) {
      paths[i].assign(PathRow::offset(kWidth + 1, 0, stride), 255);
      smallest[i].assign(std::size_t(kWidth + 2) * 4, 0);
      for (int x = -1; x <= kWidth; ++x)
        for (int p = 0; p < 3; ++p)
          if (i == 0 || x < 0 || x == kWidth)
            std::fill_n(paths[i].data() + PathRow::offset(x, p, stride), labels, std::uint8_t(0));
    }
  }

  // Row 0 or 1, upwards, so that everything is written; in two pieces.
  void sweep(int turn) {
    std::fill(side.begin(), side.end(), std::uint8_t(255));
    std::fill_n(side.data() + kPathGuard, labels, std::uint8_t(0));
    for (auto& value : tolls) value = std::uint8_t(random.below(150));
    std::fill(right_sum.begin(), right_sum.end(), std::uint16_t(0xFFFF));
    RowOfSweep row;
    row.sense = -1;
    row.width = kWidth, row.labels = labels, row.stride = stride;
    row.costs = costs.data() + turn * kWidth * stride;
    row.small = small.data(), row.large = large.data();
    row.before = {paths[turn].data(), smallest[turn].data()};
    row.now = {paths[turn + 1].data(), smallest[turn + 1].data()};
    row.side = side.data();
    row.tolls = tolls.data();
    row.sums = sums.data();
    row.best = best.data();
    row.right_sum = right_sum.data(), row.right_label = right_label.data();
    sweep_columns(row, 0, 9);
    sweep_columns(row, 9, kWidth);
  }
};

// The same by the formulas of docs/theory/stereo.md, label by label.
struct PlainSweep {
  const TwoRows& rows;
  std::array<std::vector<int>, 4> before, now;  // by direction: column, label
  std::vector<std::vector<int>> sums;           // of the row, by column
  explicit PlainSweep(const TwoRows& of) : rows(of) {}

  [[nodiscard]] int arriving(int turn, int x, int p, int k) const {
    if (k < 0 || k >= rows.labels) return kFar;
    // side: column + 1 of this row; others: columns x + 1, x, x - 1 of the row before
    const int column = p == 0 ? x + 1 : x + 2 - p;
    if (column < 0 || column >= TwoRows::kWidth || (p > 0 && turn == 0)) return 0;
    return (p == 0 ? now[0] : before[std::size_t(p)])[std::size_t(column * rows.labels + k)];
  }

  void take_path(int turn, int x, int p) {
    int least = kFar;
    for (int k = 0; k < rows.labels; ++k) least = std::min(least, arriving(turn, x, p, k));
    for (int k = 0; k < rows.labels; ++k) {
      const int near = std::min(arriving(turn, x, p, k - 1), arriving(turn, x, p, k + 1)) + rows.small[std::size_t(x)];
      const int toll = std::min({arriving(turn, x, p, k), near, least + rows.large[std::size_t(x * 4 + p)]}) - least;
      now[std::size_t(p)][std::size_t(x * rows.labels + k)] =
          rows.costs[std::size_t((turn * TwoRows::kWidth + x) * rows.stride + k)] + toll;
      sums[std::size_t(x)][std::size_t(k)] += toll;
    }
  }

  void sweep(int turn) {
    before = now;
    for (auto& paths : now) paths.assign(std::size_t(TwoRows::kWidth * rows.labels), 0);
    sums.assign(TwoRows::kWidth, std::vector<int>(static_cast<std::size_t>(rows.labels)));
    for (int x = TwoRows::kWidth - 1; x >= 0; --x) {
      for (int k = 0; k < rows.labels; ++k)
        sums[std::size_t(x)][std::size_t(k)] =
            rows.tolls[std::size_t(x * rows.stride + k)] +
            8 * rows.costs[std::size_t((turn * TwoRows::kWidth + x) * rows.stride + k)];
      for (int p = 0; p < 4; ++p) take_path(turn, x, p);
    }
  }
};

void expect_best(const TwoRows& rows, const PlainSweep& plain) {
  for (int x = 0; x < TwoRows::kWidth; ++x) {
    const std::vector<int>& sum = plain.sums[std::size_t(x)];
    const Best& best = rows.best[std::size_t(x)];
    const int k = int(std::min_element(sum.begin(), sum.end()) - sum.begin());
    EXPECT_EQ(best.label, k);
    EXPECT_EQ(best.at, sum[std::size_t(k)]);
    EXPECT_EQ(best.before, k > 0 ? sum[std::size_t(k - 1)] : 0xFFFF);
    EXPECT_EQ(best.after, k + 1 < rows.labels ? sum[std::size_t(k + 1)] : 0xFFFF);
  }
}

void expect_seen_from_right(const TwoRows& rows, const PlainSweep& plain) {
  std::vector<int> seen(rows.right_sum.size(), kFar);
  for (int x = 0; x < TwoRows::kWidth; ++x)
    for (int k = 0; k < rows.labels; ++k) {
      int& least = seen[std::size_t(TwoRows::kWidth - 1 - x + k)];
      least = std::min(least, plain.sums[std::size_t(x)][std::size_t(k)]);
    }
  for (int i = 0; i < TwoRows::kWidth; ++i) EXPECT_EQ(rows.right_sum[std::size_t(i)], seen[std::size_t(i)]) << i;
}

TEST(SweepColumns, IsWhatTheFormulasSay) {
  for (const int labels : {16, 20, 32, 64, 90, 128}) {
    TwoRows rows(labels);
    PlainSweep plain(rows);
    for (const int turn : {0, 1}) {
      rows.sweep(turn);
      plain.sweep(turn);
      expect_best(rows, plain);
      expect_seen_from_right(rows, plain);
    }
  }
}

TEST(DisparitiesOfRow, AreParabolasWhereBothImagesAgree) {
  constexpr int kWidth = 75, kLabels = 40, kLow = -7;
  Random random(21);
  std::vector<std::uint8_t> left(kWidth + kCensusSlack);
  std::vector<Best> best(left.size());
  std::vector<std::uint16_t> right_label(kWidth + 64 + 1);
  for (auto& grey : left) grey = std::uint8_t(random.below(8) ? 9 : 0);
  for (auto& label : right_label) label = std::uint16_t(20 + random.below(5));
  for (auto& b : best) {
    const auto at = std::uint16_t(random.below(600));
    const auto beside = [&] { return random.below(9) ? std::uint16_t(at + random.below(100)) : std::uint16_t(0xFFFF); };
    b = {std::uint16_t(20 + random.below(5)), beside(), at, beside()};
  }
  best[3].label = 0, best[70].label = kLabels - 1;
  FoundRow row;
  row.left = left.data(), row.best = best.data(), row.right_label = right_label.data();
  row.width = kWidth, row.right_size = kWidth + 64;
  row.low = kLow, row.first_right = -4, row.end_right = 50, row.max_apart = 1;
  std::vector<float> disparity(left.size());
  disparities_of_row(row, disparity.data());
  int found = 0;
  for (int x = 0; x < kWidth; ++x) {
    const Best& b = best[std::size_t(x)];
    const int right = x - kLow - b.label;
    const int apart = std::abs(right_label[std::size_t(kWidth - 1 - x + b.label)] - b.label);
    if (left[std::size_t(x)] == 0 || right < -4 || right >= 50 || apart > 1) {
      EXPECT_TRUE(std::isnan(disparity[std::size_t(x)])) << x;
      continue;
    }
    ++found;
    float label = b.label;
    if (const int rises = b.before + b.after - 2 * b.at; b.before != 0xFFFF && b.after != 0xFFFF && rises > 0)
      label += 0.5f * float(b.before - b.after) / float(rises);
    EXPECT_EQ(disparity[std::size_t(x)], kLow + label) << x;
  }
  EXPECT_GT(found, 15);
}

TEST(Census, IsOneBitForEachDarkerPixelAround) {
  GreyImage image(90, 5);
  Random random(4);
  for (auto& grey : image.data) grey = std::uint8_t(1 + random.below(255));
  image.at(40, 2) = 0;
  std::vector<std::vector<std::uint8_t>> rows;
  std::array<const std::uint8_t*, 5> around;
  for (int y = 0; y < 5; ++y) {
    auto& row = rows.emplace_back(std::size_t(90 + 2 * kCensusReach + kCensusSlack), std::uint8_t(7));
    std::copy_n(image.row(y), 90, row.begin() + kCensusReach);
  }
  for (std::size_t y = 0; y < 5; ++y) around[y] = rows[y].data() + kCensusReach;
  const auto census = [&](bool mirrored) {
    std::vector<std::vector<std::uint8_t>> bytes(kCensusBytes, std::vector<std::uint8_t>(90 + kCensusSlack));
    CensusRows<std::uint8_t> out;
    for (std::size_t i = 0; i < kCensusBytes; ++i) out[i] = bytes[i].data();
    census_row(around.data(), 90, mirrored, out);
    return bytes;
  };
  const auto bytes = census(false);
  for (std::size_t x = 2; x < 88; ++x) {
    int darker = 0;
    for (int y = 0; y < 5; ++y)
      for (int i = int(x) - 2; i <= int(x) + 2; ++i) darker += image.at(i, y) < image.at(int(x), 2);
    EXPECT_EQ(bytes[3][x] == 255, std::abs(int(x) - 40) <= 2) << x;
    EXPECT_EQ(__builtin_popcount(unsigned(bytes[0][x] | bytes[1][x] << 8 | bytes[2][x] << 16)), darker) << x;
  }
  for (auto& row : rows) std::reverse(row.begin(), row.begin() + 90 + 2 * kCensusReach);
  const auto mirrored = census(true);
  for (std::size_t i = 0; i < kCensusBytes; ++i)
    for (std::size_t x = 2; x < 88; ++x) EXPECT_EQ(mirrored[i][89 - x], bytes[i][x]) << x;
}

TEST(CensusCosts, AreTwiceTheBitsThatDifferOrChance) {
  constexpr int kWidth = 70;
  Random random(11);
  for (const int labels : {20, 32, 60, 128}) {
    const int stride = (labels + kLabelUnit - 1) / kLabelUnit * kLabelUnit;
    std::vector<std::vector<std::uint8_t>> left(kCensusBytes), right(kCensusBytes);
    CensusRows<const std::uint8_t> left_rows, right_rows;
    for (std::size_t i = 0; i < kCensusBytes; ++i) {
      for (auto* bytes : {&left[i], &right[i]}) {
        bytes->resize(std::size_t(kWidth + stride));
        for (auto& byte : *bytes) byte = i < 3 ? std::uint8_t(random.below(256)) : random.below(9) ? 0 : 255;
      }
      left_rows[i] = left[i].data(), right_rows[i] = right[i].data();
    }
    std::vector<std::uint8_t> costs(std::size_t(kWidth * stride) + 1, 77);
    census_costs(left_rows, right_rows, kWidth, labels, stride, 24, costs.data());
    for (int x = 0; x < kWidth; ++x)
      for (int k = 0; k < stride; ++k) {
        const std::size_t a = std::size_t(x), b = std::size_t(kWidth - 1 - x + k);
        int bits = 0;
        for (std::size_t i = 0; i < 3; ++i) bits += __builtin_popcount(unsigned(left[i][a] ^ right[i][b]));
        const int expected = k >= labels ? 255 : left[3][a] || right[3][b] ? 24 : 2 * bits;
        EXPECT_EQ(costs[std::size_t(x * stride + k)], expected) << x << ' ' << k;
      }
    EXPECT_EQ(costs.back(), 77);  // nothing beyond
  }
}

TEST(JumpRow, IsWhatTheFormulaSays) {
  const int width = 37;
  std::vector<std::uint8_t> here(std::size_t(width + kCensusSlack + 1)), before(here.size());
  std::vector<std::uint8_t> jumps(std::size_t(4 * (width + kCensusSlack)));
  Random random(8);
  for (auto* row : {&here, &before})
    for (auto& grey : *row) grey = std::uint8_t(random.below(256));
  for (const int sense : {1, -1}) {
    jump_row(here.data() + 1, before.data() + 1, sense, width, jumps.data());
    for (int x = 0; x < width; ++x) {
      const auto at = [](const std::vector<std::uint8_t>& row, int column) {
        return int(row[std::size_t(column + 1)]);
      };
      const int others[] = {at(here, x - sense), at(before, x - sense), at(before, x), at(before, x + sense)};
      for (int p = 0; p < 4; ++p)
        EXPECT_EQ(jumps[std::size_t(4 * x + p)],
                  std::max(kLeastJump, kJumpScale / (kGreyOfJump + std::abs(at(here, x) - others[p]))));
    }
  }
}

TEST(StereoTiles, KeepEveryPixelOnceAndBoundMemory) {
  for (const int width : {300, 5000})
    for (const int height : {200, 3000})
      for (const int labels : {64, 700, 2000}) {
        const std::size_t most = 400'000'000, bytes = (std::size_t(labels) + kLabelUnit - 1) / kLabelUnit * kLabelUnit;
        std::int64_t kept = 0;
        for (const StereoTile& t : stereo_tiles(width, height, labels, most)) {
          kept += std::int64_t(t.kept_x1 - t.kept_x0) * (t.kept_y1 - t.kept_y0);
          EXPECT_LE(std::size_t(t.x1 - t.x0) * std::size_t(t.y1 - t.y0) * bytes, most);
          EXPECT_LE(t.x0, t.kept_x0);
          EXPECT_GE(t.y1, t.kept_y1);
        }
        EXPECT_EQ(kept, std::int64_t(width) * height);
      }
}

TEST(StereoTiles, TheirBordersAreHardlyFelt) {
  const TestPair pair{.width = 300, .height = 240, .at_left = 10, .square = 24, .noise = 6};
  const GreyImage left = pair.image_of(true), right = pair.image_of(false);
  const DisparityCosts costs(left, right, StereoCost::kCensus, {});
  const GreyImage small = small_changes(left);
  const DisparityRange range{0, 31};
  const auto matched = [&](std::size_t most) {
    FloatImage disparity(left.width, left.height, 1, kNaN);
    for (const StereoTile& tile : stereo_tiles(left.width, left.height, 32, most))
      match_tile(costs, left, right.width, small, range, 1, tile, {}, disparity);
    return disparity;
  };
  const FloatImage whole = matched(100'000'000), cut = matched(std::size_t(300 * 150 * kLabelUnit));
  int differ = 0;
  for (std::size_t i = 0; i < whole.data.size(); ++i)
    differ += std::isnan(whole.data[i]) != std::isnan(cut.data[i]) || std::abs(whole.data[i] - cut.data[i]) > 0.25f;
  EXPECT_LT(differ, 0.005 * double(whole.data.size()));
}

}  // namespace
}  // namespace dense
}  // namespace collinea
