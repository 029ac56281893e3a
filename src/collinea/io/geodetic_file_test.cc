// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/geodetic_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/io/internal/test_damage.h"

namespace collinea {
namespace {

TEST(GeodeticFile, DistancesAreReadByTheNamesOfTheirColumns) {
  const auto rows = parse_geodetic(
      "# scale bars\n"
      "to, from, sigma_m, distance_m, name, role\n"
      "B, A, 0.001, 12.5, bar 1,\n"
      "C, A, 0.002, 7, , check\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0].from, "A");
  EXPECT_EQ((*rows)[0].to, "B");
  EXPECT_EQ((*rows)[0].value, 12.5);
  EXPECT_EQ((*rows)[0].sigma, 0.001);
  EXPECT_EQ((*rows)[0].name, "bar 1");
  EXPECT_EQ((*rows)[0].role, ControlRole::kControl);
  EXPECT_EQ((*rows)[1].role, ControlRole::kCheck);
  EXPECT_EQ((*rows)[1].line, 4);
}

TEST(GeodeticFile, ATotalStationMeasuresThreeThingsARow) {
  const auto rows = parse_geodetic(
      "from,to,setup,direction_gon,sigma_direction_mgon,zenith_deg,sigma_zenith_arcsec,distance_m,sigma_m,"
      "instrument_height_m,target_height_m\n"
      "S,A,1,100,1,90,3600,20,0.002,1.5,1.2\n"
      "S,B,1,200,1,,,,,1.5,\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 4u);
  EXPECT_EQ((*rows)[0].kind, GeodeticKind::kDistance);
  EXPECT_EQ((*rows)[1].kind, GeodeticKind::kDirection);
  EXPECT_NEAR((*rows)[1].value, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR((*rows)[1].sigma, std::numbers::pi / 200000, 1e-15);
  EXPECT_EQ((*rows)[2].kind, GeodeticKind::kZenithAngle);
  EXPECT_NEAR((*rows)[2].sigma, std::numbers::pi / 180, 1e-15);
  EXPECT_EQ((*rows)[2].target_height_m, 1.2);
  EXPECT_EQ((*rows)[3].kind, GeodeticKind::kDirection);
  EXPECT_EQ((*rows)[3].setup, "1");
}

TEST(GeodeticFile, AnAzimuthNeedsNoSetUp) {
  const auto rows = parse_geodetic("from,to,azimuth_gon,sigma_azimuth_mgon\nA,B,100,5\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 1u);
  EXPECT_EQ((*rows)[0].kind, GeodeticKind::kAzimuth);
  EXPECT_NEAR((*rows)[0].value, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR((*rows)[0].sigma, std::numbers::pi / 40000, 1e-15);
  EXPECT_EQ(parse_geodetic("from,to,azimuth_deg,sigma_azimuth_arcsec\nA,B,361,5\n").error().message,
            "line 2: the azimuth A - B is beyond a full circle of 360 degrees, 400 gon");
  EXPECT_EQ(parse_geodetic("from,to,azimuth_deg\nA,B,36\n").error().message,
            "line 1: column azimuth_deg needs a column sigma_azimuth_arcsec");
}

TEST(GeodeticFile, AVectorHasItsCovariance) {
  const std::string title = "from,to,dx_m,dy_m,dz_m,xx_m2,xy_m2,xz_m2,yy_m2,yz_m2,zz_m2\n";
  const auto rows = parse_geodetic(title + "A,B,1,2,3,4e-6,1e-6,0,5e-6,-1e-6,9e-6\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 1u);
  const GeodeticFileRow& row = (*rows)[0];
  EXPECT_EQ(row.kind, GeodeticKind::kGnssVector);
  EXPECT_TRUE(row.is_geocentric);
  EXPECT_FALSE(row.vector.is_local);
  EXPECT_EQ(row.vector.vector, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(row.vector.covariance_m2(2, 1), -1e-6);
  EXPECT_EQ(row.vector.covariance_m2(0, 1), 1e-6);
  const auto local =
      parse_geodetic("from,to,de_m,dn_m,du_m,ee_m2,en_m2,eu_m2,nn_m2,nu_m2,uu_m2\nA,B,1,2,3,1,0,0,1,0,1\n");
  ASSERT_TRUE(local) << local.error().message;
  EXPECT_TRUE((*local)[0].vector.is_local);
  const auto error = [](const std::string& text) { return parse_geodetic(text).error().message; };
  EXPECT_EQ(error(title + "A,B,1,2,3,4e-6,1,0,5e-6,0,9e-6\n"),
            "line 2: the covariance of A - B is none: it has to be positive definite");
  EXPECT_EQ(error(title + "A,B,1,2,,4e-6,0,0,5e-6,0,9e-6\n"), "line 2: the vector A - B lacks a component");
  EXPECT_EQ(error("from,to,dx_m,dy_m,dz_m,xx_m2,yy_m2,zz_m2\nA,B,1,2,3,1,1,1\n"),
            "line 1: a vector has three components and a covariance of six; missing: xy_m2, xz_m2, yz_m2");
}

TEST(GeodeticFile, WhatIsWrongIsStatedWithItsLine) {
  const auto message = [](const char* text) {
    const auto rows = parse_geodetic(text);
    return rows ? std::string("accepted") : rows.error().message;
  };
  const std::string title = "from,to,distance_m,sigma_m\n";
  EXPECT_EQ(message((title + "A,B,0,0.01\n").c_str()), "line 2: the distance A - B is not above 0");
  EXPECT_EQ(message((title + "A,B,5,0\n").c_str()), "line 2: sigma_m must be above 0");
  EXPECT_EQ(message((title + "A,B,5,\n").c_str()), "line 2: the distance A - B has no standard deviation");
  EXPECT_EQ(message((title + "\nA,A,5,1\n").c_str()), "line 3: from and to are both A");
  EXPECT_EQ(message((title + "A,B,5 m,1\n").c_str()), "line 2: distance_m \"5 m\" is not a number");
  EXPECT_EQ(message((title + "A,B,5,0,01\n").c_str()), "line 2: too many fields (decimal commas?)");
  EXPECT_EQ(message((title + "A,B,,1\n").c_str()), "line 2: nothing is measured from A to B");
  EXPECT_EQ(message("from,to,length\nA,B,1\n"), "line 1: there is no column \"length\"");
  EXPECT_EQ(message("from,to,distance_m\nA,B,1\n"), "line 1: column distance_m needs a column sigma_distance_m");
  EXPECT_EQ(message(title.c_str()), "no measurement found");
  const std::string shared = "from,to,distance_m,height_difference_m,plane,sigma_m\n";
  EXPECT_TRUE(message((shared + "A,B,1,1,,1\n").c_str()).starts_with("line 2: of which measurement"));
  EXPECT_TRUE(message((shared + "A,B,1,,wall,1\n").c_str()).starts_with("line 2: of which measurement"));
  EXPECT_EQ(message((shared + "A,B,1,,,1\nA,B,,1,,1\nA,,,,wall,1\n").c_str()), "accepted");
  const std::string angles = "from,to,zenith_deg,zenith_gon,sigma_zenith_arcsec\n";
  EXPECT_EQ(message((angles + "A,B,90,100,1\n").c_str()), "line 2: zenith_deg and zenith_gon tell one thing twice");
  EXPECT_TRUE(message((angles + "A,B,,300,1\n").c_str()).starts_with("line 2: the zenith angle A - B is not between"));
}

TEST(GeodeticFile, PointsLieOnPlanesLinesAndAtHeights) {
  const auto rows = parse_geodetic(
      "from,plane,sigma_plane_m,line,level,sigma_m,role\n"
      "A,wall,0.002,,,,\nB,,,kerb,floor,0.01,check\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 4u);
  const GeodeticFileRow& on_plane = rows->at(0);
  EXPECT_EQ(on_plane.kind, GeodeticKind::kOnPlane);
  EXPECT_EQ(on_plane.name, "wall");
  EXPECT_EQ(on_plane.from, "A");
  EXPECT_EQ(on_plane.to, "A");
  EXPECT_EQ(on_plane.sigma, 0.002);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_EQ(rows->at(static_cast<std::size_t>(1 + axis)).kind, GeodeticKind::kOnLine);
    EXPECT_EQ(rows->at(static_cast<std::size_t>(1 + axis)).axis, axis);
  }
  EXPECT_EQ(rows->at(3).kind, GeodeticKind::kAtHeight);
  EXPECT_EQ(rows->at(3).role, ControlRole::kCheck);
  const auto message = [](const char* text) {
    const auto read = parse_geodetic(text);
    return read ? std::string("read") : read.error().message;
  };
  EXPECT_EQ(message("from,plane\nA,wall\n"), "line 1: column plane needs a column sigma_plane_m");
  EXPECT_EQ(message("from,plane,sigma_m\nA,wall,\n"), "line 2: A on plane wall has no standard deviation");
  EXPECT_EQ(message("from,plane,sigma_m\nA,wall,0\n"), "line 2: sigma_m must be above 0");
  EXPECT_EQ(message("from,distance_m,sigma_m\nA,1,1\n"), "line 1: the first row must name a column to");
}

TEST(GeodeticFile, SurvivesTruncationAndGarbage) {
  read_damaged(
      "# "
      "station\nfrom,to,setup,direction_gon,sigma_direction_mgon,zenith_deg,sigma_zenith_arcsec,distance_m,sigma_m,"
      "plane,"
      "sigma_plane_m,role\nS,A,1,100,1,90,3600,20,0.002,,,check\nA,,,,,,,,,wall,0.01,\nS,B,1,200,1,,,,,,,\n",
      [](const std::string& text) {
        const auto rows = parse_geodetic(text);
        if (!rows) return;
        for (const GeodeticFileRow& row : *rows) EXPECT_TRUE(std::isfinite(row.value) && row.sigma > 0);
      });
}

}  // namespace
}  // namespace collinea
