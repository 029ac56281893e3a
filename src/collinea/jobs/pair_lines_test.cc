// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/pair_lines.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/feature/test_shapes.h"
#include "collinea/io/text_table.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 220, kHeight = 150;
constexpr double kFocal_px = 300, kBase_m = 0.5;

// A bright board, upright, on a plane that leans towards the cameras or away from them: its sides are x_left + slope
// (y - 75) in the left image, and what is in row y there is disparity(y) farther left in the right one.
struct Board {
  double x_left, x_right, slope, disparity, lean, grey;

  [[nodiscard]] double disparity_at(double row) const { return disparity + lean * (row - 75); }
  [[nodiscard]] double white(const Vector2d& in_left) const {
    const double shift = slope * (in_left.y() - 75), cosine = 1 / std::hypot(1, slope);
    return grey * blurred_step((in_left.x() - x_left - shift) * cosine, 0.8) *
           blurred_step((x_right + shift - in_left.x()) * cosine, 0.8) * blurred_step(in_left.y() - 20.4, 0.8) *
           blurred_step(129.3 - in_left.y(), 0.8);
  }
  // A point of a side in space.
  [[nodiscard]] Vector3d side_at(double x_of_side, double row) const {
    const double depth = kFocal_px * kBase_m / disparity_at(row), x = x_of_side + slope * (row - 75);
    return depth * Vector3d((x - kWidth / 2.0) / kFocal_px, (row - kHeight / 2.0) / kFocal_px, 1);
  }
};

constexpr Board kBoards[] = {{60, 85, 0.15, 30, 0.02, 0.4}, {110, 140, -0.2, 24, -0.03, 0.7}, {165, 190, 0, 36, 0, 1}};

GreyImage drawn(bool is_right, std::uint64_t seed) {
  const FloatImage image = render_shape(
      kWidth, kHeight,
      [&](const Vector2d& p) {
        double sum = 0;
        for (const Board& board : kBoards)
          sum += board.white(is_right ? Vector2d(p.x() + board.disparity_at(p.y()), p.y()) : p);
        return sum;
      },
      2, seed);
  GreyImage out(kWidth, kHeight);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = std::uint8_t(std::clamp(std::lround(image.data[i]), 1L, 255L));
  return out;
}

// The side of a board that a line of the left image is.
std::optional<std::pair<Board, double>> side_of(const EdgeLine& line) {
  for (const Board& board : kBoards)
    for (const double x : {board.x_left, board.x_right})
      if (std::abs(crossing(line, 75).value_or(RowCrossing{1e9, 0}).column - x) < 2) return std::pair(board, x);
  return std::nullopt;
}

struct Drawn {
  TestFolder folder;
  std::string left = (folder / "left.png").string(), right = (folder / "right.png").string();
  StereoPairOptions pair;

  explicit Drawn(std::uint64_t seed) {
    EXPECT_TRUE(write_png(left, drawn(false, 2 * seed)));
    EXPECT_TRUE(write_png(right, drawn(true, 2 * seed + 1)));
    pair.rectified = true;
    pair.max_disparity = 60;
    pair.focal_px = kFocal_px;
    pair.base_m = kBase_m;
  }
};

// The six sides of three boards are found and matched, and none else; their errors in space are those stated. With 18
// lines the mean of chi-squared with four degrees of freedom has a standard deviation of sqrt(8 / 18).
TEST(PairLines, SidesOfBoardsAreLinesInSpace) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Drawn images(seed);
    const auto report = lines_of_pair(images.left, images.right, images.folder / "out", images.pair, {}, {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->matched(), 6u);
    EXPECT_EQ(report->in_space(), 6u);
    for (const PairLine& found : report->lines) {
      if (!found.space) continue;
      const auto side = side_of(found.left);
      ASSERT_TRUE(side);
      const auto& [board, x] = *side;
      const SpaceLine& line = found.space->line;
      const Vector3d a = board.side_at(x, 30), b = board.side_at(x, 120);
      Vector3d d = (b - a).normalized();
      if (d.dot(line.direction) < 0) d = -d;
      const Vector3d at = a + d * (line.point - a).dot(line.direction) / d.dot(line.direction);
      Eigen::Vector4d error;
      error << line.across.transpose() * (line.point - at), line.across.transpose() * (-d / d.dot(line.direction));
      sum += error.dot(line.covariance.ldlt().solve(error));
      ++count;
      EXPECT_GT(found.points.size(), 80u);
      for (const EdgePointMatch& p : found.points) {
        if (p.left_px.y() < 30 || p.left_px.y() > 120) continue;  // corners bend the edge
        EXPECT_NEAR(p.left_px.x() - p.right_px.x(), board.disparity_at(p.left_px.y()), 6 * p.sigma_px);
      }
      // Edges lose two pixels or three at a corner.
      EXPECT_NEAR(
          std::abs(found.space->to_m - found.space->from_m) / (board.side_at(x, 129.3) - board.side_at(x, 20.4)).norm(),
          1, 0.06);
    }
  }
  EXPECT_EQ(count, 18);
  EXPECT_NEAR(sum / count, 4, 4 * std::sqrt(8.0 / count));
}

