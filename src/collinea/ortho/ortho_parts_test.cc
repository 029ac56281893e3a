// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stop_token>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/ortho/ortho_tile.h"

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

TEST(HeightField, HeightsAreBilinearOnSlopesAndSharpAtSteps) {
  FloatImage heights(20, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) heights.at(x, y) = 0.5f * float(x) + (x >= 10 ? 8.0f : 0.0f);
  heights.at(3, 3) = kNone;
  const auto at = [&](double x, double y) { return height_at(heights, x, y, 1); };
  EXPECT_FLOAT_EQ(at(6.25, 7.0), 0.5f * 5.75f);
  EXPECT_FLOAT_EQ(at(9.9, 7.5), 4.5f);
  EXPECT_FLOAT_EQ(at(10.1, 7.5), 13.0f);
  EXPECT_TRUE(std::isnan(at(3.5, 3.5)));
  EXPECT_FLOAT_EQ(at(4.1, 3.5), 2.0f);
  EXPECT_TRUE(std::isnan(at(-1, 3)));
}

TEST(Overview, KnowsRangeAndAPlaceOfEachBlock) {
  HeightField field;
  field.grid = {0, 0, 1, 70, 300, ""};
  field.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        heights.at(x, y) = column + x >= 64 ? kNone : float(column + x + 1000 * (row + y));
    return heights;
  };
  const auto result = overview(field, collinea::Run{});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->lowest_m.width, 3);
  EXPECT_EQ(result->lowest_m.height, 10);
  EXPECT_EQ(result->lowest_m.at(1, 8), 256'032);
  EXPECT_EQ(result->highest_m.at(1, 8), 287'063);
  EXPECT_TRUE(std::isnan(result->highest_m.at(2, 0)));
  ASSERT_EQ(result->places.size(), 20u);
  EXPECT_EQ(result->places[3].column, 48.5);
  EXPECT_EQ(result->places[3].row, 48.5);
}

TEST(HeightField, ThinnedKeepsEveryFourthHeightAndTheCorner) {
  HeightField field;
  field.grid = {500, 900, 0.5, 70, 301, ""};
  field.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    EXPECT_TRUE(column >= 0 && row >= 0 && column + width <= 70 && row + height <= 301);
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) heights.at(x, y) = float(column + x + 1000 * (row + y));
    return heights;
  };
  const HeightField thin = thinned(field, 4);
  EXPECT_EQ(thin.grid.width, 18);
  EXPECT_EQ(thin.grid.height, 76);
  EXPECT_EQ(thin.grid.cell_m, 2);
  EXPECT_EQ(thin.grid.west_m, 500);
  EXPECT_EQ(thin.grid.north_m, 900);
  EXPECT_FALSE(thin.read_sigma);
  const auto part = thin.read(3, 1, 15, 75);  // more than one strip, and to the last cells
  ASSERT_TRUE(part);
  EXPECT_EQ(part->at(0, 0), 14 + 1000 * 6);
  EXPECT_EQ(part->at(1, 70), 18 + 1000 * (4 * 71 + 2));
  EXPECT_EQ(part->at(14, 74), 69 + 1000 * 300);
}

TEST(HeightField, UnpackedIsTheSameAndLeavesNoFile) {
  const TestFolder folder;
  HeightField field;
  field.grid = {500, 900, 0.5, 70, 301, ""};
  const auto reader = [](float more) {
    return [more](int column, int row, int width, int height) -> Result<FloatImage> {
      FloatImage heights(width, height);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          heights.at(x, y) = column + x == 7 ? kNone : more + float(column + x + 1000 * (row + y));
      return heights;
    };
  };
  field.read = reader(0);
  {
    const auto exact = unpacked(field, folder / "scratch", collinea::Run{});
    ASSERT_TRUE(exact);
    EXPECT_FALSE(exact->read_sigma);
  }
  field.read_sigma = reader(0.25f);
  {
    const auto kept = unpacked(field, folder / "scratch", collinea::Run{});
    ASSERT_TRUE(kept && kept->read_sigma);
    EXPECT_EQ(kept->grid.width, 70);
    EXPECT_EQ(kept->grid.cell_m, 0.5);
    for (const auto& [column, row] : {std::pair(8, 0), std::pair(30, 226)}) {
      const auto heights = kept->read(column, row, 40, 75), sigmas = kept->read_sigma(column, row, 40, 75);
      ASSERT_TRUE(heights && sigmas);
      EXPECT_EQ(heights->data, field.read(column, row, 40, 75)->data);
      EXPECT_EQ(sigmas->data, field.read_sigma(column, row, 40, 75)->data);
    }
    EXPECT_TRUE(std::isnan(kept->read(7, 300, 1, 1)->at(0, 0)));
    EXPECT_TRUE(std::filesystem::is_empty((folder / "scratch").parent_path()));
  }
  EXPECT_FALSE(unpacked(field, folder / "none" / "scratch", collinea::Run{}));
}

