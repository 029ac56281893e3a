// SPDX-License-Identifier: Apache-2.0
// Adjustments without a project: what is exported and imported, and what others published.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "collinea/adjust/test_block.h"
#include "collinea/base/file.h"
#include "collinea/base/source_tree.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/text.h"
#include "collinea/jobs/adjust_project.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

using nlohmann::json;

/// Rows of a table by their first field.
std::map<std::string, std::vector<std::string>> table_in(const std::filesystem::path& path) {
  std::map<std::string, std::vector<std::string>> rows;
  const std::string text = read_file(path).value_or("");
  for (const std::string_view line : lines_of(text)) {
    const auto fields = fields_of(line, ',');
    rows[std::string(fields[0])] = {fields.begin(), fields.end()};
  }
  return rows;
}

// Once plainly, once with everything that instruments can have.
class AdjustFileRoundTrip : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(WithAndWithoutInstruments, AdjustFileRoundTrip, ::testing::Bool());

TEST_P(AdjustFileRoundTrip, WhatAProjectExportsGivesTheSameAdjustment) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto file = folder / "block.txt";
  // As a file is adjusted.
  AdjustmentOptions options{.loss = Loss::kHuber, .reject_mismatches = false, .snoop = false};
  if (GetParam()) {
    options.instruments = {.lever_arm = "estimate",
                           .position_shift = PositionShift::kBlock,
                           .position_drift = true,
                           .time_offset = true,
                           .use_attitudes = true};
  }
  ASSERT_TRUE(export_adjustment(*project, options, file));
  ASSERT_TRUE(try_adjustment(*project, options, folder / "trial"));
  const auto done = adjust_file(file, folder / "out", {}, {});
  ASSERT_TRUE(done) << done.error().message;
  const json ours = report_in(folder / "trial"), again = report_in(folder / "out");
  EXPECT_EQ(ours.at("redundancy"), again.at("redundancy"));
  EXPECT_EQ(ours.at("unknowns"), again.at("unknowns"));
  ASSERT_EQ(ours.contains("auxiliary_unknowns"), GetParam());
  if (GetParam()) {
    const json &own = ours.at("auxiliary_unknowns"), &others = again.at("auxiliary_unknowns");
    ASSERT_EQ(own.size(), 13u);  // arm, shift, drift and boresight of three axes each, and the time offset
    ASSERT_EQ(others.size(), own.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      EXPECT_EQ(own[i].at("unknown"), others[i].at("unknown"));
      const double sigma = own[i].at("sigma");
      EXPECT_NEAR(own[i].at("value").get<double>(), others[i].at("value").get<double>(), 1e-4 * sigma);
      EXPECT_NEAR(sigma, others[i].at("sigma").get<double>(), 1e-5 * sigma);
    }
    // What is asked otherwise takes the place of what the file says.
    const auto without = adjust_file(file, folder / "out",
                                     {.instruments = {.lever_arm = "0,0,0.1",
                                                      .position_shift = PositionShift::kNone,
                                                      .time_offset = false,
                                                      .use_attitudes = false}},
                                     {});
    ASSERT_TRUE(without) << without.error().message;
    EXPECT_FALSE(report_in(folder / "out").contains("auxiliary_unknowns"));
    ASSERT_TRUE(adjust_file(file, folder / "out", {}, {}));
  }
  EXPECT_NEAR(ours.at("sigma0").get<double>(), again.at("sigma0").get<double>(), 1e-9);
  const auto poses = table_in(folder / "trial" / "poses.csv"), back = table_in(folder / "out" / "poses.csv");
  ASSERT_EQ(poses.size(), back.size());
  for (const auto& [image, row] : poses)
    for (std::size_t i = 1; i < row.size(); ++i) {
      if (const auto value = number(row[i])) {
        EXPECT_NEAR(*value, *number(back.at(image)[i]), 1e-6 * std::max(1.0, std::abs(*value))) << image << " " << i;
      }
    }
  // Once more through the file itself.
  ASSERT_TRUE(convert_adjustment(*read_adjustment(file), folder / "copy.txt"));
  EXPECT_TRUE(adjust_file(folder / "copy.txt", folder / "out", {}, {}));
}

