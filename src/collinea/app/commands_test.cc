// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <nlohmann/json.hpp>

#include "collinea/app/command_for_tests.h"
#include "collinea/app/exit_code.h"
#include "collinea/base/file.h"
#include "collinea/base/source_tree.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/project/project.h"
#include "collinea/report/signed_files.h"

namespace collinea {
namespace {

using testing::collinea_with;
using testing::Outcome;

// A folder with three small images of a made-up village in images/.
void simulate_into(const std::string& folder) {
  const Outcome made = collinea_with({"simulate",       folder, "--strips",         "1",   "--images-per-strip", "3",
                                      "--cross-strips", "0",    "--width-px",       "160", "--height-px",        "120",
                                      "--gsd-m",        "0.5",  "--control-points", "2",   "--check-points",     "1",
                                      "--progress",     "none"});
  ASSERT_EQ(made.code, 0) << made.err;
}

TEST(Commands, EveryOneExplainsItself) {
  for (const Command& command : all_commands()) {
    const Outcome outcome = collinea_with({command.name, "--help"});
    EXPECT_EQ(outcome.code, 0) << command.name;
    EXPECT_NE(outcome.out.find(command.summary.substr(0, 20)), std::string::npos)
        << command.name << ": " << outcome.out;
    EXPECT_EQ(outcome.err, "") << command.name;
  }
}

TEST(Commands, EveryOneHasItsPageInTheManual) {
  for (const Command& command : all_commands()) {
    const auto path = std::filesystem::path(source_tree()) / "docs/manual" / (command.name + ".md");
    const std::string page = read_file(path).value_or("");
    EXPECT_TRUE(page.starts_with("# collinea " + command.name + "\n")) << path;
    EXPECT_NE(page.find("<!-- options: made by"), std::string::npos)
        << path << " has no place for the table of options";
  }
}

TEST(Commands, RunHelpNamesEveryOptionOfEveryStep) {
  const std::string help = collinea_with({"run", "--help"}).out;
  Settings settings;
  Settings::each(settings, [&](const char*, const char* group, auto& options) {
    for_each_field(options, [&](const auto& field, const auto&) {
      std::string flag = "--" + std::string(field.name);
      std::replace(flag.begin(), flag.end(), '_', '-');
      EXPECT_NE(help.find(flag), std::string::npos) << group << ": " << flag;
    });
  });
}

TEST(Commands, HelpListsChoicesAndKindsOfPaths) {
  const std::string help = collinea_with({"orient", "--help"}).out;
  for (const char* part : {"--calibration WORD=auto", "focal_radial (f k1 k2)", "--position-shift WORD=none",
                           "--orientation PATH", "instruments:"})
    EXPECT_NE(help.find(part), std::string::npos) << part << "\n" << help;
  EXPECT_EQ(help.find("brown_affinity"), std::string::npos);  // not of orient
  const std::string adjust = collinea_with({"adjust", "--help"}).out;
  for (const char* part : {"brown_affinity", "--lever-arm", "--false-alarm", "instruments:"})
    EXPECT_NE(adjust.find(part), std::string::npos) << part;
  const std::string simulate = collinea_with({"simulate", "--help"}).out;
  for (const char* part : {"--width-px", "--facade-width-px", "--gps-sigma-plan-m", "--facade-crs"})
    EXPECT_NE(simulate.find(part), std::string::npos) << part;
}

TEST(Commands, TheListOfCommandsIsInTheHelp) {
  const Outcome outcome = collinea_with({"--help"});
  EXPECT_EQ(outcome.code, 0);
  for (const Command& command : all_commands())
    EXPECT_NE(outcome.out.find(command.name), std::string::npos) << command.name;
  for (const CommandGroup& group : command_groups())
    EXPECT_NE(outcome.out.find(group.heading), std::string::npos) << group.heading;
}

TEST(Commands, WrongUsageEndsWithTwoAndWordsOnStderr) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "photos");
  const std::string photos = (folder / "photos").string(), project = (folder / "project").string();
  const struct {
    std::vector<std::string> arguments;
    const char* named;
  } cases[] = {
      {{}, "subcommand"},
      {{"mapp"}, "\"mapp\""},
      {{"run"}, "photos"},
      {{"run", photos}, "--project"},
      {{"run", photos, "-o", project, "--no-such-flag", "3"}, "--no-such-flag"},
      {{"run", photos, "-o", project, "--min-points", "many"}, "--min-points"},
      {{"run", photos, "-o", project, "--min-points", "2"}, "(option --min-points)"},
      {{"run", photos, "-o", project, "--calibration", "much"}, "auto, none, focal, focal_radial or brown"},
      {{"run", photos, "-o", project, "--cloud", "laz2"}, "las, laz or copc"},
      {{"run", photos, "-o", project, "--resolution", "fulll"}, "full, half or quarter"},
      {{"run", photos, "-o", project, "--seed", "-1"}, "--seed"},
      {{"run", photos, "-o", project, "--threads", "-1"}, "threads"},
      {{"run", photos, "-o", project, "--progress", "loud"}, "--progress"},
      {{"run", photos, "-o", project, "--until", "orthofoto"}, "\"orthofoto\""},
      {{"simulate", project, "--scene", "moon"}, "--scene"},
      {{"simulate", project, "--strips", "0"}, "strips"},
  };
  for (const auto& [arguments, named] : cases) {
    const Outcome outcome = collinea_with(arguments);
    EXPECT_EQ(outcome.code, 2) << named;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << named << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "") << named;
  }
  EXPECT_FALSE(std::filesystem::exists(project));
}

