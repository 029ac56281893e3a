// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/stereo_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace collinea {
namespace {

StereoReport by_levels() {
  StereoReport report;
  report.matcher = StereoMatcher::kLevels;
  report.pixels = 200;
  report.measured = 50;
  report.levels = {{.threshold = 500, .interest = 9, .matched = 7, .spikes = 2, .median_interval_px = 12.5}};
  return report;
}

TEST(StereoReport, SaysWhatEachLevelDid) {
  StereoReport report = by_levels();
  report.median_sigma_px = 0.25;
  const auto json = nlohmann::json::parse(stereo_json(report));
  EXPECT_EQ(json["matcher"], "levels");
  EXPECT_EQ(json["median_sigma_px"], 0.25);
  ASSERT_EQ(json["levels"].size(), 1u);
  EXPECT_EQ(json["levels"][0]["spikes"], 2);
  const std::string text = stereo_text(report);
  EXPECT_NE(text.find("25.0 % of 200 pixels, median sigma 0.25 px"), std::string::npos) << text;
  EXPECT_NE(text.find("12.5"), std::string::npos) << text;
}

TEST(StereoReport, WithoutSigmasThereIsNoCloud) {
  StereoReport report = by_levels();
  report.cameras = StereoReport::Cameras{};
  EXPECT_TRUE(nlohmann::json::parse(stereo_json(report))["median_sigma_px"].is_null());
  const std::string text = stereo_text(report);
  EXPECT_NE(text.find("no cloud"), std::string::npos) << text;
  EXPECT_EQ(text.find("median sigma"), std::string::npos) << text;
}

}  // namespace
}  // namespace collinea
