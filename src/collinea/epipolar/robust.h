// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "collinea/math/random.h"

namespace collinea {

/// What a robust search needs to know of a problem. Items 0 .. size() - 1 are measurements (pairs, points); they should
/// be in no meaningful order (see shuffled), because runs of neighbours are used as random samples.
template <class P>
concept RobustProblem = requires(const P& problem, const typename P::Model& model, std::array<int, P::kSample> sample,
                                 std::span<const int> support, double* out) {
  { problem.size() } -> std::convertible_to<int>;
  { *problem.solve(sample).begin() } -> std::convertible_to<typename P::Model>;  ///< models through kSample items
  problem.squared_errors(model, 0, 1, out);                                      ///< of the items [begin, end) [px^2]
  { problem.refine(model, support) } -> std::same_as<std::optional<typename P::Model>>;  ///< least squares from a start
};

struct RobustOptions {
  double max_error_px = 2;     ///< largest residual of an inlier
  double confidence = 0.9999;  ///< wanted chance of at least one sample without outliers
  int min_trials = 10;
  int max_trials = 5000;
  double min_inlier_ratio = 0;  ///< fewer inliers than this share are of no interest: bounds the trials
  std::span<const int> preferred =
      {};  ///< items believed to be right more often: every other sample is drawn from them alone
};

/// How many random samples of `sample` different items there must be for one of them to be without outliers with the
/// wanted confidence, when `inliers` of `size` items are right: log(1 - confidence) / log(1 - chance of a good sample),
/// rounded up. Infinite when there is no good sample (chance below 1e-12), 0 when all are.
[[nodiscard]] inline double samples_needed(double inliers, double size, int sample, double confidence) {
  double good = 1;
  for (int k = 0; k < sample; ++k) good *= std::max(0.0, (inliers - k) / (size - k));
  if (!(good > 1e-12)) return std::numeric_limits<double>::infinity();
  if (good >= 1) return 0;
  return std::ceil(std::log(1 - confidence) / std::log1p(-good));
}

/// How many different samples there are, size over sample: what a search of all of them would try (least median of
/// squares without chance). As a double it is exact below 2^53; 0 when there are fewer items than a sample has.
[[nodiscard]] inline double samples_possible(int size, int sample) {
  double count = size < sample ? 0 : 1;
  for (int k = 0; k < sample; ++k) count = count * (size - k) / (k + 1);  // whole after each step
  return count;
}

template <class Model>
struct RobustFit {
  Model model;
  std::vector<int> inliers;  ///< ascending
  double cost = 0;           ///< sum over all items of min(e^2 / max_error^2, 1)
  int trials = 0;
};

/// The numbers 0 .. count - 1 in random order.
[[nodiscard]] inline std::vector<int> shuffled(int count, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
  for (int i = count - 1; i > 0; --i)
    std::swap(order[static_cast<std::size_t>(i)], order[random.below(static_cast<std::uint32_t>(i) + 1)]);
  return order;
}

/// The model with the least truncated squared error (MSAC, Torr and Zisserman 2000) found by random samples, the
/// best of the first min_trials and each new best model after them improved by least squares over its inliers (Chum,
/// Matas, Kittler 2003), bad models left early by Wald's sequential test (Matas and Chum 2005) and the number of
/// samples adapted to the inliers found. Deterministic in the state of `random`. Nothing when no sample gave a model.
template <RobustProblem Problem>
class RobustSearch {
 public:
  using Model = typename Problem::Model;

  RobustSearch(const Problem& problem, const RobustOptions& options, Random& random)
      : problem_(problem),
        options_(options),
        random_(random),
        size_(problem.size()),
        threshold_px2_(options.max_error_px * options.max_error_px),
        errors_(static_cast<std::size_t>(size_)) {
    if (options.preferred.size() >= 4 * Problem::kSample) preferred_ = options.preferred;
  }

  [[nodiscard]] std::optional<RobustFit<Model>> run() {
    if (size_ < Problem::kSample) return std::nullopt;
    int needed = trials_for(options_.min_inlier_ratio * size_, size_);
    int trial = 0;
    for (; trial < needed; ++trial) {
      for (const Model& candidate : problem_.solve(sample(trial % 2 == 0 ? preferred_ : std::span<const int>()))) {
        if (rejected_early(candidate)) continue;
        const Score score = score_of(candidate);
        if (best_ && !(score.cost < best_score_.cost)) continue;
        best_ = candidate;
        best_score_ = score;
        if (trial < options_.min_trials) continue;  // these are drawn anyway: only the best of them is improved
        improve(3, kLocalSupport);
        needed = std::min(needed, trials_for(best_score_));
      }
      if (trial + 1 == options_.min_trials && best_) {
        improve(3, kLocalSupport);
        needed = std::min(needed, trials_for(best_score_));
      }
    }
    if (!best_) return std::nullopt;
    improve(4, kFinalSupport);
    return RobustFit<Model>{*best_, support(*best_, threshold_px2_, size_), best_score_.cost, trial};
  }

 private:
  static constexpr int kBlock = 32;           // items between two looks at the sequential test
  static constexpr int kLocalSupport = 400;   // items a local improvement looks at
  static constexpr int kFinalSupport = 1500;  // items the last one looks at: more do not change who is an inlier
  static constexpr double kLogReject = 7;     // a good model is lost with a chance of exp(-7)

