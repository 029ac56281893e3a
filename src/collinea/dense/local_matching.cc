// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/local_matching.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/local_kernels.h"
#include "collinea/dense/internal/local_pair.h"
#include "collinea/dense/internal/pair_check.h"

namespace collinea {
namespace {

using dense::kLocalSlack;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kNothing = std::numeric_limits<float>::infinity();
constexpr int kBandRows = 64;          // of a piece of work
constexpr int kFewestDisparities = 3;  // that have one with two neighbours
constexpr int kShiftUnknowns = 4;      // shift, gain, offset: as in area matching
constexpr float kPatchReachPx = 1;

dense::PixelTerm term_of(Similarity similarity) {
  switch (similarity) {
    case Similarity::kNcc:
    case Similarity::kCosine:
      return dense::PixelTerm::kProduct;
    case Similarity::kSad:
    case Similarity::kRank:
      return dense::PixelTerm::kDifference;
    case Similarity::kCensus:
      return dense::PixelTerm::kBits;
    default:  // d and dn are least where ssd is
      return dense::PixelTerm::kSquare;
  }
}

// Proportional to what the left window leaves unexplained, for the ratio of two disparities.
double residual_of(Similarity similarity, double cost) {
  if (is_larger_better(similarity)) return cost < 1 ? cost * (2 - cost) : 1;
  return similarity == Similarity::kSad ? cost * cost : cost;
}

// The variance of the bottom of a parabola with the least value and the second difference of the costs.
double variance_of(Similarity similarity, double least, double rises, double n) {
  if (similarity == Similarity::kRank || similarity == Similarity::kCensus) return std::nan("");
  if (similarity == Similarity::kSad)
    return std::numbers::pi / 2 * least / n / rises + 0.315 / 2 * least * least / n / (rises * rises);
  const double redundancy = std::max(1.0, n - kShiftUnknowns);
  return 2 * least / redundancy / rises + least * least / (2 * redundancy) / (rises * rises);
}

// Rows of the left image, one after another: best disparities of each.
class LocalBand {
 public:
  LocalBand(const dense::LocalPair& pair, const DisparityRange& range, const LocalOptions& options,
            const LocalLimits& limits)
      : pair_(pair), range_(range), options_(options), limits_(limits), stride_(padded(pair.left) + 2 * pair.half) {
    sums_.resize(std::size_t(stride_) * std::size_t(range.high - range.low + 1));
    windows_.resize(std::size_t(padded(pair.left)));
    costs_.resize(windows_.size());
    for (auto* row : {&best_, &label_, &before_, &after_, &second_, &last_, &last_but_1_, &earlier_, &left_penalty_})
      row->resize(windows_.size());
    for (auto* row : {&right_best_, &right_label_, &right_penalty_}) row->resize(std::size_t(padded(pair.right)));
  }

  void match(int begin, int end, DisparityMap& map) {
    for (int y = begin; y < end; ++y) {
      start_row(y);
      for (int d = range_.low; d <= range_.high; ++d) take_disparity(y, y == begin, d);
      for (int x = 0; x < pair_.left.width; ++x) decide(x, y, map);
    }
  }

 private:
  static int padded(const GreyImage& image) { return image.width + kLocalSlack; }

  void start_row(int y) {
    for (auto* row : {&best_, &before_, &after_, &second_, &last_, &last_but_1_, &earlier_, &right_best_})
      std::fill(row->begin(), row->end(), kNothing);
    std::fill(label_.begin(), label_.end(), -1.0f);
    std::fill(right_label_.begin(), right_label_.end(), -1.0f);
    const auto penalise = [&](const GreyImage& image, std::vector<float>& penalty) {
      std::fill(penalty.begin(), penalty.end(), kNothing);
      for (int x = 0; x < image.width; ++x)
        if (image.at(x, y) != 0) penalty[std::size_t(x)] = 0;
    };
    penalise(pair_.left, left_penalty_);
    penalise(pair_.right, right_penalty_);
  }

  // Rows of both images from the left border of the window of column x, and of column x - d, on.
  [[nodiscard]] dense::PixelRows rows_at(int y, int x, int d) const {
    dense::PixelRows rows;
    rows.planes = pair_.left_planes.count();
    for (std::size_t i = 0; i < rows.planes; ++i) {
      rows.left[i] = pair_.left_planes.row(i, y) + x;
      rows.right[i] = pair_.right_planes.row(i, y) + (x - d);
    }
    return rows;
  }

