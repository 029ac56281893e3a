// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/seam_plan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"
#include "collinea/ortho/internal/seam_window.h"
#include "collinea/ortho/internal/view_costs.h"

namespace collinea {
namespace {

constexpr int kSide = 2 * SeamWindow::kBlock, kCells = SeamWindow::kBlock * SeamWindow::kBlock;

// Two views that show everything, alike; the first is the cheaper one in the left half.
SeamWindow two_views(int price_per_column = 2) {
  SeamWindow window(2, 2);
  window.raised = window.steep = FloatImage(kSide, kSide);
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      auto& block = window.block(i, j);
      block.views = {0, 1};
      for (int view = 0; view < 2; ++view) {
        for (int cell = 0; cell < kCells; ++cell) {
          const int x = i * SeamWindow::kBlock + cell % SeamWindow::kBlock;
          block.choices.push_back(
              {price_per_column * std::max(0, view == 0 ? x - kSide / 2 + 1 : kSide / 2 - x), {100, 100, 100}, true});
        }
      }
    }
  }
  return window;
}

SeamWindow::Choice& choice(SeamWindow& window, int x, int y, int view) {
  constexpr int kBlock = SeamWindow::kBlock;
  return window.block(x / kBlock, y / kBlock).choices[std::size_t(view * kCells + y % kBlock * kBlock + x % kBlock)];
}

Raster<std::int16_t> seams_of(const SeamWindow& window) {
  auto labels = cheapest_views(window);
  cut_seams(window, 0, 0, kSide, kSide, labels);
  return labels;
}

TEST(SeamWindow, ASeamOnOpenGroundIsWhereTheViewsAreEquallyGood) {
  const auto labels = seams_of(two_views());
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) ASSERT_EQ(labels.at(x, y), x < kSide / 2 ? 0 : 1);
}

// A raised thing of 8 x 8 cells on the line between the views is of one of them as a whole.
TEST(SeamWindow, ASeamGoesRoundARaisedThing) {
  SeamWindow window = two_views();
  for (int y = 12; y < 20; ++y)
    for (int x = 13; x < 21; ++x) window.raised.at(x, y) = 1;
  const auto labels = seams_of(window);
  for (int y = 12; y < 20; ++y)
    for (int x = 13; x < 21; ++x) ASSERT_EQ(labels.at(x, y), labels.at(13, 12)) << x << ' ' << y;
  EXPECT_NE(labels.at(2, 16), labels.at(29, 16));
}

// The images differ everywhere but in one column.
TEST(SeamWindow, ASeamRunsWhereTheImagesAgree) {
  SeamWindow window = two_views();
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (x != 19 && x != 20) choice(window, x, y, 1).colour = {160, 160, 160};
  const auto labels = seams_of(window);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) ASSERT_EQ(labels.at(x, y), x < 20 ? 0 : 1) << x << ' ' << y;
}

TEST(SeamWindow, NoCellTakesAViewThatDoesNotShowItNorMovesWhereItMustStay) {
  SeamWindow window = two_views();
  for (int y = 4; y < 9; ++y)
    for (int x = 3; x < 7; ++x) choice(window, x, y, 0).price = SeamWindow::kForbidden;
  for (int view = 0; view < 2; ++view) choice(window, 25, 25, view).price = SeamWindow::kForbidden;
  auto labels = cheapest_views(window);
  labels.at(0, 16) = 1;  // on the border that stays
  cut_seams(window, 1, 1, kSide - 1, kSide - 1, labels);
  for (int y = 4; y < 9; ++y)
    for (int x = 3; x < 7; ++x) EXPECT_EQ(labels.at(x, y), 1);
  EXPECT_EQ(labels.at(25, 25), kNoView);
  EXPECT_EQ(labels.at(0, 16), 1);
  EXPECT_EQ(labels.at(1, 1), 0);
}

