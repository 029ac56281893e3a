// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>

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
  EXPECT_EQ(verdict.error().message, "coats = 12 is out of range: 1 to 9");
  EXPECT_EQ(verdict.error().options, std::vector{"coats"_option});
}

enum class Finish { kMatt, kSatin, kMirror };
constexpr Word<Finish> kFinishWords[] = {
    {Finish::kMatt, "matt"}, {Finish::kSatin, "satin", "a little shine"}, {Finish::kMirror, "mirror"}};
constexpr std::span<const Word<Finish>> words(Finish) { return kFinishWords; }
constexpr std::array kWallFinishes = {Finish::kMatt, Finish::kSatin};

struct RoomOptions {
  PaintOptions walls;
  PaintOptions ceiling;
  std::optional<Finish> finish;
  std::filesystem::path plan;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RoomOptions;
    visit(Part{&O::walls});
    visit(Field{"finish", &O::finish, "", "of the walls"}.or_auto("by the light").one_of(kWallFinishes));
    visit(Field{"plan", &O::plan, "", "drawing"}.leads_to(PathKind::kFile));
    visit(Group{"ceiling", &O::ceiling});
  }
};

TEST(Words, EveryValueComesBackFromItsWord) {
  for (const auto& [value, word, meaning] : kFinishWords) {
    EXPECT_EQ(word_of(value), word);
    EXPECT_EQ(from_word<Finish>(word), value);
  }
  EXPECT_FALSE(from_word<Finish>("Matt"));
  EXPECT_FALSE(from_word<Finish>(""));
}

TEST(Words, AreListedAsPeopleDo) {
  const std::array<std::string_view, 3> three = {"las", "laz", "copc"};
  EXPECT_EQ(listed(three), "las, laz or copc");
  EXPECT_EQ(listed(std::span(three).first(1)), "las");
  EXPECT_EQ(listed({}), "");
}

TEST(Options, PartsAreStatedAmongTheFieldsAndGroupsByThemselves) {
  std::string names;
  RoomOptions room;
  for_each_group("room", room, [&](const std::string& group, auto& part) {
    names += group + ":";
    for_each_field(part, [&](const auto& field, auto&) { names += " " + std::string(field.name); });
    names += "; ";
  });
  EXPECT_EQ(names, "room: coats brushes glossy finish plan; ceiling: coats brushes glossy; ");
}

TEST(Options, WhatIsWrongInPartsAndGroupsIsFound) {
  EXPECT_TRUE(validate(RoomOptions{}));
  EXPECT_FALSE(validate(RoomOptions{.walls = {.brushes = 0}}));
  EXPECT_FALSE(validate(RoomOptions{.ceiling = {.coats = 0}}));
}

TEST(Options, OnlyTheChoicesOfAFieldAreTaken) {
  EXPECT_TRUE(validate(RoomOptions{.finish = Finish::kSatin}));
  const auto verdict = validate(RoomOptions{.finish = Finish::kMirror});
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().message, "finish = \"mirror\": choose auto, matt or satin");
}

TEST(Options, AreCopiedByName) {
  RoomOptions from{.walls = {.coats = 5, .brushes = 3}, .finish = Finish::kMatt}, to;
  assign_fields(from, to, [](std::string_view name) { return name == "coats" || name == "finish"; });
  EXPECT_EQ(to.walls.coats, 5);
  EXPECT_EQ(to.walls.brushes, 1);
  EXPECT_EQ(to.finish, Finish::kMatt);
}

TEST(Error, GathersTheOptionsItIsAbout) {
  const Error error =
      Error{Errc::kBadInput, "no CRS"}.within("control.csv").about("crs"_option).about("control"_option);
  EXPECT_EQ(error.message, "control.csv: no CRS");
  EXPECT_EQ(error.options, (std::vector{"crs"_option, "control"_option}));
}

}  // namespace
}  // namespace collinea
