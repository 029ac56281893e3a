// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/correlate.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

const Vector2d kParallax(23.3, -4.6);  // left less right [px]

// Smooth texture of many waves of 6 to 40 px, the right image shifted by the parallax.
fs::path written(const fs::path& folder, const char* name, const Vector2d& shift) {
  Random random(3);
  struct Wave {
    Vector2d per_px;
    double phase, amplitude;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 60; ++i) {
    const double direction = random.uniform(0, 6.283), length = random.uniform(6, 40);
    waves.push_back({6.283 / length * Vector2d(std::cos(direction), std::sin(direction)), random.uniform(0, 6.283),
                     random.uniform(3, 9)});
  }
  GreyImage image(360, 280);
  Random noise(7, std::uint64_t(name[0]));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double grey = 128 + noise.normal();
      for (const Wave& wave : waves)
        grey += wave.amplitude * std::cos(wave.per_px.dot(Vector2d(x, y) + shift) + wave.phase);
      image.at(x, y) = std::uint8_t(std::clamp(grey + 0.5, 0.0, 255.0));
    }
  EXPECT_TRUE(write_png(folder / name, image));
  return folder / name;
}

// Every measure finds the shift, to what a paraboloid over whole pixels can.
TEST(Correlate, EveryMeasureFindsTheShift) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  ASSERT_TRUE(write_file(folder / "points.txt", "point x_left[px] y_left[px]\nA 120.4 90.7\nB 250 201.2\nC 2 3\n"));
  for (const auto& method : kSimilarityWords) {
    CorrelateOptions options;
    options.points = folder / "points.txt";
    options.parallax_px = "20,0";
    options.matching.method = method.value;
    options.surface_of = "B";
    const auto report = correlate_points(left, right, folder / "out", options, {.threads = 2});
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->points.size(), 3u);
    for (std::size_t i = 0; i < 2; ++i) {
      const CorrelatedPoint& point = report->points[i];
      ASSERT_TRUE(point.match) << method.word << " " << word_of(point.outcome);
      EXPECT_LT((point.left_px - point.match->position_px - kParallax).norm(), 0.25) << method.word;
      EXPECT_LT(*point.match->returned_px, 0.5);
    }
    EXPECT_EQ(report->points[2].outcome, AreaOutcome::kOutside);  // its window leaves the image
    const auto table = read_text_table(folder / "out/correlated.txt");
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ((*table->words("outcome"))[0], "found");
    EXPECT_TRUE(table->has(method.word));
    const auto surface = read_float_tiff(folder / "out/surface.tif");
    ASSERT_TRUE(surface);
    EXPECT_EQ(surface->width, 61);  // 81 less the template and one
    EXPECT_NE(read_file(folder / "out/surface.svg")->find("<svg"), std::string::npos);
  }
}

TEST(Correlate, FindsInterestPointsAndTheirParallaxItself) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  CorrelateOptions options;
  options.max_points = 60;
  const auto report = correlate_points(left, right, folder / "out", options, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LT((report->parallax_px - kParallax).norm(), 1);
  std::size_t found = 0;
  for (const CorrelatedPoint& point : report->points) {
    if (!point.match) continue;
    ++found;
    EXPECT_LT((point.left_px - point.match->position_px - kParallax).norm(), 0.3);
  }
  EXPECT_GT(found, 25u);
  EXPECT_NE(correlate_text(*report).find("found"), std::string::npos);
}

// A table of points over the image, one about every 22 px.
std::string points_table() {
  std::string points = "point x_left[px] y_left[px]\n";
  for (int y = 60; y < 240; y += 22)
    for (int x = 70; x < 310; x += 22)
      points += "P" + std::to_string(x) + "_" + std::to_string(y) + " " + std::to_string(x) + ".3 " +
                std::to_string(y) + ".6\n";
  return points;
}

