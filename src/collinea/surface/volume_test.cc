// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kCell = 0.25, kWest = 5000, kNorth = 7000;
constexpr int kWidth = 240, kHeight = 200;  // 60 x 50 m
constexpr float kNothing = -9999;
constexpr double kRelative = 0.03, kCommon = 0.4;  // standard deviations [m]

using Shape = std::function<double(double east, double north)>;  // from the south-western corner [m]

class VolumeOf : public ::testing::Test {
 protected:
  // Heights at the middles of cells, NaN: nothing there.
  SurfaceFiles surface(const std::string& name, const Shape& height_m, double sigma_m = 0.02, double cell_m = kCell) {
    const int width = int(kWidth * kCell / cell_m), height = int(kHeight * kCell / cell_m);
    FloatImage heights(width, height), sigmas(width, height, 1, float(sigma_m));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double value = height_m((x + 0.5) * cell_m, kHeight * kCell - (y + 0.5) * cell_m);
        heights.at(x, y) = std::isnan(value) ? kNothing : float(value);
      }
    return written(name, heights, sigmas, cell_m);
  }
  SurfaceFiles written(const std::string& name, const FloatImage& heights, const FloatImage& sigmas, double cell_m) {
    MapGrid grid;
    grid.west_m = kWest, grid.north_m = kNorth, grid.cell_m = cell_m;
    grid.width = heights.width, grid.height = heights.height;
    const SurfaceFiles files{folder_ / (name + ".tif"), folder_ / (name + "_sigma.tif")};
    for (const auto& [path, raster] : {std::pair(files.height, &heights), {*files.sigma, &sigmas}}) {
      auto writer = GeoTiffWriter<float>::create(path, grid, 1, {.nodata = double(kNothing)});
      EXPECT_TRUE(writer && writer->write(0, 0, *raster) && writer->finish());
    }
    return files;
  }
  SurfaceFiles with_relative(const std::string& name, const FloatImage& heights, const FloatImage& all,
                             const FloatImage& relative) {
    SurfaceFiles files = written(name, heights, all, kCell);
    files.sigma_relative = written(name + "_of", heights, relative, kCell).sigma;
    return files;
  }
  // A level one whose heights err by kRelative, and in common.
  SurfaceFiles with_common(const std::string& name, double height_m, double common_m = kCommon, bool hole = false) {
    FloatImage heights(kWidth, kHeight, 1, float(height_m)), sigmas(kWidth, kHeight, 1, float(kRelative)),
        all(kWidth, kHeight, 1, float(std::hypot(kRelative, common_m)));
    for (int y = kHeight / 2; hole && y < kHeight; ++y)
      for (int x = 0; x < kWidth / 4; ++x) heights.at(x, y) = sigmas.at(x, y) = all.at(x, y) = kNothing;
    return with_relative(name, heights, all, sigmas);
  }
  // In metres from the south-western corner.
  static MapArea rectangle(double west, double south, double east, double north) {
    const double y = kNorth - kHeight * kCell;
    return {{kWest + west, y + south}, {kWest + east, y + south}, {kWest + east, y + north}, {kWest + west, y + north}};
  }

  const TestFolder folder_;
  const collinea::Run run_;
};

TEST_F(VolumeOf, ABlockIsItsAreaTimesItsHeightWhereverTheBorderLies) {
  const auto level = surface("level", [](double, double) { return 105.0; });
  // Borders between cells, and a sixteenth of a cell off in y, which lines across a cell meet exactly.
  for (const MapArea& area : {rectangle(10, 10, 30, 25), rectangle(10.07, 10.0625, 30.111, 25.125)}) {
    const Volume volume = volume_over_level(level, 102, area, {}, run_).value();
    EXPECT_NEAR(volume.area_m2, size_m2(area), 1e-4);
    EXPECT_NEAR(volume.net_m3(), 3 * size_m2(area), 1e-3);
    EXPECT_EQ(volume.below_m3, 0);
    EXPECT_EQ(volume.missing_m2, 0);
  }
  const Volume whole = volume_over_level(level, 106, std::nullopt, {}, run_).value();
  EXPECT_NEAR(whole.below_m3, 60 * 50, 1e-3);
  EXPECT_NEAR(whole.net_m3(), -60 * 50, 1e-3);
}

