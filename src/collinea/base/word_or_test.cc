// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/word_or.h"

#include <gtest/gtest.h>

#include "collinea/base/options.h"

namespace collinea {
namespace {

enum class Floor { kNone, kRim };
inline constexpr Word<Floor> kFloorWords[] = {{Floor::kNone, "none"}, {Floor::kRim, "rim", "the plane of the border"}};
[[nodiscard]] constexpr std::span<const Word<Floor>> words(Floor) { return kFloorWords; }

using Path = std::filesystem::path;
using FloorLevelOrFile = WordOr<Floor, double, Path>;

TEST(WordOr, TextIsTheFirstThingThatItCanBe) {
  EXPECT_EQ(FloorLevelOrFile("rim").word(), Floor::kRim);
  EXPECT_EQ(*FloorLevelOrFile("-3.5").get<double>(), -3.5);
  EXPECT_EQ(*FloorLevelOrFile("+2").get<double>(), 2);
  for (const char* file : {"", "rim.tif", "3 m", "+-3", "inf", "nan", "Rim"}) {
    const FloorLevelOrFile value(file);
    ASSERT_NE(value.get<Path>(), nullptr) << file;
    EXPECT_EQ(*value.get<Path>(), Path(file));
    EXPECT_FALSE(value.word()) << file;
    EXPECT_EQ(value.get<double>(), nullptr) << file;
  }
  EXPECT_NE((WordOr<Floor, std::string>("3").get<std::string>()), nullptr);  // where no number may stand
}

TEST(WordOr, KeepsTheTextAsGiven) {
  EXPECT_EQ(FloorLevelOrFile("+2.50").text(), "+2.50");
  EXPECT_EQ(FloorLevelOrFile(Floor::kNone).text(), "none");
  EXPECT_EQ(FloorLevelOrFile(Floor::kNone), FloorLevelOrFile("none"));
  EXPECT_FALSE(FloorLevelOrFile("2") == FloorLevelOrFile("2.0"));
}

TEST(WordOr, ThreeNumbersArePartedByCommas) {
  using FloorOrOffset = WordOr<Floor, ThreeNumbers, std::string>;
  EXPECT_EQ(*FloorOrOffset("0.02,-0.05,-19e-2").get<ThreeNumbers>(), (ThreeNumbers{0.02, -0.05, -0.19}));
  EXPECT_EQ(*FloorOrOffset(" 1, 2,  3").get<ThreeNumbers>(), (ThreeNumbers{1, 2, 3}));
  EXPECT_EQ(FloorOrOffset("rim").word(), Floor::kRim);
  for (const char* text : {"", "1", "1,2", "1,2,", "1,2,3,4", "1,2,3 ", "1 ,2,3", "1;2;3", "1,2,inf", "nan,1,2",
                           "+1,2,3", "1,2,1e999", "x,y,z"}) {
    EXPECT_EQ(FloorOrOffset(text).get<ThreeNumbers>(), nullptr) << text;
    ASSERT_NE(FloorOrOffset(text).get<std::string>(), nullptr) << text;
  }
  EXPECT_EQ(FloorOrOffset().word(), Floor::kNone);
}

TEST(WordOr, DescriptionsOfOptionsListTheWords) {
  struct Options {
    FloorLevelOrFile base = Floor::kRim;
  };
  const auto choices = Field{"base", &Options::base, "", ""}.choices();
  ASSERT_EQ(choices.size(), 2u);
  EXPECT_EQ(choices[1].word, "rim");
  EXPECT_EQ(choices[1].meaning, "the plane of the border");
}

TEST(Words, ATableIsInOrderWhereEveryValueHasItsRow) {
  struct Row {
    Floor floor;
  };
  constexpr Row kWhole[] = {{Floor::kNone}, {Floor::kRim}}, kSwapped[] = {{Floor::kRim}, {Floor::kNone}};
  EXPECT_TRUE(is_in_order(kWhole, 2, &Row::floor));
  EXPECT_FALSE(is_in_order(kWhole, 1, &Row::floor));
  EXPECT_FALSE(is_in_order(kWhole, 3, &Row::floor));
  EXPECT_FALSE(is_in_order(kSwapped, 2, &Row::floor));
}

}  // namespace
}  // namespace collinea
