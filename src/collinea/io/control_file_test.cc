// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/control_file.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <filesystem>

#include "collinea/base/file.h"
#include "collinea/base/source_tree.h"
#include "collinea/io/internal/control_formats.h"
#include "collinea/io/internal/test_damage.h"
#include "collinea/io/text.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr const char* kCsv =
    "# collinea control, EPSG:32633\n"
    "point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role\n"
    "point, A, 500000.125, 4600000.5, 101.25, 0.01, 0.012, 0.02, control\r\n"
    "point, B 2, 500100, 4600000, , 0.01, 0.01, inf, check\n"
    "\n"
    "point, C, 500200, 4600200, 105.75\n"
    "image, id, file, x_px, y_px, sigma_px\n"
    "image, A, DJI_1.JPG, 100.5, 200.25, 0.3\n"
    "image, A, DJI_1.JPG, 100.5, 200.25, 0.3\n"
    "image, B 2, DJI_2.JPG, 1.5, 2.5\n";

std::string message_of(std::string_view text) {
  const auto control = parse_control(text);
  return control ? "no error" : control.error().message;
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST(ControlFile, OurCsvIsReadAsItIsDocumented) {
  const auto control = parse_control(kCsv);
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_EQ(control->crs, "EPSG:32633");
  ASSERT_EQ(control->points.size(), 3u);
  EXPECT_EQ(control->points[0].position_in_map, Eigen::Vector3d(500000.125, 4600000.5, 101.25));
  EXPECT_EQ(control->points[0].sigma_m, Eigen::Vector3d(0.01, 0.012, 0.02));
  EXPECT_EQ(control->points[1].name, "B 2");
  EXPECT_EQ(control->points[1].role, ControlRole::kCheck);
  EXPECT_TRUE(std::isinf(control->points[1].sigma_m.z()));
  EXPECT_EQ(control->points[1].position_in_map.z(), 103.5);  // the mean of the others
  EXPECT_EQ(control->points[2].sigma_m, Eigen::Vector3d(0.02, 0.02, 0.03));
  ASSERT_EQ(control->observations.size(), 2u);  // a copied line counts once
  EXPECT_EQ(control->observations[0].pixel, Eigen::Vector2d(100.5, 200.25));
  EXPECT_EQ(control->observations[0].sigma_px, 0.3);
  EXPECT_EQ(control->observations[1].sigma_px, 0.5);
  EXPECT_EQ(control->observations[1].file, "DJI_2.JPG");
  EXPECT_EQ(control->observations[1].line, 10);
}

TEST(ControlFile, DefaultsAreTheCallers) {
  const auto control = parse_control("point, C, 1, 2, 3\nimage, C, a.jpg, 1, 2\n", {0.5, 0.7, 2});
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_TRUE(control->crs.empty());
  EXPECT_EQ(control->points[0].sigma_m, Eigen::Vector3d(0.5, 0.5, 0.7));
  EXPECT_EQ(control->observations[0].sigma_px, 2);
}

TEST(ControlFile, AHeightOnlyPointHasNoPlan) {
  const auto control = parse_control("point, H, , , 7, , , 0.01\npoint, P, 10, 20, 5\n");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_TRUE(std::isinf(control->points[0].sigma_m.x()) && std::isinf(control->points[0].sigma_m.y()));
  EXPECT_EQ(control->points[0].position_in_map, Eigen::Vector3d(10, 20, 7));
}

TEST(ControlFile, APointMayHaveNoCoordinatesAtAll) {
  const auto control = parse_control(
      "point, id, easting, northing, height\n"
      "point, A, , ,\n"
      "image, id, file, x_px, y_px\n"
      "image, A, a.jpg, 1, 2\n");
  ASSERT_TRUE(control) << control.error().message;
  ASSERT_EQ(control->points.size(), 1u);
  EXPECT_TRUE(control->points[0].sigma_m.array().isInf().all());
  EXPECT_EQ(control->points[0].position_in_map, Eigen::Vector3d(0, 0, 0));
}

TEST(ControlFile, APointMarkedInTwoImagesNeedsNoRowOfItsOwn) {
  const auto control = parse_control(
      "image, id, file, x_px, y_px\n"
      "image, T1, a.jpg, 1, 2\n"
      "point, A, 10, 20, 30\n"
      "image, T1, b.jpg, 3, 4\n");
  ASSERT_TRUE(control) << control.error().message;
  ASSERT_EQ(control->points.size(), 2u);
  EXPECT_EQ(control->points[1].name, "T1");
  EXPECT_EQ(control->points[1].role, ControlRole::kControl);
  EXPECT_TRUE(control->points[1].sigma_m.array().isInf().all());
  EXPECT_EQ(control->points[1].position_in_map, Eigen::Vector3d(10, 20, 30));
  EXPECT_EQ(control->observations.size(), 2u);
  EXPECT_TRUE(contains(message_of("image, T1, a.jpg, 1, 2\nimage, T2, a.jpg, 3, 4\nimage, T2, b.jpg, 3, 4\n"),
                       "line 1: image row of a point T1 that no point row gives, and no other image"));
  EXPECT_TRUE(contains(message_of("image, T1, a.jpg, 1, 2\nimage, T1, a.jpg, 3, 4\n"), "measured twice in a.jpg"));
}

TEST(ControlFile, AnImageMayHaveACovariance) {
  const std::string marks = "point, A, 10, 20, 30\nimage, A, a.jpg, 1, 2, 0.3\nimage, A, b.jpg, 3, 4, 0.5\n";
  const auto control = parse_control(marks + "image_covariance, A, a.jpg, 0.04, -0.006, 0.01\n");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_NEAR(control->observations[0].sigma_px, 0.2, 1e-12);
  EXPECT_NEAR(control->observations[0].shape.row_over_column, 0.5, 1e-7);
  EXPECT_NEAR(control->observations[0].shape.correlation, -0.3, 1e-7);
  EXPECT_TRUE(control->observations[1].shape.is_round());
  EXPECT_TRUE(
      contains(message_of(marks + "image_covariance, A, c.jpg, 1, 0, 1\n"), "line 4: there is no image row of A"));
  EXPECT_TRUE(contains(message_of(marks + "image_covariance, A, a.jpg, 1, 1, 1\n"), "line 4: this is no covariance"));
  EXPECT_TRUE(contains(message_of(marks + "image_covariance, A, a.jpg, 1, 0\n"), "line 4: a row of an image's"));
}

TEST(ControlFile, ErrorsOfOurCsvNameTheLine) {
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\npoint, B, 1O4, 2, 3\n"), "line 2"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\npoint, A, 4, 5, 6\n"), "line 2: point A is given twice"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\nimage, Z, a.jpg, 1, 2\n"), "line 2"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\nimage, A, a.jpg, 1, x\n"), "line 2"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\nimage, A, a.jpg, nan, 2\n"), "line 2"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3, 0, 1, 1\n"), "line 1"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3, 1, 1, 1, chekc\n"), "line 1: role"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2\n"), "line 1"));
  EXPECT_TRUE(contains(message_of("point, A, 1, 2, 3\nsurvey by Bob\n"), "line 2"));
  EXPECT_TRUE(contains(message_of("# collinea control, nonsense\npoint, A, 1, 2, 3\n"), "line 1"));
  EXPECT_TRUE(contains(message_of("# collinea control, EPSG:32633\n"), "no control point"));
}

