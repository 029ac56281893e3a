// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/photomodeler.h"

#include <gtest/gtest.h>

#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/millimetre_camera.h"
#include "collinea/io/internal/test_damage.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

const std::string kExport =
    "Bundle of two photographs\n"
    " 0.0005 20 2000 1500\n"
    " 1.0 0.1 10.0 100.0 100.0 100.0 20.0 20.0 20.0\n"
    " 8.0 4.1 2.9 8.00 6.00 5e-3 -1e-4 1e-6 -6e-5 -3e-5\n"
    " 0.0 0.0 0.0 0.5 0.5 0.001 0.0001 0.0001 0.001 0.001\n"
    "   0 photos\\one.JPG\n"
    "   0 1.0 2.0 30.0 90.0 2.0 1.0\n"
    "   0 0.1 0.1 0.1 0.1 0.1 0.1\n"
    "\n"
    "   0 8.0 4.1 2.9 8.0 6.0 0 0 0 0 0\n"
    "   0 0 0 0 0 0 0 0 0 0 0\n"
    "   1 photos/two.JPG\n"
    "   1 5.0 2.0 30.0 0.0 0.0 0.0\n"
    "   1 0.1 0.1 0.1 0.1 0.1 0.1\n"
    "\n"
    "   1 8.0 4.1 2.9 8.0 6.0 0 0 0 0 0\n"
    "   1 0 0 0 0 0 0 0 0 0 0\n"
    "\n"
    " 1001 0.5 0.5 0.0 -1.7 -1.7 0.01\n"
    "\n"
    " 2 1.0 1.0 0.1 0.01 0.01 0.01\n"
    "\n"
    " 1 2 800.5 600.25 0.1 0.1\n"
    " 0 2 700 500 0.1 0.1\n"
    " 0 1001 900 700 0.2 0.2\n"
    "\n"
    " 1 1 2\n";

TEST(Photomodeler, ExportIsRead) {
  ASSERT_TRUE(is_photomodeler(kExport));
  EXPECT_FALSE(is_photomodeler("collinea-adjustment 1\n"));
  const auto file = parse_photomodeler(kExport);
  ASSERT_TRUE(file) << file.error().message;
  const Block& block = file->block;
  const Camera& camera = block.cameras.at({0});
  EXPECT_TRUE(is<BrownOfMeasured>(camera.model));
  EXPECT_NEAR(camera.params[Camera::kF], 2000, 1e-9);    // 8 mm at 4 um
  EXPECT_NEAR(camera.params[Camera::kCx], 1025, 1e-9);   // 4.1 mm
  EXPECT_NEAR(camera.params[Camera::kK1], 0.32, 1e-12);  // 5e-3 * 64
  EXPECT_EQ(camera.params[Camera::kB1], 0);
  EXPECT_TRUE(file->corrected_cameras.contains({0}));
  EXPECT_EQ(block.images.at({0}).file, "one.JPG");
  EXPECT_EQ(block.images.at({1}).file, "two.JPG");
  const OmegaPhiKappa angles = omega_phi_kappa(pose_of(block, {0}).rotation);
  EXPECT_NEAR(angles.omega_deg, 1, 1e-9);
  EXPECT_NEAR(angles.phi_deg, 2, 1e-9);
  EXPECT_NEAR(angles.kappa_deg, 90, 1e-9);
  EXPECT_EQ(block.control.at({1001}).sigma_m, Eigen::Vector3d(0, 0, 0.01));
  ASSERT_EQ(block.observations.size(), 2u);
  EXPECT_EQ(block.observations[0].image, ImageId{0});
  EXPECT_EQ(block.control_observations.at(0).sigma_px, 0.2);
}

