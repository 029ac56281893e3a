// SPDX-License-Identifier: Apache-2.0
// What steps make of edits: before a run, while a step is at work, and when photographs are imported anew.
#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/edit/make_edits.h"
#include "collinea/import/test_photographs.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"
#include "collinea/steps/test_small_project.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Steps = std::vector<std::string>;

// As another program: with a journal of its own.
std::string edit(const fs::path& project, const std::vector<std::string>& words) {
  Journal journal(project);
  const std::vector<Edit> edits = {parse_edit(words).value()};
  const auto made = make_edits(project, journal, edits);
  return made ? "" : made.error().message;
}

Result<Steps> bring(const fs::path& folder, Step last, Run run = {}) {
  Log log;
  run.log = log.run().log;
  COLLINEA_TRY(const Settings settings, read_settings(folder));
  COLLINEA_TRY(Project project, create_project(folder, settings, run));
  COLLINEA_TRY(bring_up_to(project, last));
  return log.steps_done();
}

/// A simulated survey, adjusted.
class EditsFlow : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(open_small_survey(folder()));
    const auto done = bring(folder(), Step::kAdjust);
    ASSERT_TRUE(done) << done.error().message;
    ASSERT_EQ(*done, (Steps{"orient", "adjust"}));
    const Block setup = store().read_setup().value();
    ASSERT_FALSE(setup.control_observations.empty());
    const ControlObservation& seen = setup.control_observations.front();
    point_ = setup.control.at(seen.point).name;
    image_ = setup.images.at(seen.image).file;
    pixel_ = seen.pixel;
  }
  [[nodiscard]] fs::path folder() const { return folder_ / "project"; }
  [[nodiscard]] ProjectStore store() const { return ProjectStore::open(folder()).value(); }
  /// Of poses and of what is recorded of the control.
  [[nodiscard]] std::string result() const {
    const auto opened = store();
    std::string text;
    for (const auto& [image, pose] : oriented_images(opened.read_block().value()))
      for (const double value : {pose.translation.x(), pose.translation.y(), pose.translation.z(), pose.rotation.w()})
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
    return text + packed(StepOutcome(opened.read_outcome<AdjustmentRecord>().value()));
  }
  [[nodiscard]] std::vector<std::string> moved(double by_px) const {
    return {"mark", point_, image_, std::to_string(pixel_.x() + by_px), std::to_string(pixel_.y()), "0.3"};
  }

  TestFolder folder_;
  std::string point_, image_;
  Eigen::Vector2d pixel_ = Eigen::Vector2d::Zero();
};

TEST_F(EditsFlow, AnEditMakesOrientAndAdjustAnewAndUndoneTheResultIsAsBefore) {
  const std::string before = result();
  EXPECT_EQ(bring(folder(), Step::kAdjust), Steps{});
  ASSERT_EQ(edit(folder(), moved(0.75)), "");
  EXPECT_EQ(bring(folder(), Step::kAdjust), (Steps{"orient", "adjust"}));
  EXPECT_NE(result(), before);
  ASSERT_EQ(edit(folder(), {"undo"}), "");
  EXPECT_EQ(bring(folder(), Step::kAdjust), (Steps{"orient", "adjust"}));
  EXPECT_EQ(result(), before);
}

TEST_F(EditsFlow, APointThatIsRemovedIsUsedNoMore) {
  const std::size_t before = store().read_outcome<AdjustmentRecord>()->control.size();
  ASSERT_EQ(edit(folder(), {"remove", point_}), "");
  EXPECT_EQ(store().read_outcome<AdjustmentRecord>()->control.size(), before);
  EXPECT_EQ(bring(folder(), Step::kAdjust), (Steps{"orient", "adjust"}));
  EXPECT_EQ(store().read_outcome<AdjustmentRecord>()->control.size(), before - 1);
  EXPECT_EQ(store().read_outcome<ImportRecord>()->control_points, store().read_setup()->control.size());
}

// Whether the step at work saw the edit or not: the next run makes it anew, also when it is undone meanwhile.
TEST_F(EditsFlow, WhatComesWhileAStepIsAtWorkCountsAtTheNextRun) {
  const std::string before = result();
  for (const double when : {0.0, 1.0})  // before it reads anything, and behind its work
    for (const bool undone : {false, true}) {
      SCOPED_TRACE(std::to_string(when) + (undone ? " undone" : ""));
      ASSERT_EQ(edit(folder(), {"role", point_, "check"}), "");  // so that there is something to do
      bool made = false;
      collinea::Run run;
      run.progress = [&](std::string_view stage, double done) {
        if (made || stage != "orient" || done != when) return;
        made = true;
        EXPECT_EQ(edit(folder(), moved(0.75)), "");
        EXPECT_EQ(
            edit(folder(), undone ? std::vector<std::string>{"undo"} : std::vector{std::string("remove"), point_}), "");
      };
      const auto done = bring(folder(), Step::kAdjust, run);
      ASSERT_TRUE(done) << done.error().message;
      ASSERT_TRUE(made);
      const auto next = bring(folder(), Step::kAdjust);
      ASSERT_TRUE(next) << next.error().message;
      EXPECT_EQ(*next, (Steps{"orient", "adjust"}));
      while (edit(folder(), {"undo"}).empty()) {
      }
      ASSERT_TRUE(bring(folder(), Step::kAdjust));
      EXPECT_EQ(result(), before);
    }
}

