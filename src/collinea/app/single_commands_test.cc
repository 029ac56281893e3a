// SPDX-License-Identifier: Apache-2.0
// Commands that work on single images, pairs and tables, each as a user calls it: once well, once badly.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "collinea/app/command_for_tests.h"
#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/text_table.h"
#include "collinea/math/random.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using testing::collinea_with;
using testing::Outcome;

constexpr int kWidth = 360, kHeight = 270;
constexpr double kFocal_px = 400, kBase_m = 10;

// Waves of all directions, 6 to 24 px long.
class Waves {
 public:
  explicit Waves(std::uint64_t seed) {
    Random random(seed);
    for (auto& wave : waves_) {
      const double k = 2 * std::numbers::pi / random.uniform(6, 24), angle = random.uniform(0, 2 * std::numbers::pi);
      wave = {k * std::cos(angle), k * std::sin(angle), random.uniform(0, 2 * std::numbers::pi)};
    }
  }
  [[nodiscard]] std::uint8_t operator()(double x, double y) const {
    double grey = 128;
    for (const auto& [u, v, phase] : waves_) grey += 11 * std::sin(u * x + v * y + phase);
    return static_cast<std::uint8_t>(std::clamp(std::round(grey), 0.0, 255.0));
  }

 private:
  std::array<std::array<double, 3>, 12> waves_;
};

// How far the right image sees what lies at a position of the left one to its left: hills 36 to 44 m away.
double disparity_px(double x, double y) { return 100 + 9 * std::sin(x / 70) * std::cos(y / 60); }

struct Rendered {
  GreyImage left, right;

  Rendered() : left(kWidth, kHeight), right(kWidth, kHeight) {
    const Waves grey(3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        left.at(x, y) = grey(x + 0.5, y + 0.5);
        // By iteration, each of which divides the error by seven: hills are far less steep than they are far.
        double in_left = x + 0.5 + 100;
        for (int i = 0; i < 8; ++i) in_left = x + 0.5 + disparity_px(in_left, y + 0.5);
        right.at(x, y) = grey(in_left, y + 0.5);
      }
  }
};

// Two images of the normal case, straight down on hills, as files.
struct HillPair {
  TestFolder folder;

  HillPair() {
    static const Rendered rendered;
    EXPECT_TRUE(write_png(folder / "left.png", rendered.left));
    EXPECT_TRUE(write_png(folder / "right.png", rendered.right));
  }
  [[nodiscard]] std::string at(const std::string& name) const { return (folder / name).string(); }
};

void expect_files(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names) EXPECT_TRUE(is_there(folder / name)) << folder / name;
}

// All went well: the answer on stdout, nothing of it on stderr.
void expect_answer(const Outcome& outcome, const char* words) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find(words), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.err.find(words), std::string::npos) << outcome.err;
}

// A message on stderr that names what is wrong, and no answer.
void expect_refusal(const Outcome& outcome, int code, const char* named) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

TEST(SingleCommands, PairMakesASurface) {
  const HillPair hills;
  const std::string left = hills.at("left.png"), right = hills.at("right.png"), out = hills.at("out");
  const Outcome made =
      collinea_with({"pair", left, right, "-o", out, "--principal-distance-px", "400", "--base-m", "10", "--max-points",
                     "150", "--levels", "1", "--first-threshold", "300", "--last-threshold", "300"});
  expect_answer(made, "relative orientation by lsm");
  expect_files(out, {"pair.txt", "points.txt", "epipolar_left.png", "epipolar_right.png", "cloud.ply"});
  EXPECT_EQ(read_file(hills.folder / "out/pair.txt").value_or(""), made.out);
  expect_refusal(collinea_with({"pair", left, right, "-o", out}), 2, "--principal-distance-px");
  ASSERT_TRUE(write_file(hills.folder / "words.png", "no image at all"));
  expect_refusal(collinea_with({"pair", left, hills.at("words.png"), "-o", out, "--principal-distance-px", "400"}), 4,
                 "words.png");
}

