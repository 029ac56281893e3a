// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/geodesy/test_geoid.h"
#include "collinea/import/test_photographs.h"

namespace collinea {
namespace {

// Three images without positions and a control file with this text.
Result<Imported> import_with_control(const std::string& text, ImportOptions options = {},
                                     const std::string& ground = "") {
  const TestFolder folder;
  const ImageHeader header = drone_header();
  for (const char* file : {"IMG_1.jpg", "IMG_2.jpg", "sub/IMG_3.JPG"}) put_image(folder / file, &header);
  EXPECT_TRUE(write_file(folder / "control.csv", text));
  options.control = (folder / "control.csv").string();
  if (!ground.empty()) {
    EXPECT_TRUE(write_file(folder / "geodetic.csv", ground));
    options.geodetic = (folder / "geodetic.csv").string();
  }
  return import_images(folder / "", options, {});
}

TEST(ImportControl, RowsFindTheirImagesByNameInAnyLetterCaseAndFolder) {
  const auto imported = import_with_control(kControl + R"(image, A, IMG_1.jpg, 10, 20, 0.4
image, A, img_2.JPG, 30, 40
image, B, sub/IMG_3.JPG, 50, 60, 0.3
image, B, IMG_3.jpg, 51, 61
image, C, IMG_1.jpg, 60, 45
image, C, IMG_2.jpg, 60, 46
)",
                                            {.control_sigma_px = 0.7});
  ASSERT_TRUE(imported) << imported.error().message;
  const Block& block = imported->block;
  EXPECT_EQ(block.georeference.value().crs, "EPSG:32633");
  ASSERT_EQ(block.control.size(), 3u);
  EXPECT_EQ(block.control.at(ControlId{2}).role, ControlRole::kCheck);
  EXPECT_LT((block.control.at(ControlId{1}).position_in_map - Eigen::Vector3d(546850, 5338600, 311)).norm(), 1e-6);
  ASSERT_EQ(block.control_observations.size(), 6u);
  std::vector<std::uint32_t> images;
  for (const ControlObservation& seen : block.control_observations) images.push_back(seen.image.value);
  EXPECT_EQ(images, (std::vector<std::uint32_t>{0, 1, 2, 2, 0, 1}));
  EXPECT_EQ(block.control_observations[0].sigma_px, 0.4);
  EXPECT_EQ(block.control_observations[1].sigma_px, 0.7);
  // The frame lies at the control: distances on the ground are those of the map, but for its scale.
  EXPECT_NEAR(
      (block.control.at(ControlId{1}).position_in_world - block.control.at(ControlId{0}).position_in_world).norm(),
      50.02, 0.05);
}

// Three degrees of longitude beside the central meridian the grid is turned: a survey that is good across it is good
// across it in the world too.
TEST(ImportControl, CovariancesAreThoseOfTheMapsAxes) {
  const auto imported = import_with_control(
      "# collinea control, EPSG:32633\npoint, A, 723000, 5338600, 310\ncovariance, A, 1e-2, 1e-9, 0, 1e-6, 0, 1e-4\n"
      "image, A, IMG_1.jpg, 10, 20\n");
  ASSERT_TRUE(imported) << imported.error().message;
  const ControlPoint& point = imported->block.control.at({0});
  const LocalFrame frame = world_frame(*imported->block.georeference).value();
  const Eigen::Vector3d east =
      (frame.local_from_map({723001, 5338600, 310}) - frame.local_from_map({723000, 5338600, 310})).normalized();
  EXPECT_GT(std::abs(east.y()), 0.02);  // the convergence of meridians
  const Eigen::Matrix3d covariance = survey_covariance(point.sigma_m, point.correlation);
  EXPECT_NEAR(std::sqrt(east.dot(covariance * east)), 0.1, 1e-6);
  const Eigen::Vector3d north = Eigen::Vector3d::UnitZ().cross(east).normalized();
  EXPECT_NEAR(std::sqrt(north.dot(covariance * north)), 1e-3, 1e-6);
}

TEST(ImportControl, RowsThatCannotBeUsedAreNamed) {
  const auto imported = import_with_control(kControl + R"(image, A, IMG_1.jpg, 10, 20
image, A, IMG_2.jpg, 500, 20
image, B, IMG_9.jpg, 10, 20
image, A, IMG_9.jpg, 11, 20
)");
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.control_observations.size(), 1u);
  EXPECT_EQ(labels_of(*imported, FindingCode::kControlOutsideImage),
            "control_outside_image: control_point A, image IMG_2.jpg; x_px 500; y_px 20; line 6\n");
  EXPECT_EQ(labels_of(*imported, FindingCode::kControlImageMissing),
            "control_image_missing: file IMG_9.jpg; count 2\n");
  EXPECT_EQ(labels_of(*imported, FindingCode::kControlSeenOnce), "control_seen_once: control_point A\n");
  EXPECT_NE(labels_of(*imported, FindingCode::kControlUnseen).find("control_unseen: control_point C\n"),
            std::string::npos);
  const auto check = import_with_control(kControl + "image, C, IMG_1.jpg, 10, 20\n");
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_EQ(labels_of(*check, FindingCode::kCheckSeenOnce), "check_seen_once: control_point C\n");
}

