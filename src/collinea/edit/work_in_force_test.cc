// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/work_in_force.h"

#include <gtest/gtest.h>

#include <set>

#include "collinea/base/file.h"
#include "collinea/edit/test_edits.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

class Work : public EditsTest {
 protected:
  std::string now() {
    EXPECT_TRUE(journal_.refresh());
    const EditContext context(setup_);
    return text_of(work_in_force(context, journal_.history()), setup_);
  }

  Block setup_ = setup_to_edit();
};

TEST_F(Work, IsWhatTheEditsInForceMakeWhateverIsUndoneAndRedone) {
  Random random(7);
  std::vector<std::string> states = {now()};
  std::set<std::string> kinds;
  while (states.size() <= 100) {
    const std::vector<std::string> words = any_work(random);
    if (!make(words).empty()) continue;
    kinds.insert(words[0]);
    states.push_back(now());
  }
  EXPECT_EQ(kinds.size(), 11u);
  for (std::size_t i = states.size() - 1; i > 0; --i) {
    ASSERT_EQ(make({"undo"}), "");
    EXPECT_EQ(now(), states[i - 1]) << i;
  }
  journal_ = Journal(project());
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_EQ(make({"redo"}), "");
    EXPECT_EQ(now(), states[i]) << i;
  }
}

TEST_F(Work, LeavesTheSetupAsItIs) {
  const std::uint64_t before = hash();
  ASSERT_EQ(make({"mask", "a", "photo 0.jpg", "0", "0", "10", "0", "10", "10"}), "");
  ASSERT_EQ(make({"patch", "a", "photo 0.jpg", "0", "0", "10", "0", "10", "10"}), "");
  EXPECT_EQ(hash(), before);
}

TEST_F(Work, AnEntryHoldsTheCommandsThatWouldBringBackWhatItReplaced) {
  const std::vector<std::string> first = {"mask", "a", "sub/photo 0.jpg", "0", "0", "10", "0", "10", "10"};
  ASSERT_EQ(make(first), "");
  ASSERT_EQ(make({"mask", "a", "*", "0", "0", "10", "0", "10", "20"}), "");
  ASSERT_EQ(make({"unmask", "a"}), "");
  std::vector<std::string> replaced;
  const std::string text = read_file(file()).value();
  for (const std::string_view line : lines_of(text)) {
    if (line.empty()) continue;
    const auto read = parse_journal_line(line);
    ASSERT_TRUE(read);
    for (const Words& words : read->replaced) replaced.push_back(line_of(words));
  }
  EXPECT_EQ(replaced, (std::vector<std::string>{"unmask a", line_of(first), "mask a * 0 0 10 0 10 20"}));
}

TEST_F(Work, IdsOfFeaturesAreGivenOnceWhateverIsUndoneOrErased) {
  const Words draw = {"draw", "*", "roof", "point", "typed", "1", "2", "3"};
  std::set<std::string> ids;
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(make(draw), "");
    const std::string id = std::get<DrawFeature>(journal_.history().entries().back().edit).feature;
    EXPECT_TRUE(ids.insert(id).second) << id;
    ASSERT_EQ(make(i % 2 == 0 ? Words{"undo"} : Words{"erase", id}), "");
  }
  EXPECT_EQ(*ids.rbegin(), "F4");
  ASSERT_EQ(make({"draw", "F9", "roof", "point", "typed", "1", "2", "3"}), "");  // by somebody else
  ASSERT_EQ(make(draw), "");
  EXPECT_EQ(std::get<DrawFeature>(journal_.history().entries().back().edit).feature, "F10");
  EXPECT_NE(make({"draw", "F4", "roof", "point", "typed", "1", "2", "3"}).find("F4 was erased"), std::string::npos);
  // One that leaves no number is not drawn, but a journal that has it is read as it always was.
  const Words last = {"draw", "F123456789012345", "roof", "point", "typed", "1", "2", "3"};
  EXPECT_NE(make(last).find("more than 14 digits"), std::string::npos);
  const auto parsed = parse_edit(last);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EditHistory history;
  ASSERT_TRUE(history.add(*parsed, ""));
  EXPECT_EQ(text_of(work_in_force(EditContext(setup_), history), setup_), line_of(last) + "; ");
}

