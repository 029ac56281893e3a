// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "collinea/store/sqlite.h"
#include "collinea/store/test_project_store.h"

namespace collinea {
namespace {

using ProjectStoreEdits = ProjectStoreTest;

// One point changed, one removed, one added, and a mark moved.
EditedControl edited(const EditableSetup& setup) {
  EditedControl control = setup.edited;
  control.control.at({2}).role = ControlRole::kControl;
  control.control.erase({11});
  std::erase_if(control.control_observations, [](const ControlObservation& one) { return one.point == ControlId{11}; });
  control.control[{12}] = {"new", ControlRole::kCheck, {1, 2, 3}, {4, 5, 6}, {0.1, 0.1, 0.1}};
  control.control_observations.push_back({{12}, {3}, {7, 8}, 0.125});
  control.last_edit = 5;
  return control;
}

TEST_F(ProjectStoreEdits, EditsChangeTheControlAndLeaveWhatWasImported) {
  ProjectStore store = open();
  const Block block = setup_block();
  ASSERT_TRUE(store.write_setup(block));
  const std::uint64_t before = store.setup_hash().value();
  EXPECT_EQ(store.last_edit(), 0u);
  ASSERT_TRUE(store.edit_setup([](const EditableSetup& setup) -> Result<EditedControl> {
    EXPECT_EQ(setup.edited.control.size(), setup.imported.control.size());
    return edited(setup);
  }));
  EXPECT_EQ(store.last_edit(), 5u);
  EXPECT_NE(store.setup_hash(), before);
  const Block now = store.read_setup().value();
  EXPECT_FALSE(now.control.contains({11}));
  EXPECT_EQ(now.control.at({2}).role, ControlRole::kControl);
  EXPECT_EQ(now.control_observations.back().sigma_px, 0.125);
  EXPECT_EQ(store.read_setup_for_names()->control.at({11}).name, block.control.at({11}).name);
  // An error leaves all as it is; going back to what was imported leaves no trace.
  EXPECT_FALSE(
      store.edit_setup([](const EditableSetup&) -> Result<EditedControl> { return fail(Errc::kBadInput, "no"); }));
  EXPECT_EQ(store.last_edit(), 5u);
  ASSERT_TRUE(store.edit_setup([](const EditableSetup& setup) -> Result<EditedControl> {
    return EditedControl{setup.imported.control, setup.imported.control_observations, 6};
  }));
  EXPECT_EQ(store.setup_hash(), before);
  ASSERT_TRUE(store.write_setup(block));
  EXPECT_EQ(store.last_edit(), 0u);
}

// What an edit costs must not grow with the block: pages that are the same are not written.
TEST_F(ProjectStoreEdits, AnEditWritesOnlyRowsThatDiffer) {
  ProjectStore store = open();
  Block block = setup_block();
  for (std::uint32_t i = 0; i < 40'000; ++i) block.control_observations.push_back({{9}, {i % 4}, {1.0 * i, 2}, 0.5});
  ASSERT_TRUE(store.write_setup(block));
  const auto edit = [&](std::uint64_t number) {
    return store.edit_setup([&](const EditableSetup& setup) -> Result<EditedControl> {
      EditedControl control = setup.edited;
      control.control_observations.back().sigma_px = 0.125 * static_cast<double>(number);
      control.last_edit = number;
      return control;
    });
  };
  ASSERT_TRUE(edit(1));  // puts what was imported aside
  auto other = sqlite::Database::open(folder_ / "block.db").value();
  ASSERT_TRUE(other.execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  ASSERT_TRUE(edit(2));
  // 40,000 marks of 32 bytes are 1.28 MB in three rows. The last, of 231 kB, is written, once more where SQLite wipes
  // what INSERT OR REPLACE frees (secure_delete, as Debian builds it), and a few pages of 16 kB that hold the rest.
  EXPECT_LT(fs::file_size(folder_ / "block.db-wal"), 2 * 231'000u + 8 * 16'384u);
}

}  // namespace
}  // namespace collinea
