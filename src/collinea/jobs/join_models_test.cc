// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/join_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/models/test_strip.h"

namespace collinea {
namespace {

using testing::strip;
using testing::Strip;

std::filesystem::path written(const Strip& made, const TestFolder& folder) {
  AdjustmentFile file;
  file.block = made.block;
  for (const auto& [id, camera] : made.block.cameras) {
    file.given_cameras[id] = camera;
    file.camera_sigmas[id] = {};
  }
  for (auto& [id, control] : file.block.control) control.position_in_map = control.position_in_world;
  const auto path = folder / "block.txt";
  EXPECT_TRUE(write_adjustment_file(path, file));
  return path;
}

TEST(JoinModels, TheBundleStandsBesideThem) {
  const TestFolder folder;
  JoinModelsOptions options;
  options.bundle = true;
  options.out = folder / "out";
  const auto report = join_models_of(written(strip(1), folder), options, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NE(models_text(*report).find("bundle        of the same measurements"), std::string::npos);
  const auto table = read_text_table(folder / "out" / "points.txt");
  ASSERT_TRUE(table);
  const auto x = table->numbers("X", "m"), bundle = table->numbers("bundle_X", "m"),
             less = table->numbers("less_bundle_X", "m");
  ASSERT_TRUE(x && bundle && less);
  for (std::size_t i = 0; i < x->size(); ++i) EXPECT_NEAR((*x)[i] - (*bundle)[i], (*less)[i], 1.6e-5);  // digits
}

TEST(JoinModels, AChainStandsByItself) {
  const TestFolder folder;
  JoinModelsOptions options;
  options.chain_only = true;
  options.out = folder / "out";
  const auto report = join_models_of(written(strip(1), folder), options, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NE(models_text(*report).find("chain         2 joins, no adjustment"), std::string::npos);
  const auto table = read_text_table(folder / "out" / "points.txt");
  ASSERT_TRUE(table);
  const auto x = table->numbers("X", "m"), sigma = table->numbers("sigma_Z", "m");
  ASSERT_TRUE(x && sigma);
  for (std::size_t i = 0; i < x->size(); ++i) EXPECT_NEAR((*x)[i], report->block.points[i].position.x(), 1e-5);
  EXPECT_GT(*std::max_element(sigma->begin(), sigma->end()), 0);
  options.bundle = true;
  EXPECT_FALSE(join_models_of(folder / "block.txt", options, {}));
}

TEST(JoinModels, ATableHasNoBundle) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "models.txt", "model point U V W\na 1 0 0 0\n"));
  JoinModelsOptions options;
  options.bundle = true;
  const auto report = join_models_of(folder / "models.txt", options, {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
