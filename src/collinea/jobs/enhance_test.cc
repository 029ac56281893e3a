// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/enhance.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/text_table.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// Grey values 100 to 163: little contrast.
fs::path dull(const fs::path& folder, int channels = 1) {
  Raster<std::uint8_t> image(64, 40, channels);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = static_cast<std::uint8_t>(100 + x);
  EXPECT_TRUE(write_png(folder / "dull.png", image));
  return folder / "dull.png";
}

TEST(EnhanceJob, StretchesAndWritesItsTables) {
  const TestFolder folder;
  const EnhanceOptions options{.contrast = Contrast::kStretch};
  const auto report = enhance_image(dull(folder / ""), folder / "out", options, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->black, 103);
  EXPECT_EQ(report->white, 160);
  const auto image = read_grey(folder / "out/enhanced.png");
  ASSERT_TRUE(image);
  EXPECT_EQ(image->at(3, 5), 0);
  EXPECT_EQ(image->at(60, 5), 255);
  const auto table = read_text_table(folder / "out/statistics.txt");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->words("step").value(), (std::vector<std::string>{"image", "stretch"}));
  EXPECT_NEAR(table->numbers("mean", "grey")->front(), 131.5, 1e-9);
  EXPECT_GT(table->numbers("contrast", "grey")->back(), 3 * table->numbers("contrast", "grey")->front());
  const auto histogram = read_text_table(folder / "out/histogram.txt");
  ASSERT_TRUE(histogram && histogram->rows.size() == 256);
  EXPECT_EQ(histogram->numbers("before", "").value()[100], 40);
  EXPECT_EQ(histogram->numbers("becomes", "grey").value()[160], 255);
  EXPECT_TRUE(read_file(folder / "out/histogram.svg")->starts_with("<svg"));
  EXPECT_NE(enhance_text(*report).find("103 becomes black"), std::string::npos);
}

TEST(EnhanceJob, DoesAllStepsInTheirOrder) {
  const TestFolder folder;
  const EnhanceOptions options{.gaussian_px = 1,
                               .reduce = 2,
                               .reduction = Reduction::kSinc,
                               .contrast = Contrast::kEqualise,
                               .lut = GreyLut::kThreshold,
                               .dither = Dither::kOrdered,
                               .palette = Palette::kHeat};
  const auto report = enhance_image(dull(folder / ""), folder / "out", options, {});
  ASSERT_TRUE(report) << report.error().message;
  std::vector<std::string> names;
  for (const EnhanceStep& step : report->steps) names.push_back(step.name);
  EXPECT_EQ(names, (std::vector<std::string>{"image", "gaussian", "sinc", "equalise", "threshold", "ordered"}));
  EXPECT_TRUE(report->is_threshold_found);
  const auto image = read_colour(folder / "out/enhanced.png");
  ASSERT_TRUE(image);
  EXPECT_EQ(image->width, 32);
  EXPECT_EQ(image->channels, 3);
}

TEST(EnhanceJob, KeepsColoursWhereAskedFor) {
  const TestFolder folder;
  const auto report =
      enhance_image(dull(folder / "", 3), folder / "out", {.colour = true, .lut = GreyLut::kNegative}, {});
  ASSERT_TRUE(report) << report.error().message;
  const auto image = read_colour(folder / "out/enhanced.png");
  ASSERT_TRUE(image && image->channels == 3);
  EXPECT_EQ(image->at(0, 0, 1), 155);
}

// As an orthophoto: half of it empty, stated by its alpha channel.
fs::path half_empty(const fs::path& folder, std::uint8_t fill) {
  Raster<std::uint8_t> image(64, 40, 4);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 64; ++x) {
      image.at(x, y, 3) = y < 20 ? 0 : 255;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = y < 20 ? fill : static_cast<std::uint8_t>(100 + x);
    }
  EXPECT_TRUE(write_png(folder / "half.png", image));
  return folder / "half.png";
}

TEST(EnhanceJob, LeavesEmptyPixelsOutAndKeepsThemEmpty) {
  const TestFolder folder;
  for (const Contrast contrast : {Contrast::kStretch, Contrast::kEqualise, Contrast::kWallis}) {
    const EnhanceOptions options{.contrast = contrast, .lut = GreyLut::kNegative};
    std::string tables[2];
    Raster<std::uint8_t> images[2];
    for (const int k : {0, 1}) {
      const auto report = enhance_image(half_empty(folder / "", k ? 255 : 0), folder / "out", options, {});
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->empty_share, 0.5);
      EXPECT_EQ(report->steps.front().histogram.total(), 64u * 20u);
      EXPECT_EQ(report->steps.back().histogram.total(), 64u * 20u);
      if (contrast == Contrast::kStretch) {
        EXPECT_EQ(report->black, 103);  // as without the empty half
      }
      EXPECT_NE(enhance_text(*report).find("50.0 % of the pixels are empty"), std::string::npos);
      tables[k] = *read_file(folder / "out/statistics.txt");
      images[k] = *read_grey(folder / "out/enhanced.png");
      const auto known = read_known_pixels(folder / "out/enhanced.png");
      ASSERT_TRUE(known && *known);
      EXPECT_EQ((*known)->at(5, 19), 0);
      EXPECT_EQ((*known)->at(5, 20), 255);
    }
    EXPECT_EQ(tables[0], tables[1]);
    EXPECT_EQ(images[0].data, images[1].data);
  }
}

TEST(EnhanceJob, RefusesAnImageWithoutPixels) {
  const TestFolder folder;
  ASSERT_TRUE(write_png(folder / "nothing.png", Raster<std::uint8_t>(8, 8, 4)));
  const auto refused = enhance_image(folder / "nothing.png", folder / "out", {}, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
}

TEST(EnhanceJob, RefusesWhatDoesNotGoTogether) {
  const TestFolder folder;
  const fs::path file = dull(folder / "");
  EXPECT_EQ(enhance_image(folder / "none.png", folder / "out", {}, {}).error().code, Errc::kNotFound);
  EXPECT_FALSE(enhance_image(file, folder / "out", {.colour = true, .palette = Palette::kHeat}, {}));
  EXPECT_FALSE(
      enhance_image(file, folder / "out", {.contrast = Contrast::kStretch, .low_percent = 95, .high_percent = 5}, {}));
  EXPECT_FALSE(enhance_image(file, folder / "out", {.reduce = 0.5}, {}));
  for (const EnhanceOptions& unread :
       {EnhanceOptions{.reduction = Reduction::kSinc}, EnhanceOptions{.low_percent = 1},
        EnhanceOptions{.wallis = {.window_px = 9}}, EnhanceOptions{.gamma = 3}, EnhanceOptions{.threshold = 90},
        EnhanceOptions{.slices = 3}, EnhanceOptions{.levels = 3},
        EnhanceOptions{.dither = Dither::kFloydSteinberg, .cell_px = 3}}) {
    const auto refused = enhance_image(file, folder / "out", unread, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
  }
}

TEST(EnhanceJob, FindsNoThresholdInOneGreyValue) {
  const TestFolder folder;
  ASSERT_TRUE(write_png(folder / "flat.png", GreyImage(20, 20, 1, 80)));
  const auto found = enhance_image(folder / "flat.png", folder / "out", {.lut = GreyLut::kThreshold}, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kIllPosed);
  EXPECT_TRUE(enhance_image(folder / "flat.png", folder / "out", {.lut = GreyLut::kThreshold, .threshold = 90}, {}));
}

}  // namespace
}  // namespace collinea