TEST(PairLines, WritesTablesImagesAndVectors) {
  const Drawn images(9);
  const auto out = images.folder / "out";
  ASSERT_TRUE(lines_of_pair(images.left, images.right, out, images.pair, {}, {}));
  for (const char* name : {"lines.txt", "edge_points.txt", "left.png", "right.png", "lines.gpkg", "lines.dxf"})
    EXPECT_TRUE(is_there(out / name)) << name;
  const auto lines = read_text_table(out / "lines.txt");
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_TRUE(lines->numbers_or("Z_first", "m", 0));
  const auto points = read_text_table(out / "edge_points.txt");
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_GT(points->rows.size(), 480u);
  const auto depths = points->numbers("depth", "m");
  ASSERT_TRUE(depths) << depths.error().message;
  for (const double depth : *depths) EXPECT_NEAR(depth, 5.44, 1.3);  // disparities of 22.4 to 36 px
  // Without cameras there are no coordinates, nor vectors of an earlier run.
  StereoPairOptions plain = images.pair;
  plain.focal_px.reset();
  plain.base_m.reset();
  const auto report = lines_of_pair(images.left, images.right, out, plain, {}, {});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->matched(), 6u);
  EXPECT_EQ(report->in_space(), 0u);
  EXPECT_FALSE(is_there(out / "lines.gpkg"));
  EXPECT_NE(lines_text(*report).find("cameras are not known"), std::string::npos);
}

// The six sides are curves as well as lines: the same disparities without a line that is fitted.
TEST(PairLines, CurvesAreMatchedWhereAsked) {
  const Drawn images(5);
  const auto out = images.folder / "out";
  PairLinesOptions options;
  options.curves = true;
  const auto report = lines_of_pair(images.left, images.right, out, images.pair, options, {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->curves);
  EXPECT_EQ(report->curves->curves.size(), 6u);
  for (const PairCurves::Curve& curve : report->curves->curves) {
    EXPECT_GT(curve.points.size(), 80u);
    for (const EdgePointMatch& p : curve.points) {
      if (p.left_px.y() < 30 || p.left_px.y() > 120) continue;  // corners bend the edge
      const auto side = std::ranges::find_if(kBoards, [&](const Board& b) {
        const double x = p.left_px.x() - b.slope * (p.left_px.y() - 75);
        return std::abs(x - b.x_left) < 2 || std::abs(x - b.x_right) < 2;
      });
      ASSERT_NE(side, std::end(kBoards));
      EXPECT_NEAR(p.left_px.x() - p.right_px.x(), side->disparity_at(p.left_px.y()), 6 * p.sigma_px);
    }
  }
  const auto points = read_text_table(out / "curve_points.txt");
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_GT(points->rows.size(), 480u);
  EXPECT_TRUE(points->numbers("depth", "m"));
  EXPECT_NE(lines_text(*report).find("any shape"), std::string::npos);
  ASSERT_TRUE(lines_of_pair(images.left, images.right, out, images.pair, {}, {}));
  EXPECT_FALSE(is_there(out / "curve_points.txt"));  // of an earlier run
}

TEST(PairLines, AnImageWithoutEdgesIsNamed) {
  const Drawn images(3);
  ASSERT_TRUE(write_png(images.right, GreyImage(kWidth, kHeight, 1, 90)));
  const auto report = lines_of_pair(images.left, images.right, images.folder / "out", images.pair, {}, {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("right.png"), std::string::npos);
}

}  // namespace
}  // namespace collinea
