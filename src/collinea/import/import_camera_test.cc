// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"
#include "collinea/import/test_photographs.h"

namespace collinea {
namespace {

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

}  // namespace
}  // namespace collinea