TEST_F(Work, AFeatureThatIsDrawnAgainKeepsItsAttributesAndItsPlace) {
  for (const Words& words : {Words{"layer", "roof", "point", "#010203"},
                             {"draw", "*", "roof", "point", "typed", "1", "2", "3"},
                             {"draw", "*", "wall", "point", "typed", "1", "2", "3"},
                             {"attribute", "F1", "use", "shed"},
                             {"draw", "F1", "roof", "point", "typed", "7", "2", "3"}})
    ASSERT_EQ(make(words), "");
  EXPECT_EQ(
      now(),
      "layer roof point \"#010203\"; draw F1 roof point with use shed typed 7 2 3; draw F2 wall point typed 1 2 3; ");
  EXPECT_NE(make({"draw", "*", "roof", "line", "typed", "1", "2", "3", "typed", "1", "2", "4"}).find("as a point"),
            std::string::npos);
  EXPECT_NE(make({"layer", "wall", "line", "#010203"}).find("F2 on it is a point"), std::string::npos);
  EXPECT_EQ(make({"attribute", "F7", "use", "shed"}), "there is no feature F7");
  EXPECT_EQ(make({"erase", "F7"}), "there is no feature F7");
  EXPECT_NE(make({"draw", "*", "a", "point", "typed", "1", "2", "3", "mark", "none.jpg", "1", "2", "1"})
                .find("no image is called"),
            std::string::npos);
}

// One edit, one undo: what a person sees as drawing a coded feature, and as moving it with another code.
TEST_F(Work, AttributesOfADrawingCommandComeAndGoWithIt) {
  ASSERT_EQ(make({"draw", "*", "roof", "point", "with", "code", "R", "with", "use", "a shed", "typed", "1", "2", "3"}),
            "");
  const std::string first = now();
  EXPECT_EQ(first, "draw F1 roof point with code R with use \"a shed\" typed 1 2 3; ");
  ASSERT_EQ(make({"draw", "F1", "roof", "point", "with", "code", "-", "with", "state", "new", "typed", "7", "2", "3"}),
            "");
  EXPECT_EQ(now(), "draw F1 roof point with state new with use \"a shed\" typed 7 2 3; ");
  const std::string text = read_file(file()).value();
  const auto last = parse_journal_line(lines_of(text)[1]);
  ASSERT_TRUE(last && last->replaced.size() == 1);
  ASSERT_EQ(make(last->replaced[0]), "");  // what is written there brings it back
  EXPECT_EQ(now(), first);
  ASSERT_EQ(make({"undo"}), "");
  ASSERT_EQ(make({"undo"}), "");
  EXPECT_EQ(now(), first);
  ASSERT_EQ(make({"undo"}), "");
  EXPECT_EQ(now(), "");
  for (const Words& wrong :
       {Words{"draw", "*", "a", "point", "with", "code"},
        {"draw", "*", "a", "point", "with", "code", "R", "with", "code", "S", "typed", "1", "2", "3"},
        {"draw", "*", "a", "point", "with", "-", "R", "typed", "1", "2", "3"}})
    EXPECT_FALSE(parse_edit(wrong));
}