// The options of an export are those of the adjustment, whatever is the usual one of a file.
TEST(AdjustFile, WhatIsExportedIsAdjustedAsItWasAskedFor) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const AdjustmentOptions all[] = {{},
                                   {.loss = Loss::kCauchy, .loss_scale_sigmas = 1, .snoop = false},
                                   {.refraction = RefractionChoice::kOn, .snoop = true},
                                   {.variance_components = true, .tests = {.false_alarm = 0.01, .sigma0_known = true}}};
  for (const AdjustmentOptions& asked : all) {
    ASSERT_TRUE(export_adjustment(*project, asked, folder / "block.txt"));
    const auto tried = try_adjustment(*project, asked, folder / "trial");
    ASSERT_TRUE(tried) << tried.error().message;
    const auto read = read_adjustment(folder / "block.txt");
    ASSERT_TRUE(read) << read.error().message;
    const auto done = adjust_file(*read, folder / "out", {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_NEAR(done->adjusted.sigma0, tried->adjusted.sigma0, 1e-7);
    EXPECT_EQ(done->adjusted.redundancy, tried->adjusted.redundancy);
    EXPECT_EQ(done->snooped.has_value(), tried->snooped.has_value());
    EXPECT_EQ(done->components.has_value(), asked.variance_components);
    EXPECT_EQ(done->refracted.has_value(), asked.refraction == RefractionChoice::kOn);
    EXPECT_EQ(done->adjusted.reliability->rejected, tried->adjusted.reliability->rejected);
    EXPECT_EQ(done->adjusted.reliability->false_alarm, asked.tests.false_alarm);
    ASSERT_EQ(done->adjusted.control.size(), tried->adjusted.control.size());
    for (std::size_t i = 0; i < done->adjusted.control.size(); ++i)
      EXPECT_LT((*done->adjusted.control[i].position_in_world - *tried->adjusted.control[i].position_in_world).norm(),
                1e-6);
  }
}

TEST(AdjustFile, OptionsThatAFileStatesAreChecked) {
  const TestFolder folder;
  const auto file = folder / "block.txt";
  const struct {
    const char *line, *said;
  } cases[] = {{"option los huber", "line 2: adjust has no option \"los\"; did you mean loss?"},
               {"option loss hubert", "line 2: option loss: "},
               {"option folds 1", "line 2: option folds: "},
               {"option snoop perhaps", "yes or no is expected"},
               {"option loss none\noption loss huber", "line 3: a second option loss, before in line 2"}};
  for (const auto& [line, said] : cases) {
    ASSERT_TRUE(
        write_file(file, "collinea-adjustment 1\n" + std::string(line) +
                             "\ncamera a 10 10 brown\nparameter a f 9 fixed\nimage i a\nmeasured_tie i 1 2 3 1\n"));
    const auto read = read_adjustment(file);
    ASSERT_FALSE(read) << line;
    EXPECT_EQ(read.error().code, Errc::kBadFormat) << line;
    EXPECT_NE(read.error().message.find(said), std::string::npos) << read.error().message;
  }
}

TEST(AdjustFile, SigmasOfAFileAreThoseThatAreGiven) {
  const auto done = adjust_file("nowhere.txt", "nowhere", {.given_sigmas = true}, {});
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().message.starts_with("a file states its sigmas itself")) << done.error().message;
  EXPECT_EQ(done.error().options, std::vector{"given_sigmas"_option});
}

TEST(AdjustFile, ErrorsNameTheFileAndTheLine) {
  const TestFolder folder;
  const auto file = folder / "broken.txt";
  ASSERT_TRUE(write_file(file, "collinea-adjustment 1\ncamera a 10 x brown\n"));
  const auto done = adjust_file(file, folder / "out", {}, {});
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("broken.txt: line 2: "), std::string::npos) << done.error().message;
  EXPECT_EQ(adjust_file(folder / "none", folder / "out", {}, {}).error().code, Errc::kNotFound);
  ASSERT_TRUE(write_file(file,
                         "collinea-adjustment 1\ncamera a 10 10 brown\nparameter a f 9 fixed\nimage i a\n"
                         "measured_tie i 1 2 3 1\n"));
  const auto lost = adjust_file(file, folder / "out", {}, {});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, Errc::kIllPosed);
  EXPECT_NE(lost.error().message.find("no image has an approximate pose"), std::string::npos);
}