  void take_disparity(int y, bool is_first, int d) {
    const int from = std::max(0, d), to = std::min(pair_.left.width, pair_.right.width + d), width = to - from;
    if (width <= 0) return;
    const int half = pair_.half, label = d - range_.low;
    std::int32_t* sums = sums_.data() + std::size_t(label) * std::size_t(stride_);
    const dense::PixelTerm term = term_of(options_.similarity);
    if (is_first) {
      std::fill_n(sums, stride_, 0);
      for (int v = -half; v <= half; ++v)
        dense::slide_columns(term, rows_at(y + v, from, d), nullptr, width + 2 * half, sums);
    } else {
      const dense::PixelRows leaving = rows_at(y - half - 1, from, d);
      dense::slide_columns(term, rows_at(y + half, from, d), &leaving, width + 2 * half, sums);
    }
    sum_windows(sums, width);
    const std::size_t left = std::size_t(from), right = std::size_t(from - d);
    if (is_larger_better(options_.similarity)) {
      const auto moments = [&](const dense::LocalMoments& of, std::size_t x) {
        return dense::WindowMoments{of.sum.row(y) + x, of.scale.row(y) + x};
      };
      dense::costs_of_products(windows_.data(), moments(pair_.left_moments, left), moments(pair_.right_moments, right),
                               pixels(), left_penalty_.data() + left, right_penalty_.data() + right, width,
                               costs_.data());
    } else {
      dense::costs_of_sums(windows_.data(), left_penalty_.data() + left, right_penalty_.data() + right, width,
                           costs_.data());
    }
    const auto at = [&](std::vector<float>& row) { return row.data() + left; };
    dense::take_label(
        costs_.data(), label, width,
        {at(best_), at(label_), at(before_), at(after_), at(second_), at(last_), at(last_but_1_), at(earlier_)},
        {right_best_.data() + right, right_label_.data() + right});
  }

  void sum_windows(const std::int32_t* columns, int width) {
    const int reach = 2 * pair_.half;
    std::int32_t sum = 0;
    for (int x = 0; x < reach; ++x) sum += columns[x];
    for (int x = 0; x < width; ++x) {
      sum += columns[x + reach];
      windows_[std::size_t(x)] = sum;
      sum -= columns[x];
    }
  }

  [[nodiscard]] float pixels() const {
    const float side = float(2 * pair_.half + 1);
    return side * side;
  }

  [[nodiscard]] bool is_sure(std::size_t x, int y) const {
    if (label_[x] < 0 || pair_.left_moments.scale.at(int(x), y) == 0) return false;
    const double best = residual_of(options_.similarity, best_[x]);
    if (!(double(second_[x]) > double(best_[x])) ||
        residual_of(options_.similarity, second_[x]) < options_.decisive_ratio * best)
      return false;
    const int label = int(label_[x]), there = int(x) - range_.low - label;
    return std::abs(int(right_label_[std::size_t(there)]) - label) <= limits_.max_left_right_px;
  }

  void decide(int column, int y, DisparityMap& map) {
    const std::size_t x = std::size_t(column);
    map.disparity.at(column, y) = map.sigma.at(column, y) = kNaN;
    // Also where the best lies at an end of what is searched: the cost beyond it is infinite.
    const double before = before_[x], least = best_[x], after = after_[x], rises = before + after - 2 * least;
    if (!is_sure(x, y) || !std::isfinite(rises) || !(rises > 0)) return;
    map.disparity.at(column, y) = float(range_.low + double(label_[x]) + (before - after) / (2 * rises));
    map.sigma.at(column, y) = float(std::sqrt(variance_of(options_.similarity, least, rises, double(pixels()))));
  }

  const dense::LocalPair& pair_;
  const DisparityRange range_;
  const LocalOptions& options_;
  const LocalLimits& limits_;
  int stride_;
  std::vector<std::int32_t> sums_, windows_;  // down the columns by label; over the windows of a row
  std::vector<float> costs_, best_, label_, before_, after_, second_, last_, last_but_1_, earlier_, left_penalty_;
  std::vector<float> right_best_, right_label_, right_penalty_;
};

Result<> check(const DisparityRange& range, const LocalOptions& options) {
  if (options.window_px % 2 == 0)
    return fail(Errc::kBadInput, "the side of the window is even", {"local_window_px"_option});
  if (options.neighbourhood_px % 2 == 0)
    return fail(Errc::kBadInput, "the side of the neighbourhood is even", {"local_neighbourhood_px"_option});
  if (range.high - range.low + 1 < kFewestDisparities)
    return fail(Errc::kBadInput, "a best disparity has one on either side: fewer than three are searched",
                {"min_disparity"_option, "max_disparity"_option});
  return {};
}

}  // namespace

Result<DisparityMap> match_locally(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                                   const LocalOptions& options, const LocalLimits& limits, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(dense::check_pair(left, right, range));
  COLLINEA_TRY(check(range, options));
  const dense::LocalPair pair(left, right, options.similarity, options.window_px / 2, options.neighbourhood_px, run);
  DisparityMap map{FloatImage(left.width, left.height), FloatImage(left.width, left.height)};
  parallel_for(run, std::size_t((left.height + kBandRows - 1) / kBandRows), [&](std::size_t band) {
    const int begin = int(band) * kBandRows;
    LocalBand(pair, range, options, limits).match(begin, std::min(begin + kBandRows, left.height), map);
  });
  if (run.stopped()) return fail(Errc::kCancelled, "matching was stopped");
  dense::remove_speckles(map.disparity, kPatchReachPx, limits.min_patch_px);
  for (std::size_t i = 0; i < map.sigma.data.size(); ++i)
    if (std::isnan(map.disparity.data[i])) map.sigma.data[i] = kNaN;
  return map;
}

}  // namespace collinea