TEST(Photomodeler, SaysInWhichLineWhatIsWrong) {
  const auto with = [](std::string_view was, std::string_view is) {
    std::string text = kExport;
    text.replace(text.find(was), was.size(), is);
    const auto file = parse_photomodeler(text);
    return file ? std::string("read") : file.error().message;
  };
  EXPECT_NE(with("8.0 4.1 2.9 8.00 6.00", "0 4.1 2.9 8 6").find("focal length and format"), std::string::npos);
  EXPECT_NE(with(" 20 2000 1500", " 20").find("lacks width and height"), std::string::npos);
  EXPECT_NE(with("90.0 2.0 1.0", "x 2.0 1.0").find("line 7: not number, projection centre"), std::string::npos);
  EXPECT_NE(with(" 0 1001 900", " 5 1001 900").find("in an image that was not listed"), std::string::npos);
  EXPECT_NE(with("900 700 0.2 0.2", "900 700 0.2 0.3").find("standard deviations of the mark"), std::string::npos);
  EXPECT_NE(with("900 700 0.2 0.2", "900 700 0 0.2").find("standard deviations of the mark"), std::string::npos);
  EXPECT_NE(with("900 700 0.2 0.2", "900 700 -1 -1").find("standard deviations of the mark"), std::string::npos);
  EXPECT_NE(with(" 1 2 800.5", " 0 2 800.5").find("point 2 is marked twice in image 0"), std::string::npos);
  EXPECT_NE(with(" 1 2 800.5 600.25 0.1 0.1", " 0 1001 9 7 0.2 0.2").find("point 1001 is marked twice in image 0"),
            std::string::npos);
  EXPECT_NE(with("0.01\n\n 2 1.0", "0.01\n 1001 1 1 1 0 0 0\n\n 2 1.0").find("control point 1001 comes twice"),
            std::string::npos);
  EXPECT_NE(with("\n\n 1 2 800.5", "\n 2 1 1 1 0 0 0\n\n 1 2 800.5").find("object point 2 comes twice"),
            std::string::npos);
}

// SmartPoints state none; the third line states what image coordinates are worth in the project.
TEST(Photomodeler, MarksWithoutASigmaHaveThatOfTheProject) {
  const auto with = [](std::string_view project) {
    std::string text = kExport;
    const auto replace = [&](std::string_view was, std::string_view is) {
      text.replace(text.find(was), was.size(), is);
    };
    replace(" 1.0 0.1 10.0", project);
    replace("900 700 0.2 0.2", "900 700 0.0000 0.0000");
    replace("700 500 0.1 0.1", "700 500 0 0");
    const auto file = parse_photomodeler(text);
    EXPECT_TRUE(file) << file.error().message;
    const Block& block = file->block;
    EXPECT_EQ(block.control_observations.at(0).sigma_px, block.observations.at(0).sigma_px);
    EXPECT_EQ(block.observations.at(1).sigma_px, 0.1);
    return block.control_observations.at(0).sigma_px;
  };
  EXPECT_EQ(with(" 0.7 0.1 10.0"), 0.7);
  EXPECT_EQ(with(" 0.0 0.1 10.0"), 1);
}

TEST(Photomodeler, SurvivesTruncationAndGarbage) {
  read_damaged(kExport, [](const std::string& text) { (void)parse_photomodeler(text); });
}

TEST(MillimetreCamera, RoundTripIsExact) {
  for (const bool forward : {false, true}) {
    const MillimetreCamera mm{2272,           1704,   0.00319, 4e-4, 7.457, {3.6, 2.6}, {4.6e-3, -4.5e-5, -2e-6},
                              {-6e-5, -4e-5}, forward};
    const MillimetreCamera back = millimetre_camera(camera_of(mm), mm.pixel_height_mm);
    EXPECT_EQ(back.forward, forward);
    EXPECT_NEAR(back.focal_mm, mm.focal_mm, 1e-14);
    EXPECT_NEAR(back.off_aspect, mm.off_aspect, 1e-15);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(back.principal_mm[i], mm.principal_mm[i], 1e-14);
      EXPECT_NEAR(back.p[i], mm.p[i], 1e-18);
    }
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back.k[i], mm.k[i], 1e-16);
  }
}

// As the header says, with pixels that are not square, straight from its formulas.
TEST(MillimetreCamera, FormulasAreThoseOfTheHeader) {
  const MillimetreCamera mm{2272, 1704, 0.00319, 4e-4, 7.457, {3.6, 2.6}, {4.6e-3, -4.5e-5, -2e-6}, {-6e-5, -4e-5}};
  const Camera camera = camera_of(mm);
  const Eigen::Vector2d measured(300.25, 1500.75);
  const double x = (measured.x() * mm.pixel_height_mm - 3.6) * (1 + 4e-4), y = 2.6 - measured.y() * mm.pixel_height_mm;
  const double r2 = x * x + y * y, radial = r2 * (mm.k[0] + r2 * (mm.k[1] + r2 * mm.k[2]));
  const Eigen::Vector2d corrected(x + x * radial + mm.p[0] * (r2 + 2 * x * x) + 2 * mm.p[1] * x * y,
                                  y + y * radial + mm.p[1] * (r2 + 2 * y * y) + 2 * mm.p[0] * x * y);
  EXPECT_LT((normalized(camera, measured) - Eigen::Vector2d(corrected.x(), -corrected.y()) / mm.focal_mm).norm(),
            1e-14);
}

// Bolognesi T12 (table 9.2): a GoPro Hero 3+ as PhotoModeler calibrated it, in millimetres, and as he gave it to
// PhotoScan, in pixels: other parameters in the other direction.
const MillimetreCamera kGoProMillimetres{
    4000, 3000, 0.001566, 0, 2.742, {3.154, 2.325}, {0.0392300, 0.0006149, 0.0001640}, {-0.0002634, -0.0001167}};