// A feature has at most SetAttribute::kMost attributes, but a command names what it takes back as well.
TEST_F(Work, AllAttributesOfAFeatureAreReplacedByOneCommandAndComeBack) {
  const auto with = [](Words words, char letter, bool set) {
    for (std::size_t i = 0; i < SetAttribute::kMost; ++i)
      words.insert(words.end(), {"with", letter + std::to_string(i), set ? "x" : "-"});
    return words;
  };
  const auto drawn = [](Words words) {
    words.insert(words.end(), {"typed", "1", "2", "3"});
    return words;
  };
  const Words draw = {"draw", "F1", "roof", "point"};
  ASSERT_EQ(make(drawn(with(draw, 'a', true))), "");
  const std::string first = now();
  EXPECT_NE(make(drawn(with(draw, 'b', true))).find("at most 100 attributes"), std::string::npos);
  ASSERT_EQ(make(drawn(with(with(draw, 'a', false), 'b', true))), "");
  EXPECT_NE(now(), first);
  const std::string text = read_file(file()).value();
  const auto last = parse_journal_line(lines_of(text)[1]);
  ASSERT_TRUE(last && last->replaced.size() == 1);
  ASSERT_EQ(make(last->replaced[0]), "");
  EXPECT_EQ(now(), first);
}

// Features are found by their ids at once: each of 20,000 is drawn, given an attribute, drawn again and half are
// erased. By looking at all of them for each that would be 10^9 comparisons of texts.
TEST(WorkInForce, ABigDrawingIsReplayedInTheOrderItWasDrawn) {
  constexpr int kFeatures = 20'000;
  EditHistory history;
  const DrawnVertex vertex{.position = {1, 2, 3}, .covariance_m2 = {}};
  const auto id = [](int i) { return DrawFeature::id_of(std::uint64_t(i + 1)); };
  for (int i = 0; i < kFeatures; ++i)
    ASSERT_TRUE(history.add(DrawFeature{id(i), "a", VectorKind::kPoint, {vertex}}, ""));
  for (int i = kFeatures; i-- > 0;) ASSERT_TRUE(history.add(SetAttribute{id(i), "code", "R"}, ""));
  for (int i = 0; i < kFeatures; i += 2) ASSERT_TRUE(history.add(EraseFeature{id(i)}, ""));
  for (int i = 1; i < kFeatures; i += 2)
    ASSERT_TRUE(history.add(DrawFeature{id(i), "b", VectorKind::kPoint, {vertex}}, ""));
  const Block setup = setup_to_edit();
  std::vector<UnfitEdit> unfit;
  const Drawing drawing = work_in_force(EditContext(setup), history, &unfit).drawing;
  EXPECT_TRUE(unfit.empty());
  EXPECT_EQ(drawing.features.size(), std::size_t(kFeatures / 2));
  int next = 1;
  for (const DrawnFeature& one : drawing.features) {
    ASSERT_EQ(one.id, id(next));
    ASSERT_EQ(drawing.features.find(one.id), &one);
    EXPECT_TRUE(one.layer == "b" && one.attributes.at("code") == "R");
    next += 2;
  }
  EXPECT_EQ(drawing.features.find(id(0)), nullptr);
}

TEST_F(Work, WhatDoesNotFitIsRefusedAndAfterAnotherImportLeftOut) {
  EXPECT_NE(make({"mask", "a", "photo 9.jpg", "0", "0", "10", "0", "10", "10"}).find("no image is called"),
            std::string::npos);
  EXPECT_EQ(make({"unmask", "a"}), "there is no mask a");
  EXPECT_EQ(make({"unpatch", "a"}), "there is no patch a");
  ASSERT_EQ(make({"mask", "a", "photo 3.jpg", "0", "0", "10", "0", "10", "10"}), "");
  ASSERT_EQ(make({"mask", "b", "photo 1.jpg", "0", "0", "10", "0", "10", "10"}), "");
  setup_.images.erase({3});
  std::vector<UnfitEdit> unfit;
  const EditContext context(setup_);
  EXPECT_EQ(work_in_force(context, journal_.history(), &unfit).masks.size(), 1u);
  ASSERT_EQ(unfit.size(), 1u);
  EXPECT_EQ(unfit[0].number, 1u);
}

}  // namespace
}  // namespace collinea