// Slips are few: where a third lies outside, the marks were counted in another way, and orientation finds out in which.
TEST(ImportControl, MarksThatWereCountedOtherwiseAreKeptForOrientation) {
  const auto imported = import_with_control(kControl + R"(image, A, IMG_1.jpg, -10, 20
image, A, IMG_2.jpg, -20, -20
image, B, IMG_1.jpg, 10, -20
image, B, IMG_2.jpg, 11, 20
image, C, IMG_1.jpg, 10, -5
image, C, IMG_2.jpg, 11, 20
)");
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.control_observations.size(), 6u);
  EXPECT_EQ(labels_of(*imported, FindingCode::kControlOutsideImage), "");
  EXPECT_EQ(labels_of(*imported, FindingCode::kMarksOutside), "marks_outside; count 4; of 6\n");
}

TEST(ImportControl, AFileBesideTheImagesThatWasNotGivenIsNamed) {
  const TestFolder folder;
  const ImageHeader header = drone_header();
  for (const char* file : {"IMG_1.jpg", "IMG_2.jpg"}) put_image(folder / "images" / file, &header);
  const auto named = [&](const ImportOptions& options) {
    const auto imported = import_images(folder / "images", options, {});
    return imported ? labels_of(*imported, FindingCode::kControlNotGiven) : imported.error().message;
  };
  EXPECT_EQ(named({}), "");
  ASSERT_TRUE(write_file(folder / "gcp_list.txt", "EPSG:32633\nnot a point\n"));
  EXPECT_EQ(named({}), "");
  ASSERT_TRUE(write_file(folder / "gcp_list.txt", "EPSG:32633\n546800 5338600 310 10 20 IMG_1.jpg A\n"));
  EXPECT_NE(named({}).find("gcp_list.txt"), std::string::npos) << named({});
  EXPECT_EQ(named({.control = folder / "gcp_list.txt"}), "");
}

TEST(ImportControl, PointsOfAnotherZoneComeToTheMapAskedFor) {
  const auto imported = import_with_control(kControl, {.crs = "EPSG:32632"});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.georeference.value().crs, "EPSG:32632");
  EXPECT_NEAR(imported->block.georeference->origin_latitude_deg, 48.198, 0.01);
  EXPECT_NEAR(imported->block.georeference->origin_longitude_deg, 15.630, 0.01);
  // Both zones' central meridians are 6 degrees, about 446 km at this latitude, apart.
  EXPECT_NEAR(imported->block.control.at(ControlId{0}).position_in_map.x(), 993000, 3000);
}

TEST(ImportControl, CheckPointsMayBeNamedOnTheCommandLine) {
  const auto imported = import_with_control(kControl, {.check = " A ,B"});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.control.at(ControlId{0}).role, ControlRole::kCheck);
  EXPECT_EQ(imported->block.control.at(ControlId{1}).role, ControlRole::kCheck);
}

