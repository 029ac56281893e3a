// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/info.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"
#include "collinea/store/sqlite.h"

namespace collinea {
namespace {

// Whoever has a new version wants to see an old project, too, and what of it has to be done again.
TEST(ProjectInfo, StepsOfAnotherVersionAreNamedAndTheOthersTold) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project);
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  const auto before = project_info(project->store);
  ASSERT_TRUE(before);
  EXPECT_TRUE(before->by_another_version.empty());
  ASSERT_NE(before->orientation(), nullptr);
  auto database = sqlite::Database::open(folder / "block" / "block.db");
  ASSERT_TRUE(database);
  ASSERT_TRUE(database->execute("UPDATE step_records SET record = x'63' WHERE step = 'orient'"));
  const auto info = project_info(project->store);
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->by_another_version, std::vector{Step::kOrient});
  EXPECT_EQ(info->orientation(), nullptr);
  EXPECT_NE(info->adjustment(), nullptr);
  EXPECT_EQ(info->steps.size() + 1, before->steps.size());
}

}  // namespace
}  // namespace collinea