// The example of the manual: measurements of 0.3 px from 109 m with a focal length of 3610 px are 9 mm on the ground,
// and about twice that in height; three times that, and the survey of 2 to 3 cm, is what the check point may be off.
TEST(AdjustFile, TheExampleOfTheManualAdjusts) {
  const auto page = std::filesystem::path(source_tree()) / "docs/manual/adjustment-file.md";
  const std::string manual = read_file(page).value_or("");
  std::string example;
  for (std::string_view line : lines_of(manual)) {
    if (line.starts_with("    collinea-adjustment")) example = "\n";
    if (!example.empty() && line.starts_with("    ")) example += std::string(line.substr(4)) + "\n";
    if (line.starts_with("## The lines")) break;
  }
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "example.txt", example));
  const auto done = adjust_file(folder / "example.txt", folder / "out", {.loss = Loss::kNone}, {});
  ASSERT_TRUE(done) << done.error().message;
  const json report = report_in(folder / "out");
  EXPECT_TRUE(report.at("undetermined").is_null());
  for (const json& point : report.at("control_points")) {
    EXPECT_EQ(point.at("role"), point.at("name") == "C1" ? "check" : "control");
    for (const json& difference : point.at("difference_m")) {
      if (difference.is_number()) {
        EXPECT_LT(std::abs(difference.get<double>()), 0.1) << point.dump();
      }
    }
  }
  EXPECT_LT(report.at("sigma0").get<double>(), 2);
}

/// A block of coded targets without any coordinates: images, rough poses in a unit of its own, bars between targets.
struct BarBlock {
  testing::Marked made = testing::marked({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.3, .seed = 2});

  BarBlock() {
    for (auto [id, pose] : oriented_images(made.block)) {
      pose.translation *= 1.3;
      set_pose(made.block, id, pose);
    }
    for (auto& [id, point] : made.block.points) point.position_in_world *= 1.3;
  }
  void bar(std::uint32_t from, std::uint32_t to, double error_m) {
    made.measure(GeodeticKind::kDistance, from, to, 0.001);
    made.block.geodetic.back().value += error_m;
  }
  // Without the lines of points that have no coordinates.
  [[nodiscard]] std::string text() const {
    AdjustmentFile file{.block = made.block};
    file.given_cameras = made.block.cameras;
    for (const auto& [id, camera] : made.block.cameras) file.camera_sigmas[id] = {};
    const std::string whole = adjustment_file_text(file);
    std::string text;
    for (const std::string_view line : lines_of(whole))
      if (!line.starts_with("control ")) text += std::string(line) + "\n";
    return text;
  }
};

TEST(AdjustFile, AScaleBarBetweenTargetsGivesTheScale) {
  BarBlock block;
  block.bar(0, 3, 0);
  block.bar(1, 4, 0.001);
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "bars.txt", block.text()));
  const auto done = adjust_file(folder / "bars.txt", folder / "out", {.loss = Loss::kNone}, {});
  ASSERT_TRUE(done) << done.error().message;
  const json report = report_in(folder / "out");
  ASSERT_EQ(report.at("geodetic").size(), 2u);
  for (const json& bar : report.at("geodetic")) {
    EXPECT_LT(std::abs(bar.at("difference").get<double>()), 0.003);
    EXPECT_GT(std::abs(bar.at("difference").get<double>()), 1e-6);
  }
  // All targets are as far from each other as they truly are, and not 1.3 times that.
  std::map<std::string, Eigen::Vector3d> found;
  for (const auto& [name, row] : table_in(folder / "out" / "control.csv"))
    if (row.size() > 17 && number(row[15]))
      found[name] = {number(row[15]).value(), number(row[16]).value(), number(row[17]).value()};
  ASSERT_EQ(found.size(), block.made.truth.size());
  for (const auto& [a, at_a] : block.made.truth)
    for (const auto& [b, at_b] : block.made.truth) {
      const auto at = [&](ControlId id) { return found.at("\"gcp" + std::to_string(id.value) + "\""); };
      EXPECT_NEAR((at(a) - at(b)).norm(), (at_a - at_b).norm(), 0.2);  // marks of 0.3 px are 12 mm in an image
    }
}