TEST(ControlFile, OpenDroneMapRowsOfOnePositionAreOnePoint) {
  const auto control = parse_control(
      "WGS84 UTM 17N\n"
      "441024.157 4564001.87 345.1 2648 2147 IMG_1356.jpg \n"
      "441024.157 4564001.87 345.1 48.5 47.25 IMG_1357.jpg\n"
      "440920.0 4564153.5 345.6 2213 1267 IMG_1356.jpg");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_EQ(control->crs, "EPSG:32617");
  ASSERT_EQ(control->points.size(), 2u);
  EXPECT_EQ(control->points[0].name, "gcp1");
  EXPECT_EQ(control->points[1].name, "gcp2");
  EXPECT_EQ(control->points[0].sigma_m, Eigen::Vector3d(0.02, 0.02, 0.03));
  ASSERT_EQ(control->observations.size(), 3u);
  EXPECT_EQ(control->observations[1].point, "gcp1");
  EXPECT_EQ(control->observations[1].pixel, Eigen::Vector2d(48.5, 47.25));
}

TEST(ControlFile, OpenDroneMapNamesTabsAndMissingHeightsAreUnderstood) {
  const auto control = parse_control(
      "\xef\xbb\xbf"
      "epsg:25833\r\n"
      "500000\t4600000\t12\t1\t2\tmy photo 1.jpg\tP 1\textra\r\n"
      "500000\t4600000\t12\t3\t4\tmy photo 2.jpg\tP 1\r\n"
      "# a remark\r\n"
      "500010 4600000 NaN 5 6 b.jpg Q\r\n"
      "500020\t4600000\t\t7\t8\t7.jpg\r\n");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_EQ(control->crs, "EPSG:25833");
  ASSERT_EQ(control->points.size(), 3u);
  EXPECT_EQ(control->points[0].name, "P 1");
  EXPECT_EQ(control->observations[1].file, "my photo 2.jpg");
  EXPECT_TRUE(std::isinf(control->points[1].sigma_m.z()));
  EXPECT_TRUE(std::isinf(control->points[2].sigma_m.z()));
  EXPECT_EQ(control->points[2].position_in_map.z(), 12);
  EXPECT_EQ(control->observations[3].pixel, Eigen::Vector2d(7, 8));
}

