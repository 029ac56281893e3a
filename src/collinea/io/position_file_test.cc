// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/position_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/block/image_axes.h"
#include "collinea/io/internal/test_damage.h"

namespace collinea {
namespace {

TEST(PositionFile, TablesSayPositionsAnglesAndSigmas) {
  const auto file = parse_positions(
      "# collinea positions, EPSG:32633\n"
      "image, easting_m, northing_m, height_m, sigma_plan_m, sigma_height_m, omega_deg, phi_deg, kappa_deg, "
      "sigma_attitude_deg, taken\n"
      "a.jpg, 500100.5, 5300000, 420, 0.02, 0.03, 1, -2, 90, 0.01, 2024-05-17T10:31:08.25\n"
      "b.jpg, 500110.5, 5300000, , 0.02, , , , , ,\n");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->crs, "EPSG:32633");
  ASSERT_EQ(file->rows.size(), 2u);
  const PositionFileRow& first = file->rows[0];
  EXPECT_EQ(*first.in_map, Eigen::Vector3d(500100.5, 5300000, 420));
  EXPECT_EQ(first.sigma_m, Eigen::Vector3d(0.02, 0.02, 0.03));
  EXPECT_EQ(first.angles->kappa_deg, 90);
  EXPECT_EQ(first.sigma_deg, Eigen::Vector3d(0.01, 0.01, 0.01));
  EXPECT_EQ(first.taken, "2024:05:17 10:31:08.250000");
  const PositionFileRow& second = file->rows[1];
  EXPECT_TRUE(std::isnan(second.in_map->z()));
  EXPECT_TRUE(std::isnan(second.sigma_m.z()));
  EXPECT_FALSE(second.angles);
}

// A level aircraft on its way east: the camera looks down, its upper edge in the east.
TEST(PositionFile, AttitudesOfAircraftAreThoseOfACameraLookingDown) {
  const auto file = parse_positions(
      "image,yaw_deg,pitch_deg,roll_deg,sigma_yaw_deg,sigma_pitch_deg,sigma_roll_deg\n"
      "a.jpg,90,0,0,0.1,0.02,0.03\nb.jpg,0,10,0,,,\nc.jpg,0,0,10,,,\n");
  ASSERT_TRUE(file) << file.error().message;
  const auto world_from_cam = [&](int row) {
    return cam_from_world(*file->rows[static_cast<std::size_t>(row)].attitude).conjugate();
  };
  EXPECT_LT((world_from_cam(0) * Eigen::Vector3d(0, -1, 0) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((world_from_cam(0) * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  // The nose up: the camera looks ahead; the right wing down: it looks to the left.
  const double sine = std::sin(10 * std::numbers::pi / 180);
  EXPECT_NEAR((world_from_cam(1) * Eigen::Vector3d::UnitZ()).y(), sine, 1e-12);
  EXPECT_NEAR((world_from_cam(2) * Eigen::Vector3d::UnitZ()).x(), -sine, 1e-12);
  // Flown east, pitch turns about north and roll about east.
  EXPECT_LT((file->rows[0].sigma_deg - Eigen::Vector3d(0.03, 0.02, 0.1)).norm(), 1e-12);
}

TEST(PositionFile, AttitudesOfCamerasAreAsDronesWriteThem) {
  const auto file =
      parse_positions("image,camera_yaw_deg,camera_pitch_deg,camera_roll_deg\na.jpg,12,-90,0\nb.jpg,12,-35,4\n");
  ASSERT_TRUE(file) << file.error().message;
  for (const PositionFileRow& row : file->rows) {
    const Eigen::Quaterniond given = cam_from_world(*row.attitude);
    EXPECT_LT(given.angularDistance(cam_from_world(attitude_prior(given))), 1e-12);
  }
  EXPECT_EQ(file->rows[1].attitude->pitch_deg, -35);
}

// Looking straight down the roll turns about the plumb line, ahead about the level axis of the view.
TEST(PositionFile, SigmasOfCamerasAreThoseOfTheirAxes) {
  const auto file = parse_positions(
      "image,camera_yaw_deg,camera_pitch_deg,camera_roll_deg,sigma_yaw_deg,sigma_pitch_deg,sigma_roll_deg\n"
      "a.jpg,0,-90,0,0.3,0.05,0.4\nb.jpg,0,0,0,0.3,0.05,0.4\nc.jpg,90,-45,0,0.2,0.2,0.2\n");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_LT((file->rows[0].sigma_deg - Eigen::Vector3d(0.05, 0.05, 0.5)).norm(), 1e-12);
  EXPECT_LT((file->rows[1].sigma_deg - Eigen::Vector3d(0.05, 0.4, 0.3)).norm(), 1e-12);
  EXPECT_LT((file->rows[2].sigma_deg - Eigen::Vector3d(0.2, 0.2, std::sqrt(0.06))).norm(), 1e-12);
  const auto isotropic =
      parse_positions("image,camera_yaw_deg,camera_pitch_deg,camera_roll_deg,sigma_attitude_deg\na.jpg,33,-70,5,0.1\n");
  EXPECT_EQ(isotropic->rows[0].sigma_deg, Eigen::Vector3d(0.1, 0.1, 0.1));
}

// The week of GPS is one of May 2022.
TEST(PositionFile, TimestampFilesOfDronesAreRead) {
  const auto file = parse_positions(
      "2\t296288.242869\t[2211]\t     3,N\t     0,E\t    75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t"
      "0.014391, 0.013698, 0.029694\t50,Q\n"
      "3\t296289.777625\t[2211]\t    -5,N\t    -0,E\t    75,V\t47.6436479170,Lat\t16.4758945272,Lon\t512.996,Ellh\t"
      "0.014268, 0.013609, 0.029783\t50,Q\n");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->rows.size(), 2u);
  const PositionFileRow& row = file->rows[0];
  EXPECT_EQ(row.number, 2);
  EXPECT_EQ(*row.geographic, Eigen::Vector3d(47.6436873208, 16.4759271684, 512.998));
  EXPECT_EQ(row.sigma_m, Eigen::Vector3d(0.013698, 0.014391, 0.029694));
  EXPECT_EQ(row.taken, "2022:05:25 10:18:08.242869");
}

TEST(PositionFile, WhatIsWrongIsNamedWithItsLine) {
  const auto message = [](std::string_view text) {
    const auto file = parse_positions(text);
    return file ? std::string("read") : file.error().message;
  };
  EXPECT_EQ(message(""), "nothing in it: the first row must name the columns");
  EXPECT_EQ(message("image,latitude_deg,longitude_deg\n"), "no position found");
  EXPECT_EQ(message("image,latitude_deg\n"), "line 1: columns belong together: latitude_deg, longitude_deg, height_m");
  EXPECT_EQ(message("image,speed\n"), "line 1: there is no column \"speed\"");
  EXPECT_EQ(message("image,omega_deg,phi_deg\n"),
            "line 1: three columns belong together: omega_deg, phi_deg, kappa_deg");
  EXPECT_EQ(message("image,omega_deg,phi_deg,kappa_deg,sigma_yaw_deg\n"),
            "line 1: column sigma_yaw_deg is the standard deviation of nothing in this table");
  EXPECT_EQ(message("image,yaw_deg,pitch_deg,roll_deg,sigma_m\n"),
            "line 1: column sigma_m is the standard deviation of nothing in this table");
  EXPECT_NE(
      message("image,latitude_deg,longitude_deg,taken\na.jpg,9,10,2024:05:17 -1:00:00\n").find("no date and time"),
      std::string::npos);
  const std::string head = "image,latitude_deg,longitude_deg,height_m,sigma_m\n";
  EXPECT_EQ(message(head + "a.jpg,91,10,100,1\n"), "line 2: there is no such latitude and longitude");
  EXPECT_EQ(message(head + "a.jpg,9,10,100,0\n"), "line 2: a standard deviation must be above 0");
  EXPECT_EQ(message(head + "a.jpg,9,10,100,1\na.jpg,9,10,100,1\n"), "line 3: a.jpg is there twice");
  EXPECT_EQ(message(head + "a.jpg,9,ten,100,1\n"), "line 2: longitude_deg \"ten\" is not a number");
  EXPECT_EQ(message(head + "a.jpg,9,,100,1\n"), "line 2: half a position of a.jpg");
  EXPECT_NE(message("1\t2\t[3]\t0,N\t0,E\t0,V\t47,Lat\t16,Lon\tx,Ellh\t1,1,1\t50,Q\n").find("line 1: no line of a"),
            std::string::npos);
}

TEST(PositionFile, SurvivesTruncationAndGarbage) {
  const auto read = [](const std::string& text) {
    const auto file = parse_positions(text);
    if (!file) return;
    for (const PositionFileRow& row : file->rows) {
      EXPECT_FALSE((row.sigma_m.array() <= 0).any());
      if (row.geographic) {
        EXPECT_LE(std::abs(row.geographic->x()), 90);
      }
    }
  };
  read_damaged(
      "# collinea positions, EPSG:32633\nimage,latitude_deg,longitude_deg,height_m,sigma_plan_m,camera_yaw_deg,"
      "camera_pitch_deg,camera_roll_deg,sigma_yaw_deg,taken\na.jpg,48,15,400,0.02,12,-80,3,0.1,2024:05:17 "
      "10:31:08.25\n",
      read);
  read_damaged(
      "2\t296288.242869\t[2211]\t3,N\t0,E\t75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t0.014391, "
      "0.013698, 0.029694\t50,Q\n",
      read);
}

}  // namespace
}  // namespace collinea
