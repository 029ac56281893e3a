// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/rejection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace collinea {
namespace {

struct Mean {
  double sigma0 = 0;
  int redundancy = 0;
  std::vector<double> w;  // of those that take part
};

// The mean of values with a standard deviation of 1; at least `fewest` of them are needed.
class MeanOf {
 public:
  MeanOf(std::vector<double> values, std::size_t fewest) : values_(std::move(values)), fewest_(fewest) {
    rejected.resize(values_.size(), 0);
  }
  std::optional<Mean> fitted() {
    return fitted_with_rejection(
        Rejection{.is_asked = true, .sigmas_are_stated = true}, [&] { return fit(); },
        [](const Mean& found) { return found.w; }, [&](std::size_t k) -> char& { return rejected[taken()[k]]; });
  }
  std::vector<char> rejected;
  int fits = 0;

 private:
  [[nodiscard]] std::vector<std::size_t> taken() const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (!rejected[i]) out.push_back(i);
    return out;
  }
  std::optional<Mean> fit() {
    ++fits;
    const std::vector<std::size_t> used = taken();
    if (used.size() < fewest_) return std::nullopt;
    const double n = double(used.size());
    double mean = 0, squares = 0;
    for (const std::size_t i : used) mean += values_[i] / n;
    Mean out;
    for (const std::size_t i : used) {
      squares += std::pow(values_[i] - mean, 2);
      out.w.push_back((values_[i] - mean) / std::sqrt(1 - 1 / n));
    }
    out.redundancy = int(used.size()) - 1;
    out.sigma0 = std::sqrt(squares / double(out.redundancy));
    return out;
  }
  std::vector<double> values_;
  std::size_t fewest_;
};

TEST(FittedWithRejection, FitsOnceForEachThatLeaves) {
  MeanOf mean({0.3, -0.8, 50, 0.5, -0.2, 30, 0.1}, 2);
  const auto found = mean.fitted();
  ASSERT_TRUE(found);
  EXPECT_EQ(std::ranges::count(mean.rejected, 1), 2);
  EXPECT_TRUE(mean.rejected[2] && mean.rejected[5]);
  EXPECT_EQ(found->redundancy, 4);
  EXPECT_EQ(mean.fits, 3);
}

TEST(FittedWithRejection, NoneLeavesWhereTheOthersCannotBeFitted) {
  MeanOf mean({0.3, -0.8, 50, 0.5}, 4);
  const auto found = mean.fitted();
  ASSERT_TRUE(found);
  EXPECT_EQ(std::ranges::count(mean.rejected, 1), 0);
  EXPECT_EQ(found->redundancy, 3);
  EXPECT_EQ(mean.fits, 2);
}

}  // namespace
}  // namespace collinea