// Noise of one grey value, rounded, in both images: the errors against the stated covariances, each model. The image is
// shifted alone, so that every model holds. Windows hardly overlap: e' C^-1 e / axes has the standard deviation
// sqrt(2 / axes) in each.
TEST(Correlate, RefinedPositionsErrByTheirSigmas) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  ASSERT_TRUE(write_file(folder / "points.txt", points_table()));
  for (const auto& [model, word, help] : kWindowModelWords) {
    CorrelateOptions options;
    options.points = folder / "points.txt";
    options.parallax_px = "23,-5";
    options.matching.search_px = 41;
    options.refine = model;
    if (model == WindowModel::kLine) options.line_px = "0,1";
    const auto report = correlate_points(left, right, folder / "out", options, {.threads = 2});
    ASSERT_TRUE(report) << report.error().message;
    const double axes = model == WindowModel::kLine ? 1 : 2;
    double sum = 0;
    int count = 0;
    for (const CorrelatedPoint& point : report->points) {
      if (!point.is_refined()) continue;
      const Vector2d error = point.left_px - kParallax - point.refined->position_px;
      // Along a line the distance from it stays that of area matching.
      sum += model == WindowModel::kLine ? error.y() * error.y() / point.refined->covariance(0, 0)
                                         : error.dot(point.refined->covariance_px2.inverse() * error);
      ++count;
    }
    ASSERT_GT(count, 80) << word;
    if (model != WindowModel::kLine) {
      EXPECT_NEAR(sum / count / axes, 1, 4 * std::sqrt(2 / axes / count)) << word;
    }
    const auto table = read_text_table(folder / "out/refined.txt");
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ((*table->words("outcome"))[0], "found");
    const auto names = window_parameter_names(model, WindowLight::kGainOffset);
    for (const auto name : names) EXPECT_TRUE(table->has("cov_" + std::string(name) + "_" + std::string(name))) << name;
    EXPECT_EQ(table->columns.size(), 14 + 2 * names.size() + names.size() * (names.size() + 1) / 2);
    EXPECT_NE(correlate_text(*report).find(word), std::string::npos);
  }
}

// The images are shifted against each other: all epipolar lines have the direction of the parallax, x_right' [p]x
// x_left = 0 with p = (23.3, -4.6, 0). Along the line of each point the error has one degree of freedom, across it
// none: the position lies on the line exactly. The way back goes along the line of the left image.
TEST(Correlate, RefinesAlongEpipolarLinesThereAndBack) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  ASSERT_TRUE(write_file(folder / "points.txt", points_table()));
  ASSERT_TRUE(write_file(folder / "F.txt", "0 0 -4.6\n0 0 -23.3\n4.6 23.3 0\n"));
  CorrelateOptions options;
  options.points = folder / "points.txt";
  options.parallax_px = "23,-5";
  options.matching.search_px = 41;
  options.refine = WindowModel::kLine;
  options.epipolar = folder / "F.txt";
  options.refine_return_px = 0.2;
  const auto report = correlate_points(left, right, folder / "out", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  const Vector2d along = kParallax.normalized(), across(-along.y(), along.x());
  double sum = 0;
  int count = 0;
  for (const CorrelatedPoint& point : report->points) {
    if (!point.is_refined()) continue;
    const Vector2d error = point.refined->position_px - (point.left_px - kParallax);
    EXPECT_NEAR(error.dot(across), 0, 1e-9);
    sum += std::pow(error.dot(along), 2) / point.refined->covariance(0, 0);
    ++count;
    ASSERT_TRUE(point.off_line_px && point.refined_returned_px);
    EXPECT_LT(std::abs(*point.off_line_px), 0.4);  // of area matching
    EXPECT_LE(*point.refined_returned_px, 0.2);
  }
  ASSERT_GT(count, 80);
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2.0 / count));
  const auto table = read_text_table(folder / "out/refined.txt");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_TRUE(table->has("returned") && table->has("off_line"));
  // Lines that pass the matches by 8 px: too far from all.
  ASSERT_TRUE(write_file(folder / "F.txt", "0 0 -4.6\n0 0 -23.3\n4.6 23.3 190\n"));
  const auto off = correlate_points(left, right, folder / "out", options, {.threads = 2});
  ASSERT_TRUE(off) << off.error().message;
  for (const CorrelatedPoint& point : off->points)
    EXPECT_TRUE(!point.refined || point.refined->outcome == WindowOutcome::kOffLine);
}