TEST(HeightField, SigmasOfAnotherModelAreRefusedInWords) {
  const TestFolder folder;
  const auto write = [&](const std::string& name, const MapGrid& grid) {
    auto writer = GeoTiffWriter<float>::create(folder / name, grid, 1, {});
    return writer && writer->write(0, 0, FloatImage(grid.width, grid.height, 1, 5)) && writer->finish();
  };
  const MapGrid grid{500'000.5, 5'000'000, 0.05, 40, 30, ""};
  MapGrid moved = grid, coarser = grid, smaller = grid;
  moved.north_m += grid.cell_m;
  coarser.cell_m = 0.051;
  smaller.height = 29;
  ASSERT_TRUE(write("dsm.tif", grid) && write("sigma.tif", grid));
  EXPECT_TRUE(open_height_field(folder / "dsm.tif", folder / "sigma.tif")->read_sigma);
  for (const MapGrid& other : {moved, coarser, smaller}) {
    ASSERT_TRUE(write("other.tif", other));
    const auto refused = open_height_field(folder / "dsm.tif", folder / "other.tif");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
    EXPECT_NE(refused.error().message.find("does not lie on"), std::string::npos) << refused.error().message;
  }
}

// Cells of one view, of which `unseen` of the 5 x 5 in the middle are seen by nobody, the middle among them.
Labels with_unseen(int unseen) {
  Labels labels(9, 9, 1, 3);
  labels.at(4, 4) = kNoView;
  for (int i = 0, left = unseen - 1; left > 0; ++i) {
    auto& label = labels.at(2 + i % 5, 2 + i / 5);
    if (label != kNoView) label = kNoView, --left;
  }
  return labels;
}

TEST(Pinholes, CloseWhereNoMoreThanTenOfTwentyFiveCellsAreUnseen) {
  const FloatImage level(9, 9);
  for (const int unseen : {1, 10, 11, 25}) {
    Labels labels = with_unseen(unseen);
    close_pinholes(level, 4, labels);
    EXPECT_EQ(labels.at(4, 4), unseen <= 10 ? 3 : kNoView) << unseen;
  }
}

TEST(Pinholes, TakeTheViewOfMostCellsAround) {
  Labels labels(9, 9, 1, 2);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 4; ++x) labels.at(x, y) = 1;  // 10 of 25
  labels.at(4, 4) = kNoView;
  close_pinholes(FloatImage(9, 9), 3, labels);
  EXPECT_EQ(labels.at(4, 4), 2);
}

TEST(Pinholes, HiddenPlacesKeepTheirBordersAndCellsWithoutHeightStayEmpty) {
  Labels labels(12, 12, 1, 0);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 6; ++x) labels.at(x, y) = kNoView;
  labels.at(9, 6) = kNoView;
  FloatImage heights(12, 12);
  heights.at(9, 6) = kNone;
  const Labels before = labels;
  close_pinholes(heights, 1, labels);
  EXPECT_EQ(labels.data, before.data);
}

