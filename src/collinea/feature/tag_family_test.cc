// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/tag_family.h"

#include <gtest/gtest.h>

#include <bit>

#include "collinea/math/random.h"

namespace collinea {
namespace {

class TagFamilyOf : public testing::TestWithParam<Word<TagFamily>> {};

TEST_P(TagFamilyOf, DistanceIsThatOfItsCodes) {
  const TagCodes& codes = tag_codes(GetParam().value);
  int least = codes.side * codes.side;
  for (std::size_t i = 0; i < codes.bits.size(); ++i) {
    TagBits turned = codes.bits[i];
    for (int turns = 0; turns < 4; ++turns) {
      for (std::size_t k = 0; k <= i; ++k)
        if (k != i || turns != 0) least = std::min(least, std::popcount(turned ^ codes.bits[k]));
      turned = turned_tag(turned, codes.side);
    }
    EXPECT_EQ(turned, codes.bits[i]);
  }
  EXPECT_EQ(least, codes.distance);
}

// Of every tenth code: turned, and with as many wrong cells as can be corrected.
TEST_P(TagFamilyOf, CodesAreReadTurnedAndDamaged) {
  const TagFamily family = GetParam().value;
  const TagCodes& codes = tag_codes(family);
  Random random(1);
  for (std::size_t id = 0; id < codes.bits.size(); id += 10)
    for (int turns = 0; turns < 4; ++turns) {
      TagBits bits = codes.bits[id];
      for (int k = 0; k < turns; ++k) bits = turned_tag(bits, codes.side);
      int wrong = 0;
      for (const TagBits whole = bits; wrong < codes.correctable(); wrong = std::popcount(bits ^ whole))
        bits = whole ^ ((bits ^ whole) | TagBits(1) << int(random.uniform(0, codes.side * codes.side - 1e-9)));
      const auto reading = read_tag(family, bits, 99);
      if (!reading && family == TagFamily::kArucoOriginal) continue;  // some are others turned
      ASSERT_TRUE(reading) << id;
      EXPECT_EQ(reading->id, int(id));
      EXPECT_EQ(reading->turns, turns);
      EXPECT_EQ(std::popcount(reading->wrong), wrong);
      EXPECT_EQ(read_tag(family, bits, wrong - 1).has_value(), false);
    }
}

INSTANTIATE_TEST_SUITE_P(Families, TagFamilyOf, testing::ValuesIn(kTagFamilyWords), [](const auto& tested) {
  std::string name(tested.param.word);
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
});

TEST(TagFamilies, WordsOfTheOriginalAreThoseOfItsFormula) {
  const TagCodes& codes = tag_codes(TagFamily::kArucoOriginal);
  ASSERT_EQ(codes.bits.size(), 1024u);
  EXPECT_EQ(codes.bits[0], TagBits(0b10000'10000'10000'10000'10000));
  EXPECT_EQ(codes.bits[0b0001101100], TagBits(0b10000'10111'01001'01110'10000));
  EXPECT_FALSE(read_tag(TagFamily::kArucoOriginal, 0, 99));
}

TEST(TagFamilies, ChanceOfRandomCells) {
  const TagFamily family = TagFamily::kAruco4x4x50;
  EXPECT_DOUBLE_EQ(tag_codes(family).chance_of_random(0), 200 / 65536.0);
  Random random(3);
  int read = 0;
  for (int k = 0; k < 20'000; ++k) read += read_tag(family, TagBits(random.uniform(0, 65536)), 1).has_value();
  const double chance = tag_codes(family).chance_of_random(1);
  EXPECT_NEAR(read / 20'000.0, chance, 4 * std::sqrt(chance / 20'000));
}

TEST(TagFamilies, NamesEndInTheNumber) {
  for (const char* name : {"12", "tag12", "T-012", "A3_12"}) EXPECT_TRUE(is_name_of_tag(name, 12)) << name;
  for (const char* name : {"112", "tag2", "12a", "", "tag", "99999999999999999999"})
    EXPECT_FALSE(is_name_of_tag(name, 12)) << name;
  EXPECT_TRUE(is_name_of_tag("0", 0));
}

}  // namespace
}  // namespace collinea