TEST_F(EditsFlow, WhatWaitsIsTakenInBeforeTheNextStep) {
  Journal journal(folder());
  ASSERT_TRUE(journal.append([&](const EditHistory&) -> Result<std::vector<NewEdit>> {
    return std::vector<NewEdit>{{parse_edit(moved(0.75)).value()}};
  }));
  EXPECT_EQ(bring(folder(), Step::kAdjust), (Steps{"orient", "adjust"}));
  EXPECT_EQ(store().last_edit(), 1u);
}

TEST_F(EditsFlow, ABrokenJournalEndsTheRunAndIsNamed) {
  ASSERT_TRUE(write_file(folder() / "journal.jsonl", "x\n"));
  const auto done = bring(folder(), Step::kAdjust);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("journal.jsonl: line 1"), std::string::npos) << done.error().message;
}

/// Three photographs and three points without marks.
class EditsImport : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* file : {"a.jpg", "b.jpg", "c.jpg"}) put(file);
    ASSERT_TRUE(write_file(folder_ / "control.csv", kControl));
    settings_.photos = (folder_ / "photos").string();
    settings_.import.control = folder_ / "control.csv";
    ASSERT_TRUE(import());
  }
  void put(const std::string& file) const {
    const ImageHeader header = header_at(48.2, 15.63);
    put_image(folder_ / "photos" / file, &header);
  }
  [[nodiscard]] fs::path folder() const { return folder_ / "project"; }
  [[nodiscard]] Result<> import() const {
    COLLINEA_TRY(Project project, create_project(folder(), settings_, {}));
    return bring_up_to(project, Step::kImport);
  }
  [[nodiscard]] ProjectStore store() const { return ProjectStore::open(folder()).value(); }
  [[nodiscard]] std::string findings() const {
    std::string text;
    const ImportRecord record = store().read_outcome<ImportRecord>().value();
    const Block setup = store().read_setup_for_names().value();
    for (const Finding& one : record.findings) text += label_of(one, setup) + "; " + one.detail + "\n";
    return text;
  }

  TestFolder folder_;
  Settings settings_;
};

TEST_F(EditsImport, AgainItKeepsThemAndNamesThoseThatFitNoMore) {
  EXPECT_NE(findings().find("control_unseen: control_point A"), std::string::npos) << findings();
  for (const char* file : {"a.jpg", "b.jpg", "c.jpg"}) ASSERT_EQ(edit(folder(), {"mark", "A", file, "10", "20"}), "");
  ASSERT_EQ(edit(folder(), {"point", "D", "control", "546810", "5338610", "310"}), "");
  ASSERT_EQ(edit(folder(), {"mark", "D", "c.jpg", "30", "40"}), "");
  put("aa.jpg");  // all later ones have other numbers
  fs::remove(folder_ / "photos" / "c.jpg");
  ASSERT_TRUE(import());
  const Block setup = store().read_setup().value();
  std::vector<std::string> marks;
  for (const ControlObservation& one : setup.control_observations)
    marks.push_back(setup.control.at(one.point).name + " " + setup.images.at(one.image).file);
  EXPECT_EQ(marks, (std::vector<std::string>{"A a.jpg", "A b.jpg"}));
  EXPECT_EQ(setup.control.size(), 4u);
  EXPECT_EQ(store().read_outcome<ImportRecord>()->control_points, 4u);
  const std::string found = findings();
  EXPECT_EQ(found.find("control_unseen: control_point A"), std::string::npos) << found;
  EXPECT_NE(found.find("edit_unfit: "), std::string::npos) << found;
  EXPECT_NE(found.find("mark A c.jpg 10 20 0.5: no image is called c.jpg"), std::string::npos) << found;
  EXPECT_NE(found.find("mark D c.jpg 30 40 0.5: no image"), std::string::npos) << found;
  // With the photograph back all is as before; undone, nothing is left of it.
  put("c.jpg");
  ASSERT_TRUE(import());
  EXPECT_EQ(findings().find("edit_unfit"), std::string::npos);
  EXPECT_EQ(store().read_setup()->control_observations.size(), 4u);
  while (edit(folder(), {"undo"}).empty()) {
  }
  ASSERT_TRUE(import());
  EXPECT_NE(findings().find("control_unseen: control_point A"), std::string::npos) << findings();
  EXPECT_EQ(store().read_setup()->control.size(), 3u);
}

}  // namespace
}  // namespace collinea
