// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "collinea/base/hash.h"
#include "collinea/base/id.h"
#include "collinea/base/options.h"

namespace collinea {
namespace {

static_assert(!std::is_convertible_v<CameraId, ImageId>);

TEST(Check, ABrokenPromiseIsABug) { EXPECT_THROW(COLLINEA_CHECK(1 + 1 == 3), std::logic_error); }

TEST(Hash, OrderAndSplitMatter) {
  EXPECT_NE(Hash().add("ab").add("c").value(), Hash().add("a").add("bc").value());
  EXPECT_NE(Hash().add(1).add(2).value(), Hash().add(2).add(1).value());
  EXPECT_EQ(Hash().add("same").hex(), Hash().add("same").hex());
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
