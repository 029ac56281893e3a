// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/project/project.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

constexpr std::size_t kImages = 9, kPairs = kImages * (kImages - 1) / 2;  // more than are stored at once

// Images of a plane of noise, each a little further to the right.
void put_images(const std::filesystem::path& folder) {
  Random random(3);
  Raster<std::uint8_t> plane(300, 120, 1);
  for (std::uint8_t& value : plane.data) value = std::uint8_t(random.below(256));
  std::filesystem::create_directories(folder);
  for (std::size_t image = 0; image < kImages; ++image) {
    Raster<std::uint8_t> view(160, 120, 1);
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x) view.at(x, y) = plane.at(x + 12 * int(image), y);
    ASSERT_TRUE(write_jpeg(folder / ("image" + std::to_string(image) + ".jpg"), view, 95));
  }
}

Result<Project> matched(const TestFolder& folder, const std::string& name, const collinea::Run& run) {
  Settings settings;
  settings.photos = (folder / "photos").string();
  COLLINEA_TRY(Project project, create_project(folder / name, settings, run));
  COLLINEA_TRY(bring_up_to(project, Step::kMatch));
  return project;
}

TEST(MatchStep, StoppedAmongThePairsItGoesOnWithThoseThatAreMissing) {
  const TestFolder folder;
  put_images(folder / "photos");
  const auto whole = matched(folder, "whole", {});
  ASSERT_TRUE(whole) << whole.error().message;
  const std::vector<ImagePair> wanted = whole->store.read_pairs().value();
  ASSERT_EQ(wanted.size(), kPairs);
  EXPECT_TRUE(std::any_of(wanted.begin(), wanted.end(), [](const ImagePair& pair) { return !pair.matches.empty(); }));

  std::stop_source stop;
  collinea::Run run{.stop = stop.get_token()};
  run.progress = [&](std::string_view stage, double done) {
    if (stage == "match" && done >= 5.0 / kPairs) stop.request_stop();
  };
  const auto stopped = matched(folder, "stopped", run);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::kCancelled);

  std::vector<std::string> lines;
  std::vector<double> progress;
  run = {.threads = 2};
  run.log = [&](std::string_view line) { lines.emplace_back(line); };
  run.progress = [&](std::string_view stage, double done) {
    if (stage == "match") progress.push_back(done);
  };
  const auto resumed = matched(folder, "stopped", run);
  ASSERT_TRUE(resumed) << resumed.error().message;
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "match: 5 of 36 pairs kept from before"), 1);
  EXPECT_EQ(progress.size(), 1 + kPairs - 5 + 1);  // and the beginning and the end of the step
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  EXPECT_EQ(progress.back(), 1);
  const std::vector<ImagePair> pairs = resumed->store.read_pairs().value();
  ASSERT_EQ(pairs.size(), wanted.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(pairs[i].first, wanted[i].first);
    EXPECT_EQ(pairs[i].second, wanted[i].second);
    EXPECT_EQ(pairs[i].geometry, wanted[i].geometry) << i;
    EXPECT_TRUE(pairs[i].matches == wanted[i].matches) << i;
    EXPECT_EQ(pairs[i].putative, wanted[i].putative) << i;
  }
}

}  // namespace
}  // namespace collinea