// Worked out by hand, in prices of 1/256: V = 0.1 + 6 min(raised) + 0.5 step + (1 - step) different, step the larger
// one.
TEST(SeamWindow, PricesOfSeamsAreThoseOfTheFormula) {
  struct Case {
    const char* what;
    float raised[2], steep[2], different;
    int price;
  };
  const Case cases[] = {{"on level ground, images alike", {0, 0}, {0, 0}, 0, 26},
                        {"on level ground, images half different", {0, 0}, {0, 0}, 0.5, 154},
                        {"across a raised thing", {1, 1}, {0, 0}, 0, 1562},
                        {"along its outline", {1, 0}, {0, 0}, 0, 26},
                        {"across what is raised a little", {0.5, 0.25}, {0, 0}, 0, 410},
                        {"along a step, where differences do not show", {0, 0}, {0, 1}, 1, 154},
                        {"along half a step", {0, 0}, {0.5, 0.25}, 1, 218}};
  for (const Case& one : cases) {
    SeamWindow window = two_views();
    for (int i = 0; i < 2; ++i) {
      window.raised.at(7 + i, 9) = one.raised[i], window.steep.at(7 + i, 9) = one.steep[i];
      window.raised.at(9, 7 + i) = one.raised[i], window.steep.at(9, 7 + i) = one.steep[i];
    }
    EXPECT_EQ(window.seam_price(7, 9, 8, 9, one.different), one.price) << one.what;
    EXPECT_EQ(window.seam_price(8, 9, 7, 9, one.different), one.price) << one.what;
    EXPECT_EQ(window.seam_price(9, 7, 9, 8, one.different), one.price) << one.what;
  }
}

// The mean over the channels of what lies between them, of 30 grey levels.
TEST(SeamWindow, DifferencesOfImagesAreMeansOverChannelsThatEndAtThirtyLevels) {
  using Choice = SeamWindow::Choice;
  const Choice grey{0, {100, 100, 100}, true}, colourless{0, {100, 100, 100}, false};
  const auto from_grey = [&](const Choice& other) {
    EXPECT_EQ(SeamWindow::difference(&grey, &other), SeamWindow::difference(&other, &grey));
    return SeamWindow::difference(&grey, &other);
  };
  EXPECT_EQ(from_grey(grey), 0);
  EXPECT_FLOAT_EQ(from_grey({0, {103, 94, 100}, true}), 0.1f);
  EXPECT_FLOAT_EQ(from_grey({0, {145, 100, 100}, true}), 0.5f);
  EXPECT_FLOAT_EQ(from_grey({0, {71, 129, 71}, true}), 29 / 30.0f);
  EXPECT_EQ(from_grey({0, {130, 130, 130}, true}), 1);
  EXPECT_EQ(from_grey({0, {255, 255, 255}, true}), 1);
  EXPECT_EQ(from_grey(colourless), 1);
  EXPECT_EQ(SeamWindow::difference(&colourless, &colourless), 1);
  EXPECT_EQ(SeamWindow::difference(&grey, nullptr), 1);
}

// Energy of a labelling, as cut_seams is to make it small.
int energy(const SeamWindow& window, const Raster<std::int16_t>& labels) {
  int sum = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto own = labels.at(x, y);
      sum += window.choice(x, y, own)->price;
      for (const auto& [u, v] : {std::pair(x + 1, y), std::pair(x, y + 1)}) {
        if (u >= kSide || v >= kSide || labels.at(u, v) == own) continue;
        const auto different = [&](int i, int j) {
          return SeamWindow::difference(window.choice(i, j, own), window.choice(i, j, labels.at(u, v)));
        };
        sum += window.seam_price(x, y, u, v, (different(x, y) + different(u, v)) / 2);
      }
    }
  }
  return sum;
}