TEST(AdjustFile, BarsThatContradictEachOtherAreNamed) {
  BarBlock block;
  block.bar(0, 3, 0);
  block.bar(1, 4, 0.5);
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "bars.txt", block.text()));
  const auto done = adjust_file(folder / "bars.txt", folder / "out", {.loss = Loss::kNone}, {});
  const std::string named =
      done ? report_in(folder / "out").at("reliability").at("suspects").dump() : done.error().message;
  for (const char* bar : {"gcp0 - gcp3", "gcp1 - gcp4"}) EXPECT_NE(named.find(bar), std::string::npos) << named;
}

// An end that a single image shows has no position to begin at, and a bar between names that nobody marked is none.
TEST(AdjustFile, ABarThatNothingHoldsIsNamed) {
  BarBlock block;
  block.bar(0, 3, 0);
  const std::string good = block.text();
  const TestFolder folder;
  const auto message = [&](const std::string& text) {
    EXPECT_TRUE(write_file(folder / "bars.txt", text));
    const auto done = adjust_file(folder / "bars.txt", folder / "out", {}, {});
    return done ? std::string("accepted") : done.error().message;
  };
  EXPECT_NE(message(good + "ground distance gcp0 gcp77 3 0.01 control\n").find("no control or check point \"gcp77\""),
            std::string::npos);
  std::string once;
  int seen = 0;
  for (const std::string_view line : lines_of(good))
    if (line.find(" gcp3 ") == std::string_view::npos || !line.starts_with("measured_") || seen++ == 0)
      once += std::string(line) + "\n";
  EXPECT_NE(message(once).find("or measure it in a second image"), std::string::npos);
  // With a line of its own it is accepted, and the bar is reported to take no part.
  EXPECT_EQ(message(once + "control gcp3 - - - - - -\n"), "accepted");
  EXPECT_NE(report_in(folder / "out").dump().find("geodetic_left_out"), std::string::npos);
}

std::string line_of_words(std::initializer_list<std::string_view> words) {
  std::string line;
  for (const std::string_view word : words) line += std::string(word) + " ";
  return line + "\n";
}

std::filesystem::path shared_data() { return std::filesystem::path(source_tree()) / "../shared/data"; }

// Published by the authors of DBAT for its camera calibration demo (21 images, 100 points, lens of measured
// coordinates): sigma 0 1.6148 with a redundancy of 3725, cc 7.45699532 mm +- 0.00105 and so on.
TEST(PublishedAdjustment, CameraCalibrationDemo) {
  const auto script = shared_data() / "dbat_text/script/camcaldemo/camcaldemo.xml";
  if (!std::filesystem::exists(script)) GTEST_SKIP() << "needs the shared data";
  const TestFolder folder;
  const auto done = adjust_file(script, folder / "out", {.loss = Loss::kNone}, {});
  ASSERT_TRUE(done) << done.error().message;
  const json report = report_in(folder / "out");
  EXPECT_NEAR(report.at("sigma0").get<double>(), 1.6148, 5e-5);
  EXPECT_EQ(report.at("redundancy"), 3725);
  const json camera = report.at("cameras").at(0).at("parameters");
  const auto value = [&](const char* name) { return camera.at(name).at("value").get<double>(); };
  const double pixel = 5.43764 / 1704, c = value("f") * pixel,
               sigma_c = camera.at("f").at("sigma").get<double>() * pixel;
  constexpr double kWanted = 0.02;  // of the published standard deviations
  EXPECT_NEAR(c, 7.45699532273933752, kWanted * 0.00105);
  EXPECT_NEAR(sigma_c / 0.00105, 1, 0.01);
  EXPECT_NEAR(value("cx") * pixel, 3.61546239970888994, kWanted * 0.00082);
  EXPECT_NEAR(value("cy") * pixel, 2.61329279848268081, kWanted * 0.00098);
  EXPECT_NEAR(value("k1") / (c * c), 0.00458860662755811253, kWanted * 2.21e-5);
  EXPECT_NEAR(value("k2") / std::pow(c, 4), -4.51350997187018702e-05, kWanted * 2.65e-6);
  EXPECT_NEAR(value("k3") / std::pow(c, 6), -2.05253370760761127e-06, kWanted * 1.01e-7);
  EXPECT_NEAR(value("p1") / c, -6.12803065099492536e-05, kWanted * 3.52e-6);
  EXPECT_NEAR(-value("p2") / c, -4.41170561685059337e-05, kWanted * 3.94e-6);
  EXPECT_NEAR(-value("b1") / (value("f") + value("b1")), 0.000389597677690423, kWanted * 2.08e-5);
  const auto row = table_in(folder / "out" / "poses.csv").at("\"P8250021.JPG\"");
  const double expected[] = {0.454947, 1.793849, 1.468066, -39.413082, -1.183179, -179.838467};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(*number(row[1 + i]), expected[i], 1.5e-6);
  const double sigmas[] = {0.000155, 0.000179, 0.000207};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(*number(row[7 + i]) / sigmas[i], 1, 0.01);
  const double angles[] = {0.0085, 0.00761, 0.00275};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(*number(row[13 + i]) / angles[i], 1, 0.01);
}

