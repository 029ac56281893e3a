// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/dtm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kCell = 0.1;
constexpr int kWidth = 700, kHeight = 600;
constexpr float kSigma = 0.02f;

double terrain_m(int x, int y) { return 250 + 2 * std::sin(0.008 * x) + 0.004 * y; }

// 12 m x 10 m and 5 m high.
bool is_house(int x, int y) { return x >= 200 && x < 320 && y >= 300 && y < 400; }
bool is_hole(int x, int y) { return x >= 500 && x < 540 && y >= 100 && y < 140; }

// A surface model on disk: rolling ground with noise, a house, a hole that was filled, and an empty corner.
class DtmOfAHouse : public testing::Test {
 protected:
  void SetUp() override {
    MapGrid grid;
    grid.west_m = 1000, grid.north_m = 2000, grid.cell_m = kCell;
    grid.width = kWidth, grid.height = kHeight;
    FloatImage height(kWidth, kHeight, 1, kNoHeight), sigma = height;
    Raster<std::uint8_t> state(kWidth, kHeight);
    Random random(8);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (x < 50 && y < 50) continue;
        height.at(x, y) = float(terrain_m(x, y) + (is_house(x, y) ? 5 : 0) + kSigma * random.normal());
        sigma.at(x, y) = kSigma;
        state.at(x, y) = std::uint8_t(is_hole(x, y) ? CellState::kInterpolated : CellState::kMeasured);
      }
    dsm_ = {folder_ / "dsm.tif",
            folder_ / "dsm_sigma.tif",
            folder_ / "dsm_state.tif",
            {},
            folder_ / "dsm_sigma_relative.tif"};
    write<float>(dsm_.height, grid, height);
    write<float>(dsm_.sigma_relative, grid, sigma);
    write<float>(dsm_.sigma, grid, sigma);
    write<std::uint8_t>(dsm_.state, grid, state);
  }
  template <class T>
  static void write(const std::filesystem::path& path, const MapGrid& grid, const Raster<T>& raster) {
    auto writer = GeoTiffWriter<T>::create(path, grid, 1, {});
    ASSERT_TRUE(writer && writer->write(0, 0, raster) && writer->finish());
  }
  [[nodiscard]] DtmFiles files(const std::string& name) const {
    return {folder_ / (name + ".tif"), folder_ / (name + "_sigma.tif"), folder_ / (name + "_state.tif"),
            folder_ / (name + ".gpkg"), folder_ / (name + "_sigma_relative.tif")};
  }
  static FloatImage heights_of(const std::filesystem::path& path) {
    return *GeoTiffReader::open(path)->read_float(0, 0, kWidth, kHeight);
  }
  static Raster<std::uint8_t> bytes_of(const std::filesystem::path& path) {
    return *GeoTiffReader::open(path)->read_byte(0, 0, kWidth, kHeight);
  }

  TestFolder folder_;
  DsmFiles dsm_;
};

// The ground under the house is met to what a bend of 2 m * 0.08^2 per m^2 makes over half of 10 m, 0.16 m.
TEST_F(DtmOfAHouse, TheGroundStaysAndGoesOnUnderTheHouse) {
  const DtmFiles dtm = files("dtm");
  const auto made = build_dtm(dsm_, dtm, {}, {});
  ASSERT_TRUE(made) << made.error().message;
  const DtmSummary* const summary = &made->summary;
  const FloatImage height = heights_of(dtm.height), sigma = heights_of(dtm.sigma), surface = heights_of(dsm_.height);
  const auto state = bytes_of(dtm.state);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto is = CellState(state.at(x, y));
      if (x < 50 && y < 50) {
        EXPECT_EQ(is, CellState::kEmpty);
        EXPECT_EQ(height.at(x, y), kNoHeight);
      } else if (is_house(x, y) || is_hole(x, y)) {
        EXPECT_EQ(is, CellState::kInterpolated);
        EXPECT_NEAR(height.at(x, y), terrain_m(x, y), 0.17);
        EXPECT_GT(sigma.at(x, y), 0);
      } else {
        EXPECT_EQ(is, CellState::kMeasured);
        EXPECT_EQ(height.at(x, y), surface.at(x, y));
        EXPECT_EQ(sigma.at(x, y), kSigma);
      }
    }
  EXPECT_EQ(summary->interpolated_cells, 120u * 100 + 40 * 40);
  EXPECT_EQ(summary->empty_cells, 2500u);
  EXPECT_NEAR(summary->mean_sigma_m, kSigma, 1e-6);
  EXPECT_EQ(summary->contour_m, 0.5);  // 6 m of relief / 20, the next of 1, 2, 5
  EXPECT_GT(summary->contours, 10u);
  EXPECT_TRUE(is_there(folder_ / "dtm.dxf"));
  const auto shows_ground = [&](int x, int y, double above_m) {
    return made->ground.shows_ground({1000 + (x + 0.5) * kCell, 2000 - (y + 0.5) * kCell, terrain_m(x, y) + above_m},
                                     kSigma);
  };
  EXPECT_TRUE(shows_ground(600, 300, 0.05));
  EXPECT_FALSE(shows_ground(600, 300, 1));
  EXPECT_TRUE(shows_ground(250, 350, 0.1));  // under the house
  EXPECT_FALSE(shows_ground(250, 350, 5));
  EXPECT_FALSE(made->ground.shows_ground({900, 2000, 250}, kSigma));  // off the map
}

