// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/block/subject_label.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/geodesy/test_geoid.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

ImageHeader drone_header() {
  ImageHeader header;
  header.maker = "Maker";
  header.model = "Model";
  header.focal_mm = 8.8;
  header.focal_35mm_mm = 24;
  return header;
}

ImageHeader header_at(double latitude_deg, double longitude_deg) {
  ImageHeader header = drone_header();
  header.latitude_deg = latitude_deg;
  header.longitude_deg = longitude_deg;
  header.height_m = 400;
  return header;
}

// No two images have the same bytes.
void put_image(const std::filesystem::path& path, const ImageHeader* header, int width_px = 120, int height_px = 90) {
  static std::uint8_t shade = 0;
  Raster<std::uint8_t> image(width_px, height_px, 1);
  std::fill(image.data.begin(), image.data.end(), ++shade);
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_jpeg(path, image, 90, header));
}

// What the findings of that code say, one a line.
std::string labels_of(const Imported& imported, FindingCode code) {
  std::string text;
  for (const Finding& one : imported.findings)
    if (one.code == code) text += label_of(one, imported.block) + "\n";
  return text;
}

// Why a file was skipped: the code, what else it is about, figures and the words of whatever refused it.
std::string reason_for(const Imported& imported, const std::string& file) {
  for (const Finding& one : imported.skipped) {
    if (one.subjects.at(0).name != file) continue;
    std::string text(word_of(one.code));
    if (one.subjects.size() > 1) text += ", " + one.subjects[1].name;
    for (const Figure& figure : one.figures) text += fmt::format(", {} {:.0f}", word_of(figure.name), figure.value);
    return one.detail.empty() ? text : text + ": " + one.detail;
  }
  return "not skipped";
}

// The camera that an image of 120 x 90 pixels with this header gets.
Camera camera_of(const ImageHeader& header) {
  const TestFolder folder;
  put_image(folder / "a.jpg", &header);
  put_image(folder / "b.jpg", &header);
  const auto imported = import_images(folder / "", {}, {});
  EXPECT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.cameras.size(), 1u);
  return imported->block.cameras.begin()->second;
}

constexpr double kDiagonal_px = 150;               // of 120 x 90
constexpr double kFullFrameDiagonal_mm = 43.2666;  // of 36 x 24

TEST(ImportFocal, TheEquivalentIsMeasuredOnTheDiagonal) {
  ImageHeader header = drone_header();
  header.focal_mm.reset();
  const Camera camera = camera_of(header);
  EXPECT_NEAR(camera.focal_px(), 24 * kDiagonal_px / kFullFrameDiagonal_mm, 1e-9);
  EXPECT_NEAR(camera.prior.sigma_f_px, 0.05 * camera.focal_px(), 1e-9);
  EXPECT_TRUE(camera.prior.calibrate);
}

TEST(ImportFocal, WithoutAnyItIsAssumedAndHardlyKnown) {
  const Camera camera = camera_of(ImageHeader{});
  EXPECT_NEAR(camera.focal_px(), 1.2 * 120, 1e-9);
  EXPECT_GE(camera.prior.sigma_f_px, 0.3 * camera.focal_px());
  EXPECT_EQ(camera.prior.source, Provenance::kAssumed);
}

// Many makers begin the name of the model with their own.
TEST(ImportCamera, TheMakerIsNamedOnce) {
  const auto name = [](const char* maker, const char* model) {
    ImageHeader header = drone_header();
    header.maker = maker;
    header.model = model;
    return camera_of(header).name;
  };
  EXPECT_EQ(name("Canon", "Canon DIGITAL IXUS 120 IS"), "Canon DIGITAL IXUS 120 IS 8.8 mm");
  EXPECT_EQ(name("NIKON CORPORATION", "NIKON D80"), "NIKON D80 8.8 mm");
  EXPECT_EQ(name("SONY", "DSC-RX100"), "SONY DSC-RX100 8.8 mm");
  EXPECT_EQ(name("DJI", "DJIX"), "DJI DJIX 8.8 mm");  // another word
  EXPECT_EQ(name("", "Model"), "Model 8.8 mm");
  EXPECT_EQ(name("Canon", ""), "Canon 8.8 mm");
}