TEST(ImportControl, WhatIsWrongIsStated) {
  const struct {
    std::string text;
    ImportOptions options;
    Errc code;
    const char* named;
  } cases[] = {
      {kControl, {.check = "Z"}, Errc::kBadInput, "\"Z\""},
      {"point, A, 1, 2, 3\npoint, B, 2, 2, 3\n", {}, Errc::kBadInput, "names no CRS"},
      {kControl, {.crs = "EPSG:99999"}, Errc::kBadInput, "EPSG:99999"},
      {kControl, {.crs = "EPSG:4326"}, Errc::kUnsupported, "degrees"},
      {"nonsense", {}, Errc::kBadFormat, "control.csv: line 1"},
      {"", {}, Errc::kBadFormat, "control.csv"},
  };
  for (const auto& [text, options, code, named] : cases) {
    const auto imported = import_with_control(text, options);
    ASSERT_FALSE(imported) << text;
    EXPECT_EQ(imported.error().code, code) << imported.error().message;
    EXPECT_NE(imported.error().message.find(named), std::string::npos) << imported.error().message;
  }
}

const std::string kMarks = R"(point, A, , ,
point, B, , ,
image, A, IMG_1.jpg, 10, 20
image, A, IMG_2.jpg, 12, 20
image, B, IMG_1.jpg, 30, 20
image, B, IMG_2.jpg, 32, 20
)";

TEST(ImportGeodetic, PointsWithoutCoordinatesNeedNoMap) {
  const auto imported = import_with_control(kMarks, {}, "from,to,distance_m,sigma_m\nA,B,2.5,0.001\n");
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_FALSE(imported->block.georeference);
  EXPECT_EQ(imported->block.control_observations.size(), 4u);
  ASSERT_EQ(imported->block.geodetic.size(), 1u);
  EXPECT_EQ(imported->block.geodetic[0].value, 2.5);
  EXPECT_EQ(imported->block.geodetic[0].to, ControlId{1});
}

TEST(ImportGeodetic, PointsThatAreOnlyMarkedNeedNoRow) {
  std::string marks(kMarks);
  for (std::size_t at; (at = marks.find("point, ")) != std::string::npos;)
    marks.erase(at, marks.find('\n', at) + 1 - at);
  const auto imported = import_with_control(marks, {}, "from,to,distance_m,sigma_m\nA,B,2.5,0.001\n");
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.control.size(), 2u);
  EXPECT_EQ(imported->block.control_observations.size(), 4u);
  EXPECT_EQ(imported->block.geodetic.size(), 1u);
}

TEST(ImportGeodetic, DirectionsOfOneSetupShareIt) {
  const auto imported = import_with_control(kMarks, {},
                                            "from,to,setup,direction_gon,sigma_direction_mgon\n"
                                            "A,B,,10,1\nA,B,,20,1\nB,A,x,30,1\n");
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.geodetic[0].setup, imported->block.geodetic[1].setup);
  EXPECT_NE(imported->block.geodetic[0].setup, imported->block.geodetic[2].setup);
}

TEST(ImportGeodetic, WhatDoesNotFitIsNamedWithFileAndLine) {
  const auto message = [](const std::string& ground) {
    const auto imported = import_with_control(kMarks, {}, ground);
    return imported ? "accepted" : imported.error().message;
  };
  const std::string title = "from,to,distance_m,sigma_m\n";
  EXPECT_TRUE(message(title + "A,C,1,1\n").ends_with("geodetic.csv: line 2: there is no point C in the control file"));
  EXPECT_TRUE(message(title + "A,B,1,0\n").ends_with("geodetic.csv: line 2: sigma_m must be above 0"));
  EXPECT_TRUE(message("from,to,setup,direction_deg,sigma_direction_arcsec\nA,B,1,1,1\nB,A,1,1,1\n")
                  .ends_with("geodetic.csv: line 3: set-up 1 stands on A and on B"));
}

TEST(ImportControl, CheckPointsWithoutControlAreAnError) {
  const TestFolder folder;
  const auto imported = import_images(folder / "", {.check = "A"}, {});
  ASSERT_FALSE(imported);
  EXPECT_EQ(imported.error().options, (std::vector{"check"_option, "control"_option}));
}

