// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/difference_statistics.h"

#include <algorithm>
#include <cmath>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr std::size_t kMostKept = std::size_t{1} << 21;

}  // namespace

void DifferenceStatistics::add(double difference_m, double tolerance_m) {
  if (count_ % stride_ == 0) {
    kept_.push_back(float(difference_m));
    if (kept_.size() == kMostKept) {  // every second one is enough
      for (std::size_t i = 0; 2 * i < kept_.size(); ++i) kept_[i] = kept_[2 * i];
      kept_.resize(kept_.size() / 2);
      stride_ *= 2;
    }
  }
  lowest_m_ = count_ == 0 ? difference_m : std::min(lowest_m_, difference_m);
  highest_m_ = count_ == 0 ? difference_m : std::max(highest_m_, difference_m);
  ++count_;
  sum_m_ += difference_m;
  sum_squares_m2_ += difference_m * difference_m;
  for (std::size_t i = 0; i < kMultiples.size(); ++i) below_[i] += std::abs(difference_m) < kMultiples[i] * tolerance_m;
}

double DifferenceStatistics::mean_m() const { return count_ == 0 ? 0 : sum_m_ / double(count_); }

double DifferenceStatistics::rms_m() const { return count_ == 0 ? 0 : std::sqrt(sum_squares_m2_ / double(count_)); }

double DifferenceStatistics::standard_deviation_m() const {
  if (count_ < 2) return 0;
  const double about_mean = sum_squares_m2_ - sum_m_ * sum_m_ / double(count_);
  return std::sqrt(std::max(about_mean, 0.0) / double(count_ - 1));
}

double DifferenceStatistics::median_m() const {
  if (kept_.empty()) return 0;
  std::vector<float> values = kept_;
  return double(median(values));
}

double DifferenceStatistics::nmad_m() const {
  if (kept_.empty()) return 0;
  std::vector<float> values = kept_;
  const float middle = median(values);
  for (float& value : values) value = std::abs(value - middle);
  return 1.4826 * double(median(values));
}

double DifferenceStatistics::share_below(std::size_t i) const {
  return count_ == 0 ? 0 : double(below_[i]) / double(count_);
}

}  // namespace collinea