// Keys' kernel reproduces polynomials of degree 2.
TEST(Bicubic, ReproducesAParabola) {
  ColourImage picture(12, 12, 3);
  const auto value = [](double x, double y, int c) {
    return 20 + 1.0 * c + (x - 0.5) * (x - 0.5) + (y - 0.5) * (x - 0.5);
  };
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = std::uint8_t(value(x + 0.5, y + 0.5, c));
  float colour[3];
  bicubic(picture, 5.8, 4.3, colour);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour[c], value(5.8, 4.3, c), 1e-4);
}

TEST(PixelCache, DecodesOnceAndForgetsTheOldest) {
  int decoded = 0;
  PixelCache cache([&](ImageId, int) -> Result<ColourImage> { return ++decoded, ColourImage(10, 10, 3); }, 700);
  ASSERT_TRUE(cache.picture(ImageId{1}, 1));
  ASSERT_TRUE(cache.picture(ImageId{2}, 1));
  ASSERT_TRUE(cache.picture(ImageId{1}, 1));
  EXPECT_EQ(decoded, 2);
  ASSERT_TRUE(cache.picture(ImageId{3}, 1));  // 2 goes
  ASSERT_TRUE(cache.picture(ImageId{1}, 1));
  EXPECT_EQ(decoded, 3);
  ASSERT_TRUE(cache.picture(ImageId{2}, 1));
  EXPECT_EQ(decoded, 4);
}

TEST(PixelCache, KeepsNoMorePicturesThanItMayHoweverSmallTheyAre) {
  int decoded = 0;
  PixelCache cache([&](ImageId, int) -> Result<ColourImage> { return ++decoded, ColourImage(1, 1, 3); }, 700, 2);
  for (const std::uint32_t image : {1, 2, 3, 3, 2}) ASSERT_TRUE(cache.picture(ImageId{image}, 1));
  EXPECT_EQ(decoded, 3);
  ASSERT_TRUE(cache.picture(ImageId{1}, 1));  // 3 goes
  ASSERT_TRUE(cache.picture(ImageId{2}, 1));
  EXPECT_EQ(decoded, 4);
}

TEST(PixelCache, PassesErrorsOn) {
  PixelCache cache([](ImageId, int) -> Result<ColourImage> { return fail(Errc::kNotFound, "gone"); }, 700);
  const auto picture = cache.picture(ImageId{1}, 1);
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, Errc::kNotFound);
}

// A strip of 12 pictures, each overlapping the next two; a fifth of the places shows something else in each picture.
TEST(Exposures, GainsAndFalloffAreRecoveredDespiteOutliers) {
  Random random(11);
  constexpr int kPictures = 12;
  std::vector<std::vector<ColourSample>> samples(kPictures);
  std::vector<double> log_gain;
  for (int i = 0; i < kPictures; ++i) log_gain.push_back(random.uniform(-0.2, 0.2));
  double trend = 0;  // which would be the directions'
  for (int i = 0; i < kPictures; ++i) trend += (i - 5.5) * log_gain[std::size_t(i)] / 143;
  for (int i = 0; i < kPictures; ++i) log_gain[std::size_t(i)] -= trend * (i - 5.5);
  const std::vector<Eigen::Vector2d> places(1200, Eigen::Vector2d::Zero());
  for (std::uint32_t place = 0; place < 1200; ++place) {
    const double colour = random.uniform(3.5, 4.5);
    for (int i = int(place) / 100; i < std::min(kPictures, int(place) / 100 + 3); ++i) {
      const double r2 = random.uniform(0, 1), wrong = random.uniform() < 0.2 ? random.uniform(-0.5, 0.5) : 0;
      const float value = float(colour + log_gain[std::size_t(i)] - 0.3 * r2 + wrong + 0.02 * random.normal());
      samples[std::size_t(i)].push_back({place, float(r2), {value, value, value}});
    }
  }
  std::vector<Standpoint> standpoints;
  for (int i = 0; i < kPictures; ++i) standpoints.push_back({CameraId{1}, {double(i), 0}});
  const auto exposures = balance_exposures(places, samples, standpoints, collinea::Run{}).value().exposures;
  EXPECT_NEAR(exposures[0].falloff[0], 0.3, 0.02);
  for (std::size_t i = 1; i < kPictures; ++i) {
    const double ratio = std::log(double(exposures[i].gain[2]) / double(exposures[i - 1].gain[2]));
    EXPECT_NEAR(ratio, log_gain[i - 1] - log_gain[i], 0.02) << i;
  }
}

