// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Words = std::vector<std::string>;

std::string error_of(const Words& words) {
  const auto edit = parse_edit(words);
  return edit ? "" : edit.error().message;
}

// One command of each kind with everything that it can say, and with the least.
std::vector<Words> commands() {
  return {{"mark", "P1", "DJI_1.jpg", "1200.31", "800.2", "0.05"},
          {"mark", "P 1", "sub folder/a \"b\".jpg", "-0.5", "0"},
          {"unmark", "P1", "DJI_1.jpg"},
          {"point", "P1", "check", "500100.5", "5300000", "-4.25", "0.02", "0.02", "-"},
          {"point", "P1", "control", "-", "-", "12"},
          {"point", "P1", "control", "-", "-", "-", "-", "-", "-"},
          {"role", "P1", "check"},
          {"remove",
           "\xc3\x9c"
           "ber"},
          {"mask", "M1", "a b.jpg", "0", "0", "10.25", "0", "10", "5.5"},
          {"mask", "legs", "*", "0", "0", "10", "0", "10", "5", "0", "5"},
          {"unmask", "M1"},
          {"patch", "S1", "a.jpg", "500000.25", "5300000.5", "500010", "5300000", "500010", "5300010"},
          {"unpatch", "S1"},
          {"classify", "6", "410.5", "-", "500000.25", "5300000.5", "500010", "5300000", "500010", "5300010"},
          {"cut", "-", "410.5", "500000.25", "5300000.5", "500010", "5300000", "500010", "5300010"},
          {"crop", "-1", "1", "0", "0", "10", "0", "10", "5", "0", "5"},
          {"draw", "*", "roof", "point", "typed", "500000.25", "5300000.5", "-3"},
          {"draw", "F1",    "roof", "line", "mono",    "1",    "2",    "3",   "cov",    "1", "0", "0.5",
           "1",    "0",     "2",    "mark", "a b.jpg", "10.5", "20",   "0.5", "stereo", "1", "2", "4",
           "mark", "a.jpg", "1",    "2",    "0.5",     "mark", "mark", "3",   "4",      "1"},
          {"erase", "F1"},
          {"attribute", "F1", "use", ""},
          {"layer", "roof", "polygon", "#e67e22"},
          {"layer", "roof", "any", "#000000"},
          {"undo"},
          {"redo"}};
}

TEST(Edits, WordsComeBackFromWhatTheyMake) {
  std::vector<bool> seen(std::variant_size_v<Edit>);
  for (const Words& words : commands()) {
    const auto edit = parse_edit(words);
    ASSERT_TRUE(edit) << words[0] << ": " << edit.error().message;
    seen[edit->index()] = true;
    EXPECT_EQ(words_of(*edit), words);
    EXPECT_EQ(words_in_line(line_of(words)), words) << line_of(words);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), false), 0);  // one of each kind
}

TEST(Edits, NumbersComeBackBitByBit) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    MarkPoint mark{.point = "P", .image = "a", .pixel = {random.normal() * 1e4, random.uniform()}};
    mark.sigma_px = random.uniform() + 1e-9;
    const auto again = parse_edit(words_of(Edit(mark)));
    ASSERT_TRUE(again);
    const auto& read = std::get<MarkPoint>(*again);
    EXPECT_EQ(read.pixel, mark.pixel);
    EXPECT_EQ(read.sigma_px, mark.sigma_px);
  }
}

