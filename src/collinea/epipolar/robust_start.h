// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/epipolar/robust.h"
#include "collinea/math/least_median.h"

namespace collinea {

/// By what an orientation is found that many gross errors must not bend.
enum class RobustStart : std::uint8_t {
  kTruncated,    ///< least truncated squares (RobustSearch): needs an error beyond which a measurement is wrong
  kLeastMedian,  ///< least median of squares (Rousseeuw 1984): needs none, and more than half to be right
  kL1,           ///< least sum of absolute errors: needs none; stands as many errors that are not large
};
inline constexpr Word<RobustStart> kRobustStartWords[] = {
    {RobustStart::kTruncated, "truncated", "least truncated squares, within a tenth of the image's width"},
    {RobustStart::kLeastMedian, "least_median", "least median of squares: up to nearly half may be wrong"},
    {RobustStart::kL1, "l1", "least sum of absolute errors"}};
[[nodiscard]] constexpr std::span<const Word<RobustStart>> words(RobustStart) { return kRobustStartWords; }

/// A model found without a limit for errors but wrong_beyond() their standard deviation.
template <class Model>
struct StartFit {
  Model model;
  std::vector<int> inliers;  ///< ascending: within wrong_beyond(directions) times `scale_px`
  double scale_px = 0;       ///< standard deviation of one coordinate of an error, of those that count as right
  int trials = 0;
};

/// Problems that can be refined by the least sum of absolute errors from a start, by iteratively reweighted least
/// squares: Gauss-Newton with the weights 1 / |e|.
template <class P>
concept RefinesAbsolutely = RobustProblem<P> && requires(const P& problem, const typename P::Model& model) {
  { problem.refine_absolute(model) } -> std::same_as<std::optional<typename P::Model>>;
};

/// The orientation with the least median of squared errors, or the least sum of absolute ones, over minimal samples:
/// all of them when they are few, else as many as leave a chance of 1e-4 that three times none of them is free of gross
/// errors with half of the measurements wrong.
///
///     least median     min over samples of the h-th smallest e^2, h by median_rank() of n errors and samples of p
///     scale            robust_sigma() of its root
///     then             least squares of those within wrong_beyond() scales, twice; in the end the scale is theirs
///
/// The sum of absolute errors is first brought to its minimum by reweighting.
///
/// The median breaks down at half of the measurements, whatever their errors are. The sum of absolute errors is bent by
/// leverage and by errors that agree with each other, since no error is left out of it; errors behind a camera count as
/// 1e5 px. `directions` of an error: 1 (epipolar) or 2. Deterministic in the state of `random`. Nothing when no sample
/// gave a model, or a refinement is not determined; by absolute errors nothing of a problem that cannot refine by them.
template <RobustProblem Problem>
class StartSearch {
 public:
  using Model = typename Problem::Model;

  StartSearch(const Problem& problem, RobustStart kind, int directions, Random& random)
      : problem_(problem),
        kind_(kind),
        directions_(directions),
        random_(random),
        size_(problem.size()),
        errors_(static_cast<std::size_t>(std::max(size_, 0))) {}

  [[nodiscard]] std::optional<StartFit<Model>> run() {
    if (size_ <= kSample) return std::nullopt;
    for_each_sample([&](const std::array<int, kSample>& sample) { attempt(sample); });
    if (!best_) return std::nullopt;
    if (kind_ == RobustStart::kL1 && !refine_absolute()) return std::nullopt;
    for (int round = 0; round < kRefinements; ++round) {
      best_ = problem_.refine(*best_, within(*best_, scale_of(*best_)));
      if (!best_) return std::nullopt;
    }
    const double scale = scale_of(*best_, within(*best_, scale_of(*best_)));
    return StartFit<Model>{*best_, within(*best_, scale), scale, trials_};
  }

 private:
  static constexpr int kSample = Problem::kSample;
  static constexpr int kRefinements = 2;
  static constexpr double kFarthest_px = 1e5;
  static constexpr double kExact_px = 1e-6;  // of measurements without errors: rounding
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  static constexpr int kBlock = 64;  // errors between two looks at whether a model can still be the best

  template <class Visit>
  void for_each_sample(Visit&& visit) {
    const double needed = 3 * std::ceil(std::log(1e-4) / std::log1p(-std::pow(0.5, kSample)));
    std::array<int, kSample> sample;
    if (samples_possible(size_, kSample) <= needed) {
      const auto extend = [&](auto&& self, int depth, int from) -> void {
        if (depth == kSample) return visit(sample);
        for (int i = from; i < size_; ++i) {
          sample[static_cast<std::size_t>(depth)] = i;
          self(self, depth + 1, i + 1);
        }
      };
      return extend(extend, 0, 0);
    }
    for (int trial = 0; trial < static_cast<int>(needed); ++trial) {
      for (int k = 0; k < kSample;) {
        const auto drawn = static_cast<int>(random_.below(static_cast<std::uint32_t>(size_)));
        if (std::find(sample.begin(), sample.begin() + k, drawn) == sample.begin() + k)
          sample[static_cast<std::size_t>(k++)] = drawn;
      }
      visit(sample);
    }
  }

