// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/local_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <thread>

#include "collinea/math/random.h"

namespace collinea {
namespace {

LocalFrame frame(const std::string& crs = "EPSG:32633", double latitude_deg = 52.5, double longitude_deg = 13.4) {
  return LocalFrame::create(crs, latitude_deg, longitude_deg, 80).value();
}

TEST(LocalFrame, MapAndLocalRoundTripToAMicrometre) {
  const LocalFrame local_frame = frame();
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d local(random.uniform(-5000, 5000), random.uniform(-5000, 5000), random.uniform(-100, 500));
    EXPECT_LT((local_frame.local_from_map(local_frame.map_from_local(local)) - local).norm(), 1e-6);
    EXPECT_LT((local_frame.local_from_geographic(local_frame.geographic_from_local(local)) - local).norm(), 1e-7);
  }
}

// On the central meridian UTM easting is 500 km exactly and northing is 0.9996 of the meridian arc, which is
// 4,984,944.378 m at 45 degrees on WGS84 (series of Helmert, any textbook).
TEST(LocalFrame, TheCentralMeridianHasItsTextbookValues) {
  const LocalFrame local_frame = frame("EPSG:32633", 45, 15);
  const Eigen::Vector3d map = local_frame.map_from_local(local_frame.local_from_geographic({45, 15, 100}));
  EXPECT_NEAR(map.x(), 500000, 1e-6);
  EXPECT_NEAR(map.y(), 0.9996 * 4984944.378, 1e-3);
  EXPECT_NEAR(map.z(), 100, 1e-6);
}

TEST(LocalFrame, TheMapIsSmallerThanTheGroundByTheScaleFactor) {
  const LocalFrame local_frame = LocalFrame::create("EPSG:32633", 45, 15, 0).value();
  const Eigen::Vector3d west = local_frame.map_from_local(Eigen::Vector3d(-50, 0, 0));
  const Eigen::Vector3d east = local_frame.map_from_local(Eigen::Vector3d(50, 0, 0));
  EXPECT_NEAR((east - west).head<2>().norm(), 99.96, 1e-6);
}

// A tangent plane leaves the ellipsoid by d^2 / 2R, where R is between the two principal radii.
TEST(LocalFrame, TheGroundFallsAwayWithTheSquareOfTheDistance) {
  const LocalFrame local_frame = LocalFrame::create("EPSG:32633", 45, 15, 0).value();
  for (const double distance_m : {1000.0, 3000.0}) {
    const double height_m = local_frame.map_from_local(Eigen::Vector3d(distance_m, 0, 0)).z();
    EXPECT_NEAR(height_m, distance_m * distance_m / (2 * 6388838.29), 1e-5);
  }
}

TEST(LocalFrame, EastNorthAndUpAreWhereTheyShouldBe) {
  const LocalFrame local_frame = frame();
  const Eigen::Vector3d origin = local_frame.geographic_from_local(Eigen::Vector3d::Zero());
  EXPECT_GT(local_frame.geographic_from_local({100, 0, 0})[1], origin[1]);
  EXPECT_GT(local_frame.geographic_from_local({0, 100, 0})[0], origin[0]);
  EXPECT_NEAR(local_frame.geographic_from_local({0, 0, 100})[2], 180, 1e-7);
  EXPECT_NEAR(origin[0], 52.5, 1e-12);
  EXPECT_NEAR(origin[1], 13.4, 1e-12);
}

TEST(LocalFrame, AnAuthorityThatPutsNorthFirstDoesNotMatter) {
  const LocalFrame gauss_krueger = frame("EPSG:31468", 48.1, 11.6);  // axes north, east
  const Eigen::Vector3d map = gauss_krueger.map_from_local(Eigen::Vector3d::Zero().eval());
  EXPECT_NEAR(map.x(), 4.47e6, 3e4);
  EXPECT_NEAR(map.y(), 5.33e6, 3e4);
}

TEST(LocalFrame, ManyPointsAreTheSameBitsAsOneByOne) {
  const LocalFrame local_frame = frame();
  std::vector<Eigen::Vector3d> points;
  Random random(2);
  for (int i = 0; i < 10'000; ++i) points.emplace_back(random.uniform(-500, 500), random.uniform(-500, 500), i * 0.01);
  std::vector<Eigen::Vector3d> together = points;
  local_frame.map_from_local(together);
  for (std::size_t i = 0; i < points.size(); i += 97) EXPECT_EQ(together[i], local_frame.map_from_local(points[i]));
  local_frame.local_from_map(together);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((together[i] - points[i]).norm(), 1e-6);
}

TEST(LocalFrame, ServesSeveralThreadsAtOnce) {
  const LocalFrame local_frame = frame();
  const Eigen::Vector3d expected = local_frame.map_from_local(Eigen::Vector3d(10, 20, 30));
  std::array<int, 4> wrong{};
  {
    std::vector<std::jthread> threads;
    for (int& count : wrong)
      threads.emplace_back([&count, &local_frame, &expected] {
        for (int i = 0; i < 2000; ++i) count += local_frame.map_from_local(Eigen::Vector3d(10, 20, 30)) != expected;
      });
  }
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

TEST(LocalFrame, UnusableReferenceSystemsAreRefusedInWords) {
  EXPECT_NE(check_crs("EPSG:4326").error().message.find("degrees"), std::string::npos);
  EXPECT_NE(check_crs("EPSG:2263").error().message.find("foot"), std::string::npos);
  EXPECT_NE(check_crs("EPSG:999999").error().message.find("not a coordinate reference system"), std::string::npos);
  EXPECT_NE(check_crs("hello").error().message.find("hello"), std::string::npos);
  EXPECT_NE(check_crs("EPSG:4978").error().message.find("not a projected"), std::string::npos);
  EXPECT_NE(check_crs("EPSG:2053").error().message.find("point"), std::string::npos);  // axes west and south
  EXPECT_FALSE(check_crs(""));
  EXPECT_EQ(check_crs("EPSG:32633").value(), "WGS 84 / UTM zone 33N");
}

TEST(LocalFrame, MapsWhoseMetresAreNoneAreRefusedAndABetterOneIsNamed) {
  for (const char* crs : {"EPSG:3857", "EPSG:3395", "EPSG:3857+5773"}) {
    const auto frame = LocalFrame::create(crs, 48, 15, 300);
    if (!frame && frame.error().message.find("grid") != std::string::npos) continue;  // no geoid here
    ASSERT_FALSE(frame) << crs;
    EXPECT_EQ(frame.error().code, Errc::kUnsupported);
    EXPECT_NE(frame.error().message.find("EPSG:32633"), std::string::npos) << frame.error().message;
    EXPECT_NE(frame.error().message.find("1.49"), std::string::npos) << frame.error().message;
  }
  EXPECT_FALSE(LocalFrame::create("EPSG:3857", 0.1, 15, 300));  // nearly true to scale, but for nobody's use
  EXPECT_TRUE(LocalFrame::create("EPSG:3035", 35, 33, 300));    // Europe's, at its far end
  // Surveyed points in it are positions all the same.
  EXPECT_TRUE(geographic_from_map("EPSG:3857", {1669792.36, 6106854.83, 300}));
}

TEST(LocalFrame, AnOriginThatIsNoPositionIsRefused) {
  EXPECT_FALSE(LocalFrame::create("EPSG:32633", 95, 15, 0));
  EXPECT_FALSE(LocalFrame::create("EPSG:32633", 45, std::nan(""), 0));
}

// The height of EGM96 over the ellipsoid at 45 N 15 E is about 46 m.
TEST(LocalFrame, HeightsAboveTheGeoidAreConverted) {
  const Result<LocalFrame> geoid = LocalFrame::create("EPSG:32633+5773", 45, 15, 0);
  if (!geoid) {
    EXPECT_NE(geoid.error().message.find("egm96"), std::string::npos) << geoid.error().message;
    GTEST_SKIP() << "no EGM96 grid here; the error named it";
  }
  const Eigen::Vector3d map = geoid->map_from_local(Eigen::Vector3d::Zero().eval());
  EXPECT_GT(-map.z(), 43);
  EXPECT_LT(-map.z(), 49);
  EXPECT_LT(geoid->local_from_map(map).norm(), 1e-6);
}

TEST(LocalFrame, AMissingGeoidIsNamed) {
  const Result<LocalFrame> british = LocalFrame::create("EPSG:27700+5701", 51.5, 0, 0);
  if (british) GTEST_SKIP() << "the British grids are installed here";
  EXPECT_NE(british.error().message.find("grid"), std::string::npos) << british.error().message;
}

TEST(LocalFrame, DescriptionsAreWellKnownText) {
  const LocalFrame local_frame = frame();
  EXPECT_EQ(local_frame.wkt1().rfind("PROJCS[\"WGS 84 / UTM zone 33N\"", 0), 0u);
  EXPECT_EQ(local_frame.wkt2().rfind("PROJCRS[\"WGS 84 / UTM zone 33N\"", 0), 0u);
  EXPECT_EQ(local_frame.crs_name(), "WGS 84 / UTM zone 33N");
  EXPECT_EQ(local_frame.crs(), "EPSG:32633");
  EXPECT_TRUE(local_frame.missing_grid().empty());
}

TEST(Utm, ZonesAndTheirExceptions) {
  EXPECT_EQ(utm_crs(52.5, 13.4), "EPSG:32633");
  EXPECT_EQ(utm_crs(-33.9, 18.4), "EPSG:32734");
  EXPECT_EQ(utm_crs(60.4, 5.3), "EPSG:32632");   // Bergen
  EXPECT_EQ(utm_crs(78.2, 15.6), "EPSG:32633");  // Longyearbyen
  EXPECT_EQ(utm_crs(0, -180), "EPSG:32601");
  EXPECT_EQ(utm_crs(0, 180), "EPSG:32601");
  EXPECT_EQ(utm_crs(0, 179.9), "EPSG:32660");
}

TEST(GeographicFromMap, InvertsTheLocalFrame) {
  const LocalFrame local_frame = frame();
  const Eigen::Vector3d map = local_frame.map_from_local(Eigen::Vector3d(1, 2, 3));
  const Eigen::Vector3d geographic = geographic_from_map("EPSG:32633", map).value();
  EXPECT_LT((local_frame.local_from_geographic(geographic) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
  EXPECT_FALSE(geographic_from_map("EPSG:4326", map));
}

// Bolognesi T4: eleven marks of a network in UTM of ED50 (zone 32), to a millimetre in plan and 0.1 mm in height. A
// number of single precision has steps of half a metre at such a northing; the local frame loses nothing. (There and
// back all marks move alike, by 0.8 mm: the change of datum is one of latitude and longitude, without the 45 m between
// both ellipsoids.)
TEST(LocalFrame, NetworkOfBolognesiT4KeepsItsDigits) {
  const double marks[11][3] = {
      {4958051.929, 723086.306, 3.7293}, {4958102.953, 723173.734, 3.7927}, {4958305.682, 723176.585, 2.2066},
      {4958343.333, 723153.588, 2.3287}, {4958316.980, 723035.859, 2.4483}, {4958255.515, 723022.282, 2.8022},
      {4958216.423, 723046.694, 2.6171}, {4958255.343, 723099.278, 2.3288}, {4958293.478, 723076.170, 2.3856},
      {4958284.795, 723040.695, 2.9456}, {4958340.444, 723189.045, 2.5069}};
  const LocalFrame local_frame = LocalFrame::create("EPSG:23032", 44.745, 11.818, 0).value();
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low, sum = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> moved;
  for (const auto& mark : marks) {
    const Eigen::Vector3d map(mark[1], mark[0], mark[2]), local = local_frame.local_from_map(map);
    EXPECT_LT(local.norm(), 1000);
    const Eigen::Vector3d by = local_frame.map_from_local(local) - map;
    if (!moved) moved = by;
    EXPECT_LT((by - *moved).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT(by.cwiseAbs().maxCoeff(), 1e-3);
    low = low.cwiseMin(map), high = high.cwiseMax(map), sum += map;
  }
  EXPECT_LT((high - low - Eigen::Vector3d(166.8, 291.4, 1.586)).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((sum / 11 - Eigen::Vector3d(723100.0215, 4958251.5341, 2.7356)).cwiseAbs().maxCoeff(), 5.1e-5);
  EXPECT_EQ(std::nextafter(4958051.929f, 1e9f) - 4958051.929f, 0.5f);
}

}  // namespace
}  // namespace collinea