// In a random landscape no single cell can change its view to make the energy smaller: an expansion holds all such
// changes.
TEST(SeamWindow, NoSingleCellCouldDoBetter) {
  Random random(7);
  SeamWindow window = two_views(6);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      window.raised.at(x, y) = float(random.uniform() < 0.2);
      window.steep.at(x, y) = float(random.uniform());
      for (int view = 0; view < 2; ++view)
        for (auto& channel : choice(window, x, y, view).colour) channel = std::uint8_t(random.uniform(80, 120));
    }
  }
  const auto before = cheapest_views(window);
  auto labels = before;
  cut_seams(window, 0, 0, kSide, kSide, labels);
  const int least = energy(window, labels);
  EXPECT_LT(least, energy(window, before));
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      auto changed = labels;
      changed.at(x, y) = std::int16_t(1 - labels.at(x, y));
      EXPECT_GE(energy(window, changed), least - 2) << x << ' ' << y;  // prices are rounded
    }
  }
}

// A roof with a chimney, 10 m square, across the border of two windows of the plan and midway between two images
// that each see all of it but what the chimney hides: it is of one image, that part included.
TEST(SeamPlan, ARoofIsOfOneImageAsAWhole) {
  constexpr double kCell = 0.2, kMiddleX = 1024 * kCell, kMiddleY = 16;
  constexpr int kWidth = 1184, kHeight = 160;
  const auto height_at = [](double x, double y) {
    const double dx = std::abs(x - kMiddleX), dy = std::abs(y - kMiddleY);
    return dx < 0.8 && dy < 0.8 ? 9.0f : dx < 5 && dy < 5 ? 6.0f : 0.0f;
  };
  HeightField surface, terrain;
  surface.grid = terrain.grid = {0, kHeight * kCell, kCell, kWidth, kHeight, ""};
  const auto read = [grid = surface.grid](auto height) {
    return [grid, height](int column, int row, int width, int height_cells) -> Result<FloatImage> {
      FloatImage heights(width, height_cells);
      for (int y = 0; y < height_cells; ++y)
        for (int x = 0; x < width; ++x)
          heights.at(x, y) = height(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5));
      return heights;
    };
  };
  surface.read = read(height_at);
  terrain.read = read([](double, double) { return 0.0f; });
  const auto heights = overview(surface, collinea::Run{});
  ASSERT_TRUE(heights);
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(300, 400, 300);
  for (const std::uint32_t i : {1u, 2u}) {
    block.images[ImageId{i}] = Image{.file = {}, .camera = CameraId{1}, .taken = {}, .position = {}, .attitude = {}};
    const Eigen::Quaterniond down(0, 1, 0, 0);
    const Eigen::Vector3d centre(kMiddleX + (i == 1 ? -7 : 7), kMiddleY + 1, 40);
    set_pose(block, ImageId{i}, {down, -(down * centre)});
  }
  PixelCache images(
      [](ImageId, int shrink) -> Result<ColourImage> { return ColourImage(400 / shrink, 300 / shrink, 3, 100); },
      1 << 24);
  OrthoScene scene{surface.grid, &surface, &*heights, nullptr, views_of(block, nullptr), {}, {}, &images, 12, &terrain};
  scene.balance.exposures.resize(2);
  const auto plan = plan_seams(scene, collinea::Run{});
  ASSERT_TRUE(plan);
  const auto at = [&](double x, double y) {
    return plan->source.at(int(x / (4 * kCell)), int((kHeight * kCell - y) / (4 * kCell)));
  };
  const auto roof = at(kMiddleX, kMiddleY);
  EXPECT_NE(roof, 0);
  for (double y = kMiddleY - 4.5; y < kMiddleY + 4.6; y += 0.5)
    for (double x = kMiddleX - 4.5; x < kMiddleX + 4.6; x += 0.5) ASSERT_EQ(at(x, y), roof) << x << ' ' << y;
  EXPECT_EQ(at(kMiddleX - 12, kMiddleY), 1);
  EXPECT_EQ(at(kMiddleX + 12, kMiddleY), 2);
}

}  // namespace
}  // namespace collinea
