// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/heights.h"

#include <gtest/gtest.h>

#include <unistd.h>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "collinea/geodesy/local_frame.h"
#include "collinea/geodesy/test_geoid.h"

namespace collinea {
namespace {

class GeoidFile : public ::testing::Test {
 protected:
  GeoidFile() : folder_(std::filesystem::temp_directory_path() / ("collinea_geoid_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write_test_geoid(folder_ / "test geoid.gtx");
  }
  ~GeoidFile() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  [[nodiscard]] std::string geoid() const { return (folder_ / "test geoid.gtx").string(); }

  std::filesystem::path folder_;
};

// The heights of the map are those over the ellipsoid less the height of the geoid there, which a bilinear grid holds
// but for the rounding of its floats.
TEST_F(GeoidFile, ItsHeightsAreTakenOffThoseOverTheEllipsoid) {
  const std::string crs = with_heights("EPSG:32633", geoid()).value();
  const auto frame = LocalFrame::create(crs, 48.2, 15.6, 300);
  ASSERT_TRUE(frame) << frame.error().message;
  const LocalFrame plain = LocalFrame::create("EPSG:32633", 48.2, 15.6, 300).value();
  for (const auto& [latitude, longitude] : {std::pair(48.2, 15.6), {48.25, 15.51}, {48.03, 15.72}}) {
    const Eigen::Vector3d geographic(latitude, longitude, 412.5), local = frame->local_from_geographic(geographic);
    const Eigen::Vector3d map = frame->map_from_local(local);
    EXPECT_NEAR(map.z(), 412.5 - test_geoid_m(latitude, longitude), 1e-4);
    EXPECT_LT((map - plain.map_from_local(local)).head<2>().norm(), 1e-6);
    EXPECT_LT((frame->local_from_map(map) - local).norm(), 1e-6);
  }
  EXPECT_NE(frame->crs_name().find("test geoid.gtx"), std::string::npos) << frame->crs_name();
  EXPECT_TRUE(states_heights(crs).value());
  EXPECT_FALSE(frame->wkt1().empty());
}

TEST_F(GeoidFile, ItsUndulationIsThatOfTheGrid) {
  for (const auto& [latitude, longitude] : {std::pair(48.2, 15.6), {47.3, 14.2}}) {
    const auto undulation = undulation_m(geoid(), latitude, longitude);
    ASSERT_TRUE(undulation) << undulation.error().message;
    EXPECT_NEAR(*undulation, test_geoid_m(latitude, longitude), 1e-4);
  }
  EXPECT_EQ(undulation_m(HeightSurface::kEllipsoid, 48, 15).value(), 0);
  EXPECT_FALSE(undulation_m(geoid(), 52, 15));
}

TEST_F(GeoidFile, HeightsOfACompoundCrsAreReplaced) {
  EXPECT_EQ(with_heights("EPSG:32633+5773", "ellipsoidal").value(), "EPSG:32633");
  EXPECT_EQ(with_heights("EPSG:32633", "ellipsoidal").value(), "EPSG:32633");
  EXPECT_EQ(with_heights("EPSG:32633", "EPSG:5773").value(), "EPSG:32633+EPSG:5773");
  EXPECT_EQ(with_heights("EPSG:32633+5773", geoid()).value(), "EPSG:32633+geoid:" + geoid());
  EXPECT_EQ(with_heights("EPSG:32633+geoid:" + geoid(), "ellipsoidal").value(), "EPSG:32633");
  EXPECT_TRUE(states_heights("EPSG:32633+5773").value());
  EXPECT_FALSE(states_heights("EPSG:32633").value());
}

// A CRS without a code is written out.
TEST_F(GeoidFile, ACrsInManyWordsMayHaveThemToo) {
  const std::string utm = "+proj=utm +zone=33 +datum=WGS84 +units=m";
  const auto frame = LocalFrame::create(with_heights(utm, geoid()).value(), 48.2, 15.6, 300);
  ASSERT_TRUE(frame) << frame.error().message;
  const Eigen::Vector3d local = frame->local_from_geographic({48.2, 15.6, 400});
  EXPECT_NEAR(frame->map_from_local(local).z(), 400 - test_geoid_m(48.2, 15.6), 1e-4);
  EXPECT_TRUE(states_heights(with_heights(utm, "EPSG:5773").value()).value());
}

TEST_F(GeoidFile, WhatIsNoSystemOfHeightsIsRefusedInWords) {
  const auto message = [](const auto& result) { return result ? std::string() : result.error().message; };
  EXPECT_NE(message(with_heights("EPSG:32633", "nowhere.gtx")).find("no such file"), std::string::npos);
  EXPECT_NE(message(with_heights("EPSG:32633", "EPSG:4326")).find("no vertical"), std::string::npos);
  EXPECT_NE(message(with_heights("EPSG:32633", "EPSG:999999")).find("no vertical"), std::string::npos);
  EXPECT_FALSE(with_heights("EPSG:4326", "ellipsoidal"));
  std::ofstream(folder_ / "broken.gtx") << "not a grid";
  const auto frame =
      LocalFrame::create(with_heights("EPSG:32633", (folder_ / "broken.gtx").string()).value(), 48.2, 15.6, 0);
  EXPECT_NE(message(frame).find("broken.gtx"), std::string::npos) << message(frame);
  // A position that the grid does not reach.
  const auto far = LocalFrame::create(with_heights("EPSG:32633", geoid()).value(), 52, 15, 0);
  ASSERT_FALSE(far);
  EXPECT_NE(message(far).find("geoid grid"), std::string::npos) << message(far);
}

// Nobody has all grids: the error says which, where it comes from and where it belongs.
TEST(MissingGeoid, IsNamedWithWhatToDo) {
  const auto british = LocalFrame::create("EPSG:27700+5701", 51.5, 0, 0);
  if (british) GTEST_SKIP() << "the British grids are installed here";
  const std::string& message = british.error().message;
  EXPECT_NE(message.find("which is not installed for PROJ"), std::string::npos) << message;
  EXPECT_NE(message.find("ut it into /"), std::string::npos) << message;
  EXPECT_EQ(british.error().options, std::vector{"heights"_option});
}

}  // namespace
}  // namespace collinea
