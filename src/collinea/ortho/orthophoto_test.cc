// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/orthophoto.h"

#include "collinea/ortho/test_orthophoto.h"

namespace collinea {
namespace {

bool near_box_edge(const World& world, double x, double y, double distance_m) {
  const bool around = x > world.box_from - distance_m && x < world.box_to + distance_m &&
                      y > world.box_from - distance_m && y < world.box_to + distance_m;
  const bool within = x > world.box_from + distance_m && x < world.box_to - distance_m &&
                      y > world.box_from + distance_m && y < world.box_to - distance_m;
  return around && !within;
}

// The largest difference to the true colour over all painted cells that are not right at the edges of the box.
double worst_colour(const Product& product, const World& world) {
  double worst = 0;
  for (int row = 0; row < product.grid.height; ++row) {
    for (int column = 0; column < product.grid.width; ++column) {
      const double x = product.grid.east_of(column + 0.5), y = product.grid.north_of(row + 0.5);
      if (product.rgba.at(column, row, 3) == 0 || near_box_edge(world, x, y, 3 * kCell)) continue;
      const Colour truth = world.colour(x, y);
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(product.rgba.at(column, row, c) - truth[std::size_t(c)]));
    }
  }
  return worst;
}

// Images and result are rounded to whole levels: 0.5 each, and a little for interpolation.
TEST(Orthophoto, ColoursAreThoseOfTheGround) {
  const World world;
  const Product product =
      make(world, block_of(nine_centres()), {.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}});
  ASSERT_TRUE(product.summary);
  EXPECT_LT(worst_colour(product, world), 1.5);
  EXPECT_GT(product.summary->painted_cells, 0.97 * kSide * kSide);
  EXPECT_GE(product.summary->images_used, 6u);
  EXPECT_EQ(product.grid.cell_m, kCell);
  EXPECT_EQ(product.grid.width, kSide);
}

TEST(Orthophoto, CellsWithoutHeightAreTransparent) {
  const Product product =
      make({}, block_of(nine_centres()), {.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}});
  ASSERT_TRUE(product.summary);
  EXPECT_EQ(product.rgba.at(3, 4, 3), 0);
  EXPECT_EQ(product.source.at(3, 4), 0);
  EXPECT_EQ(product.rgba.at(8, 4, 3), 255);
}

// One camera in the west: ground in the lee of the box, from its wall at x = 20 to 20 + 8 (20 - 4) / (50 - 8) = 23.05,
// is hidden; the rest is not. At the border of what is hidden interpolation may mix in a little of the roof, which is
// 90 levels away.
TEST(Orthophoto, HiddenGroundIsNotPaintedWithTheRoof) {
  const World world;
  const Product product =
      make(world, block_of({{4, 16, 50}}), {.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}});
  ASSERT_TRUE(product.summary);
  EXPECT_LT(worst_colour(product, world), 30);
  const int row = kSide - int(16 / kCell);
  const auto alpha = [&](double x) { return int(product.rgba.at(int(x / kCell), row, 3)); };
  EXPECT_EQ(alpha(20.5), 0);
  EXPECT_EQ(alpha(22.5), 0);
  EXPECT_EQ(alpha(24.5), 255);
  EXPECT_EQ(alpha(16.0), 255);
  EXPECT_EQ(alpha(11.0), 255);
}

// The wall facing the camera must not leave a trace on the ground in front of it.
TEST(Orthophoto, NoCellShowsAWall) {
  const World world;
  const Product product =
      make(world, block_of(nine_centres()), {.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}});
  ASSERT_TRUE(product.summary);
  int bluish = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) bluish += product.rgba.at(x, y, 3) != 0 && product.rgba.at(x, y, 2) > 140;
  EXPECT_LE(bluish, 20);  // at the very edge of the roof interpolation mixes a little
}

