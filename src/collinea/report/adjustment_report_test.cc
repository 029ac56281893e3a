// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/adjustment_report.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/io/file.h"

namespace collinea {
namespace {

TEST(WriteAdjustment, ACalibratedCameraWithoutCovarianceHasNoSigmasAndAHeldOneHasZeros) {
  const TestFolder folder;
  AdjustmentReport report;
  report.block.georeference = Georeference{"EPSG:32633", 45, 15, 100};
  report.block.cameras[{1}] = report.block.cameras[{2}] = ideal_camera(1500, 2000, 1500);
  report.block.cameras[{1}].name = "free";
  report.block.cameras[{2}].name = "held";
  report.adjusted.cameras[{1}] = report.block.cameras[{1}];
  report.adjusted.undetermined = "the scale";
  ASSERT_TRUE(write_adjustment(report, folder / "out"));
  const std::string table = *read_file(folder / "out" / "cameras.csv");
  EXPECT_NE(table.find("\"free\",f,px,1500,\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\"held\",f,px,1500,0\n"), std::string::npos) << table;
}

}  // namespace
}  // namespace collinea