TEST(Commands, WhatIsNotThereEndsWithThree) {
  const TestFolder folder;
  const std::string nothing = (folder / "nothing").string(), project = (folder / "project").string();
  const std::vector<std::vector<std::string>> cases = {{"run", nothing, "-o", project},
                                                       {"import", nothing, "-o", project},
                                                       {"orient", nothing},
                                                       {"report", nothing},
                                                       {"info", nothing},
                                                       {"info", nothing, "--json"},
                                                       {"verify", nothing},
                                                       {"export", nothing, project},
                                                       {"assess", nothing, nothing}};
  for (const auto& arguments : cases) {
    const Outcome outcome = collinea_with(arguments);
    EXPECT_EQ(outcome.code, 3) << arguments[0] << ": " << outcome.err;
    EXPECT_NE(outcome.err.find(nothing), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
  EXPECT_FALSE(std::filesystem::exists(nothing));
}

TEST(Commands, AnErrorIsShownEvenWhereNoProgressIs) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "photos");
  const Outcome outcome =
      collinea_with({"run", (folder / "photos").string(), "-o", (folder / "project").string(), "--progress", "none"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("0 usable photographs"), std::string::npos) << outcome.err;
}

TEST(Commands, ImportThenInfo) {
  const TestFolder folder;
  simulate_into((folder / "block").string());
  const std::string images = (folder / "block/images").string(), project = (folder / "project").string();
  const Outcome imported = collinea_with({"import", images, "-o", project, "--progress", "json"});
  EXPECT_EQ(imported.code, 0) << imported.err;
  EXPECT_EQ(imported.out, "");
  std::istringstream lines(imported.err);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_TRUE(nlohmann::json::accept(line)) << line;
  EXPECT_GT(count, 1);
  const Outcome info = collinea_with({"info", project, "--json"});
  EXPECT_EQ(info.code, 0);
  EXPECT_EQ(nlohmann::json::parse(info.out).at("images"), 3);
  EXPECT_EQ(collinea_with({"info", project}).code, 0);
  std::ifstream log(project + "/log.txt");
  std::ostringstream text;
  text << log.rdbuf();
  EXPECT_NE(text.str().find("import   3 images"), std::string::npos) << text.str();
}

TEST(Commands, AStepKeepsTheOptionsThatWereNotGiven) {
  const TestFolder folder;
  simulate_into((folder / "block").string());
  const std::string images = (folder / "block/images").string(), project = (folder / "project").string();
  ASSERT_EQ(
      collinea_with({"run", images, "-o", project, "--until", "import", "--max-features", "500", "--seed", "7"}).code,
      0);
  const Settings before = read_settings(project).value();
  const Outcome detected = collinea_with({"detect", project, "--max-features", "600"});
  EXPECT_EQ(detected.code, 0) << detected.err;
  const Settings after = read_settings(project).value();
  EXPECT_EQ(after.detect.sift.max_features, 600);
  EXPECT_EQ(after.seed, 7u);
  Settings expected = before;
  expected.detect.sift.max_features = 600;
  EXPECT_EQ(options_text(after, "detect"), options_text(expected, "detect"));
  EXPECT_EQ(options_text(after, "match"), options_text(before, "match"));
}

TEST(Commands, ExportBeforeOrientationIsNotFound) {
  const TestFolder folder;
  simulate_into((folder / "block").string());
  const std::string project = (folder / "project").string();
  ASSERT_EQ(collinea_with({"import", (folder / "block/images").string(), "-o", project}).code, 0);
  const Outcome outcome = collinea_with({"export", project, (folder / "out").string()});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("not oriented yet"), std::string::npos) << outcome.err;
}