TEST(SingleCommands, GridAndEvaluateMeetOnAHill) {
  const TestFolder folder;
  std::string some = "X[m] Y[m] Z[m] sigma_Z[m]\n", others = "X[m] Y[m] Z[m]\n";
  Random random(2);
  for (int i = 0; i < 400; ++i) {
    const double x = random.uniform(0, 60), y = random.uniform(0, 60), z = 300 + 5 * std::sin(x / 20) + 0.1 * y;
    const std::string at = std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z + (i % 2) * 0.25);
    (i % 2 ? others : some) += at + (i % 2 ? "\n" : " 0.001\n");
  }
  ASSERT_TRUE(write_file(folder / "some.txt", some) && write_file(folder / "others.txt", others));
  const std::string hill = (folder / "hill.tif").string(), others_file = (folder / "others.txt").string();
  const Outcome gridded = collinea_with({"grid", (folder / "some.txt").string(), "-o", hill, "--cell-m", "2"});
  expect_answer(gridded, "200 points");
  expect_files(folder / "", {"hill.tif", "hill_sigma.tif"});
  const Outcome evaluated =
      collinea_with({"evaluate", hill, others_file, "--coregistration", "none", "--out", (folder / "out").string()});
  expect_answer(evaluated, "RMS");
  expect_files(folder / "out", {"evaluation.txt", "differences.tif", "differences.png"});

  ASSERT_TRUE(write_file(folder / "flat.txt", "X[m] Y[m]\n1 2\n"));
  ASSERT_TRUE(write_file(folder / "two.txt", "X[m] Y[m] Z[m]\n1 2 3\n4 5 6\n"));
  expect_refusal(collinea_with({"grid", (folder / "flat.txt").string(), "-o", hill}), 4, "column Z");
  expect_refusal(collinea_with({"grid", (folder / "two.txt").string(), "-o", hill}), 6, "three points");
  expect_refusal(collinea_with({"evaluate", hill, (folder / "flat.txt").string()}), 4, "column Z");
  expect_refusal(collinea_with({"evaluate", hill, others_file, "--scale-number", "6800"}), 2, "--height-over-base");
}

TEST(SingleCommands, EnhanceWritesTheImageAndItsStatistics) {
  const HillPair hills;
  const std::string left = hills.at("left.png"), out = hills.at("out");
  const Outcome made = collinea_with({"enhance", left, "-o", out, "--contrast", "stretch", "--palette", "heat"});
  expect_answer(made, "becomes black");
  expect_files(out, {"enhanced.png", "statistics.txt", "histogram.txt", "histogram.svg"});
  expect_refusal(collinea_with({"enhance", left, "-o", out, "--colour", "--palette", "heat"}), 2, "--palette");
  ASSERT_TRUE(write_png(hills.folder / "flat.png", GreyImage(20, 20, 1, 80)));
  expect_refusal(collinea_with({"enhance", hills.at("flat.png"), "-o", out, "--lut", "threshold"}), 6, "--threshold");
}

TEST(SingleCommands, CorrelateFindsPointsOfOneImageInTheOther) {
  const HillPair hills;
  const std::string left = hills.at("left.png"), right = hills.at("right.png"), out = hills.at("out");
  ASSERT_TRUE(write_file(hills.folder / "points.txt", "point x_left[px] y_left[px]\nA 200 100\nB 250 180\n"));
  const Outcome made = collinea_with(
      {"correlate", left, right, "-o", out, "--points", hills.at("points.txt"), "--parallax-px", "100,0"});
  expect_answer(made, "2 points");
  expect_files(out, {"correlated.txt", "left.png", "right.png"});
  const auto table = read_text_table(hills.folder / "out/correlated.txt");
  ASSERT_TRUE(table) << table.error().message;
  // To a fifth of a pixel, which is what area matching is good for.
  const std::vector<double> x = table->numbers("x_right", "px").value_or(std::vector<double>{});
  ASSERT_EQ(x.size(), 2u);
  EXPECT_NEAR(x[0], 200 - disparity_px(200, 100), 0.2);
  EXPECT_NEAR(x[1], 250 - disparity_px(250, 180), 0.2);
  ASSERT_TRUE(write_file(hills.folder / "bad.txt", "point x_left[px]\nA 200\n"));
  expect_refusal(collinea_with({"correlate", left, right, "-o", out, "--points", hills.at("bad.txt")}), 4, "y_left");
  expect_refusal(collinea_with({"correlate", left, right, "-o", out, "--template-px", "20"}), 2, "--template-px");
}