// Without a height in any row there is no column of heights. Where others have one, which number is missing is not
// known.
TEST(ControlFile, RowsOfOpenDroneMapWithANumberLessAreRefused) {
  const std::string full = "EPSG:32633\n500000 4600000 12 1 2 a.jpg P\n", less = "500010 4600000 5 6 b.jpg Q\n";
  EXPECT_EQ(
      message_of(full + less),
      "line 3: 4 numbers in front of the image, where line 2 has 5: one is missing (a height that was not surveyed "
      "is written NaN)");
  EXPECT_TRUE(contains(message_of("EPSG:32633\n" + less + "500000 4600000 12 1 2 a.jpg P\n"), "line 2: 4 numbers"));
  // The field between two tabs is the northing.
  EXPECT_TRUE(contains(message_of("EPSG:32633\n500000\t\t12\t1\t2\ta.jpg\n"), "line 2: not of the form"));
  const auto plan = parse_control("EPSG:32633\n" + less + "500020 4600000 7 8 7.jpg R\n");
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_TRUE(std::isinf(plan->points[1].sigma_m.z()));
  EXPECT_EQ(plan->observations[1].pixel, Eigen::Vector2d(7, 8));
}

TEST(ControlFile, ErrorsOfOpenDroneMapFilesNameTheLine) {
  EXPECT_TRUE(contains(message_of("EPSG:32633\n1 2 3 4 5 a.jpg\n1 2 3 a\n"), "line 3"));
  EXPECT_TRUE(contains(message_of("hello\n1 2 3 4 5 a.jpg\n"), "line 1"));
  EXPECT_TRUE(contains(message_of("EPSG:32633\n1 2 3 4 5 a.jpg P\n1 2 9 4 5 b.jpg P\n"), "line 3"));
  EXPECT_TRUE(contains(message_of(""), "no control point"));
}

TEST(ControlFile, TheManyWaysToNameACrsAreUnderstood) {
  EXPECT_EQ(normalised_crs("EPSG:32617"), "EPSG:32617");
  EXPECT_EQ(normalised_crs(" epsg:32633+5773\t"), "EPSG:32633+5773");
  EXPECT_EQ(normalised_crs("WGS84 UTM 54N"), "EPSG:32654");
  EXPECT_EQ(normalised_crs("WGS 84 / UTM zone 7S"), "EPSG:32707");
  EXPECT_EQ(normalised_crs("+proj=utm +zone=52 +north +ellps=WGS84 +datum=WGS84 +units=m +no_defs"), "EPSG:32652");
  EXPECT_EQ(normalised_crs("+proj=utm +zone=17 +south +datum=WGS84 +units=m"), "EPSG:32717");
  EXPECT_EQ(normalised_crs("+proj=tmerc +lat_0=0 +lon_0=9 +ellps=bessel"),
            "+proj=tmerc +lat_0=0 +lon_0=9 +ellps=bessel +type=crs");
  EXPECT_EQ(normalised_crs("NAD27 UTM 17N"), "");
  EXPECT_EQ(normalised_crs("WGS84 UTM 61N"), "");
  EXPECT_EQ(normalised_crs("easting northing"), "");
}

TEST(ControlFile, DegreesComeBackInTheUtmZone) {
  // Truth: PROJ's cs2cs, to 0.1 mm.
  const auto control = parse_control(
      "EPSG:4326\n"
      "16.47592207\t47.64350399\t463.662\t2501.0\t2452.0\tA.JPG\t1\n"
      "16.47579934\t47.64316881\t461.928\t2501.0\t2452.0\tA.JPG\t5\n");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_EQ(control->crs, "EPSG:32633");
  EXPECT_LT((control->points[0].position_in_map - Eigen::Vector3d(610852.3942, 5277733.5909, 463.662)).norm(), 2e-4);
  EXPECT_LT((control->points[1].position_in_map - Eigen::Vector3d(610843.8857, 5277696.1650, 461.928)).norm(), 2e-4);
}