TEST(Correlate, NeighboursDecideWhereAsked) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  ASSERT_TRUE(write_file(folder / "points.txt", points_table()));
  CorrelateOptions options;
  options.points = folder / "points.txt";
  options.parallax_px = "23,-5";
  options.decision = PointDecision::kRelaxation;
  options.refine = WindowModel::kTranslation;
  const auto report = correlate_points(left, right, folder / "out", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  std::size_t found = 0;
  for (const CorrelatedPoint& point : report->points) {
    if (!point.match) continue;
    ++found;
    EXPECT_LT((point.left_px - point.match->position_px - kParallax).norm(), 0.3);
    EXPECT_GE(*point.probability, options.relaxation.least_probability);
  }
  EXPECT_GT(found, 90u);
  const auto table = read_text_table(folder / "out/correlated.txt");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_TRUE(table->has("probability"));
  EXPECT_NE(correlate_text(*report).find("neighbours"), std::string::npos);
  const auto option_of = [&] {
    return correlate_points(left, right, folder / "out", options, {}).error().options.front().name;
  };
  options.matching.return_px = 3;
  EXPECT_EQ(option_of(), "return_px");
  options.matching.return_px = AreaOptions{}.return_px;
  options.decision = PointDecision::kReturn;
  options.relaxation.neighbours = 5;
  EXPECT_EQ(option_of(), "decision");
}

TEST(Correlate, SaysWhatIsWrong) {
  const TestFolder folder;
  const fs::path left = written(folder / "", "left.png", {0, 0}), right = written(folder / "", "right.png", kParallax);
  CorrelateOptions options;
  options.max_points = 5;
  options.parallax_px = "20";
  const auto option_of = [&] {
    return correlate_points(left, right, folder / "out", options, {}).error().options.front().name;
  };
  EXPECT_EQ(option_of(), "parallax_px");
  options.parallax_px = "23,-5";
  options.surface_of = "nobody";
  EXPECT_EQ(option_of(), "surface_of");
  options.surface_of.reset();
  options.matching.template_px = 20;
  EXPECT_EQ(option_of(), "template_px");
  options.matching.template_px = 21;
  options.window.robust = true;
  EXPECT_EQ(option_of(), "refine");
  options.refine = WindowModel::kAffine;
  options.line_px = "1,0";
  EXPECT_EQ(option_of(), "line_px");
  options.refine = WindowModel::kLine;
  for (const char* wrong : {"1", "0,0", "a,b"}) {
    options.line_px = wrong;
    EXPECT_EQ(option_of(), "line_px") << wrong;
  }
  options.epipolar = folder / "F.txt";
  EXPECT_EQ(option_of(), "line_px");  // given twice
  options.line_px.reset();
  ASSERT_TRUE(write_file(folder / "F.txt", "1 2 3\n4 5 6\n"));
  EXPECT_EQ(option_of(), "epipolar");
  options.refine = WindowModel::kAffine;
  EXPECT_EQ(option_of(), "epipolar");
  options.epipolar.reset();
  options.window.window_px = 20;
  EXPECT_EQ(option_of(), "window_px");
  options.window = {};
  options.refine.reset();
  options.points = folder / "points.txt";
  EXPECT_EQ(option_of(), "max_points");
  options.max_points.reset();
  ASSERT_TRUE(write_file(folder / "points.txt", "point x_left y_left x_right y_right\nA 120 90 97 95\n"));
  EXPECT_EQ(option_of(), "parallax_px");
  ASSERT_TRUE(write_file(folder / "points.txt", "point x[px] y[px]\nA 120.4 90.7\n"));
  const auto columns = correlate_points(left, right, folder / "out", options, {});
  ASSERT_FALSE(columns);
  EXPECT_NE(columns.error().message.find("x_left"), std::string::npos);
}

}  // namespace
}  // namespace collinea