TEST(Orthophoto, UnevenExposuresAreBalanced) {
  const World world;
  const Block block = block_of(nine_centres());
  const Product product = make(world, block, {}, true);
  ASSERT_TRUE(product.summary);
  // Every point of the ground gets the same colour from all images that show it: to a grey level of the hundred that
  // it has in the mean, to three at worst. Planted are up to 50 %.
  const ColourBalance& balance = product.summary->kept.balance;
  const std::vector<View> views = views_of(block, nullptr);
  ASSERT_EQ(balance.exposures.size(), views.size());
  double worst = 0, sum = 0, planted = 0;
  int common = 0, sightings = 0;
  for (int y = 2; y < 30; y += 3) {
    for (int x = 2; x < 30; x += 3) {
      const Eigen::Vector3d position(x, y, 0);
      std::array<std::vector<double>, 3> brightness, uneven;
      for (std::size_t i = 0; i < views.size(); ++i) {
        const auto pixel = pixel_of(views[i], position);
        if (!pixel || !well_inside(views[i], *pixel)) continue;
        const double darker = std::exp(-0.25 * relative_radius2(views[i].camera, *pixel));
        for (std::size_t c = 0; c < 3; ++c) {
          uneven[c].push_back(gain_of(views[i].image)[c] * darker);
          brightness[c].push_back(uneven[c].back() * double(balance.factor(i, views[i], position, *pixel)[c]));
        }
      }
      if (brightness[0].size() < 2) continue;
      ++common, sightings += int(brightness[0].size());
      const auto spread = [](const std::vector<double>& all) {
        const auto [least, most] = std::minmax_element(all.begin(), all.end());
        return *most / *least - 1;
      };
      for (std::size_t c = 0; c < 3; ++c) {
        worst = std::max(worst, spread(brightness[c]));
        sum += spread(brightness[c]);
        planted = std::max(planted, spread(uneven[c]));
      }
    }
  }
  EXPECT_GT(common, 90);  // of 100 positions
  EXPECT_GT(sightings, 5 * common);
  EXPECT_GT(planted, 0.4);
  EXPECT_LT(sum / (3 * common), 0.01);
  EXPECT_LT(worst, 0.03);
}

TEST(Orthophoto, ThreadsDoNotMatter) {
  const Block block = block_of({{4, 4, 50}, {28, 28, 50}});
  const OrthoOptions fine{.cell_m = 0.03, .feather_cells = 12, .balance = true, .seamlines = {}};  // more than one tile
  const Product one = make({}, block, fine, true), three = make({}, block, fine, true, 3);
  ASSERT_TRUE(one.summary && three.summary);
  EXPECT_GT(one.grid.width, kOrthoTile);
  EXPECT_EQ(one.rgba.data, three.rgba.data);
  EXPECT_EQ(one.source.data, three.source.data);
}

TEST(Orthophoto, TheSeamlinesThatWereFoundGiveTheSameImageWhenTheyAreGiven) {
  const Block block = block_of(nine_centres());
  const OrthoOptions fine{.cell_m = 0.07, .feather_cells = 12, .balance = true, .seamlines = {}};
  const Product found = make({}, block, fine, true);
  ASSERT_TRUE(found.summary);
  ASSERT_GT(found.summary->seamlines.size(), 4u);
  const Product given = make({}, block, fine, true, 1, {.terrain = nullptr, .given = &found.summary->seamlines});
  ASSERT_TRUE(given.summary);
  EXPECT_EQ(given.rgba.data, found.rgba.data);
  EXPECT_EQ(given.source.data, found.source.data);
  EXPECT_EQ(given.summary->not_followed, found.summary->not_followed);
}

// A view from the west is asked for everywhere: it is taken everywhere but in the lee of the box and beside its
// image.
TEST(Orthophoto, AGivenImageIsUsedWhereverItSeesTheGround) {
  const World world;
  const Block block = block_of({{4, 16, 50}, {28, 16, 50}});
  const std::vector<SeamPolygon> everything = {{1, {{{-1, -1}, {-1, 40}, {40, 40}, {40, -1}}}}};
  const Product product = make(world, block, {.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}},
                               false, 1, {.terrain = nullptr, .given = &everything});
  ASSERT_TRUE(product.summary);
  const int row = kSide - int(16 / kCell);
  const auto source = [&](double x) { return product.source.at(int(x / kCell), row); };
  for (const double x : {1.0, 8.0, 14.0, 18.0, 25.5}) EXPECT_EQ(source(x), 1) << x;
  EXPECT_EQ(source(20.7), 2);
  EXPECT_EQ(source(22.0), 2);
  EXPECT_LT(worst_colour(product, world), 30);
  EXPECT_EQ(product.summary->not_followed.size(), 1u);
  EXPECT_GT(product.summary->not_followed.at(0), 100u);
  EXPECT_LT(product.summary->not_followed.at(0), product.summary->painted_cells / 3);
}