// Control of an export fixed, and weighted by 1 mm: prague2016.
TEST(PublishedAdjustment, FixedAndWeightedControl) {
  const auto exported = shared_data() / "dbat_text/prague2016/cam/pmexports/fixed-no-orient-pmexport.txt";
  if (!std::filesystem::exists(exported)) GTEST_SKIP() << "needs the shared data";
  const TestFolder folder;
  ASSERT_TRUE(convert_adjustment(*read_adjustment(exported), folder / "fixed.txt"));
  std::string text = *read_file(folder / "fixed.txt");
  ASSERT_TRUE(adjust_file(folder / "fixed.txt", folder / "fixed", {.loss = Loss::kNone}, {}));
  EXPECT_NEAR(report_in(folder / "fixed").at("sigma0").get<double>(), 1.78095, 5e-6);
  EXPECT_EQ(report_in(folder / "fixed").at("redundancy"), 3734);
  auto row = table_in(folder / "fixed" / "poses.csv").at("\"P8250021.JPG\"");
  const double fixed[] = {-0.045117, 1.294186, 1.469723, -39.433594, -1.177710, -179.839440};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(*number(row[1 + i]), fixed[i], 5.1e-7);
  const std::string exact = " 0 0 0\n", weighted = " 0.001 0.001 0.001\n";
  for (std::size_t at = text.find("\ncontrol 10"); at != std::string::npos; at = text.find("\ncontrol 10", at + 1)) {
    const std::size_t end = text.find('\n', at + 1) + 1;
    ASSERT_EQ(text.substr(end - exact.size(), exact.size()), exact);
    text.replace(end - exact.size(), exact.size(), weighted);
  }
  ASSERT_TRUE(write_file(folder / "weighted.txt", text));
  ASSERT_TRUE(adjust_file(folder / "weighted.txt", folder / "weighted", {.loss = Loss::kNone}, {}));
  EXPECT_NEAR(report_in(folder / "weighted").at("sigma0").get<double>(), 1.60984, 5e-6);
  row = table_in(folder / "weighted" / "poses.csv").at("\"P8250021.JPG\"");
  // Its control lies 2.5 um further along x.
  const double shifted[] = {-0.044862 - 2.5e-6, 1.294258, 1.469618, -39.437121, -1.170854, -179.836957};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(*number(row[1 + i]), shifted[i], 6e-7);
  EXPECT_NEAR(*number(row[7]) / 0.00291, 1, 0.01);
}