TEST(ImportFocal, AnImpossibleOneIsNotBelieved) {
  ImageHeader header = drone_header();
  header.focal_mm.reset();
  header.focal_35mm_mm = 3000;
  EXPECT_EQ(camera_of(header).prior.source, Provenance::kAssumed);
}

TEST(ImportFocal, TheFindingTellsAMissingFromAnImpossibleOne) {
  ImageHeader impossible = drone_header();
  impossible.focal_mm.reset();
  impossible.focal_35mm_mm = 3000;
  const TestFolder folder;
  for (const auto& [file, header] : {std::pair("a.jpg", ImageHeader{}), std::pair("b.jpg", impossible)})
    put_image(folder / file, &header);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(labels_of(*imported, FindingCode::kFocalAssumed),
            "focal_assumed: camera unknown camera; width_px 120; height_px 90; focal_px 144\n");
  EXPECT_EQ(labels_of(*imported, FindingCode::kFocalImpossible),
            "focal_impossible: camera Maker Model; width_px 120; height_px 90; focal_px 144\n");
}

TEST(ImportFocal, AGivenCameraIsFixed) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto imported = import_images(folder / "", {.camera_params = "101,100,61,44,-0.1,0.01,0.002,1e-4,-2e-4"}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  const Camera& camera = imported->block.cameras.begin()->second;
  const std::array<double, Camera::kAllParams> expected = {100, 61, 44, -0.1, 0.01, 0.002, 1e-4, -2e-4, 1, 0};
  EXPECT_EQ(camera.params, expected);
  EXPECT_FALSE(camera.prior.calibrate);
  EXPECT_TRUE(imported->findings.empty());
}

TEST(ImportFocal, AFisheyeIsWhatTheUserSays) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto given = import_images(
      folder / "", {.camera_model = KannalaBrandt{}, .camera_params = "101,100,61,44,-0.1,0.01,0.002,1e-4"}, {});
  ASSERT_TRUE(given) << given.error().message;
  const Camera& camera = given->block.cameras.begin()->second;
  EXPECT_TRUE(is<KannalaBrandt>(camera.model));
  EXPECT_EQ(camera.params[Camera::kK4], 1e-4);
  EXPECT_EQ(camera.params[Camera::kP1], 0);
  // Nothing stated: from corner to corner (150 px) half a turn.
  const auto assumed = import_images(folder / "", {.camera_model = Equidistant{}}, {});
  ASSERT_TRUE(assumed);
  EXPECT_NEAR(assumed->block.cameras.begin()->second.focal_px(), 150 / 3.14159265, 1e-6);
  EXPECT_TRUE(is<Equidistant>(assumed->block.cameras.begin()->second.model));
  const auto of_no_lens = import_images(folder / "", {.camera_model = BrownOfMeasured{}}, {});
  ASSERT_FALSE(of_no_lens);
  EXPECT_EQ(of_no_lens.error().options, std::vector{"camera_model"_option});
  EXPECT_NE(of_no_lens.error().message.find("brown, equidistant, equisolid or kannala_brandt"), std::string::npos);
  const auto long_list = import_images(
      folder / "", {.camera_model = KannalaBrandt{}, .camera_params = "101,100,61,44,-0.1,0.01,0.002,1e-4,0"}, {});
  EXPECT_FALSE(long_list);
}

TEST(ImportFocal, AGivenCameraThatIsNoneIsAnError) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  for (const char* params :
       {"100,100", "100,100,x,45", "0,100,60,45", "-100,100,60,45", "1,2,3,4,5,6,7,8,9,10", "100,100,nan,45",
        "inf,inf,60,45", "100,100,60,45,nan", "100,100,130,45", "100,100,60,-1"}) {
    const auto imported = import_images(folder / "", {.camera_params = params}, {});
    ASSERT_FALSE(imported) << params;
    EXPECT_EQ(imported.error().code, Errc::kBadInput) << params;
    EXPECT_EQ(imported.error().options, std::vector{"camera_params"_option});
  }
}

