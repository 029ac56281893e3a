// SPDX-License-Identifier: Apache-2.0
// Edits of all kinds in one journal: control, masks, patches, the drawing and the cloud.
#include <gtest/gtest.h>

#include <set>

#include "collinea/edit/read_work.h"
#include "collinea/edit/test_edits.h"
#include "collinea/edit/work_in_force.h"

namespace collinea {
namespace {

class MixedEdits : public EditsTest {
 protected:
  /// What the steps read of the project: the fingerprint of its setup, and the work in force with the texts that enter
  /// fingerprints. All is read from the disk.
  [[nodiscard]] std::string state() const {
    const Project opened{.folder = project(), .store = store()};
    const Block setup = opened.store.read_setup().value();
    const EditedWork work = read_work(opened).value();
    return std::to_string(hash()) + " " + masks_of(work).text() + patches_text(work) + " " + text_of(work, setup);
  }
  void restart() { journal_ = Journal(project()); }
};

// A random walk of new edits, undo and redo: the project is always what the edits that are left made it, so that 200
// edits are taken back one by one to what was imported, and come back one by one.
TEST_F(MixedEdits, TwoHundredOfAllKindsAreUndoneAndRedoneAlsoAfterRestarts) {
  Random random(12);
  std::vector<std::string> states = {state()};
  std::size_t at = 0;  // the state in force; those behind it can be redone
  std::set<std::string> kinds;
  int undone = 0, redone = 0, ended = 0;
  while (at < 200) {
    const std::uint32_t dice = random.below(10);
    if (dice == 0 && at > 0) {
      ASSERT_EQ(make({"undo"}), "");
      --at, ++undone;
    } else if (dice == 1 && at + 1 < states.size()) {
      ASSERT_EQ(make({"redo"}), "");
      ++at, ++redone;
    } else if (dice == 2) {
      restart();
    } else {
      const auto words = random.below(2) == 0 ? any_command(random) : any_work(random);
      if (!make(words).empty()) continue;
      kinds.insert(words[0]);
      ended += at + 1 < states.size();
      states.resize(at + 1);
      states.push_back(state());
      ++at;
      continue;
    }
    ASSERT_EQ(state(), states[at]);
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<Edit> - 2) << "all but undo and redo";
  EXPECT_GT(std::min({undone, redone, ended}), 3);

  // The journal alone makes the same of what was imported.
  const std::uint64_t last = hash();
  auto imported = store();
  ASSERT_TRUE(write_setup_with_edits(imported, setup_to_edit(), journal_));
  EXPECT_EQ(hash(), last);

  for (; at > 0; --at) {
    if (at % 50 == 0) restart();
    ASSERT_EQ(make({"undo"}), "");
    if (at % 4 == 0) ASSERT_EQ(state(), states[at - 1]) << at;
  }
  EXPECT_EQ(make({"undo"}), "there is nothing to undo");
  restart();
  EXPECT_EQ(state(), states[0]);
  for (; at + 1 < states.size(); ++at) {
    if (at % 50 == 0) restart();
    ASSERT_EQ(make({"redo"}), "");
    if (at % 4 == 0) ASSERT_EQ(state(), states[at + 1]) << at;
  }
  EXPECT_EQ(state(), states.back());
  EXPECT_EQ(make({"redo"}), "there is nothing to redo");
}

}  // namespace
}  // namespace collinea