Camera gopro_pixels() {
  Camera camera = ideal_camera(1702.38, 4000, 3000);  // fx
  camera.params[Camera::kK1] = -0.191453;
  camera.params[Camera::kK2] = 0.034744;
  camera.params[Camera::kK3] = -0.003290;
  return camera;
}

// Where the pixel units of his table come from: 1750.96 px (he states fx, fy of the converted polynomial beside the
// size of the format, 6.265 mm = 4000 px), 2014.05 and 1484.67 px (printed 2014.55, half a pixel more, and 148.74).
TEST(MillimetreCamera, GoProOfBolognesiT12InPixels) {
  const Camera camera = camera_of(kGoProMillimetres);
  EXPECT_NEAR(camera.focal_px(), 1750.96, 5e-3);
  EXPECT_NEAR(camera.params[Camera::kCx], 2014.05, 5e-3);
  EXPECT_NEAR(camera.params[Camera::kCy], 1484.67, 5e-3);
  EXPECT_NEAR(6.265 / kGoProMillimetres.pixel_height_mm, 4000, 1);
}

// The radius of a measured point, and where the converted polynomial has its ray: within 10 px up to 2.7 mm, 54 px at
// 3.13 mm, and beyond the fold of the polynomial nowhere (the text's own numbers there, 1733.0 and -6673.9, lie on the
// branch that comes back). The farthest it reaches are 1973.2 px, less than half the width: 11.9 % of the format have
// no ray.
TEST(MillimetreCamera, ConversionOfBolognesiT12) {
  MillimetreCamera radial = kGoProMillimetres;
  radial.p = {};
  radial.principal_mm = {};
  const Camera measured = camera_of(radial), converted = gopro_pixels();
  const auto converted_px = [&](double r_mm) -> std::optional<double> {
    const Eigen::Vector2d ray = normalized(measured, {r_mm / radial.pixel_height_mm, 0});
    const auto pixel = project(converted, ray.homogeneous());
    if (!pixel) return std::nullopt;
    return pixel->x() - converted.params[Camera::kCx];
  };
  const double table[][3] = {{1.0, 638.6, 628.4},
                             {2.0, 1277.1, 1281.1},
                             {2.35, 1500.6, 1507.5},
                             {2.7, 1724.1, 1723.1},
                             {3.13, 1998.7, 1945.1}};
  for (const auto& row : table) {
    EXPECT_NEAR(row[0] / radial.pixel_height_mm, row[1], 0.051);
    ASSERT_TRUE(converted_px(row[0])) << row[0];
    EXPECT_NEAR(*converted_px(row[0]), row[2], 0.051);
  }
  EXPECT_FALSE(converted_px(3.5));
  EXPECT_FALSE(converted_px(3.9));
  double farthest = 0, at = 0;
  for (double x = 1.5; x < 2.5; x += 1e-4)
    if (const auto pixel = project(converted, {x, 0, 1}); pixel && pixel->x() - 2000 > farthest)
      farthest = pixel->x() - 2000, at = x;
  EXPECT_NEAR(farthest, 1973.2, 0.05);
  EXPECT_NEAR(at, 2.007, 5e-4);
  EXPECT_NEAR(std::atan(at) * 180 / std::acos(-1.0), 63.5, 0.05);
  int outside = 0, cells = 0;
  for (double x = 5; x < 4000; x += 10)
    for (double y = 5; y < 3000; y += 10, ++cells) outside += std::hypot(x - 2000, y - 1500) > farthest;
  EXPECT_NEAR(100.0 * outside / cells, 11.9, 0.05);
}

// The field of view by PhotoModeler's polynomial: 122.6 x 94.5 degrees, 146.6 over the diagonal.
TEST(MillimetreCamera, FieldOfViewOfBolognesiT12) {
  MillimetreCamera radial = kGoProMillimetres;
  radial.p = {};
  radial.principal_mm = {2000 * radial.pixel_height_mm, 1500 * radial.pixel_height_mm};
  const Camera camera = camera_of(radial);
  const auto degrees = [&](const Eigen::Vector2d& corner) {
    return 2 * std::atan(normalized(camera, corner).norm()) * 180 / std::acos(-1.0);
  };
  EXPECT_NEAR(degrees({4000, 1500}), 122.6, 0.05);
  EXPECT_NEAR(degrees({2000, 3000}), 94.5, 0.05);
  EXPECT_NEAR(degrees({4000, 3000}), 146.6, 0.05);
}

}  // namespace
}  // namespace collinea