TEST(Edits, AWrongCommandSaysWhatIsWrong) {
  const struct {
    Words words;
    const char* part;
  } cases[] = {
      {{}, "no command is given"},
      {{"paint", "P1"},
       "\"paint\": one of mark, unmark, point, role, remove, mask, unmask, patch, unpatch, draw, erase, attribute, "
       "layer, classify, cut, crop, undo, redo"},
      {{"mark", "P1"}, "mark POINT IMAGE X Y [SIGMA_PX]"},
      {{"mark", "P1", "a.jpg", "1", "2", "3", "4"}, "mark POINT IMAGE"},
      {{"mark", "P1", "a.jpg", "one", "2"}, "X: \"one\""},
      {{"mark", "P1", "a.jpg", "1", "nan"}, "Y: \"nan\""},
      {{"mark", "P1", "a.jpg", "inf", "1"}, "X: \"inf\""},
      {{"mark", "P1", "a.jpg", "1", "1e999"}, "Y: \"1e999\""},
      {{"mark", "P1", "a.jpg", "1", "2", "0"}, "SIGMA_PX: a standard deviation"},
      {{"mark", "P1", "a.jpg", "1", "2", "-1"}, "SIGMA_PX: a standard deviation"},
      {{"mark", "", "a.jpg", "1", "2"}, "POINT: the name is empty"},
      {{"mark", "P\n1", "a.jpg", "1", "2"}, "control character"},
      {{"mark", "P1", std::string("a\0b", 3), "1", "2"}, "control character"},
      {{"mark", "P1", "\xff\xfe", "1", "2"}, "IMAGE: the name is not UTF-8"},
      {{"mark", std::string(501, 'x'), "a.jpg", "1", "2"}, "500 bytes"},
      {{"point", "P1", "main", "1", "2", "3"}, "\"main\" is no role"},
      {{"point", "P1", "check", "1", "2"}, "point NAME"},
      {{"point", "P1", "check", "-", "2", "3", "0.1", "0.1", "0.1"}, "SE: a standard deviation of a coordinate"},
      {{"point", "P1", "check", "1", "2", "3", "0.1", "0", "0.1"}, "SN"},
      {{"role", "P1", ""}, "no role"},
      {{"remove"}, "remove POINT"},
      {{"mask", "M", "a.jpg", "0", "0", "1", "1"}, "mask MASK IMAGE|*"},
      {{"mask", "M", "a.jpg", "0", "0", "1", "1", "2"}, "mask MASK IMAGE|*"},
      {{"mask", "M", "a.jpg", "0", "0", "1", "1", "2", "y"}, "Y: \"y\""},
      {{"mask", "M", "a.jpg", "0", "0", "1", "1", "2", "2"}, "encloses nothing"},
      {{"mask", "M", "a.jpg", "5", "5", "5", "5", "5", "5"}, "encloses nothing"},
      {{"mask", "-", "a.jpg", "0", "0", "1", "1", "2", "0"}, "cannot be a new name"},
      {{"patch", "S", "a.jpg", "0", "0", "1", "1", "2", "nan"}, "N: \"nan\""},
      {{"classify", "256", "-", "-", "0", "0", "1", "1", "2", "0"}, "CLASS: \"256\""},
      {{"classify", "2.5", "-", "-", "0", "0", "1", "1", "2", "0"}, "CLASS: \"2.5\""},
      {{"classify"}, "classify CLASS LOW|- HIGH|-"},
      {{"cut", "2", "1", "0", "0", "1", "1", "2", "0"}, "LOW: the lowest height 2 lies above the highest, 1"},
      {{"cut", "-", "high", "0", "0", "1", "1", "2", "0"}, "HIGH: \"high\""},
      {{"crop", "-", "-", "0", "0", "1", "1"}, "crop LOW|- HIGH|-"},
      {{"crop", "-", "-", "0", "0", "1", "1", "2", "2"}, "encloses nothing"},
      {{"draw", "*", "roof", "line", "typed", "1", "2", "3"}, "a line has 2 vertices or more, not 1"},
      {{"draw", "*", "roof", "point", "typed", "1", "2", "3", "typed", "1", "2", "3"}, "a point has 1 vertex, not 2"},
      {{"draw", "*", "roof", "blob", "typed", "1", "2", "3"}, "\"blob\" is no kind"},
      {{"draw", "*", "roof", "point", "guess", "1", "2", "3"}, "\"guess\" begins no vertex"},
      {{"draw", "*", "roof", "point", "typed", "1", "2", "nan"}, "H: \"nan\""},
      {{"draw", "*", "roof", "point", "typed", "1", "2", "3", "cov", "1", "2"}, "the command is written"},
      {{"draw", "*", "roof", "point", "typed", "1", "2", "3", "cov", "1", "2", "0", "1", "0", "1"}, "no covariance"},
      {{"draw", "*", "roof", "point", "typed", "1", "2", "3", "mark", "a.jpg", "1", "2", "0"}, "SIGMA_PX"},
      {{"draw", "a,b", "roof", "point", "typed", "1", "2", "3"}, "FEATURE: \"a,b\" cannot be a new name"},
      {{"attribute", "F1", "use", std::string(2001, 'x')}, "2000 bytes"},
      {{"attribute", "F1", "use", "a\nb"}, "control character"},
      {{"layer", "roof", "any", "red"}, "no colour"},
      {{"layer", "roof", "all", "#000000"}, "no kind"},
      {{"undo", "2"}, "undo"}};
  for (const auto& [words, part] : cases) EXPECT_NE(error_of(words).find(part), std::string::npos) << error_of(words);
}

TEST(Edits, ALineOfWordsThatDoesNotCloseIsRefused) {
  EXPECT_EQ(words_in_line("  mark \"P 1\"\ta.jpg  "), (Words{"mark", "P 1", "a.jpg"}));
  EXPECT_EQ(words_in_line(R"(a"b c"d "" "\"\\")"), (Words{"ab cd", "", "\"\\"}));
  EXPECT_EQ(words_in_line("C:\\a.jpg"), (Words{"C:\\a.jpg"}));  // a backslash is one outside quotation marks
  EXPECT_FALSE(words_in_line("mark \"P1"));
  EXPECT_FALSE(words_in_line("\"\\"));
}

template <class Kind>
constexpr int parts_changed(const Kind&) {
  return int(EditsPoint<Kind>) + int(EditsWork<Kind>) + int(std::is_same_v<Kind, Undo> || std::is_same_v<Kind, Redo>);
}

TEST(Edits, ThoseOfControlNameTheirPointAndChangeNothingElse) {
  for (const Words& words : commands()) {
    const Edit edit = parse_edit(words).value();
    EXPECT_EQ(std::visit([](const auto& kind) { return parts_changed(kind); }, edit), 1);
    const bool is_of_point =
        std::visit([](const auto& kind) { return EditsPoint<std::decay_t<decltype(kind)>>; }, edit);
    EXPECT_EQ(point_of(edit), is_of_point ? words[1] : "");
    EXPECT_EQ(is_of_history(edit), words[0] == "undo" || words[0] == "redo");
  }
}

}  // namespace
}  // namespace collinea