// Six strips of eight pictures over ground that sends more light back to the sun: brighter the further west one stands,
// most where the shadow of the camera falls. The exposures differ at random; they must not take over that trend.
TEST(Exposures, LightSentBackToTheSunDoesNotBecomeATrendOfTheGains) {
  Random random(12);
  constexpr int kAcross = 8, kDown = 6;
  const auto log_brightness = [](const Eigen::Vector2d& u) {
    return -0.5 * u.x() + 0.2 * std::exp(-30 * (u - Eigen::Vector2d(-0.25, 0.1)).squaredNorm());
  };
  std::vector<double> log_gain;
  for (int i = 0; i < kAcross * kDown; ++i) log_gain.push_back(0.05 * random.normal());
  std::vector<std::vector<ColourSample>> samples(kAcross * kDown);
  std::vector<Eigen::Vector2d> places;
  for (std::uint32_t place = 0; place < 3000; ++place) {
    const Eigen::Vector2d at(random.uniform(-0.3, 0.2 * kAcross + 0.1), random.uniform(-0.3, 0.3 * kDown));
    places.push_back(at);
    const double colour = random.uniform(3.5, 4.5);
    for (int i = 0; i < kAcross * kDown; ++i) {
      const Eigen::Vector2d from(0.2 * (i % kAcross), 0.3 * (i / kAcross)), t = from - at;  // in flying heights
      if (t.cwiseAbs().maxCoeff() > 0.5) continue;
      const Eigen::Vector2d u = t / std::sqrt(1 + t.squaredNorm());
      const float value = float(colour + log_gain[std::size_t(i)] + log_brightness(u) + 0.02 * random.normal());
      samples[std::size_t(i)].push_back({place, float(2 * t.squaredNorm()), {value, value, value}, u});
    }
  }
  std::vector<Standpoint> standpoints;
  for (int i = 0; i < kAcross * kDown; ++i)
    standpoints.push_back({CameraId{1}, {0.2 * (i % kAcross), 0.3 * (i / kAcross)}});
  const ColourBalance balance = balance_exposures(places, samples, standpoints, collinea::Run{}).value();
  double trend = 0, squares = 0;  // of the gains from west to east
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double x = double(i % kAcross) - (kAcross - 1) / 2.0;
    trend += x * (std::log(double(balance.exposures[i].gain[1])) + log_gain[i]), squares += x * x;
  }
  // The directions' trend of 0.5 would make 0.1 from picture to picture. What is left is the chance trend of the gains.
  EXPECT_NEAR(trend / squares, 0, 0.01);
  // Every place looks the same from everywhere. How much of that the fall-off does is arbitrary.
  const auto corrected = [&](const Eigen::Vector2d& t) {
    const Eigen::Vector2d u = t / std::sqrt(1 + t.squaredNorm());
    return double(balance.exposures[0].falloff[1]) * 2 * t.squaredNorm() + double(balance.directions.at(u)[1]) +
           log_brightness(u);
  };
  const double above = corrected({0, 0});
  for (const auto& [x, y] : {std::pair(-0.3, 0.0), {0.3, 0.0}, {0.0, 0.3}, {0.2, -0.3}, {-0.25, 0.1}})
    EXPECT_NEAR(corrected({x, y}), above, 0.05) << x << " " << y;
  // In the middle of the block the directions have nothing to say on the whole; at its eastern border, seen from the
  // west only, the ground keeps the brightness of that side.
  EXPECT_NEAR(double(balance.places.at({0.7, 0.75})[1]), 0, 0.03);
  EXPECT_NEAR(double(balance.places.at({1.8, 0.75})[1]), -0.5 * 0.4, 0.06);
}