TEST(ImportFocal, AGivenCameraFitsImagesOfOneSizeOnly) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr, 90, 120);
  const auto imported = import_images(folder / "", {.camera_params = "100,100,45,45"}, {});
  ASSERT_FALSE(imported);
  EXPECT_EQ(imported.error().code, Errc::kBadInput);
  EXPECT_NE(imported.error().message.find("b.jpg has 90 x 120 px"), std::string::npos) << imported.error().message;
}

TEST(Import, OneCameraForImagesOfOneBodyLensAndSize) {
  const TestFolder folder;
  ImageHeader header = drone_header(), zoomed = header, other_body = header;
  zoomed.focal_mm = 20;
  zoomed.focal_35mm_mm = 55;
  other_body.serial = "2";
  put_image(folder / "1.jpg", &header);
  put_image(folder / "2.jpg", &header);
  put_image(folder / "3.jpg", &zoomed);
  put_image(folder / "4.jpg", &other_body);
  put_image(folder / "5.jpg", &header, 90, 120);  // turned, or another format: not the same pixels
  put_image(folder / "6.jpg", &header);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  std::vector<std::uint32_t> cameras;
  for (const auto& [id, image] : imported->block.images) cameras.push_back(image.camera.value);
  EXPECT_EQ(cameras, (std::vector<std::uint32_t>{0, 0, 1, 2, 3, 0}));
}

TEST(Import, BrokenDuplicateAndTinyFilesAreNamedAndTheRestGoesOn) {
  const TestFolder folder;
  const ImageHeader header = drone_header();
  put_image(folder / "a.jpg", &header);
  put_image(folder / "sub/b.jpg", &header);
  std::filesystem::copy_file(folder / "a.jpg", folder / "copy.jpg");
  put_image(folder / "tiny.jpg", &header, 40, 30);
  ASSERT_TRUE(write_file(folder / "text.jpg", "no image"));
  ASSERT_TRUE(write_file(folder / "empty.png", ""));
  ASSERT_TRUE(write_file(folder / "notes.txt", "not even called an image"));
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  ASSERT_EQ(imported->block.images.size(), 2u);
  EXPECT_EQ(imported->block.images.at(ImageId{0}).file, "a.jpg");
  EXPECT_EQ(imported->block.images.at(ImageId{1}).file, "sub/b.jpg");
  EXPECT_EQ(imported->file_hash.size(), 2u);
  EXPECT_EQ(imported->skipped.size(), 4u);
  EXPECT_EQ(reason_for(*imported, "copy.jpg"), "image_duplicate, a.jpg");
  EXPECT_EQ(reason_for(*imported, "empty.png"), "image_unreadable: is empty");
  EXPECT_EQ(reason_for(*imported, "text.jpg"), "image_unreadable: is neither JPEG, PNG nor TIFF");
  EXPECT_EQ(reason_for(*imported, "tiny.jpg"), "image_too_small, limit 64");
}

TEST(Import, RastersOfAProjectAmongTheInputAreNotImported) {
  const TestFolder folder;
  for (const char* file : {"a.jpg", "b.jpg", "project/products/ortho.jpg", "products/ortho.jpg", "depth/1.jpg"})
    put_image(folder / file, nullptr);
  ASSERT_TRUE(write_file(folder / "project/block.db", "a project below"));
  const auto below = import_images(folder / "", {}, {});
  ASSERT_TRUE(below) << below.error().message;
  EXPECT_EQ(below->block.images.size(), 4u);  // products and depth here are the user's own
  ASSERT_TRUE(write_file(folder / "block.db", "a project in the folder itself"));
  const auto within = import_images(folder / "", {}, {});
  ASSERT_TRUE(within) << within.error().message;
  EXPECT_EQ(within->block.images.size(), 2u);
}

