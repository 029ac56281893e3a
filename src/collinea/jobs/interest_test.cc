// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/interest.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/text_table.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// Chequered fields of 16 pixels.
fs::path board(const fs::path& folder) {
  GreyImage image(160, 128);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) image.at(x, y) = (x / 16 + y / 16) % 2 == 0 ? 60 : 190;
  EXPECT_TRUE(write_png(folder / "board.png", image));
  return folder / "board.png";
}

TEST(InterestJob, WritesPointsMapAndRepeatability) {
  const TestFolder folder;
  InterestJobOptions options;
  options.points.method = InterestOperator::kFoerstner;
  options.repeatability = RepeatabilityOf::kThis;
  const auto report = find_interest(board(folder / ""), folder / "out", options, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->found.points.size(), 63u);  // crossings of 9 x 7 lines

  const auto table = read_text_table(folder / "out/points.txt");
  ASSERT_TRUE(table) << table.error().message;
  const auto x = table->numbers("x", "px"), sigma = table->numbers("sigma_x", "px");
  ASSERT_TRUE(x && sigma);
  for (std::size_t i = 0; i < x->size(); ++i) {
    EXPECT_NEAR(std::remainder((*x)[i], 16), 0, 0.01);
    EXPECT_GT((*sigma)[i], 0);
  }
  const auto map = read_float_tiff(folder / "out/map.tif");
  ASSERT_TRUE(map);
  EXPECT_EQ(map->width, 160);
  EXPECT_TRUE(fs::exists(folder / "out/points.png") && fs::exists(folder / "out/map.png"));
  const auto repeated = read_text_table(folder / "out/repeatability.txt");
  ASSERT_TRUE(repeated);
  EXPECT_EQ(repeated->rows.size(), 19u);
  EXPECT_NEAR(repeated->numbers("repeatability", "")->front(), 1, 1e-12);  // unchanged
  EXPECT_TRUE(read_file(folder / "out/repeatability.svg")->starts_with("<svg"));
  EXPECT_NE(interest_text(*report).find("63 points"), std::string::npos);
}

TEST(InterestJob, SaysWhatIsWrong) {
  const TestFolder folder;
  EXPECT_EQ(find_interest(folder / "none.png", folder / "out", {}, {}).error().code, Errc::kNotFound);
  InterestJobOptions options;
  options.points.harris_k = 3;
  EXPECT_FALSE(find_interest(board(folder / ""), folder / "out", options, {}));
  GreyImage flat(40, 40, 1, 100);
  ASSERT_TRUE(write_png(folder / "flat.png", flat));
  const auto none = find_interest(folder / "flat.png", folder / "out", {}, {});
  ASSERT_TRUE(none);
  EXPECT_NE(interest_text(*none).find("nothing stands out"), std::string::npos);
}

}  // namespace
}  // namespace collinea