TEST(Exposures, MayBeCancelled) {
  std::vector<std::vector<ColourSample>> samples(2);
  for (std::uint32_t i = 0; i < 50; ++i)
    for (auto& seen : samples) seen.push_back({i, 0.1f, {4, 4, 4}});
  const std::vector<Eigen::Vector2d> places(50, Eigen::Vector2d::Zero());
  const std::vector<Standpoint> standpoints{{CameraId{1}, {0, 0}}, {CameraId{1}, {1, 0}}};
  std::stop_source stop;
  stop.request_stop();
  collinea::Run run;
  run.stop = stop.get_token();
  const auto balance = balance_exposures(places, samples, standpoints, run);
  ASSERT_FALSE(balance);
  EXPECT_EQ(balance.error().code, Errc::kCancelled);
}

// The pictures stand a little aside of the line: that is no axis along which exposures could have a trend.
TEST(Exposures, OfAStripAreNotHeldBackAcrossIt) {
  Random random(14);
  constexpr int kPictures = 8;
  std::vector<Standpoint> standpoints;
  std::vector<double> log_gain;
  for (int i = 0; i < kPictures; ++i) {
    log_gain.push_back(0.3 * (i % 2 == 0 ? 1 : -1) * (i % 4 < 2 ? 1 : 0.3));
    standpoints.push_back({CameraId{1}, {0.2 * i, 0.01 * (i % 2 == 0 ? 1 : -1)}});
  }
  std::vector<std::vector<ColourSample>> samples(kPictures);
  std::vector<Eigen::Vector2d> places;
  for (std::uint32_t place = 0; place < 600; ++place) {
    places.emplace_back(random.uniform(0, 1.4), random.uniform(-0.3, 0.3));
    for (std::size_t i = 0; i < kPictures; ++i) {
      const Eigen::Vector2d t = standpoints[i].at - places.back();
      if (t.cwiseAbs().maxCoeff() > 0.4) continue;
      const float value = float(4 + log_gain[i] + 0.02 * random.normal());
      samples[i].push_back(
          {place, float(2 * t.squaredNorm()), {value, value, value}, t / std::sqrt(1 + t.squaredNorm())});
    }
  }
  const ColourBalance balance = balance_exposures(places, samples, standpoints, collinea::Run{}).value();
  double product = 0, squares = 0;
  for (std::size_t i = 1; i < kPictures; ++i) {
    const double truth = log_gain[i - 1] - log_gain[i];
    product += truth * std::log(double(balance.exposures[i].gain[1]) / double(balance.exposures[i - 1].gain[1]));
    squares += truth * truth;
  }
  EXPECT_NEAR(product / squares, 1, 0.02);
}

TEST(Exposures, PicturesWithoutCommonPlacesStayAsTheyAre) {
  std::vector<std::vector<ColourSample>> samples(2);
  const std::vector<Eigen::Vector2d> places(50, Eigen::Vector2d::Zero());
  for (std::uint32_t i = 0; i < 50; ++i) {
    const bool second = i % 2 == 1;  // is brighter, towards its corners and from the east
    const Eigen::Vector2d direction(0.01 * i - 0.25, 0.2);
    const float r2 = 0.02f * float(i), value = second ? 4.5f + 0.3f * r2 + float(direction.x()) : 4.0f;
    samples[second].push_back({i, r2, {value, value - 0.2f, value + 0.1f}, direction});
  }
  const std::vector<Standpoint> standpoints{{CameraId{1}, {0, 0}}, {CameraId{1}, {1, 0}}};
  const ColourBalance balance = balance_exposures(places, samples, standpoints, collinea::Run{}).value();
  ASSERT_EQ(balance.exposures.size(), 2u);
  const std::array<float, 3> ones{1, 1, 1}, zeros{0, 0, 0};
  for (const Exposure& exposure : balance.exposures) {
    EXPECT_EQ(exposure.gain, ones);
    EXPECT_EQ(exposure.falloff, zeros);
  }
  for (const double x : {-0.8, -0.2, 0.0, 0.5}) {
    EXPECT_EQ(balance.directions.at({x, 0.2}), zeros) << x;
    EXPECT_EQ(balance.places.at({x, 0}), zeros) << x;
  }
}