TEST_F(VolumeOf, AConeOnTheGroundIsAThirdOfItsCylinder) {
  const auto cone = surface(
      "cone", [](double x, double y) { return 100 + std::max(0.0, 8 * (1 - std::hypot(x - 30, y - 25) / 20)); });
  const Volume volume = volume_over_rim(cone, rectangle(5, 3, 55, 47), {}, run_).value();
  const double exact = std::numbers::pi * 20 * 20 * 8 / 3;
  EXPECT_NEAR(volume.net_m3(), exact, 1e-3 * exact);
  EXPECT_NEAR(volume.plane->x(), 100, 1e-6);
  EXPECT_NEAR(volume.rim_rms_m, 0, 1e-6);
}

TEST_F(VolumeOf, APyramidOnASlopeAndAPitInIt) {
  const auto slope = [](double x, double y) { return 200 + 0.1 * x - 0.05 * y; };
  const auto heap = surface("heap", [&](double x, double y) {
    return slope(x, y) + std::max(0.0, 6 - 0.6 * std::max(std::abs(x - 20), std::abs(y - 25))) -
           std::max(0.0, 2 - 0.5 * std::max(std::abs(x - 45), std::abs(y - 25)));
  });
  const Volume volume = volume_over_rim(heap, rectangle(4.1, 5.2, 55.3, 45.4), {}, run_).value();
  EXPECT_NEAR(volume.above_m3, 20 * 20 * 6 / 3.0, 1);
  EXPECT_NEAR(volume.below_m3, 8 * 8 * 2 / 3.0, 0.2);
  EXPECT_NEAR(volume.plane->y(), 0.1, 1e-4);
  EXPECT_NEAR(volume.plane->z(), -0.05, 1e-4);
}

// Two planes are bilinear: read between the cells of another raster they differ exactly.
TEST_F(VolumeOf, BetweenTwoSurfacesOfDifferentCells) {
  const auto above = surface("above", [](double x, double y) { return 10 + 0.02 * x + 0.01 * y; });
  const auto below = surface(
      "below", [](double x, double y) { return 8 + 0.02 * x - 0.01 * y; }, 0.02, 0.5);
  const MapArea area = rectangle(10, 10, 50, 40);
  const Volume volume = volume_over_surface(above, below, area, {}, run_).value();
  EXPECT_NEAR(volume.net_m3(), 1200 * (2 + 0.02 * 25), 0.05);
  EXPECT_NEAR(volume.area_m2, 1200, 1e-3);
}

TEST_F(VolumeOf, WhatHasNoHeightsIsStatedAndNotMadeUp) {
  const auto holed = surface("holed", [](double x, double) { return x < 10 ? std::nan("") : 105.0; });
  const Volume volume = volume_over_level(holed, 102, rectangle(5, 10, 25, 20), {}, run_).value();
  EXPECT_NEAR(volume.missing_m2, 50, 1e-3);
  EXPECT_NEAR(volume.area_m2, 150, 1e-3);
  EXPECT_NEAR(volume.net_m3(), 450, 1e-3);
  EXPECT_TRUE(std::isfinite(volume.sigma_m3()));
}

// Errors that are alike over a length: white noise under a Gaussian of the width w is alike by exp(-d^2 / 4 w^2).
TEST_F(VolumeOf, SigmaCoversTheErrorsOfHeightsThatAreAlike) {
  constexpr int kBlocks = 60;
  constexpr double kWidthCells = 2, kSigma = 0.05, kShift = 0.03;
  const MapArea area = rectangle(10, 10, 40, 30);
  VolumeOptions options;
  options.correlation_m = std::sqrt(2.0) * kWidthCells * kCell;
  options.shift_sigma_m = kShift;
  double chi2 = 0;
  for (int block = 0; block < kBlocks; ++block) {
    Random random(5, std::uint64_t(block));
    FloatImage white(kWidth, kHeight), heights(kWidth, kHeight);
    for (float& value : white.data) value = float(random.normal());
    const int reach = 8;
    double weight[2 * reach + 1], squares = 0;
    for (int i = -reach; i <= reach; ++i) weight[i + reach] = std::exp(-0.5 * i * i / (kWidthCells * kWidthCells));
    for (const double w : weight) squares += w * w;
    FloatImage once(kWidth, kHeight);
    for (int pass = 0; pass < 2; ++pass)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          double sum = 0;
          for (int i = -reach; i <= reach; ++i)
            sum += weight[i + reach] *
                   double(pass == 0 ? white.at((x + i + kWidth) % kWidth, y) : once.at(x, (y + i + kHeight) % kHeight));
          (pass == 0 ? once : heights).at(x, y) = float(sum);
        }
    const double shift_m = kShift * random.normal();
    for (float& value : heights.data) value = float(105 + shift_m + kSigma * double(value) / squares);
    const auto files = written("noise", heights, FloatImage(kWidth, kHeight, 1, float(kSigma)), kCell);
    const Volume volume = volume_over_level(files, 100, area, options, run_).value();
    chi2 += std::pow((volume.net_m3() - 3000) / volume.sigma_m3(), 2);
  }
  EXPECT_NEAR(chi2 / kBlocks, 1, 4 * std::sqrt(2.0 / kBlocks));
}

