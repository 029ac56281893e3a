// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/sha256.h"
#include "collinea/geometry/rotation.h"
#include "collinea/raster/geotiff.h"
#include "collinea/report/internal/coverage.h"
#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/summary.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/internal/test_block.h"
#include "collinea/report/statistics.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

class ReportTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("collinea_report_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string page() const { return *read_file(folder_ / "report.html"); }
  [[nodiscard]] nlohmann::json figures() const { return nlohmann::json::parse(*read_file(folder_ / "report.json")); }
  fs::path folder_;
};

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

int count_of(const std::string& text, std::string_view part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

TEST_F(ReportTest, PageAndJsonTellTheSameFigures) {
  const ReportInput input = report_of_test_flight(3, 6, 800);
  const auto written = write_report(input, folder_);
  ASSERT_TRUE(written) << written.error().message;
  const auto json = figures();
  EXPECT_EQ(json["images"], 18);
  EXPECT_EQ(json["oriented"], 17);
  EXPECT_EQ(json["image_list"].size(), 17u);
  EXPECT_EQ(json["left_out"].size(), 3u);
  EXPECT_EQ(json["check_rmse_m"]["points"], 4);
  double squares = 0;
  for (const ControlDifference& control : input.control)
    if (!control.used) squares += control.difference_m.x() * control.difference_m.x();
  EXPECT_NEAR(json["check_rmse_m"]["east"], std::sqrt(squares / 4), 1e-12);
  EXPECT_EQ(json["steps"][0]["figures"]["images"], 40);
  EXPECT_EQ(json["steps"][1]["name"], "detect");
  EXPECT_EQ(json["steps"][2]["figures"]["oriented"], 39);
  EXPECT_TRUE(json["steps"][2]["figures"]["gsd_m"].is_null());
  EXPECT_EQ(json["steps"][3]["figures"].size(), 1u);
  EXPECT_EQ(json["steps"][3]["figures"]["skipped_because"]["code"], "not_downwards");
  EXPECT_EQ(json["findings"][0]["code"], "check_point");
  const std::string html = page();
  EXPECT_TRUE(contains(html, "17 of 18"));
  EXPECT_TRUE(contains(html, json["statement"].get<std::string>()));
  EXPECT_TRUE(contains(html, "4 independent check points"));
  EXPECT_TRUE(contains(html, length_text(std::sqrt(squares / 4), "m")));
  EXPECT_TRUE(contains(html, "DJI_0999.JPG"));
  EXPECT_TRUE(contains(html, "WGS 84 / UTM zone 33N"));
}

// What is wrong comes first and a systematic error that moves no point by its sigma last, each once, with options as
// they are typed.
TEST_F(ReportTest, WhatMattersStandsAboveWhatHardlyMovesAnything) {
  ReportInput input = report_of_test_flight(2, 4, 200);
  Finding tiny = finding_of(FindingCode::kSystematic, {Subject(CameraId{0}, Aspect::kAdditional)},
                            {{FigureName::kChance, 1e-9}, {FigureName::kRatio, 0.1}},
                            {OptionName{"additional", "orient", "polynomial"}});
  tiny.severity = Severity::kNote;
  Finding large = tiny;
  large.severity = Severity::kWeak;
  large.subjects[0].aspect = Aspect::kAffinity;
  large.figures[1].value = 3;
  large.remedies = {OptionName{"calibration", "orient", "brown_affinity"}};
  input.findings.insert(input.findings.begin(), {tiny, large});
  input.spelling = [](const OptionName& option) { return "<flag " + option.name + ">"; };
  ASSERT_TRUE(write_report(input, folder_));
  const std::string html = page();
  const auto wrong = html.find("contradicts the control points"), weak = html.find("&lt;flag calibration&gt;"),
             note = html.find("&lt;flag additional&gt;");
  ASSERT_NE(wrong, std::string::npos);
  ASSERT_NE(weak, std::string::npos);
  ASSERT_NE(note, std::string::npos);
  EXPECT_LT(wrong, weak);
  EXPECT_LT(weak, note);
  EXPECT_EQ(count_of(html, "&lt;flag calibration&gt;"), 1);
  EXPECT_FALSE(contains(html, "option additional"));
}

TEST_F(ReportTest, ThePageNeedsNothingFromOutsideAndItsTagsClose) {
  ASSERT_TRUE(write_report(report_of_test_flight(2, 4, 200), folder_));
  const std::string html = page();
  for (const char* outside : {"http://", "https://", "<script", "@import", "url("})
    EXPECT_FALSE(contains(html, outside));
  for (const std::string tag : {"section", "div", "table", "figure", "svg", "tr", "td", "text", "ul", "dl"})
    EXPECT_EQ(count_of(html, "<" + tag + " ") + count_of(html, "<" + tag + ">"), count_of(html, "</" + tag + ">"))
        << tag;
  EXPECT_TRUE(contains(html, "Quarry north &lt;1&gt;"));
  EXPECT_FALSE(contains(html, "nan"));
}

TEST_F(ReportTest, TheSameInputGivesTheSameBytes) {
  const ReportInput input = report_of_test_flight(2, 4, 200);
  ASSERT_TRUE(write_report(input, folder_ / "a"));
  ASSERT_TRUE(write_report(input, folder_ / "b"));
  EXPECT_EQ(*read_file(folder_ / "a/report.html"), *read_file(folder_ / "b/report.html"));
  EXPECT_EQ(*read_file(folder_ / "a/report.json"), *read_file(folder_ / "b/report.json"));
}

TEST_F(ReportTest, TheSignatureBlockSaysWhoSignsAndWhat) {
  ReportInput input = report_of_test_flight(2, 4, 200);
  ASSERT_TRUE(write_report(input, folder_));
  EXPECT_FALSE(contains(page(), "SHA-256"));
  EXPECT_FALSE(fs::exists(folder_ / "hashes.json"));
  input.signer = {"Anna <Rossi>", "Pavia 1234", "2026-05-01"};
  input.files = SignedFiles{"0.1.0",
                            42,
                            {{FileRole::kImage, "a.jpg", "/photos", 3, Sha256().add("abc").hex()},
                             {FileRole::kGiven, "control.csv", "/survey", 0, ""},
                             {FileRole::kProduct, "products/ortho.tif", {}, 1, Sha256().add("o").hex()}}};
  ASSERT_TRUE(write_report(input, folder_));
  const std::string html = page();
  for (const char* part : {"Anna &lt;Rossi&gt;", "Pavia 1234", "2026-05-01", "collinea 0.1.0, seed 42",
                           "1 photograph and 1 other file, 1 of which could not be read", "1 file<br>"})
    EXPECT_TRUE(contains(html, part)) << part;
  const auto all = signed_files_of(*read_file(folder_ / "hashes.json"));
  ASSERT_TRUE(all) << all.error().message;
  for (const SignedPart part : {SignedPart::kInputs, SignedPart::kProducts}) {
    EXPECT_TRUE(contains(html, digest_of(*input.files, part)));
    EXPECT_EQ(digest_of(*all, part), digest_of(*input.files, part));
  }
  ASSERT_EQ(all->files.size(), 5u);
  EXPECT_EQ(all->files[3].name, "report/report.html");
  EXPECT_EQ(all->files[3].sha256, Sha256().add(html).hex());
  EXPECT_EQ(figures()["signature"]["surveyor"], "Anna <Rossi>");
  EXPECT_EQ(figures()["signature"]["products_sha256"], digest_of(*all, SignedPart::kProducts));
}

TEST_F(ReportTest, EveryImageCameraAndControlPointIsInTheFigures) {
  ReportInput input = report_of_test_flight(2, 4, 200);
  input.rotation_sigma_rad[{2}] = {0.001, 0.002, 0.003};
  ASSERT_TRUE(write_report(input, folder_));
  const auto json = figures();
  const auto& image = json["image_list"][2];
  EXPECT_EQ(image["file"], input.block.images.at({2}).file);
  EXPECT_NEAR(image["centre_sigma_m"][1].get<double>(), 0.012, 1e-12);
  EXPECT_NEAR(image["rotation_sigma_deg"][0].get<double>(), 0.001 * 180 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(image["position_difference_m"][0].get<double>(), input.positions[2].difference_m.x(), 1e-12);
  EXPECT_TRUE(json["image_list"][1]["rotation_sigma_deg"].is_null());
  std::size_t rays = 0;
  double squares = 0;
  for (const auto& one : json["image_list"]) {
    rays += one["rays"].get<std::size_t>();
    squares += one["rays"].get<double>() * std::pow(one["rms_px"].get<double>(), 2);
  }
  const auto& camera = json["cameras"][0];
  EXPECT_EQ(camera["images"], 7);
  EXPECT_EQ(camera["rays"], rays);
  EXPECT_NEAR(camera["rms_px"].get<double>(), std::sqrt(squares / double(rays)), 1e-9);
  EXPECT_NEAR(camera["parameters"]["f"]["sigma"].get<double>(), 0.41, 1e-12);
  EXPECT_EQ(json["control_points"].size(), input.control.size());
}

TEST_F(ReportTest, AnEmptyProjectStillHasAReport) {
  ASSERT_TRUE(write_report({}, folder_));
  EXPECT_TRUE(contains(page(), "neither location nor scale"));
  EXPECT_FALSE(contains(page(), "nan"));
  EXPECT_TRUE(figures()["check_rmse_m"].is_null());
}

TEST_F(ReportTest, WithoutCheckPointsNothingIsStatedToBeVerified) {
  ReportInput input = report_of_test_flight(2, 4, 100);
  for (ControlDifference& control : input.control) control.used = true;
  EXPECT_TRUE(contains(summary_of(input).statement, "nothing independent verifies the accuracy"));
  input.control.clear();
  EXPECT_TRUE(contains(summary_of(input).statement, "positions of the cameras alone"));
  input.georeferenced = input.metric = false;
  const ReportSummary free = summary_of(input);
  EXPECT_EQ(free.unit, "units");
  EXPECT_TRUE(contains(free.statement, "neither location nor scale"));
}

TEST_F(ReportTest, ControlThatWasFoundWrongIsListedAndCounted) {
  ReportInput input = report_of_test_flight(2, 4, 100);
  ControlDifference& wrong = input.control.front();
  wrong.excluded = true;
  wrong.used = false;
  wrong.rays = 0;
  const ReportSummary summary = summary_of(input);
  EXPECT_EQ(summary.excluded_points, 1);
  EXPECT_EQ(summary.check.points, 4);
  EXPECT_TRUE(contains(summary.cautions.at(1), "1 control point was found wrong and not used"));
}

TEST_F(ReportTest, ImagesAreEmbeddedAndMissingOnesBecomeFindings) {
  fs::create_directories(folder_);
  MapGrid grid{500000, 4.98e6, 0.5, 300, 200, ""};
  {
    GeoTiffWriter<float>::Options options;
    options.nodata = -9999;
    auto writer = GeoTiffWriter<float>::create(folder_ / "dsm.tif", grid, 1, options);
    ASSERT_TRUE(writer) << writer.error().message;
    FloatImage heights(300, 200);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 300; ++x)
        heights.at(x, y) = x < 20 ? -9999.0f : 100 + 5 * std::sin(float(x) / 30) * std::cos(float(y) / 20);
    ASSERT_TRUE(writer->write(0, 0, heights));
    ASSERT_TRUE(writer->finish());
  }
  ReportInput input = report_of_test_flight(2, 4, 100);
  input.dsm = folder_ / "dsm.tif";
  input.ortho = folder_ / "missing.tif";
  ASSERT_TRUE(write_report(input, folder_));
  EXPECT_EQ(count_of(page(), "data:image/jpeg;base64,/9j/"), 1);
  EXPECT_TRUE(contains(page(), "no preview of missing.tif"));
  EXPECT_TRUE(contains(page(), "95."));  // the scale starts at the lowest height, not at nodata
}

TEST(ResidualStatistics, NoiseComesBackAsItWasPutIn) {
  const ReportInput input = report_of_test_flight(3, 6, 1500);
  const ResidualStatistics s = residual_statistics(input.block);
  ASSERT_GT(s.observations, 2000u);
  EXPECT_NEAR(s.rms_px, 0.3, 4 * 0.3 / std::sqrt(4.0 * double(s.observations)));
  EXPECT_NEAR(s.mean_px, 0.3 * std::sqrt(std::numbers::pi / 2), 0.01);  // Rayleigh distribution
  std::size_t in_histogram = 0, observations = 0, points = 0;
  for (const std::size_t n : s.histogram) in_histogram += n;
  for (const ImageResiduals& image : s.images) observations += std::size_t(image.observations);
  for (const std::size_t n : s.rays) points += n;
  EXPECT_EQ(in_histogram, 2 * s.observations);
  EXPECT_EQ(observations, s.observations);
  EXPECT_EQ(points, input.block.points.size());
  ASSERT_EQ(s.grids.size(), 1u);
  EXPECT_EQ(s.grids[0].columns, 16);
  EXPECT_EQ(s.grids[0].rows, 12);
}

TEST(ResidualStatistics, AShiftShowsInTheGridWithItsSign) {
  ReportInput input = report_of_test_flight(2, 5, 800);
  for (Observation& o : input.block.observations)
    if (o.pixel.x() < 2000) o.pixel.x() += 1.5;
  const ResidualGrid grid = residual_statistics(input.block).grids.at(0);
  Eigen::Vector2d left = Eigen::Vector2d::Zero(), right = left;
  int lefts = 0, rights = 0;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const auto i = std::size_t(row * grid.columns + column);
      (column < 7 ? left : right) += grid.mean_px[i] * grid.count[i] * (column == 7 || column == 8 ? 0 : 1);
      (column < 7 ? lefts : rights) += column == 7 || column == 8 ? 0 : grid.count[i];
    }
  EXPECT_NEAR(left.x() / lefts, 1.5, 0.05);
  EXPECT_NEAR(right.x() / rights, 0, 0.05);
  EXPECT_NEAR(left.y() / lefts, 0, 0.05);
}

