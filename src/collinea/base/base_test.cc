// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "collinea/base/hash.h"
#include "collinea/base/id.h"
#include "collinea/base/options.h"
#include "collinea/base/random.h"

namespace collinea {
namespace {

static_assert(!std::is_convertible_v<CameraId, ImageId>);

TEST(Check, ABrokenPromiseIsABug) { EXPECT_THROW(COLLINEA_CHECK(1 + 1 == 3), std::logic_error); }

TEST(Hash, OrderAndSplitMatter) {
  EXPECT_NE(Hash().add("ab").add("c").value(), Hash().add("a").add("bc").value());
  EXPECT_NE(Hash().add(1).add(2).value(), Hash().add(2).add(1).value());
  EXPECT_EQ(Hash().add("same").hex(), Hash().add("same").hex());
}

// The mean of n standard normal numbers has sigma 1/sqrt(n), their mean square sqrt(2/n); four sigmas each.
TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  constexpr int n = 100'000;
  Random random(7);
  double sum = 0, sum_of_squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    sum += x;
    sum_of_squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(sum_of_squares / n, 1, 4 * std::sqrt(2.0 / n));
}

TEST(Random, StreamsOfNeighbouringItemsDiffer) {
  EXPECT_NE(Random(1, 0).bits(), Random(1, 1).bits());
  EXPECT_NE(Random(1, 1).bits(), Random(2, 0).bits());
}

TEST(Random, BelowReachesEveryValue) {
  Random random(3);
  bool seen[5] = {};
  for (int i = 0; i < 200; ++i) seen[random.below(5)] = true;
  for (const bool value : seen) EXPECT_TRUE(value);
}

struct PaintOptions {
  double coats = 2;
  int brushes = 1;
  bool glossy = false;
  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PaintOptions;
    visit(Field{"coats", &O::coats, "1", "layers of paint", 1, 9});
    visit(Field{"brushes", &O::brushes, "1", "brushes used", 1});
    visit(Field{"glossy", &O::glossy, "", "shine"});
  }
};

TEST(Options, DefaultsAreValid) { EXPECT_TRUE(validate(PaintOptions{})); }

TEST(Options, TheWrongFieldIsNamed) {
  const auto verdict = validate(PaintOptions{.coats = 12});
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().code, Errc::kBadInput);
  EXPECT_NE(verdict.error().message.find("coats"), std::string::npos);
}

}  // namespace
}  // namespace collinea