TEST_F(VolumeOf, IndependentErrorsAddUpInSquares) {
  const auto level = surface(
      "level", [](double, double) { return 105.0; }, 0.04);
  VolumeOptions options;
  options.correlation_m = 0;
  const Volume volume = volume_over_level(level, 102, rectangle(10, 10, 30, 25), options, run_).value();
  EXPECT_NEAR(volume.sigma_heights_m3, 0.04 * kCell * kCell * std::sqrt(300 / (kCell * kCell)), 1e-5);
  options.correlation_m = 1e4;  // all alike
  EXPECT_GT(volume_over_level(level, 102, rectangle(10, 10, 12, 12), options, run_).value().sigma_heights_m3, 0.159);
}

// What the orientation adds lifts the area as a whole; what is measured from the surface itself does not see it.
TEST_F(VolumeOf, WhatHeightsHaveInCommonIsNoNoise) {
  const MapArea area = rectangle(10, 10, 30, 25);
  const SurfaceFiles level = with_common("dsm", 105);
  const auto plain = surface(
      "plain", [](double, double) { return 105.0; }, kRelative);
  const double by_heights = volume_over_level(plain, 102, area, {}, run_).value().sigma_heights_m3;
  VolumeOptions options;
  options.shift_sigma_m = 0.3;
  const Volume over_level = volume_over_level(level, 102, area, options, run_).value();
  EXPECT_NEAR(over_level.sigma_heights_m3, by_heights, 1e-4 * by_heights);
  EXPECT_NEAR(over_level.sigma_shift_m3, 0.5 * 300, 1e-3);
  EXPECT_EQ(volume_over_rim(level, area, options, run_).value().sigma_shift_m3, 0);
  // The same orientation, whatever the form of the area and also beside a hole; and another one.
  const Volume over_own = volume_over_surface(level, with_common("dtm", 101), area, options, run_).value();
  EXPECT_EQ(over_own.sigma_shift_m3, 0);
  EXPECT_NEAR(over_own.sigma_heights_m3, std::sqrt(2.0) * by_heights, 1e-4 * by_heights);
  const MapArea triangle = {area[0], area[1], area[2]};
  EXPECT_EQ(volume_over_surface(level, with_common("dtm", 101), triangle, {}, run_)->sigma_shift_m3, 0);
  const Volume beside_hole = volume_over_surface(level, with_common("dtm", 101, kCommon, true), area, {}, run_).value();
  EXPECT_GT(beside_hole.missing_m2, 50);
  EXPECT_EQ(beside_hole.sigma_shift_m3, 0);
  const Volume over_other = volume_over_surface(level, with_common("dtm", 101, 0.3), area, {}, run_).value();
  EXPECT_NEAR(over_other.sigma_shift_m3, 0.5 * 300, 1e-3);
}

TEST_F(VolumeOf, TwoSurveysOfOnePrecisionAreTwoAlsoInOneFolder) {
  const MapArea area = rectangle(10, 10, 30, 25);
  fs::create_directory(folder_ / "later");
  const auto shift_m3 = [&](const std::string& name, const std::string& base) {
    return volume_over_surface(with_common(name, 105), with_common(base, 101), area, {}, run_)->sigma_shift_m3;
  };
  for (const auto& [name, base] :
       {std::pair("dsm", "later/dtm"), {"dsm", "epoch2"}, {"dsm_may", "dtm_june"}, {"may", "june"}})
    EXPECT_NEAR(shift_m3(name, base), std::sqrt(2.0) * kCommon * 300, 1e-3) << base;
  for (const auto& [name, base] : {std::pair("dsm", "dtm"), {"dsm_may", "dtm_may"}, {"may_DTM", "may_DSM"}})
    EXPECT_EQ(shift_m3(name, base), 0) << base;
}