TEST(ControlRms, AxesThatWereNotSurveyedDoNotCount) {
  ReportInput input = report_of_test_flight(2, 4, 50);
  for (ControlDifference& control : input.control) control.difference_m.z() = std::nan("");
  const AxisRms rms = control_rms(input, true);
  EXPECT_TRUE(rms.axis_m[0] && rms.axis_m[1]);
  EXPECT_FALSE(rms.axis_m[2]);
  EXPECT_FALSE(rms.spatial_m);
  EXPECT_EQ(rms.points, 5);
}

TEST(ControlRms, ImageResidualsReferToTheEstimatedPosition) {
  ReportInput input = report_of_test_flight(3, 6, 50);
  ControlDifference control = input.control[4];
  control.difference_m.setZero();  // the image points were made from the surveyed position
  const double expected = 0.3 * std::sqrt(2.0);
  EXPECT_NEAR(control_rms_px(input.block, control), expected, 4 * expected / std::sqrt(4.0 * control.rays));
  control.difference_m.setConstant(std::nan(""));
  EXPECT_TRUE(std::isnan(control_rms_px(input.block, control)));
}

TEST(Coverage, ANadirFootprintIsTheImageTimesTheScale) {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 800, 600);
  block.images[{0}].camera = {0};
  const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{0, 0, 0});
  set_pose(block, {0}, {rotation, -(rotation * Eigen::Vector3d(10, 20, 105))});
  block.points[{0}] = {{0, 0, 5}, {}};
  const Coverage coverage = coverage_of(block);
  EXPECT_EQ(coverage.ground_height, 5);
  Eigen::Vector2d low = coverage.footprints.at({0})[0], high = low;
  for (const auto& p : coverage.footprints.at({0})) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  EXPECT_LT((low - Eigen::Vector2d(10 - 40, 20 - 30)).norm(), 1e-9);
  EXPECT_LT((high - Eigen::Vector2d(10 + 40, 20 + 30)).norm(), 1e-9);
  EXPECT_NEAR(overlap_of(coverage, 100).area(1), 80 * 60, 1e-6);
  EXPECT_EQ(overlap_of(coverage, 100).area(2), 0);
}

