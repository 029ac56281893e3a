// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

// The error of reading a project.json with this text.
Error error_of(const TestFolder& folder, const std::string& text) {
  EXPECT_TRUE(write_file(folder / "project.json", text));
  const auto settings = read_settings(folder / "");
  return settings ? Error{Errc::kCancelled, "no error"} : settings.error();
}

TEST(Settings, ComeBackAsTheyWereWritten) {
  const TestFolder folder;
  Settings settings;
  settings.photos = "/photos/ü \"quoted\"";
  settings.seed = 0xfedcba9876543210u;
  settings.import.crs = "EPSG:25832";
  settings.import.check = "A2,A7";
  settings.import.gps_sigma_m = 0.1 + 0.2;  // no short decimal fraction
  settings.orient.calibration = Calibration::kFocal;
  settings.orient.use_positions = false;
  settings.orient.min_points = 23;
  settings.surface.cell_m = 0.25;
  ASSERT_TRUE(write_settings(folder / "", settings));
  const auto read = read_settings(folder / "");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->photos, settings.photos);
  EXPECT_EQ(read->seed, settings.seed);
  for (const char* step : {"import", "detect", "match", "orient", "densify", "surface", "ortho"})
    EXPECT_EQ(options_text(*read, step), options_text(settings, step));
}

TEST(Settings, OptionsLeftOutHaveTheirDefaults) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "project.json", R"({"photos": "/p", "options": {"orient": {"min_points": 30}}})"));
  const auto settings = read_settings(folder / "");
  ASSERT_TRUE(settings) << settings.error().message;
  Settings expected;
  expected.orient.min_points = 30;
  EXPECT_EQ(options_text(*settings, "orient"), options_text(expected, "orient"));
  EXPECT_EQ(options_text(*settings, "detect"), options_text(expected, "detect"));
}

TEST(Settings, AFolderWithoutProjectIsNotFound) {
  const TestFolder folder;
  const auto settings = read_settings(folder / "");
  ASSERT_FALSE(settings);
  EXPECT_EQ(settings.error().code, Errc::kNotFound);
}

TEST(Settings, WhatIsWrongIsNamedWithItsPosition) {
  const TestFolder folder;
  const struct {
    const char *text, *named;
    Errc code;
  } cases[] = {
      {R"({"photos": "/p")", "project.json", Errc::kBadFormat},
      {R"([1, 2])", "project.json", Errc::kBadFormat},
      {R"({"options": {}})", "photos", Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"orient": {"max_eror_px": 3}}})", "options.orient.max_eror_px",
       Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"orientt": {}}})", "options.orientt", Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"orient": {"max_error_px": "3"}}})", "options.orient.max_error_px",
       Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"orient": {"min_points": 20.5}}})", "options.orient.min_points",
       Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"orient": {"min_points": 4294967396}}})", "options.orient.min_points",
       Errc::kBadFormat},
      {R"({"photos": "/p", "seed": -1})", "seed", Errc::kBadFormat},
      {R"({"photos": "/p", "seed": 1.5})", "seed", Errc::kBadFormat},
      {R"({"photos": "/p", "seed": 18446744073709551616})", "seed", Errc::kBadFormat},
      {R"({"photos": "/p", "options": {"densify": {"cloud": "laz2"}}})", "las, laz or copc", Errc::kBadInput},
      {R"({"photos": "/p", "options": {"densify": {"resolution": "fulll"}}})", "full, half or quarter",
       Errc::kBadInput},
      {R"({"photos": "/p", "options": {"orient": {"max_error_px": -3}}})", "max_error_px", Errc::kBadInput},
      {R"({"photos": "/p", "options": {"orient": {"calibration": "much"}}})", "calibration", Errc::kBadInput},
  };
  for (const auto& [text, named, code] : cases) {
    const Error error = error_of(folder, text);
    EXPECT_EQ(error.code, code) << text;
    EXPECT_NE(error.message.find(named), std::string::npos) << text << " -> " << error.message;
  }
}