TEST_F(VolumeOf, AFolderIsTheSameHoweverItIsNamed) {
  const MapArea area = rectangle(10, 10, 30, 25);
  const SurfaceFiles level = with_common("dsm", 105);
  SurfaceFiles below = with_common("dtm", 101);
  fs::create_directory(folder_ / "other");
  fs::create_directory_symlink(folder_ / "", folder_ / "link");
  for (const char* folder : {"./", "other/../", "link/"}) {
    below.height = folder_ / (folder + std::string("dtm.tif"));
    EXPECT_EQ(volume_over_surface(level, below, area, {}, run_).value().sigma_shift_m3, 0) << below.height;
  }
}

// Terrain far from any ground that was seen is known to metres: of the squares of two floats like that nothing is left
// that tells a common part of millimetres.
TEST_F(VolumeOf, ACommonPartThatRoundingDrownsIsThatOfTheOthers) {
  constexpr double kSmall = 0.005;
  const MapArea area = rectangle(10, 10, 26, 26);
  const auto known_to = [&](const std::string& name, double height_m, double west_m, double east_m) {
    FloatImage heights(kWidth, kHeight, 1, float(height_m)), sigmas = heights, all = heights;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double relative_m = x * kCell < 18 ? west_m : east_m * (1 + 0.001 * x);
        sigmas.at(x, y) = float(relative_m);
        all.at(x, y) = std::sqrt(float(relative_m) * float(relative_m) + float(kSmall * kSmall));
      }
    return with_relative(name, heights, all, sigmas);
  };
  fs::create_directory(folder_ / "later");
  const SurfaceFiles level = known_to("dsm", 105, 0.02, 0.02);
  for (const auto& [west_m, east_m] : {std::pair(0.02, 10.3), {10.3, 10.3}}) {
    const Volume own = volume_over_surface(level, known_to("dtm", 101, west_m, east_m), area, {}, run_).value();
    EXPECT_EQ(own.sigma_shift_m3, 0) << west_m;
  }
  const Volume later = volume_over_surface(level, known_to("later/dtm", 101, 0.02, 10.3), area, {}, run_).value();
  EXPECT_NEAR(later.sigma_shift_m3, std::sqrt(2.0) * kSmall * 256, 1e-3 * 256 * kSmall);
}

TEST_F(VolumeOf, MistakesAreNamed) {
  const auto level = surface("level", [](double, double) { return 105.0; });
  const auto message = [](const auto& result) { return result ? std::string() : result.error().message; };
  EXPECT_NE(message(volume_over_level(level, 0, rectangle(500, 500, 600, 600), {}, run_)).find("beside"),
            std::string::npos);
  EXPECT_NE(message(volume_over_level({folder_ / "nowhere.tif", {}}, 0, std::nullopt, {}, run_)).find("nowhere"),
            std::string::npos);
  const auto empty = surface("empty", [](double, double) { return std::nan(""); });
  EXPECT_NE(message(volume_over_rim(empty, rectangle(10, 10, 20, 20), {}, run_)).find("border"), std::string::npos);
  VolumeOptions options;
  options.sigma_m = -1;
  EXPECT_FALSE(volume_over_level(level, 0, std::nullopt, options, run_));
  SurfaceFiles files = level;
  files.sigma_relative = folder_ / "gone.tif";
  EXPECT_NE(message(volume_over_level(files, 0, std::nullopt, {}, run_)).find("gone"), std::string::npos);
  files.sigma_relative = surface(
                             "coarse", [](double, double) { return 105.0; }, 0.02, 0.5)
                             .sigma;
  EXPECT_NE(message(volume_over_level(files, 0, std::nullopt, {}, run_)).find("coarse_sigma.tif does not lie over"),
            std::string::npos);
  files.sigma.reset();
  EXPECT_NE(message(volume_over_surface(level, files, std::nullopt, {}, run_)).find("without the whole"),
            std::string::npos);
}

}  // namespace
}  // namespace collinea