// The corrected results of the exercises: one point from two images of known orientation, and one image from five
// points. Focal length 8.865 mm, pixels of 2.41 um, rows counted downwards.
TEST(PublishedAdjustment, CollinearityExercises) {
  const auto data = shared_data() / "collinearity_exercises/data";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "needs the shared data";
  const TestFolder folder;
  const std::string head = "collinea-adjustment 1\ncamera c 5472 3648 brown\nparameter c f " + exact(8.865 / 0.00241) +
                           " fixed\nparameter c cx 2737.24 fixed\nparameter c cy 1839.91 fixed\n";
  std::string text = head;
  const std::string two = *read_file(data / "inter/inputInter02.txt"),
                    five = *read_file(data / "resec/resecResc121.inp");
  for (const std::string_view line : lines_of(two)) {
    const auto w = words_of(line);
    if (w.size() < 9) continue;
    text += line_of_words({"image", w[0], "c"}) +
            line_of_words({"pose", w[0], w[3], w[4], w[5], w[6], w[7], w[8], "fixed"}) +
            line_of_words({"measured_tie", w[0], "9", w[1], w[2].substr(1), "1"});
  }
  ASSERT_TRUE(write_file(folder / "two.txt", text));
  const auto done = adjust_file(folder / "two.txt", folder / "two", {.loss = Loss::kNone}, {});
  ASSERT_TRUE(done) << done.error().message;
  const auto point = table_in(folder / "two" / "points.csv").at("9");
  const double intersected[] = {265516.57, 6239995.97, 87.69};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(*number(point[1 + i]), intersected[i], 0.0055);
  text = head + "image DJI_0121 c\n";
  for (const std::string_view line : lines_of(five)) {
    const auto w = words_of(line);
    if (w.size() != 6) continue;
    text += line_of_words({"control", w[0], w[3], w[4], w[5], "0 0 0"}) +
            line_of_words({"measured_control DJI_0121", w[0], w[1], w[2], "1"});
  }
  ASSERT_TRUE(write_file(folder / "five.txt", text));
  ASSERT_TRUE(adjust_file(folder / "five.txt", folder / "five", {.loss = Loss::kNone}, {}));
  const auto image = table_in(folder / "five" / "poses.csv").at("\"DJI_0121\"");
  const double resected[] = {-49652.05, -3758661.01, 140.36, -10.731, 0.324, -177.159};
  const double digits[] = {0.0055, 0.0055, 0.0055, 0.00055, 0.00055, 0.00055};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(*number(image[1 + i]), resected[i], digits[i]);
  // 4.6 px in the mean of ten coordinates, of which four are redundant.
  EXPECT_NEAR(report_in(folder / "five").at("sigma0").get<double>() * std::sqrt(4 / 10.0), 4.6, 0.05);
}

// Additional parameters from the command to the report, and through the file.
TEST(AdjustFile, AdditionalParametersAreTestedAndKept) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 14;
  survey.control_points = 8;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 150, .wrong_share = 0});
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const AdjustmentOptions asked{.additional = AdditionalSet::kEbner,
                                .additional_fixed = "a3",
                                .loss = Loss::kHuber,
                                .reject_mismatches = false,
                                .snoop = false};
  const auto adjusted = try_adjustment(*project, asked, folder / "trial");
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->additional.size(), 1u);
  EXPECT_EQ(adjusted->additional[0].parameters.size(), 11u);
  ASSERT_TRUE(export_adjustment(*project, asked, folder / "block.txt"));
  const auto done = adjust_file(folder / "block.txt", folder / "out", {}, {});
  ASSERT_TRUE(done) << done.error().message;
  const json ours = report_in(folder / "trial"), again = report_in(folder / "out");
  ASSERT_EQ(ours.at("additional").size(), 1u);
  const json &test = ours.at("additional").at(0), &other = again.at("additional").at(0);
  EXPECT_EQ(test.at("set"), "ebner");
  EXPECT_EQ(test.at("parameters").size(), 11u);
  EXPECT_NEAR(test.at("f").get<double>(), other.at("f").get<double>(), 1e-4 * test.at("f").get<double>());
  for (std::size_t i = 0; i < 11; ++i) {
    const json &one = test.at("parameters").at(i), &same = other.at("parameters").at(i);
    EXPECT_NE(one.at("parameter"), "a3");
    EXPECT_NEAR(one.at("sigma_px").get<double>(), same.at("sigma_px").get<double>(), 1e-6);
    EXPECT_GT(one.at("sigma_px").get<double>(), 0);
  }
  const json& parameters = ours.at("cameras").at(0).at("parameters");
  EXPECT_TRUE(parameters.contains("a12"));
  EXPECT_EQ(parameters.at("p1").at("sigma"), 0);  // the set says the same
  EXPECT_NE(read_file(folder / "out" / "adjustment.html")->find("<h2>Additional parameters</h2>"), std::string::npos);
  for (const AdjustmentOptions& wrong :
       {AdjustmentOptions{.additional = AdditionalSet::kEbner, .additional_fixed = "a13"},
        AdjustmentOptions{.additional_fixed = "a1"}})
    EXPECT_EQ(try_adjustment(*project, wrong, folder / "trial").error().code, Errc::kBadInput);
  const auto bent = try_adjustment(*project, {.refraction = RefractionChoice::kOn}, folder / "trial");
  ASSERT_TRUE(bent) << bent.error().message;
}

}  // namespace
}  // namespace collinea
