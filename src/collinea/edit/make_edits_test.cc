// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/make_edits.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/edit/read_edits.h"
#include "collinea/edit/test_edits.h"
#include "collinea/store/sqlite.h"

namespace collinea {
namespace {

using MakeEdits = EditsTest;

TEST_F(MakeEdits, AMarkTakesThePlaceOfAllEarlierOnesInThatImage) {
  const std::uint64_t before = hash();
  EXPECT_EQ(make({"mark", "B", "photo 0.jpg", "12.5", "30.25"}), "");
  EXPECT_EQ(marks_of("B"), (std::vector<std::string>{"mark B 2 10.5 20.25 0.5", "mark B 0 12.5 30.25 0.5"}));
  EXPECT_EQ(make({"mark", "A", "SUB/photo 0.jpg", "1", "2", "0.05"}), "");
  EXPECT_EQ(marks_of("A"), (std::vector<std::string>{"mark A 0 1 2 0.05", "mark A 1 0.3333333333333333 200 0.25"}));
  EXPECT_NE(hash(), before);
  EXPECT_EQ(make({"unmark", "A", "photo 0.jpg"}), "");
  EXPECT_EQ(marks_of("A").size(), 1u);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(make({"undo"}), "");
  EXPECT_EQ(marks_of("A").size(), 3u);
  EXPECT_EQ(make({"undo"}), "");
  EXPECT_EQ(hash(), before);
  // The journal holds the image as the block calls it, and the standard deviation that was meant.
  EXPECT_EQ(line_of(words_of(journal_.history().at(1).edit)), "mark B \"sub/photo 0.jpg\" 12.5 30.25 0.5");
}

TEST_F(MakeEdits, StandardDeviationsThatAreNotSaidAreThoseOfTheProject) {
  Settings settings;
  settings.import.control_sigma_px = 0.125;
  settings.import.control_sigma_m = 0.0625;
  ASSERT_TRUE(write_settings(project(), settings));
  EXPECT_EQ(make({"mark", "B", "photo 0.jpg", "1", "2"}), "");
  EXPECT_EQ(marks_of("B").back(), "mark B 0 1 2 0.125");
  EXPECT_EQ(make({"point", "N", "control", "546810", "5338610", "-"}), "");
  EXPECT_EQ(point("N")->sigma_m.x(), 0.0625);
  EXPECT_TRUE(std::isinf(point("N")->sigma_m.z()));
}

TEST_F(MakeEdits, APointLiesInTheWorldWhereTheMapHasIt) {
  EXPECT_EQ(make({"point", "N 1", "check", "546810.25", "5338610.5", "310.125", "0.01", "0.02", "-"}), "");
  const auto added = point("N 1");
  ASSERT_TRUE(added);
  EXPECT_EQ(added->role, ControlRole::kCheck);
  EXPECT_EQ(added->position_in_map, Eigen::Vector3d(546810.25, 5338610.5, 310.125));
  const LocalFrame frame = world_frame(*setup_to_edit().georeference).value();
  EXPECT_EQ(added->position_in_world, frame.local_from_map(added->position_in_map));
  EXPECT_LT((frame.map_from_local(added->position_in_world) - added->position_in_map).norm(), 1e-6);
  // A change keeps the marks.
  EXPECT_EQ(make({"mark", "N 1", "photo 3.jpg", "4000", "0"}), "");
  EXPECT_EQ(make({"point", "N 1", "control", "-", "-", "311", "-", "-", "0.5"}), "");
  EXPECT_EQ(marks_of("N 1").size(), 1u);
  EXPECT_EQ(point("N 1")->sigma_m.z(), 0.5);
  EXPECT_TRUE(std::isinf(point("N 1")->sigma_m.x()));
  EXPECT_EQ(make({"role", "N 1", "check"}), "");
  EXPECT_EQ(point("N 1")->role, ControlRole::kCheck);
}

TEST_F(MakeEdits, WhatDoesNotFitIsRefusedInWordsAndLeavesNothing) {
  const struct {
    std::vector<std::string> words;
    const char* part;
  } cases[] = {{{"mark", "N", "photo 0.jpg", "1", "2"}, "there is no point N: add it first (point N control E N H"},
               {{"mark", "A", "photo 9.jpg", "1", "2"}, "no image is called photo 9.jpg"},
               {{"mark", "A", "photo 0.jpg", "4000.5", "2"}, "outside sub/photo 0.jpg, which has 4000 x 3000 pixels"},
               {{"mark", "A", "photo 0.jpg", "1", "-0.001"}, "outside"},
               {{"unmark", "A", "photo 2.jpg"}, "point A is not marked in sub/photo 2.jpg"},
               {{"role", "N", "check"}, "there is no point N"},
               {{"remove", "N"}, "there is no point N"},
               {{"remove", "A"}, "measurements on the ground name point A"},
               {{"point", "a,b", "check", "1", "2", "3"}, "cannot be a new name"},
               {{"point", "-", "check", "1", "2", "3"}, "cannot be a new name"},
               {{"point", "N", "check", "5338610", "546810", "300"}, "from the project: coordinates are easting"},
               {{"point", "N", "check", "1e300", "1", "1"}, "from the project"},
               {{"undo"}, "nothing to undo"},
               {{"redo"}, "nothing to redo"}};
  const std::uint64_t before = hash();
  for (const auto& [words, part] : cases) {
    const std::string error = make(words);
    EXPECT_NE(error.find(part), std::string::npos) << words[0] << ": " << error;
  }
  EXPECT_EQ(read_file(file()).value_or(""), "");
  EXPECT_EQ(hash(), before);
  EXPECT_EQ(store().last_edit(), 0u);
}

TEST_F(MakeEdits, WithoutAMapOnlyPointsWithoutCoordinatesCanBeAdded) {
  Block block = setup_to_edit();
  block.georeference.reset();
  ASSERT_TRUE(store().write_setup(block));
  EXPECT_NE(make({"point", "N", "control", "1", "2", "3"}).find("no map"), std::string::npos);
  EXPECT_EQ(make({"point", "N", "control", "-", "-", "-"}), "");
  EXPECT_EQ(make({"mark", "N", "photo 0.jpg", "1", "2"}), "");
  EXPECT_FALSE(point("N")->sigma_m.array().isFinite().any());
}

TEST_F(MakeEdits, BeforeAnImportTheyAreRefused) {
  std::filesystem::remove(folder_ / "block.db");
  EXPECT_NE(make({"remove", "B"}).find("import some first"), std::string::npos);
}

TEST_F(MakeEdits, AnEntryHoldsTheCommandsThatWouldBringBackWhatItReplaced) {
  ASSERT_EQ(make({"mark", "B", "photo 0.jpg", "1", "2"}), "");
  ASSERT_EQ(make({"mark", "B", "photo 2.jpg", "1", "2"}), "");
  ASSERT_EQ(make({"role", "B", "check"}), "");
  ASSERT_EQ(make({"remove", "B"}), "");
  ASSERT_EQ(make({"point", "N", "check", "-", "-", "-"}), "");
  std::vector<std::string> replaced;
  const std::string text = read_file(file()).value();
  for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1) {
    const auto line = parse_journal_line(text.substr(begin, text.find('\n', begin) - begin));
    ASSERT_TRUE(line);
    std::string all;
    for (const Words& words : line->replaced) all += line_of(words) + "; ";
    replaced.push_back(all);
  }
  EXPECT_EQ(replaced,
            (std::vector<std::string>{
                "unmark B \"sub/photo 0.jpg\"; ", "mark B \"sub/photo 2.jpg\" 10.5 20.25 0.5; ", "role B control; ",
                "point B check 546810 5338600 301 0.01 0.02 0.03; mark B \"sub/photo 0.jpg\" 1 2 0.5; "
                "mark B \"sub/photo 2.jpg\" 1 2 0.5; ",
                "remove N; "}));
}

// What a setup shall be by a history, found without what the database remembers between edits.
std::uint64_t hash_anew(const std::filesystem::path& folder, const Block& imported, Journal& journal) {
  auto store = ProjectStore::open(folder).value();
  EXPECT_TRUE(write_setup_with_edits(store, imported, journal));
  return store.setup_hash().value();
}

// 200 random edits of all kinds, with some undone and redone between: the setup is at each undo what it was before, and
// after all redos what it was at the end, also as the journal alone makes it.
TEST_F(MakeEdits, ManyOfAllKindsCanBeUndoneAndRedone) {
  Random random(11);
  std::vector<std::uint64_t> hashes = {hash()};
  std::set<std::string> kinds;
  int refused = 0;
  while (hashes.size() <= 200) {
    const std::vector<std::string> words = any_command(random);
    if (!make(words).empty()) {
      ++refused;
      continue;
    }
    kinds.insert(words[0]);
    hashes.push_back(hash());
    if (random.below(8) > 0) continue;
    ASSERT_EQ(make({"undo"}), "");
    EXPECT_EQ(hash(), hashes[hashes.size() - 2]);
    if (random.below(2) > 0) {
      hashes.pop_back();  // the next edit ends what could be redone
      continue;
    }
    ASSERT_EQ(make({"redo"}), "");
    EXPECT_EQ(hash(), hashes.back());
  }
  while (make({"redo"}).empty()) hashes.push_back(hash());
  EXPECT_EQ(kinds.size(), 5u);
  EXPECT_LT(refused, 400);
  const TestFolder* const folder = &folder_;
  std::filesystem::create_directories(*folder / "anew");
  EXPECT_EQ(hash_anew(folder_ / "anew", setup_to_edit(), journal_), hashes.back());
  for (std::size_t i = hashes.size() - 1; i > 0; --i) {
    ASSERT_EQ(make({"undo"}), "");
    EXPECT_EQ(hash(), hashes[i - 1]) << i;
  }
  EXPECT_EQ(make({"undo"}), "there is nothing to undo");
  journal_ = Journal(project());  // as after a restart
  for (std::size_t i = 1; i < hashes.size(); ++i) {
    ASSERT_EQ(make({"redo"}), "");
    EXPECT_EQ(hash(), hashes[i]) << i;
  }
  EXPECT_EQ(make({"redo"}), "there is nothing to redo");
}

TEST_F(MakeEdits, ImportedAnewTheyAreStillInForceAndWhatFitsNoMoreIsNamed) {
  ASSERT_EQ(make({"mark", "B", "photo 0.jpg", "1", "2"}), "");
  ASSERT_EQ(make({"mark", "B", "photo 3.jpg", "5", "6"}), "");
  ASSERT_EQ(make({"point", "N", "check", "546810", "5338610", "310"}), "");
  ASSERT_EQ(make({"mark", "N", "photo 1.jpg", "7", "8"}), "");
  ASSERT_EQ(make({"mark", "C", "photo 1.jpg", "9", "10"}), "");
  ASSERT_EQ(make({"role", "C", "check"}), "");
  ASSERT_EQ(make({"undo"}), "");
  // The last photograph and the point C are gone, there is another photograph, and B was surveyed anew.
  Block block = setup_to_edit();
  block.images.erase({3});
  block.images[{7}] = {.file = "sub/photo 00.jpg", .camera = {0}};
  block.control.erase({2});
  block.control_observations.pop_back();
  block.control.at({1}).position_in_map.x() += 1;
  auto opened = store();
  const auto unfit = write_setup_with_edits(opened, block, journal_);
  ASSERT_TRUE(unfit) << unfit.error().message;
  ASSERT_EQ(unfit->size(), 2u);
  EXPECT_EQ((*unfit)[0].number, 2u);
  EXPECT_EQ((*unfit)[0].command, "mark B \"sub/photo 3.jpg\" 5 6 0.5");
  EXPECT_NE((*unfit)[0].why.message.find("no image is called sub/photo 3.jpg"), std::string::npos);
  EXPECT_EQ((*unfit)[1].point, "C");
  EXPECT_EQ(marks_of("B"), (std::vector<std::string>{"mark B 2 10.5 20.25 0.5", "mark B 0 1 2 0.5"}));
  EXPECT_EQ(marks_of("N"), (std::vector<std::string>{"mark N 1 7 8 0.5"}));
  EXPECT_EQ(point("B")->position_in_map.x(), 546811);  // the file's, not what an edit replaced
  EXPECT_EQ(make({"mark", "B", "photo 00.jpg", "3", "4"}), "");
  EXPECT_EQ(marks_of("B").size(), 3u);
  // All undone, the setup is what was imported now.
  while (make({"undo"}).empty()) {
  }
  const std::uint64_t undone = hash();
  ASSERT_TRUE(store().write_setup(block));
  EXPECT_EQ(hash(), undone);
}

TEST_F(MakeEdits, ThoseThatWaitAreTakenIntoTheDatabaseLater) {
  auto writer = sqlite::Database::open(folder_ / "block.db").value();
  const std::vector<Edit> edits = {edit({"mark", "B", "photo 0.jpg", "1", "2"})};
  const std::uint64_t before = hash();
  {
    const auto busy = sqlite::Transaction::begin(writer);  // a step that writes for long
    ASSERT_TRUE(busy);
    for (int i = 0; i < 2; ++i) {
      const auto made = make_edits(project(), journal_, edits);
      ASSERT_TRUE(made) << made.error().message;
      EXPECT_TRUE(made->waiting);
    }
    EXPECT_EQ(journal_.number(), 2u);
  }
  EXPECT_EQ(hash(), before);
  auto opened = store();
  Journal other(project());
  ASSERT_TRUE(apply_edits(opened, other));
  EXPECT_EQ(opened.last_edit(), 2u);
  EXPECT_EQ(marks_of("B").size(), 2u);
}

TEST_F(MakeEdits, AJournalThatIsGoneLeavesWhatWasImported) {
  const std::uint64_t before = hash();
  ASSERT_EQ(make({"remove", "B"}), "");
  ASSERT_EQ(make({"point", "N", "check", "-", "-", "-"}), "");
  std::filesystem::remove(file());
  auto opened = store();
  ASSERT_TRUE(apply_edits(opened, journal_));
  EXPECT_EQ(hash(), before);
}

TEST_F(MakeEdits, ARemovedPointIsThereForWhatWasMadeWithIt) {
  Block oriented = setup_to_edit();
  for (const auto& [id, image] : oriented.images) set_pose(oriented, id, {});
  ASSERT_TRUE(store().write_orientation(oriented));
  ASSERT_EQ(make({"remove", "B"}), "");
  EXPECT_FALSE(store().read_setup()->control.contains({1}));
  const auto block = store().read_block();
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_EQ(block->control.at({1}).name, "B");
  EXPECT_EQ(block->control_observations.size(), oriented.control_observations.size());
  EXPECT_EQ(store().read_setup_for_names()->control.at({1}).name, "B");
  // A step that began with it may end later.
  ASSERT_TRUE(store().write_orientation(oriented));
  EXPECT_TRUE(store().read_found()->control.contains({1}));
  // One that began without it ends its use.
  ASSERT_TRUE(store().write_orientation(store().read_setup().value()));
  EXPECT_FALSE(store().read_block()->control.contains({1}));
  EXPECT_TRUE(store().read_setup_for_names()->control.contains({1}));  // an adjustment before may name it
  ASSERT_EQ(make({"undo"}), "");
  EXPECT_TRUE(store().read_setup()->control.contains({1}));
}

TEST(ReadEdits, OfAListAndOfAJournalThoseInForceAreTaken) {
  const auto lines = [](std::string_view text) {
    const auto edits = read_edits(text);
    std::vector<std::string> all;
    if (!edits) return std::vector<std::string>{edits.error().message};
    for (const Edit& edit : *edits) all.push_back(line_of(words_of(edit)));
    return all;
  };
  using Lines = std::vector<std::string>;
  EXPECT_EQ(lines("# by hand\n\n  role A check\r\nmark \"P 1\" a.jpg 1 2\nundo\nremove B"),
            (Lines{"role A check", "remove B"}));
  const std::string journal = text_of({1, "", Edit(RemovePoint{"A"})}) + "\n" + text_of({2, "", Undo{}}) + "\n" +
                              text_of({3, "", Edit(RemovePoint{"B"})}) + "\n";
  EXPECT_EQ(lines(journal), Lines{"remove B"});
  EXPECT_EQ(lines(journal + "{\"number\":4,\"ti"), Lines{"remove B"});
  EXPECT_EQ(lines("role A check\nrole A main\n"), Lines{"line 2: \"main\" is no role: control or check"});
  EXPECT_EQ(lines("undo\n"), Lines{"line 1: there is nothing to undo"});
}

}  // namespace
}  // namespace collinea