  void attempt(const std::array<int, kSample>& sample) {
    ++trials_;
    for (const Model& candidate : problem_.solve(sample)) {
      const double criterion = criterion_of(candidate, least_);
      if (!(criterion < least_)) continue;
      least_ = criterion;
      best_ = candidate;
    }
  }

  [[nodiscard]] double criterion_of(const Model& model, double limit = kNoLimit) {
    return kind_ == RobustStart::kLeastMedian ? central(model, limit) : sum_of_absolute(model, limit);
  }

  // Nearly all candidates are worse than the best one, so errors are looked at in blocks: infinity where what was seen
  // already tells that the sum reaches the limit.
  [[nodiscard]] double sum_of_absolute(const Model& model, double limit) {
    double sum = 0;
    for (int begin = 0; begin < size_; begin += kBlock) {
      const int end = std::min(begin + kBlock, size_);
      problem_.squared_errors(model, begin, end, errors_.data());
      for (int i = 0; i < end - begin; ++i) {
        const double e = errors_[static_cast<std::size_t>(i)];
        sum += e < kFarthest_px * kFarthest_px ? std::sqrt(e) : kFarthest_px;
      }
      if (!(sum < limit)) return kNoLimit;
    }
    return sum;
  }

  // The h-th smallest squared error; infinity where so many reach the limit that it must, too.
  [[nodiscard]] double central(const Model& model, double limit = kNoLimit) {
    const int h = static_cast<int>(median_rank(static_cast<std::size_t>(size_), kSample));
    int above = 0;
    for (int begin = 0; begin < size_; begin += kBlock) {
      const int end = std::min(begin + kBlock, size_);
      double* block = errors_.data() + begin;
      problem_.squared_errors(model, begin, end, block);
      for (int i = 0; i < end - begin; ++i) {
        if (!(block[i] < kFarthest_px * kFarthest_px)) block[i] = kFarthest_px * kFarthest_px;
        above += !(block[i] < limit);
      }
      if (above > size_ - h) return kNoLimit;
    }
    std::nth_element(errors_.begin(), errors_.begin() + (h - 1), errors_.end());
    return errors_[static_cast<std::size_t>(h - 1)];
  }

  [[nodiscard]] double scale_of(const Model& model) {
    return std::max(kExact_px,
                    robust_sigma(std::sqrt(central(model)), static_cast<std::size_t>(size_), kSample, directions_));
  }

  // By those that count as right: with nearly half wrong the median is one of the largest errors of the others.
  [[nodiscard]] double scale_of(const Model& model, const std::vector<int>& items) {
    problem_.squared_errors(model, 0, size_, errors_.data());
    double squares = 0;
    for (const int i : items) squares += errors_[static_cast<std::size_t>(i)];
    const double free = static_cast<double>(directions_) * (static_cast<double>(items.size()) - kSample);
    return free > 0 ? std::max(kExact_px, std::sqrt(squares / free)) : scale_of(model);
  }

  [[nodiscard]] std::vector<int> within(const Model& model, double scale) {
    const double limit = wrong_beyond(directions_) * scale;
    problem_.squared_errors(model, 0, size_, errors_.data());
    std::vector<int> items;
    for (int i = 0; i < size_; ++i)
      if (errors_[static_cast<std::size_t>(i)] <= limit * limit) items.push_back(i);
    return items;
  }

  // What makes the sum larger is not taken; false: not determined.
  bool refine_absolute() {
    if constexpr (RefinesAbsolutely<Problem>) {
      const std::optional<Model> next = problem_.refine_absolute(*best_);
      if (next && criterion_of(*next) <= criterion_of(*best_)) best_ = next;
      return next.has_value();
    }
    return false;
  }

  const Problem& problem_;
  const RobustStart kind_;
  const int directions_;
  Random& random_;
  const int size_;
  std::vector<double> errors_;
  std::optional<Model> best_;
  double least_ = kNoLimit;
  int trials_ = 0;
};

template <RobustProblem Problem>
[[nodiscard]] std::optional<StartFit<typename Problem::Model>> robust_start(const Problem& problem, RobustStart kind,
                                                                            int directions, Random& random) {
  return StartSearch<Problem>(problem, kind, directions, random).run();
}

}  // namespace collinea