// People know better: the house is a mound of the ground, and a square of lawn is a hedge. Between mound and lawn the
// coarse ground is a slope on which neither lies.
TEST_F(DtmOfAHouse, WhatPeopleSayOfTheGroundHolds) {
  const auto is_hedge = [](double x, double y) { return x >= 400 && x < 460 && y >= 350 && y < 390; };
  const auto is_beside_house = [](int x, int y) {
    return x >= 185 && x < 335 && y >= 285 && y < 415 && !is_house(x, y);
  };
  const DtmFiles dtm = files("dtm");
  const auto made = build_dtm(dsm_, dtm, {}, {}, [&](const Eigen::Vector3d& on_map) -> std::optional<bool> {
    const double x = (on_map.x() - 1000) / kCell, y = (2000 - on_map.y()) / kCell;
    EXPECT_NEAR(on_map.z(), 250, 12);
    EXPECT_NEAR(x - std::floor(x), 0.5, 1e-6);  // the middles of cells are asked for
    EXPECT_NEAR(y - std::floor(y), 0.5, 1e-6);
    if (is_house(int(x), int(y))) return true;
    if (is_hedge(x, y)) return false;
    return std::nullopt;
  });
  ASSERT_TRUE(made) << made.error().message;
  const FloatImage height = heights_of(dtm.height), surface = heights_of(dsm_.height);
  const auto state = bytes_of(dtm.state);
  for (int y = 50; y < kHeight; ++y)
    for (int x = 50; x < kWidth; ++x) {
      if (is_beside_house(x, y)) continue;
      const bool measured = !is_hedge(x, y) && !is_hole(x, y);
      EXPECT_EQ(CellState(state.at(x, y)), measured ? CellState::kMeasured : CellState::kInterpolated);
      if (measured) {
        EXPECT_EQ(height.at(x, y), surface.at(x, y));
      } else if (is_hedge(x, y)) {
        EXPECT_NEAR(height.at(x, y), terrain_m(x, y), 0.17);
      }
    }
}

// What lifts a survey as a whole, as receivers do by metres, says nothing of a house against the ground beside it.
TEST_F(DtmOfAHouse, AnErrorOfTheWholeSurveyMakesNoGround) {
  constexpr float kCommon = 2;
  FloatImage sigma = heights_of(dsm_.sigma);
  for (float& one : sigma.data)
    if (one != kNoHeight) one = std::hypot(one, kCommon);
  write<float>(dsm_.sigma, GeoTiffReader::open(dsm_.height)->grid(), sigma);
  const DtmFiles dtm = files("dtm");
  const auto made = build_dtm(dsm_, dtm, {}, {});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->summary.interpolated_cells, 120u * 100 + 40 * 40);
  EXPECT_EQ(made->summary.contour_m, 0.5);
  EXPECT_NEAR(made->summary.mean_sigma_relative_m, kSigma, 1e-6);
  EXPECT_NEAR(made->summary.mean_sigma_m, std::hypot(kSigma, kCommon), 1e-6);
  sigma = heights_of(dtm.sigma);
  const FloatImage relative = heights_of(dtm.sigma_relative);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (x < 50 && y < 50) {
        EXPECT_EQ(sigma.at(x, y), kNoHeight);
        EXPECT_EQ(relative.at(x, y), kNoHeight);
      } else {
        EXPECT_NEAR(sigma.at(x, y), std::hypot(relative.at(x, y), kCommon), 1e-6);
        EXPECT_TRUE(is_house(x, y) || is_hole(x, y) ? relative.at(x, y) > 0 : relative.at(x, y) == kSigma);
      }
    }
}

