// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "collinea/app/command_for_tests.h"
#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/edit/journal.h"
#include "collinea/project/settings.h"
#include "collinea/store/project_store.h"

namespace collinea {
namespace {

using testing::collinea_with;
using testing::Outcome;

/// Projects with two photographs and one point.
class EditCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    Block block;
    block.georeference = Georeference{"EPSG:32633", 48.2, 15.63, 300};
    block.cameras[{0}] = ideal_camera(3000, 4000, 3000);
    for (std::uint32_t i = 0; i < 2; ++i) {
      block.images[{i}].file = i == 0 ? "a.jpg" : "b c.jpg";
      block.images[{i}].camera = {0};
    }
    block.control[{0}] = {"P1", ControlRole::kControl, {546800, 5338600, 300}, {1, 2, 3}, {0.1, 0.1, 0.1}};
    for (const std::string& project : {project_, other_}) {
      std::filesystem::create_directories(project);
      ASSERT_TRUE(write_settings(project, {}));
      ASSERT_TRUE(ProjectStore::open(project).and_then([&](ProjectStore store) { return store.write_setup(block); }));
    }
  }
  Outcome edit(std::vector<std::string> words) { return edit_in(project_, std::move(words)); }
  static Outcome edit_in(const std::string& project, std::vector<std::string> words) {
    words.insert(words.begin(), {"edit", project});
    return collinea_with(words);
  }

  TestFolder folder_;
  std::string project_ = (folder_ / "project").string(), other_ = (folder_ / "other").string();
};

TEST_F(EditCommand, MakesListsUndoesAndReplays) {
  EXPECT_EQ(edit({"mark", "P1", "a.jpg", "12.5", "30.25", "0.3"}).out, "edit 1: mark P1 a.jpg 12.5 30.25 0.3\n");
  EXPECT_EQ(edit({"mark", "P1", "b c.jpg", "1", "2"}).out, "edit 2: mark P1 \"b c.jpg\" 1 2 0.5\n");
  EXPECT_EQ(edit({"point", "N", "check", "-", "-", "-3.5"}).out, "edit 3: point N check - - -3.5 - - 0.02\n");
  EXPECT_EQ(edit({"undo"}).out, "edit 4: undo point N check - - -3.5 - - 0.02\n");
  const Outcome list = edit({"list"});
  EXPECT_EQ(list.code, 0);
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 4);
  EXPECT_NE(list.out.find("undone  point N"), std::string::npos) << list.out;
  EXPECT_NE(list.out.find("undo (edit 3)"), std::string::npos) << list.out;
  const auto json = nlohmann::json::parse(edit({"list", "--json"}).out);
  EXPECT_EQ(json.at("number"), 4);
  EXPECT_EQ(json.at("redo"), "point N check - - -3.5 - - 0.02");
  EXPECT_EQ(edit_in(other_, {"replay", project_ + "/journal.jsonl"}).out,
            "edit 1: mark P1 a.jpg 12.5 30.25 0.3\nedit 2: mark P1 \"b c.jpg\" 1 2 0.5\n");
  EXPECT_EQ(ProjectStore::open(project_)->setup_hash().value(), ProjectStore::open(other_)->setup_hash().value());
  EXPECT_EQ(edit({"redo", "--json"}).out, "{\"number\":5}\n");
}

TEST_F(EditCommand, AListThatDoesNotFitMakesNothing) {
  ASSERT_TRUE(write_file(folder_ / "list", "role P1 check\nmark P1 d.jpg 1 2\n"));
  const Outcome outcome = edit({"replay", (folder_ / "list").string()});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("mark P1 d.jpg 1 2: no image is called d.jpg"), std::string::npos) << outcome.err;
  EXPECT_EQ(edit({"list"}).out, "");
  ASSERT_TRUE(write_file(folder_ / "list", "role P1 check\nrole P1\n"));
  const Outcome wrong = edit({"replay", (folder_ / "list").string()});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("list: line 2: the command is written: role NAME"), std::string::npos) << wrong.err;
}

TEST_F(EditCommand, WrongWordsEndWithTwoAndMissingThingsWithThree) {
  EXPECT_EQ(edit({"paint"}).code, 2);
  EXPECT_NE(edit({"paint"}).err.find("or list, replay"), std::string::npos);
  EXPECT_EQ(edit({}).code, 2);
  EXPECT_EQ(edit({"replay"}).code, 2);
  EXPECT_EQ(edit({"mark", "P1", "a.jpg", "-1", "2"}).code, 2);
  EXPECT_EQ(edit({"mark", "P2", "a.jpg", "1", "2"}).code, 3);
  EXPECT_EQ(edit({"replay", "none"}).code, 3);
  EXPECT_EQ(edit_in((folder_ / "none").string(), {"list"}).code, 3);
  EXPECT_EQ(edit_in((folder_ / "none").string(), {"undo"}).code, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none"));
}

}  // namespace
}  // namespace collinea