TEST(Commands, ExportSaysWhatItLeavesOut) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "photos");
  Block block;
  block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
  for (std::uint32_t i = 0; i < 3; ++i)
    block.images[ImageId{i}] = {.file = std::to_string(i) + ".jpg", .camera = CameraId{0}};
  for (std::uint32_t i = 0; i < 2; ++i) set_pose(block, ImageId{i}, {});
  {
    Settings settings;
    settings.photos = (folder / "photos").string();
    auto project = create_project(folder / "project", settings, {});
    ASSERT_TRUE(project) << project.error().message;
    ASSERT_TRUE(project->store.write_setup(block));
    ASSERT_TRUE(project->store.write_orientation(block));
  }
  const std::string out = (folder / "out").string();
  const Outcome outcome = collinea_with({"export", (folder / "project").string(), out});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, out + "\n");
  EXPECT_NE(outcome.err.find("note: 1 image without orientation is left out."), std::string::npos) << outcome.err;
}

TEST(Commands, VerifyEndsWithZeroOnlyWhereAllIsTheSame) {
  const TestFolder folder;
  const std::string project = (folder / "project").string();
  ASSERT_TRUE(write_file(folder / "project/products/ortho.tif", "ortho"));
  SignedFiles all{"0.1.0", 1, {{FileRole::kProduct, "products/ortho.tif", {}}}};
  ASSERT_TRUE(hash_files(project, all.files, {}));
  ASSERT_TRUE(write_file(folder / "project" / kHashesFile, signed_files_json(all)));
  const Outcome same = collinea_with({"verify", project});
  EXPECT_EQ(same.code, 0) << same.err;
  EXPECT_NE(same.out.find("same      products/ortho.tif\n"), std::string::npos) << same.out;
  EXPECT_NE(same.out.find(digest_of(all, SignedPart::kProducts)), std::string::npos) << same.out;
  ASSERT_TRUE(write_file(folder / "project/products/ortho.tif", "Ortho"));
  EXPECT_EQ(collinea_with({"verify", project}).code, kFilesDiffer);
  const Outcome json = collinea_with({"verify", project, "--json"});
  EXPECT_EQ(json.code, kFilesDiffer);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("files").at(0).at("state"), "changed");
  ASSERT_TRUE(write_file(folder / "project" / kHashesFile, "{"));
  EXPECT_EQ(collinea_with({"verify", project}).code, exit_code(Errc::kBadFormat));
}

TEST(ExitCode, IsAsTheHelpSays) {
  EXPECT_EQ(exit_code(Errc::kBadInput), 2);
  EXPECT_EQ(exit_code(Errc::kNotFound), 3);
  EXPECT_EQ(exit_code(Errc::kBadFormat), 4);
  EXPECT_EQ(exit_code(Errc::kUnsupported), 5);
  EXPECT_EQ(exit_code(Errc::kIllPosed), 6);
  EXPECT_EQ(exit_code(Errc::kNotConverged), 7);
  EXPECT_EQ(exit_code(Errc::kCancelled), 130);
}