TEST(ChannelTable, SmoothedValuesFollowAPlaneAndGoOnWhereThereAreNone) {
  Random random(13);
  std::vector<ChannelValues> scattered;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d at(random.uniform(100, 140), random.uniform(-20, 0));
    if (at.x() > 120 && at.x() < 130) continue;  // nothing is known here
    scattered.push_back({at, {float(at.x()), 7, float(-at.y())}});
  }
  const ChannelTable table = smoothed_table(scattered, 1);
  EXPECT_NEAR(double(table.at({110, -10})[0]), 110, 0.3);
  EXPECT_NEAR(double(table.at({110, -5})[2]), 5, 0.3);
  for (const double x : {90.0, 110.0, 124.0, 150.0}) EXPECT_NEAR(double(table.at({x, -10})[1]), 7, 1e-4) << x;
  EXPECT_NEAR(double(table.at({123, -10})[0]), 120, 1.5);  // as the nearest
  EXPECT_NEAR(double(table.at({128, -10})[0]), 130, 1.5);
  EXPECT_EQ(table.at({1000, -10}), table.at({200, -10}));
}

// Two sites in opposite corners: between them a thousand rings of nodes take over from one another.
TEST(ChannelTable, LongGapsStayBetweenTheirEnds) {
  const std::vector<ChannelValues> scattered{{{0, 0}, {1, 1, 1}}, {{990, 990}, {2, 2, 2}}};
  const ChannelTable table = smoothed_table(scattered, 1);
  for (double t = 0; t <= 990; t += 11) {
    EXPECT_GE(table.at({t, 990 - t})[0], 1) << t;
    EXPECT_LE(table.at({t, 990 - t})[0], 2) << t;
  }
  EXPECT_NEAR(double(table.at({900, 900})[0]), 2, 1e-6);
}

TEST(ChannelTable, OfOnePlaceOrOfNone) {
  EXPECT_EQ(smoothed_table({}, 1).at({3, 4})[0], 0);
  const std::vector<ChannelValues> one{{{5, 6}, {1, 2, 3}}};
  EXPECT_EQ(smoothed_table(one, 0).at({5, 6})[0], 0);
  for (const double x : {-9.0, 5.0, 99.0}) EXPECT_NEAR(double(smoothed_table(one, 2).at({x, 6})[2]), 3, 1e-6);
}

// A tower of 133 m on a plateau hides places of it 266 m away, by lines of sight flatter than those from a pit that the
// area holds, too: what it casts over the area must not be told by these alone.
TEST(OrthoScene, WhatIsFarAwayHidesPlacesAboveTheLowestOfTheArea) {
  HeightField surface;
  surface.grid = {0, 800, 1, 1760, 800, ""};
  surface.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int u = column + x, v = row + y;
        heights.at(x, y) = u >= 1336 && u < 1342 && v < 40 ? 333.0f : u == 1700 && v == 700 ? 0.0f : 200.0f;
      }
    return heights;
  };
  const auto heights = overview(surface, collinea::Run{});
  ASSERT_TRUE(heights);
  View view;
  view.camera = ideal_camera(1000, 4000, 4000);
  view.centre_in_world = view.centre_in_map = {0.5, 783.5, 1000};
  view.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view.cam_from_world = {Eigen::Quaterniond(view.rotation), -(view.rotation * view.centre_in_world)};
  OrthoScene scene;
  scene.grid = surface.grid;
  scene.surface = &surface, scene.surface_overview = &*heights;
  scene.views = {view};
  std::vector<std::size_t> views;
  const auto patch = make_patch(scene, {1600, 0, 128, 768}, views);
  ASSERT_TRUE(patch && *patch);
  const Occluders& occluders = (*patch)->occluders;
  const auto hidden = [&](double x) {
    return occluders.hide(x - occluders.column(), 16.5 - occluders.row(), 200, 0.5 - occluders.column(),
                          16.5 - occluders.row(), 1000);
  };
  EXPECT_TRUE(hidden(1602.5));
  EXPECT_TRUE(hidden(1604.5));
  EXPECT_FALSE(hidden(1630.5));
}

}  // namespace
}  // namespace collinea