  struct Score {
    double cost = 0;
    int inliers = 0;
    int preferred_inliers = 0;
  };

  // Different items, of `among` or, when that is empty, of all.
  std::array<int, Problem::kSample> sample(std::span<const int> among) {
    const auto choices = static_cast<std::uint32_t>(among.empty() ? static_cast<std::size_t>(size_) : among.size());
    std::array<int, Problem::kSample> chosen;
    for (int k = 0; k < Problem::kSample;) {
      const std::uint32_t drawn = random_.below(choices);
      const int item = among.empty() ? static_cast<int>(drawn) : among[drawn];
      bool fresh = true;
      for (int j = 0; j < k; ++j) fresh = fresh && chosen[static_cast<std::size_t>(j)] != item;
      if (fresh) chosen[static_cast<std::size_t>(k++)] = item;
    }
    return chosen;
  }

  [[nodiscard]] int trials_for(double inliers, double size) const {
    const double least = std::min(options_.min_trials, options_.max_trials), most = options_.max_trials;
    return static_cast<int>(
        std::clamp(samples_needed(inliers, size, Problem::kSample, options_.confidence), least, most));
  }

  // Preferred items have had half of the samples.
  [[nodiscard]] int trials_for(const Score& score) const {
    const int among_all = trials_for(score.inliers, size_);
    if (preferred_.empty()) return among_all;
    return std::min(among_all, 2 * trials_for(score.preferred_inliers, static_cast<double>(preferred_.size())));
  }

  // Wald's test between "as good as the best so far" and "as bad as chance", starting at a random item so that no
  // block of items has a say in every decision.
  bool rejected_early(const Model& model) {
    if (size_ < 4 * kBlock) return false;
    const double good =
        std::clamp(best_ ? static_cast<double>(best_score_.inliers) / size_ : options_.min_inlier_ratio, 0.1, 0.99);
    const double bad = std::min(chance_, good / 3);
    const double inlier_step = std::log(bad / good), outlier_step = std::log((1 - bad) / (1 - good));
    int begin = static_cast<int>(random_.below(static_cast<std::uint32_t>(size_)));
    double evidence = 0;
    int seen = 0, inliers = 0;
    while (seen < size_) {
      const int count = std::min({kBlock, size_ - begin, size_ - seen});
      problem_.squared_errors(model, begin, begin + count, errors_.data());
      int here = 0;
      for (int i = 0; i < count; ++i) here += errors_[static_cast<std::size_t>(i)] < threshold_px2_;
      inliers += here;
      seen += count;
      begin = begin + count == size_ ? 0 : begin + count;
      evidence += here * inlier_step + (count - here) * outlier_step;
      if (evidence > kLogReject) {
        chance_ += 0.05 * (std::clamp(static_cast<double>(inliers) / seen, 0.002, 0.3) - chance_);
        return true;
      }
      if (evidence < -kLogReject) return false;
    }
    return false;
  }

  [[nodiscard]] Score score_of(const Model& model) {
    problem_.squared_errors(model, 0, size_, errors_.data());
    Score score;
    for (const double e : errors_) {
      const bool inside = e < threshold_px2_;  // false for not-a-number
      score.cost += inside ? e : threshold_px2_;
      score.inliers += inside;
    }
    score.cost /= threshold_px2_;
    for (const int i : preferred_) score.preferred_inliers += errors_[static_cast<std::size_t>(i)] < threshold_px2_;
    return score;
  }

  [[nodiscard]] std::vector<int> support(const Model& model, double limit_px2, int most) {
    problem_.squared_errors(model, 0, size_, errors_.data());
    std::vector<int> items;
    for (int i = 0; i < size_ && static_cast<int>(items.size()) < most; ++i)
      if (errors_[static_cast<std::size_t>(i)] < limit_px2) items.push_back(i);
    return items;
  }

  // Least squares over the inliers as long as it makes the best model better. The first round looks beyond the
  // threshold, because a model from a minimal sample carries the noise of that sample.
  void improve(int rounds, int most) {
    for (int round = 0; round < rounds; ++round) {
      const double widening = round == 0 ? 4 : 1;
      const std::vector<int> items = support(*best_, widening * threshold_px2_, most);
      if (static_cast<int>(items.size()) <= Problem::kSample) return;
      const std::optional<Model> candidate = problem_.refine(*best_, items);
      if (!candidate) return;
      const Score score = score_of(*candidate);
      const bool better = score.cost < best_score_.cost;
      const double gain = best_score_.cost - score.cost;
      if (better) {
        best_ = candidate;
        best_score_ = score;
      }
      if (round > 0 && !(gain > 1e-3 * best_score_.cost)) return;
    }
  }

  const Problem& problem_;
  const RobustOptions& options_;
  Random& random_;
  int size_;
  double threshold_px2_;
  std::vector<double> errors_;
  std::span<const int> preferred_;
  std::optional<Model> best_;
  Score best_score_;
  double chance_ = 0.05;  // share of the items that fit a wrong model, as seen so far
};

template <RobustProblem Problem>
[[nodiscard]] std::optional<RobustFit<typename Problem::Model>> robust_fit(const Problem& problem,
                                                                           const RobustOptions& options,
                                                                           Random& random) {
  return RobustSearch<Problem>(problem, options, random).run();
}

}  // namespace collinea