// A file that is converted keeps how it is to be adjusted: what it states, and what is given, which goes before.
TEST(Commands, AConversionKeepsTheOptionsOfTheAdjustment) {
  const TestFolder folder;
  const std::string file = (folder / "a.txt").string(), converted = (folder / "b.txt").string();
  ASSERT_TRUE(write_file(
      file,
      "collinea-adjustment 1\noption loss none\noption loss-scale-sigmas 3\noption folds 7\ncamera a 10 10 brown\n"
      "parameter a f 9 fixed\nimage i a\nmeasured_tie i 1 2 3 1\n"));
  const auto convert = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"adjust", "--import", file, "--export", converted});
    const Outcome outcome = collinea_with(more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return read_file(converted).value_or("");
  };
  const std::string text = convert({"--lever-arm", "estimate", "--loss", "cauchy", "--refraction", "on", "--snoop"});
  for (const char* line : {"option loss cauchy\n", "option folds 7\n", "option loss_scale_sigmas 3\n",
                           "option lever_arm estimate\n", "option refraction on\n", "option snoop yes\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  EXPECT_EQ(convert({"--loss", "auto"}).find("option loss "), std::string::npos);
  EXPECT_NE(collinea_with({"adjust", "--import", file, "--export", converted, "--output", "out"}).code, 0);
}

// Flags of which nothing is chosen as long as neither is given.
TEST(Commands, AnAnswerMayStandBehindAFlag) {
  const TestFolder folder;
  const std::string file = (folder / "a.txt").string(), converted = (folder / "b.txt").string();
  ASSERT_TRUE(write_file(file,
                         "collinea-adjustment 1\ncamera a 10 10 brown\nparameter a f 9 fixed\nimage i a\n"
                         "measured_tie i 1 2 3 1\n"));
  const struct {
    std::vector<std::string> flags;
    const char* written;
  } cases[] = {{{}, ""},
               {{"--snoop"}, "option snoop yes\n"},
               {{"--snoop", "yes"}, "option snoop yes\n"},
               {{"--no-snoop"}, "option snoop no\n"},
               {{"--snoop", "no"}, "option snoop no\n"},
               {{"--snoop=no"}, "option snoop no\n"},
               {{"--variance-components", "yes"}, "option variance_components yes\n"},
               {{"--variance-components", "no"}, ""}};
  for (const auto& [flags, written] : cases) {
    std::vector<std::string> words{"adjust", "--import", file, "--export", converted};
    words.insert(words.end(), flags.begin(), flags.end());
    const Outcome outcome = collinea_with(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string text = read_file(converted).value_or("");
    if (*written)
      EXPECT_NE(text.find(written), std::string::npos) << written;
    else
      EXPECT_EQ(text.find("\noption"), std::string::npos) << text;
  }
}

// Three images in a row, c = 100 mm, bases of 100 and 80: exact measurements of nine points.
TEST(Commands, ThreeImagesAreJoined) {
  const TestFolder folder;
  const std::string file = (folder / "m.txt").string(), out = (folder / "out").string();
  std::string text = "image point x[mm] y[mm]\n";
  for (int p = 0; p < 9; ++p) {
    const double x = 60 + 40 * (p % 3), y = 70 * (p / 3) - 70, depth = 200 + 15 * ((p * 5) % 4);
    for (const auto& [name, centre] : {std::pair("A", 0.0), {"B", 100.0}, {"C", 180.0}})
      text += name + std::string(" ") + std::to_string(p) + " " + std::to_string(100 * (x - centre) / depth) + " " +
              std::to_string(100 * y / depth) + "\n";
  }
  ASSERT_TRUE(write_file(file, text));
  const Outcome outcome =
      collinea_with({"triplet", file, "--principal-distance", "100", "--sigma", "0.001", "--base-m", "100", "-o", out});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 of 16 combinations are acceptable"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("base_ratio  0.800"), std::string::npos) << outcome.out;
  EXPECT_NE(read_file(std::filesystem::path(out) / "combinations.txt").value_or("").find("1D"), std::string::npos);
  EXPECT_EQ(collinea_with({"triplet", file}).code, 2);  // no principal distance
}

// Four rolled images of a camera with c = 1000 px around twelve points: exact measurements calibrate it.
TEST(Commands, FactoriseFindsTheCamera) {
  const TestFolder folder;
  const std::string file = (folder / "m.txt").string(), out = (folder / "out").string();
  std::string text = "image point x[px] y[px]\n";
  const OmegaPhiKappa attitudes[] = {{0, 0, 0}, {3, 25, 60}, {-22, -8, -75}, {18, -20, 120}};
  for (int i = 0; i < 4; ++i)
    for (int p = 0; p < 12; ++p) {
      const Eigen::Quaterniond rotation = cam_from_world(attitudes[i]);
      const Eigen::Vector3d point(p % 3 - 1.0, (p / 3) * 0.6 - 0.9, 0.3 * ((7 * p) % 5) - 0.6);
      const Eigen::Vector3d seen = rotation * point + Eigen::Vector3d(0, 0, 6 + 0.4 * i);
      text += std::to_string(i) + " " + std::to_string(p) + " " + std::to_string(1000 * seen.x() / seen.z() + 640) +
              " " + std::to_string(1000 * seen.y() / seen.z() + 480) + "\n";
    }
  ASSERT_TRUE(write_file(file, text));
  const Outcome outcome = collinea_with({"factorise", file, "--principal-distance", "1000", "--principal-point",
                                         "640,480", "--sigma", "0.01", "--calibration", "focal", "-o", out});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("c_x   1000.0"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("calibrated path"), std::string::npos);
  EXPECT_NE(read_file(std::filesystem::path(out) / "interior.txt").value_or("").find("c_x"), std::string::npos);
  EXPECT_EQ(collinea_with({"factorise", (folder / "none").string()}).code, 3);
}

TEST(Commands, CollinearityAndRefractionReadAndWriteTables) {
  const TestFolder folder;
  const std::string points = (folder / "p.txt").string(), images = (folder / "i.txt").string(),
                    measured = (folder / "m.txt").string(), out = (folder / "out").string();
  ASSERT_TRUE(write_file(points, "point latitude[deg] longitude[deg] H[m] N[m]\n1 48.2 15.6 250 45\n"));
  ASSERT_TRUE(write_file(images,
                         "image latitude[deg] longitude[deg] h[m] omega[deg] phi[deg] kappa[deg]\nA 48.2 15.6 1295 "
                         "0 0 0\n"));
  const Outcome seen = collinea_with(
      {"collinearity", points, images, "--principal-distance-mm", "100", "--refraction", "atmosphere", "-o", out});
  ASSERT_EQ(seen.code, 0) << seen.err;
  EXPECT_NE(seen.out.find("1000.000"), std::string::npos) << seen.out;
  EXPECT_NE(read_file(std::filesystem::path(out) / "derivatives.txt").value_or("").find("latitude0"),
            std::string::npos);
  EXPECT_EQ(collinea_with({"collinearity", points, images}).code, 2);
  ASSERT_TRUE(write_file(measured, "point x[mm] y[mm]\n1 100 0\n"));
  const Outcome refraction = collinea_with({"refraction", measured, "--principal-distance", "150", "--camera-height-m",
                                            "3000", "--refraction", "coefficient", "-o", out});
  ASSERT_EQ(refraction.code, 0) << refraction.err;
  EXPECT_NE(refraction.out.find("4.4162"), std::string::npos) << refraction.out;  // Mussio D.8 [um]
  EXPECT_NE(read_file(std::filesystem::path(out) / "refraction.txt").value_or("").find("99.995584"), std::string::npos);
  EXPECT_EQ(collinea_with({"refraction", measured, "--principal-distance", "150"}).code, 2);  // no height
}

}  // namespace
}  // namespace collinea