// The lower right quarter made as a tile of its own, against the same cells of a larger one.
TEST(Orthophoto, TheCutIntoTilesDoesNotMatter) {
  const World world;
  const Block block = block_of(nine_centres());
  const HeightField surface = surface_of(world);
  const auto heights = overview(surface, collinea::Run{});
  ASSERT_TRUE(heights);
  PixelCache images([&](ImageId image, int) -> Result<ColourImage> { return raster(world, block, image, true); },
                    1 << 30);
  OrthoScene scene{surface.grid, &surface, &*heights, nullptr, views_of(block, nullptr), {}, {}, &images, 12};
  scene.shrink.assign(9, 1);
  scene.balance.exposures.resize(9);
  const auto whole = make_ortho_tile(scene, 0, 0, kSide, kSide, collinea::Run{});
  const auto part = make_ortho_tile(scene, 80, 64, 80, 96, collinea::Run{});
  ASSERT_TRUE(whole && part);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 80; ++x) {
      ASSERT_EQ(part->source.at(x, y), whole->source.at(80 + x, 64 + y)) << x << ' ' << y;
      for (int c = 0; c < 4; ++c) ASSERT_EQ(part->rgba.at(x, y, c), whole->rgba.at(80 + x, 64 + y, c)) << x << ' ' << y;
    }
  }
}

// A ridge of 120 m from x = 199 m to 201 m, a thousand cells of the surface away from some of the ground that it hides:
// from a camera 300 m above x = 400 m its shadow reaches to x = 400 - 300 (400 - 199) / (300 - 120) = 65 m.
TEST(Orthophoto, AMountainFarAwayHidesTheGround) {
  HeightField surface;
  surface.grid = {0, 16, 0.125, 1760, 128, ""};
  surface.read = [&](int column, int, int width, int height) -> Result<FloatImage> {
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        heights.at(x, y) =
            float(std::clamp(150 - 30 * std::abs(surface.grid.east_of(column + x + 0.5) - 200), 0.0, 120.0));
    return heights;
  };
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(250, 500, 200);
  const ImageId id{1};
  block.images[id] = Image{.file = {}, .camera = CameraId{1}, .taken = {}, .position = {}, .attitude = {}};
  const Eigen::Quaterniond down(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond west(Eigen::AngleAxisd(0.78, Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond rotation = west * down;
  set_pose(block, id, {rotation, -(rotation * Eigen::Vector3d(400, 8, 300))});
  const PixelSource pixels = [](ImageId, int shrink) -> Result<ColourImage> {
    return ColourImage((500 + shrink - 1) / shrink, (200 + shrink - 1) / shrink, 3, 100);
  };
  for (const double cell_m : {0.125, 0.5}) {
    Raster<std::uint8_t> alpha;
    const OrthoSink sink{[&](const MapGrid& grid) -> Result<> {
                           alpha = Raster<std::uint8_t>(grid.width, grid.height);
                           return {};
                         },
                         [&](int column, int row, const OrthoTile& tile) -> Result<> {
                           for (int y = 0; y < tile.rgba.height; ++y)
                             for (int x = 0; x < tile.rgba.width; ++x)
                               alpha.at(column + x, row + y) = tile.rgba.at(x, y, 3);
                           return {};
                         }};
    const auto made = make_orthophoto(block, nullptr, surface, {}, pixels, cell_m, sink, {}, collinea::Run{});
    ASSERT_TRUE(made);
    const auto painted = [&](double x) { return alpha.at(int(x / cell_m), alpha.height / 2) != 0; };
    for (const double x : {10.0, 30.0, 50.0, 62.0, 203.0}) EXPECT_TRUE(painted(x)) << x;
    for (const double x : {69.0, 75.0, 90.0, 120.0, 150.0, 170.0, 190.0}) EXPECT_FALSE(painted(x)) << x;
  }
}

TEST(Orthophoto, WithoutOrientedImagesThereIsNone) {
  const Product product = make({}, Block{}, {});
  ASSERT_FALSE(product.summary);
  EXPECT_EQ(product.summary.error().code, Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