TEST(Import, FewerThanTwoImagesAreAnErrorThatSaysWhere) {
  const TestFolder folder;
  put_image(folder / "only.jpg", nullptr);
  for (const std::string& name : {std::string(), std::string("missing")}) {
    const auto imported = import_images(folder / name, {}, {});
    ASSERT_FALSE(imported);
    EXPECT_EQ(imported.error().code, Errc::kNotFound);
    EXPECT_NE(imported.error().message.find((folder / name).string()), std::string::npos) << imported.error().message;
  }
}

TEST(Import, PositionsGetTheUtmZoneAndStatedSigmasWin) {
  const TestFolder folder;
  const ImageHeader plain = header_at(48.2, 15.6);
  ImageHeader precise = header_at(48.2005, 15.6), flat = header_at(48.2, 15.6005);
  precise.sigma_east_m = 0.02;
  precise.sigma_north_m = 0.03;
  precise.sigma_height_m = 0.05;
  flat.height_m.reset();
  put_image(folder / "1.jpg", &plain);
  put_image(folder / "2.jpg", &precise);
  put_image(folder / "3.jpg", &flat);
  const auto imported = import_images(folder / "", {.gps_sigma_m = 3, .gps_sigma_height_m = 6}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  const Block& block = imported->block;
  ASSERT_TRUE(block.georeference);
  EXPECT_EQ(block.georeference->crs, "EPSG:32633");
  const auto& first = block.images.at(ImageId{0}).position.value();
  const auto& second = block.images.at(ImageId{1}).position.value();
  EXPECT_EQ(first.sigma_m, Eigen::Vector3d(3, 3, 6));
  EXPECT_EQ(second.sigma_m, Eigen::Vector3d(0.02, 0.03, 0.05));
  EXPECT_TRUE(std::isinf(block.images.at(ImageId{2}).position->sigma_m.z()));
  // 0.0005 degrees of latitude are 55.6 m of meridian here.
  EXPECT_NEAR(second.position_in_world.y() - first.position_in_world.y(), 55.6, 0.1);
}

TEST(Import, ImagesOnBothSidesOfTheDateLineAreBesideEachOther) {
  const TestFolder folder;
  const ImageHeader west = header_at(-17, 179.999), east = header_at(-17, -179.997);
  put_image(folder / "1.jpg", &west);
  put_image(folder / "2.jpg", &east);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  const Block& block = imported->block;
  EXPECT_EQ(block.georeference.value().crs, "EPSG:32701");
  EXPECT_NEAR(block.georeference->origin_longitude_deg, -179.999, 1e-9);
  for (const auto& [id, image] : block.images)
    EXPECT_LT(image.position->position_in_world.head<2>().norm(), 250) << image.file;
}

TEST(Import, AMapThatIsNoneIsAnErrorAlsoWhereNothingIsPlaced) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto imported = import_images(folder / "", {.crs = "nonsense"}, {});
  ASSERT_FALSE(imported);
  EXPECT_EQ(imported.error().options, std::vector{"crs"_option});
}

TEST(Import, WithoutPositionsAndControlThereIsNoMap) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_FALSE(imported->block.georeference);
}

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

const std::string kControl = R"(# collinea control, EPSG:32633
point, A, 546800, 5338600, 310, 0.01, 0.01, 0.02, control
point, B, 546850, 5338600, 311, 0.01, 0.01, 0.02, control
point, C, 546800, 5338650, 312, 0.01, 0.01, 0.02, check
)";

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

TEST(SourcesFingerprint, ChangesWithImagesAndControlOnly) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  ASSERT_TRUE(write_file(folder / "control.csv", kControl));
  const ImportOptions options{.control = (folder / "control.csv").string()};
  const std::string before = fingerprint_of_sources(folder / "", options);
  ASSERT_TRUE(write_file(folder / "notes.txt", "of no interest"));
  EXPECT_EQ(fingerprint_of_sources(folder / "", options), before);
  put_image(folder / "b.jpg", nullptr);
  const std::string more = fingerprint_of_sources(folder / "", options);
  EXPECT_NE(more, before);
  ASSERT_TRUE(write_file(folder / "control.csv", kControl + "image, A, a.jpg, 1, 2\n"));
  EXPECT_NE(fingerprint_of_sources(folder / "", options), more);
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
