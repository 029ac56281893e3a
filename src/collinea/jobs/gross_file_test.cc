// SPDX-License-Identifier: Apache-2.0
// Slips in single values of an adjustment file: refused by name, or with data snooping rejected and nothing else.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "collinea/adjust/test_block.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/jobs/adjust_project.h"

namespace collinea {
namespace {

// Six control points and tie points in a strip of five images; poses and points are known roughly.
Block strip() {
  Block block = testing::test_block({.rows = 1, .columns = 5, .points = 60, .sigma_px = 0.5, .control = 6});
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  return testing::disturbed(std::move(block), 0.003, 0.3);
}

AdjustmentFile file_of(const Block& block) {
  AdjustmentFile file{.block = block};
  file.given_cameras = block.cameras;
  for (const auto& [id, camera] : block.cameras) file.camera_sigmas[id] = {};
  return file;
}

struct Slip {
  const char* name;
  std::string group;  // of what is wrong, as errors name it
  std::function<void(Block&)> make;
};

// In the third control point and its first mark, and in a ray of a tie point that three images see.
std::vector<Slip> slips() {
  std::vector<Slip> all;
  const auto coordinate = [&](const char* name, int axis, auto&& change) {
    all.push_back({name, axis == 2 ? "gcp2 (control_height" : "gcp2 (control_plan", [=](Block& block) {
                     double& value = block.control.at({2}).position_in_world[axis];
                     value = change(value);
                   }});
  };
  for (const int axis : {0, 1, 2}) {
    coordinate("ten metres", axis, [](double value) { return value + 10; });
    coordinate("a digit in front", axis, [](double value) { return value + 100; });
    coordinate("a decimal slip", axis, [](double value) { return 10 * (value + 100); });
    coordinate("two", axis, [](double value) { return 100 * (value + 100); });
    coordinate("a sign", axis, [](double value) { return -value - 100; });
  }
  const auto mark = [&](const char* name, auto&& change) {
    all.push_back({name, "(control_images", [=](Block& block) {
                     for (ControlObservation& seen : block.control_observations)
                       if (seen.point == ControlId{2}) return change(seen.pixel);
                   }});
  };
  mark("column times ten", [](Eigen::Vector2d& pixel) { pixel.x() *= 10; });
  mark("columns exchanged", [](Eigen::Vector2d& pixel) { std::swap(pixel.x(), pixel.y()); });
  mark("sign of a column", [](Eigen::Vector2d& pixel) { pixel.x() *= -1; });
  return all;
}

TEST(GrossFile, ASlipInOneValueIsNoAdjustmentOrShowsInSigma0) {
  const TestFolder folder;
  int refused = 0;
  for (const Slip& slip : slips()) {
    SCOPED_TRACE(slip.name);
    Block block = strip();
    slip.make(block);
    ASSERT_TRUE(write_adjustment_file(folder / "block.txt", file_of(block)));
    const auto report = adjust_file(folder / "block.txt", folder / "out", {.loss = Loss::kNone, .snoop = false}, {});
    if (report) {
      EXPECT_GT(report->adjusted.redundancy, 200);
      EXPECT_GT(report->adjusted.sigma0, 3);
      EXPECT_TRUE(report->adjusted.converged);
      continue;
    }
    ++refused;
    const Errc code = report.error().code;
    EXPECT_TRUE(code == Errc::kNotConverged || code == Errc::kIllPosed) << report.error().message;
    EXPECT_NE(report.error().message.find(slip.group), std::string::npos) << report.error().message;
  }
  EXPECT_GT(refused, 5);
}

TEST(GrossFile, DataSnoopingRejectsTheSlipAlone) {
  const TestFolder folder;
  for (const Slip& slip : slips()) {
    SCOPED_TRACE(slip.name);
    Block block = strip();
    slip.make(block);
    ASSERT_TRUE(write_adjustment_file(folder / "block.txt", file_of(block)));
    const auto report = adjust_file(folder / "block.txt", folder / "out", {.loss = Loss::kNone, .snoop = true}, {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LT(report->adjusted.sigma0, 1.2);
    EXPECT_EQ(report->snooped->rejected.size(), 1u);
  }
}

}  // namespace
}  // namespace collinea