TEST(SingleCommands, IntersectionMatchesItsPointsInTheImages) {
  const HillPair hills;
  std::string measured = "image point x[px] y[px]\n";
  int n = 0;
  for (const int y : {80, 130, 190})
    for (const int x : {190, 240, 290}) {
      const std::string point = " " + std::to_string(++n) + " ";
      measured += "left" + point + std::to_string(x) + " " + std::to_string(y) + "\n";
      measured += "right" + point + std::to_string(x - disparity_px(x, y) + 0.7) + " " + std::to_string(y) + "\n";
    }
  ASSERT_TRUE(write_file(hills.folder / "measured.txt", measured));
  ASSERT_TRUE(
      write_file(hills.folder / "poses.txt", "image X Y Z omega phi kappa\nleft 0 0 40 0 0 0\nright 10 0 40 0 0 0\n"));
  const std::vector<std::string> asked = {"intersection",
                                          hills.at("measured.txt"),
                                          hills.at("poses.txt"),
                                          "--principal-distance",
                                          "400",
                                          "--principal-point",
                                          "180,135"};
  std::vector<std::string> with_images = asked;
  with_images.insert(with_images.end(), {"--images", hills.at(""), "--out", hills.at("out")});
  const Outcome made = collinea_with(with_images);
  expect_answer(made, "matched in all images");
  expect_files(hills.folder / "out", {"points.txt", "residuals.txt", "refined.txt", "windows.txt"});
  const auto refined = read_text_table(hills.folder / "out/refined.txt");
  ASSERT_TRUE(refined) << refined.error().message;
  const auto names = refined->words("point");
  const auto heights = refined->numbers("Z", "m");
  ASSERT_TRUE(names && heights);
  EXPECT_GE(names->size(), 7u);  // of nine
  for (std::size_t i = 0; i < names->size(); ++i) {
    const int k = std::stoi((*names)[i]) - 1;
    const double depth = kFocal_px * kBase_m /
                         disparity_px(190 + 50 * (k % 3), k / 3 == 0   ? 80
                                                          : k / 3 == 1 ? 130
                                                                       : 190);
    EXPECT_NEAR((*heights)[i], 40 - depth, 0.08);  // a fifth of a pixel of disparity
  }
  std::vector<std::string> elsewhere = asked;
  elsewhere.insert(elsewhere.end(), {"--images", hills.at("none")});
  expect_refusal(collinea_with(elsewhere), 3, "none");
  ASSERT_TRUE(write_file(hills.folder / "poses.txt", "image X Y Z omega phi\nleft 0 0 40 0 0\n"));
  expect_refusal(collinea_with(asked), 4, "kappa");
}

TEST(SingleCommands, InterestWritesPointsAndTheirMap) {
  const HillPair hills;
  const std::string left = hills.at("left.png"), out = hills.at("out");
  const Outcome made = collinea_with({"interest", left, "-o", out, "--operator", "foerstner", "--max-points", "50"});
  expect_answer(made, "foerstner");
  expect_files(out, {"points.txt", "points.png", "map.tif", "map.png"});
  ASSERT_TRUE(write_file(hills.folder / "words.png", "no image at all"));
  expect_refusal(collinea_with({"interest", hills.at("words.png"), "-o", out}), 4, "words.png");
  expect_refusal(collinea_with({"interest", left, "-o", out, "--operator", "sobel"}), 2, "--operator");
}

TEST(SingleCommands, EdgesFindADisc) {
  const TestFolder folder;
  GreyImage image(120, 80);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 120; ++x) {
      const double inside = 0.5 * std::erfc((std::hypot(x + 0.5 - 50.25, y + 0.5 - 40.5) - 15) / 1.1);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(200 - 150 * inside));
    }
  ASSERT_TRUE(write_png(folder / "disc.png", image));
  const std::string disc = (folder / "disc.png").string(), out = (folder / "out").string();
  const Outcome made = collinea_with({"edges", disc, "-o", out, "--find", "circles"});
  expect_answer(made, "circles");
  const auto found = read_text_table(folder / "out/found.txt");
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->rows.size(), 1u);
  expect_refusal(collinea_with({"edges", disc, "-o", out, "--find", "shapes"}), 2, "--shape");
  ASSERT_TRUE(write_file(folder / "points.txt", "point x[px]\nA 50\n"));
  expect_refusal(
      collinea_with({"edges", disc, "-o", out, "--find", "targets", "--points", (folder / "points.txt").string()}), 4,
      "column y");
}