TEST(Coverage, AnImageThatLooksSidewaysCoversItsTiePoints) {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 800, 600);
  block.images[{0}].camera = {0};
  set_pose(block, {0}, {cam_from_world(OmegaPhiKappa{90, 0, 0}), Eigen::Vector3d::Zero()});
  const std::vector<Eigen::Vector2d> corners = {{0, 10}, {6, 10}, {6, 14},
                                                {0, 14}, {3, 12}, {0, 90}};  // the last: far behind
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    block.points[{i}] = {{corners[i].x(), corners[i].y(), 0}, {}};
    Observation o;
    o.image = {0};
    o.point = {i};
    o.pixel.setZero();
    block.observations.push_back(o);
  }
  const Coverage coverage = coverage_of(block);
  EXPECT_EQ(coverage.footprints.at({0}).size(), 4u);
  EXPECT_NEAR(overlap_of(coverage, 60).area(1), 24, 1e-9);
}

TEST(Svg, TextCannotBreakThePage) {
  EXPECT_EQ(escaped("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(escaped("\xc3\xa9\n"), "\xc3\xa9 ");
  EXPECT_EQ(escaped(std::string("\x01\xff\xc3", 3)), "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
}

TEST(Svg, ScalesHaveRoundNumbers) {
  EXPECT_EQ(round_below(0.034), 0.02);
  EXPECT_EQ(round_below(99), 50);
  EXPECT_EQ(round_below(1), 1);
  const auto t = ticks(-0.9, 1.1, 5);
  ASSERT_EQ(t.size(), 4u);
  EXPECT_NEAR(t.front(), -0.5, 1e-12);
  EXPECT_EQ(tick_text(t.front(), 0.5), "-0.5");
  EXPECT_TRUE(ticks(1, 1, 5).empty());
}

TEST(NumberText, WhatRoundsToZeroHasNoSign) {
  EXPECT_EQ(number_text(-0.04, 1), "0.0");
  EXPECT_EQ(number_text(-0.06, 1), "-0.1");
  EXPECT_EQ(number_text(-0.4, 0), "0");
  EXPECT_EQ(number_text(-10, 0), "-10");
  EXPECT_EQ(number_text(2.345, 2), "2.35");
  EXPECT_NE(height_scale({"", 1, 1, -0.04, 9.96}, "m").find(">0.0 m<"), std::string::npos);
}

TEST(LengthText, ShowsWhatMatters) {
  EXPECT_EQ(length_text(1.23456, "m"), "1.235 m");
  EXPECT_EQ(length_text(0.0164, "m"), "0.016 m");
  EXPECT_EQ(length_text(0.00234, "m"), "0.0023 m");
  EXPECT_EQ(length_text(0.0000034, "m"), "0.0000034 m");
  EXPECT_EQ(length_text(0.000123, "units"), "0.00012 units");
  EXPECT_EQ(length_text(std::nullopt, "m"), "\xe2\x80\x93");
}

}  // namespace
}  // namespace collinea