// Contours keep three sigmas of a usual cell apart, whatever those of a hundredth are.
TEST_F(DtmOfAHouse, AFewBadlyKnownCellsDoNotSpreadTheContours) {
  const auto interval_m = [&](float sigma_m, int from_row, int from_column) {
    FloatImage sigma = heights_of(dsm_.sigma_relative);
    for (int y = from_row; y < kHeight; ++y)
      for (int x = from_column; x < kWidth; ++x) sigma.at(x, y) = sigma_m;
    write<float>(dsm_.sigma_relative, GeoTiffReader::open(dsm_.height)->grid(), sigma);
    return build_dtm(dsm_, files("dtm"), {}, {}).value().summary.contour_m;
  };
  EXPECT_EQ(interval_m(5, 500, 660), 0.5);
  EXPECT_EQ(interval_m(0.5f, 60, 0), 2);
}

TEST_F(DtmOfAHouse, ThreadsDoNotMatter) {
  collinea::Run three;
  three.threads = 3;
  ASSERT_TRUE(build_dtm(dsm_, files("one"), {}, {}));
  ASSERT_TRUE(build_dtm(dsm_, files("three"), {}, three));
  for (const char* ending : {".tif", "_sigma.tif", "_sigma_relative.tif", "_state.tif", ".gpkg", ".dxf"})
    EXPECT_EQ(*read_file(folder_ / (std::string("one") + ending)),
              *read_file(folder_ / (std::string("three") + ending)))
        << ending;
}

TEST_F(DtmOfAHouse, WithoutContoursEarlierOnesGo) {
  DtmOptions options;
  ASSERT_TRUE(build_dtm(dsm_, files("dtm"), options, {}));
  EXPECT_TRUE(is_there(folder_ / "dtm.gpkg"));
  options.contour_m = 0;
  const auto made = build_dtm(dsm_, files("dtm"), options, {});
  ASSERT_TRUE(made);
  EXPECT_EQ(made->summary.contours, 0u);
  EXPECT_FALSE(is_there(folder_ / "dtm.gpkg"));
  EXPECT_FALSE(is_there(folder_ / "dtm.dxf"));
}

// Whenever it is stopped, nothing half made stays, and an earlier model is not touched.
TEST_F(DtmOfAHouse, StoppedItLeavesNothingBehind) {
  ASSERT_TRUE(build_dtm(dsm_, files("earlier"), {}, {}));
  const std::string before = *read_file(folder_ / "earlier.tif");
  const auto count = [&] {
    return std::distance(std::filesystem::directory_iterator(folder_ / ""), std::filesystem::directory_iterator());
  };
  const auto files_before = count();
  for (const double when : {0.0, 0.2, 0.5, 0.7, 0.95}) {
    std::stop_source stop;
    collinea::Run run;
    run.stop = stop.get_token();
    run.progress = [&](std::string_view, double done) {
      if (done >= when) stop.request_stop();
    };
    for (const char* name : {"new", "earlier"}) {
      const auto made = build_dtm(dsm_, files(name), {}, run);
      ASSERT_FALSE(made) << when;
      EXPECT_EQ(made.error().code, Errc::kCancelled) << when;
    }
    EXPECT_EQ(count(), files_before) << when;
    EXPECT_EQ(*read_file(folder_ / "earlier.tif"), before) << when;
  }
}

TEST_F(DtmOfAHouse, AMissingSurfaceIsAnErrorInWords) {
  dsm_.state = folder_ / "nowhere.tif";
  const auto summary = build_dtm(dsm_, files("dtm"), {}, {});
  ASSERT_FALSE(summary);
  EXPECT_NE(summary.error().message.find("nowhere.tif"), std::string::npos);
}

}  // namespace
}  // namespace collinea