// As written by earlier versions, whose words were strings.
TEST(Settings, ArraysNestedWithoutEndAreRefused) {
  const TestFolder folder;
  const std::string nested = std::string(200'000, '[') + std::string(200'000, ']');
  for (const std::string text :
       {R"({"photos": "/p", "options": )" + nested + "}", R"({"photos": "/p", "options": {"orient": )" + nested + "}}",
        R"({"photos": "/p", "options": {"orient": {"max_error_px": )" + nested + "}}}"})
    EXPECT_EQ(error_of(folder, text).code, Errc::kBadFormat);
}

TEST(Settings, AnOlderProjectIsRead) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "project.json", R"({
    "photos": "/p", "seed": 3,
    "options": {
      "import": {"camera_model": "kannala_brandt", "control": "/c/gcp.csv", "crs": null, "geodetic": null},
      "pairs": {"pairs": "all"},
      "orient": {"mode": "global", "calibration": "auto", "additional": "ebner", "orientation": "/m"},
      "instruments": {"position_shift": "strips", "lever_arm": null},
      "densify": {"resolution": "half", "cloud": "laz"},
      "ortho": {"seamlines": ""}}})"));
  const auto settings = read_settings(folder / "");
  ASSERT_TRUE(settings) << settings.error().message;
  EXPECT_EQ(settings->import.camera_model, CameraModel(KannalaBrandt{}));
  EXPECT_EQ(settings->import.control, std::filesystem::path("/c/gcp.csv"));
  EXPECT_EQ(settings->pairs.pairs, PairChoice::kAll);
  EXPECT_EQ(settings->orient.mode, OrientMode::kGlobal);
  EXPECT_FALSE(settings->orient.calibration);
  EXPECT_EQ(settings->orient.additional, AdditionalSet::kEbner);
  EXPECT_EQ(settings->orient.orientation, std::filesystem::path("/m"));
  EXPECT_EQ(settings->orient.instruments.position_shift, PositionShift::kStrips);
  EXPECT_EQ(settings->densify.resolution, Resolution::kHalf);
  EXPECT_EQ(settings->densify.cloud, LasForm::kLaz);
  EXPECT_FALSE(settings->ortho.seamlines);
}

// Every word that may be chosen is written, read and shown; every other is refused with the list.
TEST(Settings, EveryChoiceGoesThroughProjectJson) {
  const TestFolder folder;
  int choices = 0;
  Settings all;
  Settings::each(all, [&](const char*, const std::string& group, auto& options) {
    for_each_field(options, [&](const auto& field, auto& owner) {
      const auto text = [&](std::string_view word) {
        return R"({"photos": "/p", "options": {")" + group + R"(": {")" + std::string(field.name) + R"(": ")" +
               std::string(word) + R"("}}})";
      };
      std::vector<std::string_view> known;
      for (const Choice& choice : field.choices()) {
        known.push_back(choice.word);
        ++choices;
        ASSERT_TRUE(write_file(folder / "project.json", text(choice.word)));
        const auto settings = read_settings(folder / "");
        ASSERT_TRUE(settings) << choice.word << ": " << settings.error().message;
        ASSERT_TRUE(write_settings(folder / "", *settings));
        EXPECT_NE(read_file(folder / "project.json")
                      ->find("\"" + std::string(field.name) + "\": \"" + std::string(choice.word) + "\""),
                  std::string::npos);
      }
      using Value = OptionValue<decltype(owner.*field.member)>;
      if (known.empty() || detail::kIsWordOr<Value>) return;  // where other texts may stand too
      const Error error = error_of(folder, text("nonsense"));
      EXPECT_NE(error.message.find("choose " + listed(known)), std::string::npos) << error.message;
      EXPECT_EQ(error.options, std::vector{OptionName{std::string(field.name)}});
    });
  });
  EXPECT_GT(choices, 25);
}

TEST(Settings, NamesThatAreNotUtf8AreRefusedBeforeTheyAreDamaged) {
  Settings photos, control;
  photos.photos = "/photos/M\xfcnchen";
  control.photos = "/photos/M\xc3\xbcnchen";
  EXPECT_TRUE(validate_settings(control));
  control.import.control = "/control/M\xfcnchen.csv";
  for (const Settings& settings : {photos, control}) {
    const auto valid = validate_settings(settings);
    ASSERT_FALSE(valid);
    EXPECT_EQ(valid.error().code, Errc::kBadInput);
    EXPECT_NE(valid.error().message.find("UTF-8"), std::string::npos) << valid.error().message;
  }
}

TEST(Settings, ASeedChangesEveryStepAndAnOptionOnlyItsOwn) {
  const Settings before;
  Settings seed, option;
  seed.seed = 2;
  option.match.max_ratio = 0.5 * (before.match.max_ratio + 1);
  for (const char* step : {"import", "detect", "match", "orient", "densify", "surface", "ortho"}) {
    EXPECT_NE(options_text(seed, step), options_text(before, step)) << step;
    EXPECT_EQ(options_text(option, step) == options_text(before, step), step != std::string("match")) << step;
  }
}

TEST(Settings, ChosenOptionsAreThoseThatDifferFromTheDefaults) {
  Settings settings;
  EXPECT_TRUE(chosen_options(settings).empty());
  settings.import.crs = "EPSG:25832";
  settings.orient.max_error_px = 2.5;
  settings.orient.use_control = false;
  settings.seed = 9;
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"import.crs", "EPSG:25832"}, {"orient.max_error_px", "2.5 px"}, {"orient.use_control", "false"}, {"seed", "9"}};
  EXPECT_EQ(chosen_options(settings), expected);
}

}  // namespace
}  // namespace collinea