TEST(ControlFile, DegreesThatNoUtmZoneReachesAreRefusedByName) {
  const auto control = parse_control("EPSG:4326\n15.25 48.5 100 10.5 20.5 a.jpg\n100 6 48.5 100 10.5 b.jpg\n");
  ASSERT_FALSE(control);
  EXPECT_NE(control.error().message.find("too far from point"), std::string::npos) << control.error().message;
}

TEST(ControlFile, RolesCanBeSetByName) {
  auto control = parse_control(kCsv);
  ASSERT_TRUE(control);
  ASSERT_TRUE(set_check_points(*control, std::vector<std::string>{"C"}));
  EXPECT_EQ(control->points[1].role, ControlRole::kControl);
  EXPECT_EQ(control->points[2].role, ControlRole::kCheck);
  const auto unknown = set_check_points(*control, std::vector<std::string>{"X"});
  ASSERT_FALSE(unknown);
  EXPECT_TRUE(contains(unknown.error().message, "B 2"));
}

TEST(ControlFile, AMissingFileSaysSo) {
  const auto control = read_control("/nowhere/gcp_list.txt");
  ASSERT_FALSE(control);
  EXPECT_EQ(control.error().code, Errc::kNotFound);
}

// Laws of every format of the list, on its example in the manual; all examples hold the same two points.

// What stands indented below the heading of a format.
std::string example_of(const ControlFormat& format) {
  const auto page = std::filesystem::path(source_tree()) / "docs/manual/import.md";
  const std::string manual = read_file(page).value_or("");
  std::string example;
  bool below = false;
  for (const std::string_view line : lines_of(manual)) {
    if (line.starts_with("#")) below = line == "### " + std::string(format.name);
    if (below && line.starts_with("    ")) example += std::string(line.substr(4)) + "\n";
  }
  return example;
}

TEST(ControlFormats, EachIsRecognisedByItselfAlone) {
  const auto formats = control_formats();
  for (const ControlFormat& format : formats) {
    const std::string example = example_of(format);
    ASSERT_FALSE(example.empty()) << "docs/manual/import.md has no example of " << format.name;
    EXPECT_TRUE(format.recognises(example)) << format.name;
    for (std::size_t i = 0; i + 1 < formats.size(); ++i) {
      if (formats[i].name != format.name) {
        EXPECT_FALSE(formats[i].recognises(example)) << formats[i].name << " takes " << format.name;
      }
    }
  }
}

TEST(ControlFormats, TheExamplesOfTheManualAreOneSurvey) {
  for (const ControlFormat& format : control_formats()) {
    const auto control = parse_control(example_of(format));
    ASSERT_TRUE(control) << format.name << ": " << control.error().message;
    EXPECT_EQ(control->crs, "EPSG:32633") << format.name;
    ASSERT_GE(control->points.size(), 2u) << format.name;
    EXPECT_EQ(control->points[0].name, "A1") << format.name;
    EXPECT_EQ(control->points[0].position_in_map, Eigen::Vector3d(546812.31, 5338101.92, 352.18)) << format.name;
    EXPECT_TRUE((control->points[0].sigma_m.array() > 0).all()) << format.name;
    EXPECT_EQ(control->points[1].name, "A2") << format.name;
    EXPECT_EQ(control->points[1].position_in_map, Eigen::Vector3d(546871.02, 5338120.44, 353.02)) << format.name;
    ASSERT_EQ(control->observations.size(), 2u) << format.name;
    EXPECT_EQ(control->observations[0].point, "A1") << format.name;
    EXPECT_EQ(control->observations[0].file, "IMG_0003.jpg") << format.name;
    EXPECT_EQ(control->observations[0].pixel, Eigen::Vector2d(812.4, 1033.7)) << format.name;
    EXPECT_EQ(control->observations[1].point, "A2") << format.name;
    EXPECT_EQ(control->observations[1].pixel, Eigen::Vector2d(1711.2, 640.9)) << format.name;
  }
}

TEST(ControlFormats, SurviveTruncationAndGarbage) {
  for (const ControlFormat& format : control_formats())
    read_damaged(example_of(format), [](const std::string& text) {
      const auto file = parse_control(text);
      if (!file) return;
      for (const ControlFilePoint& point : file->points) ASSERT_TRUE(point.position_in_map.allFinite()) << text;
      for (const auto& seen : file->observations) ASSERT_TRUE(seen.pixel.allFinite() && seen.sigma_px > 0) << text;
    });
}