TEST(SingleCommands, ModelsJoinsThemOnTheGround) {
  const TestFolder folder;
  // Two models of the same ground, the second turned by 90 degrees and half as large.
  std::string models = "model point U[m] V[m] W[m] sigma[m]\n", control = "point X[m] Y[m] Z[m]\n";
  for (int i = 0; i < 12; ++i) {
    const double x = 10 * (i % 4), y = 12 * (i / 4), z = (i * 7) % 5;
    const std::string name = "P" + std::to_string(i);
    if (x <= 20)
      models += "A " + name + " " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + " 0.01\n";
    if (x >= 10)
      models += "B " + name + " " + std::to_string(y / 2) + " " + std::to_string(-x / 2) + " " + std::to_string(z / 2) +
                " 0.01\n";
    if (i % 4 == 0 || i % 4 == 3)
      control +=
          name + " " + std::to_string(1000 + x) + " " + std::to_string(2000 + y) + " " + std::to_string(300 + z) + "\n";
  }
  ASSERT_TRUE(write_file(folder / "models.txt", models) && write_file(folder / "control.txt", control));
  const std::string table = (folder / "models.txt").string(), out = (folder / "out").string();
  const Outcome made = collinea_with({"models", table, "--control", (folder / "control.txt").string(), "--out", out});
  expect_answer(made, "2 of 2 joined");
  expect_files(out, {"points.txt", "models.txt", "residuals.txt", "control.txt"});
  ASSERT_TRUE(write_file(folder / "bad.txt", "model point U V\nA 1 2 3\n"));
  expect_refusal(collinea_with({"models", (folder / "bad.txt").string()}), 4, "column W");
  ASSERT_TRUE(write_file(folder / "apart.txt",
                         "model point U V W\nA 1 0 0 0\nA 2 1 0 0\nA 3 0 1 0\nB 4 0 0 0\nB 5 1 0 0\nB 6 0 1 0\n"));
  expect_refusal(collinea_with({"models", (folder / "apart.txt").string()}), 6, "models");
}

TEST(SingleCommands, InteriorOrientsAScanByItsMarks) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "camera.txt",
                         "camera RC30\nprincipal_distance_mm 153.358\nprincipal_point_mm -0.006 0.006\n"
                         "mark 1 -105.997 -105.995\nmark 2 106.004 106.008\nmark 3 -106.000 106.009\n"
                         "mark 4 106.012 -105.995\nmark 5 -112.000 0.007\nmark 6 112.006 0.007\n"));
  ASSERT_TRUE(write_file(folder / "marks.txt",
                         "image mark x[px] y[px]\n27 1 1347 19285\n27 2 19161 1470\n27 3 1345 1471\n27 4 19163 19283\n"
                         "27 5 843 10379\n27 6 19666 10376\n"));
  const std::string marks = (folder / "marks.txt").string(), camera = (folder / "camera.txt").string();
  const Outcome made = collinea_with({"interior", marks, "--calibration", camera, "--out", (folder / "out").string()});
  expect_answer(made, "image 27");
  expect_files(folder / "out", {"interior.txt", "residuals.txt"});
  expect_refusal(collinea_with({"interior", marks}), 2, "--calibration");
  ASSERT_TRUE(write_file(folder / "bad.txt", "image mark x[px]\n27 1 5\n"));
  expect_refusal(collinea_with({"interior", (folder / "bad.txt").string(), "--calibration", camera}), 4, "column y");
  ASSERT_TRUE(write_file(folder / "one.txt", "mark x[px] y[px]\n1 5 5\n"));
  expect_refusal(collinea_with({"interior", (folder / "one.txt").string(), "--calibration", camera}), 6,
                 "do not determine");
}

}  // namespace
}  // namespace collinea
