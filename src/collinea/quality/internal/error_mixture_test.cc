// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/error_mixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/math/random.h"

namespace collinea {
namespace {

struct Drawn {
  std::vector<CheckedError> errors;
  std::vector<double> coordinates;  // one of each error that is not gross
  std::vector<bool> gross;
};

// Errors of the scale 0.7 with nu degrees of freedom (0: normal); a share is uniform within 25; none beyond `cut`.
Drawn draw(int nu, double share, int directions, double cut = INFINITY, int count = 20000) {
  Random random(7, static_cast<std::uint64_t>(100 * nu + directions));
  Drawn drawn;
  while (static_cast<int>(drawn.errors.size()) < count) {
    double factor = 0.7;
    if (nu > 0) {
      double chi2 = 0;
      for (int k = 0; k < nu; ++k) chi2 += std::pow(random.normal(), 2);
      factor *= std::sqrt(nu / chi2);
    }
    double x = factor * random.normal(), y = directions == 2 ? factor * random.normal() : 0;
    const bool gross = random.uniform() < share;
    if (gross) do {
        x = random.uniform(-25, 25), y = directions == 2 ? random.uniform(-25, 25) : 0;
      } while (std::hypot(x, y) > 25);
    if (std::hypot(x, y) > cut) continue;
    drawn.errors.push_back({x * x + y * y, directions});
    drawn.gross.push_back(gross);
    if (!gross) drawn.coordinates.push_back(std::abs(x));
  }
  return drawn;
}

// Of good errors those beyond the limit of 0.1 % are one of a thousand, within four deviations and the uncertainty of
// the fit, whatever their tails are, with and without gross ones and cut off or not.
TEST(ErrorMixture, OneOfAThousandGoodErrorsIsBeyondTheLimit) {
  for (const int nu : {0, 3, 5, 8})
    for (const int directions : {1, 2})
      for (const double share : {0.0, 0.01, 0.05})
        for (const double cut : {double(INFINITY), 9.0}) {
          if (share > 0 && cut < INFINITY) continue;
          const Drawn drawn = draw(nu, share, directions, cut);
          const auto fitted = fit_errors(drawn.errors);
          ASSERT_TRUE(fitted);
          EXPECT_EQ(fitted->is_normal(), nu == 0) << nu << " " << share << " " << fitted->degrees_of_freedom;
          EXPECT_EQ(fitted->gross_share > 0, share > 0);
          EXPECT_NEAR(fitted->gross_share, share, 0.3 * share) << nu << " " << directions;
          EXPECT_NEAR(fitted->scale, 0.7, 0.04);
          const double limit = fitted->limit(0.001);
          const auto beyond =
              std::ranges::count_if(drawn.coordinates, [&](double coordinate) { return coordinate > limit; });
          EXPECT_NEAR(double(beyond), 20, 18) << nu << " " << directions << " " << share << " " << cut;
        }
}

// Of those called gross hardly one of a thousand good errors; of the gross ones most, the better the shorter the tails.
TEST(ErrorMixture, GrossErrorsAreToldFromLongTails) {
  for (const int nu : {0, 3, 8}) {
    const Drawn drawn = draw(nu, 0.03, 2);
    const auto fitted = fit_errors(drawn.errors);
    ASSERT_TRUE(fitted);
    double gross = 0, found = 0, lost = 0, expected = 0;
    for (std::size_t i = 0; i < drawn.errors.size(); ++i) {
      const double probability = fitted->gross_probability(drawn.errors[i]);
      gross += drawn.gross[i];
      if (probability <= 0.5) continue;
      (drawn.gross[i] ? found : lost) += 1;
      expected += 1 - probability;
    }
    EXPECT_GT(found / gross, nu == 3 ? 0.8 : 0.94);
    EXPECT_NEAR(lost, expected, 4 * std::sqrt(expected) + 4) << nu;
  }
}

TEST(ErrorMixture, StudentErrorsWithoutGrossOnesLoseNone) {
  for (const int nu : {3, 8}) {
    const Drawn drawn = draw(nu, 0, 2);
    const auto fitted = fit_errors(drawn.errors);
    ASSERT_TRUE(fitted);
    EXPECT_EQ(fitted->gross_share, 0);
    for (const CheckedError& one : drawn.errors) EXPECT_EQ(fitted->gross_probability(one), 0);
  }
}

TEST(ErrorMixture, TooFewErrorsOrNoneAtAllGiveNothing) {
  EXPECT_FALSE(fit_errors({}));
  EXPECT_FALSE(fit_errors(draw(4, 0, 2, INFINITY, 199).errors));
  EXPECT_FALSE(fit_errors(std::vector<CheckedError>(1000, {0, 2})));
  EXPECT_FALSE(fit_errors(std::vector<CheckedError>(1000, {1, 0})));
  EXPECT_FALSE(fit_errors(std::vector<CheckedError>(1000, {NAN, 2})));
}

TEST(ErrorMixture, ErrorsOfOneSizeHaveAFiniteAnswer) {
  const auto fitted = fit_errors(std::vector<CheckedError>(1000, {1, 2}));
  ASSERT_TRUE(fitted);
  EXPECT_TRUE(std::isfinite(fitted->scale) && std::isfinite(fitted->limit(0.001)));
}

}  // namespace
}  // namespace collinea