struct RealFile {
  const char* path;
  const char* crs;
  std::size_t points, observations;
};

// The counts were taken from the files with awk: distinct names, or positions, and rows.
TEST(ControlFile, RealFilesAreRead) {
  const auto data = std::filesystem::path(source_tree()) / "../shared/data";
  if (!std::filesystem::exists(data / "INDEX.md")) GTEST_SKIP() << "needs the shared data";
  for (const RealFile& file : {RealFile{"sheffield_cross/gcp_list.txt", "EPSG:32617", 5, 25},
                               RealFile{"odm_copr/gcp_list.txt", "EPSG:32611", 10, 27},
                               RealFile{"odm_gcp_only/bellus/gcp_list.txt", "EPSG:32617", 4, 4},
                               RealFile{"oppaiyama/gcp_list.txt", "EPSG:32654", 4, 149},
                               RealFile{"helenenschacht_rtk/GCP/gcp_list.txt", "EPSG:32633", 5, 35}}) {
    const auto control = read_control(data / file.path);
    ASSERT_TRUE(control) << control.error().message;
    EXPECT_EQ(control->crs, file.crs) << file.path;
    EXPECT_EQ(control->points.size(), file.points) << file.path;
    EXPECT_EQ(control->observations.size(), file.observations) << file.path;
  }
}

TEST(ControlFile, SurvivesTruncationAndGarbage) {
  int accepted = 0, refused = 0;
  const auto read = [&](const std::string& text) {
    const auto file = parse_control(text);
    ++(file ? accepted : refused);
    if (!file) return;
    for (const ControlFilePoint& point : file->points) ASSERT_TRUE(point.position_in_map.allFinite()) << text;
    for (const auto& seen : file->observations) ASSERT_TRUE(seen.pixel.allFinite() && seen.sigma_px > 0) << text;
  };
  read_damaged(kCsv, read);
  read_damaged(
      "# collinea control, EPSG:32633\npoint, A, 1, 2, 3\ncovariance, A, 1e-4, 2e-5, 0, 1e-4, 0, 4e-4\nimage, A, "
      "a.jpg, 5, 6\n",
      read);
  read_damaged("EPSG:32633\n1 2 3 4 5 a.jpg\n1 2 3 6 7 b.jpg P\n9 8 nan 1 1 c.jpg\n", read);
  EXPECT_GT(accepted, 300);
  EXPECT_GT(refused, 300);
}

TEST(ControlFile, ACovarianceStandsInPlaceOfSigmas) {
  const std::string head = "point, A, 1, 2, 3\npoint, B, 1, 2,\n";
  const auto file =
      parse_control(head +
                    "covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2\n"
                    "covariance, A, 4e-4, 1e-4, -1e-4, 1e-4, 0, 9e-4\ncovariance, B, 4e-4, 1e-4,, 1e-4,,\n");
  ASSERT_TRUE(file) << file.error().message;
  const ControlFilePoint &a = file->points[0], &b = file->points[1];
  EXPECT_LT((a.sigma_m - Eigen::Vector3d(0.02, 0.01, 0.03)).norm(), 1e-15);
  EXPECT_LT((a.correlation - Eigen::Vector3d(0.5, -1 / 6.0, 0)).norm(), 1e-15);
  EXPECT_TRUE(std::isinf(b.sigma_m.z()));
  EXPECT_EQ(b.correlation, Eigen::Vector3d(0.5, 0, 0));
  const auto error = [&](const std::string& row) {
    const auto read = parse_control(head + row);
    return read ? std::string("read") : read.error().message;
  };
  EXPECT_EQ(error("covariance, Z, 1, 0, 0, 1, 0, 1\n"), "line 3: there is no point Z above this line");
  EXPECT_EQ(error("covariance, A, 1, 2, 0, 1, 0, 1\n"),
            "line 3: this is no covariance of A: it has to be positive definite");
  EXPECT_EQ(error("covariance, B, 1, 0, 0, 1, 0, 1\n"),
            "line 3: covariances of an axis that has no coordinate, or no variance above 0");
  EXPECT_EQ(error("covariance, A, 1, 0, 0, 1, 0, 1\ncovariance, A, 1, 0, 0, 1, 0, 1\n"),
            "line 4: the covariance of A is given twice");
  EXPECT_EQ(error("covariance, A, 1, 0, 0, 1\n"),
            "line 3: a covariance row needs: covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2");
}

}  // namespace
}  // namespace collinea