// Control above a geoid and positions above the ellipsoid, or the other way round: the same location on Earth.
class ImportHeights : public ::testing::Test {
 protected:
  ImportHeights() {
    const ImageHeader header = header_at(48.2, 15.6);
    for (const char* file : {"a.jpg", "b.jpg"}) put_image(folder_ / "photos" / file, &header);
    write_test_geoid(folder_ / "geoid.gtx");
    geoid_m_ = test_geoid_m(48.2, 15.6);
    options_.control = (folder_ / "control.csv").string();
    const LocalFrame frame = LocalFrame::create("EPSG:32633", 48.2, 15.6, 0).value();
    map_ = frame.map_from_local(frame.local_from_geographic({48.2, 15.6, 400 - geoid_m_}));
  }
  // With control where the camera is: how far over it.
  [[nodiscard]] Result<double> control_over_camera_m(const std::string& crs) {
    if (!write_file(folder_ / "control.csv",
                    "# collinea control, " + crs + "\n" +
                        fmt::format("point, A, {:.4f}, {:.4f}, {:.4f}\nimage, A, a.jpg, 50, 50\n", map_.x(), map_.y(),
                                    map_.z())))
      return fail(Errc::kBadInput, "not written");
    auto imported = import_images(folder_ / "photos", options_, {});
    if (!imported) return tl::unexpected(imported.error());
    imported_ = std::move(*imported);
    const Block& block = imported_.block;
    return block.control.begin()->second.position_in_world.z() -
           block.images.begin()->second.position->position_in_world.z();
  }

  const TestFolder folder_;
  ImportOptions options_;
  Imported imported_;
  Eigen::Vector3d map_;  // heights over the geoid
  double geoid_m_ = 0;
};

TEST_F(ImportHeights, ControlOverAGeoidMeetsPositionsOverTheEllipsoid) {
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), -geoid_m_, 1e-3);  // nobody stated it
  options_.control_heights = (folder_ / "geoid.gtx").string();
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), 0, 1e-3);
  // The map keeps ellipsoidal heights.
  EXPECT_EQ(imported_.block.georeference->crs, "EPSG:32633");
  EXPECT_NEAR(imported_.block.control.begin()->second.position_in_map.z(), 400, 1e-3);
}

TEST_F(ImportHeights, HeightsOfTheMapAreThoseOfControlThatStatesNone) {
  options_.heights = (folder_ / "geoid.gtx").string();
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), 0, 1e-3);
  EXPECT_NEAR(imported_.block.control.begin()->second.position_in_map.z(), 400 - geoid_m_, 1e-3);
  EXPECT_EQ(imported_.block.georeference->crs, "EPSG:32633+geoid:" + (folder_ / "geoid.gtx").string());
}

TEST_F(ImportHeights, HeightsOfTheImagesMayCountFromAGeoid) {
  options_.gps_heights = (folder_ / "geoid.gtx").string();
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), -2 * geoid_m_, 1e-3);
  EXPECT_FALSE(labels_of(imported_, FindingCode::kHeightsCountFrom).empty());
  options_.heights = options_.gps_heights;
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), -geoid_m_, 1e-3);
}

// A file of positions says itself what its heights count from: its CRS, else --heights; --gps-heights is of headers.
TEST_F(ImportHeights, HeightsOfAPositionFileAreThoseOfItsMap) {
  const std::string coordinates = fmt::format(",{:.4f},{:.4f},{:.4f}\n", map_.x(), map_.y(), map_.z());
  ASSERT_TRUE(
      write_file(folder_ / "gnss.csv", "# collinea positions, EPSG:32633\nimage,easting_m,northing_m,height_m\na.jpg" +
                                           coordinates + "b.jpg" + coordinates));
  options_.positions = (folder_ / "gnss.csv").string();
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), 0, 1e-3);  // both over the ellipsoid
  options_.heights = (folder_ / "geoid.gtx").string();
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), 0, 1e-3);  // both over the geoid
  const double raised_m = imported_.block.images.begin()->second.position->height_m;
  EXPECT_NEAR(raised_m, 400, 1e-3);
  options_.gps_heights = *options_.heights;
  EXPECT_NEAR(control_over_camera_m("EPSG:32633").value(), 0, 1e-3);
  EXPECT_TRUE(labels_of(imported_, FindingCode::kHeightsCountFrom).empty());
}

TEST_F(ImportHeights, WhatIsWrongIsNamedByItsOption) {
  options_.gps_heights = "nowhere.gtx";
  EXPECT_EQ(control_over_camera_m("EPSG:32633").error().options, std::vector{"gps_heights"_option});
  options_.gps_heights = "ellipsoidal";
  options_.control_heights = "EPSG:4326";
  EXPECT_EQ(control_over_camera_m("EPSG:32633").error().options, std::vector{"control_heights"_option});
}

}  // namespace
}  // namespace collinea
