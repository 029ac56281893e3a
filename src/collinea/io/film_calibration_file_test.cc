// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/film_calibration_file.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

// The certificate of the camera of the pair 27/28 of film_pairs.
constexpr const char* kExample = R"(# RC30, certificate
camera                 RC30 of the pair 27/28
principal_distance_mm  153.358
principal_point_mm     -0.006 0.006
radial_correction      0.8878e-4 -0.1528e-7 0.5256e-12
decentring_correction  0.1346e-6 0.1224e-7
mark_sigma_mm          0.002
mark 1  -105.997 -105.995  cross
mark 2   106.004  106.008        # upper right
mark 3  -106.000  106.009
)";

TEST(FilmCalibrationFile, ReadsACertificate) {
  const auto c = parse_film_calibration(kExample);
  ASSERT_TRUE(c) << c.error().message;
  EXPECT_EQ(c->camera, "RC30 of the pair 27/28");
  EXPECT_EQ(c->principal_distance_mm, 153.358);
  EXPECT_EQ(c->symmetry_point_mm, Eigen::Vector2d(-0.006, 0.006));
  EXPECT_EQ(c->radial[1], -0.1528e-7);
  ASSERT_EQ(c->marks.size(), 3u);
  EXPECT_EQ(c->marks[1].name, "2");
  EXPECT_EQ(c->marks[1].film_mm, Eigen::Vector2d(106.004, 106.008));
  EXPECT_EQ(c->marks[2].sigma_mm, 0.002);
  EXPECT_EQ(c->marks[0].kind, MarkKind::kCross);
  EXPECT_FALSE(c->marks[1].kind);
}

TEST(FilmCalibrationFile, WritesWhatItReads) {
  auto c = parse_film_calibration(kExample);
  ASSERT_TRUE(c);
  c->image_size_mm = Eigen::Vector2d(210.5, 212);
  const std::string text = text_of(*c);
  const auto again = parse_film_calibration(text);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(text_of(*again), text);
  EXPECT_EQ(again->camera, c->camera);
  EXPECT_EQ(again->radial, c->radial);
  EXPECT_EQ(again->decentring, c->decentring);
  EXPECT_EQ(again->symmetry_point_mm, c->symmetry_point_mm);
  EXPECT_EQ(again->image_size_mm, c->image_size_mm);
  ASSERT_EQ(again->marks.size(), 3u);
  EXPECT_EQ(again->marks[0].kind, MarkKind::kCross);
  EXPECT_EQ(again->marks[1].film_mm, c->marks[1].film_mm);
  EXPECT_EQ(again->marks[2].sigma_mm, 0.002);
}

TEST(FilmCalibrationFile, CoordinatesInBracketsAreNotDefined) {
  const auto c = parse_film_calibration(
      "principal_distance_mm 152\nmark 1 -112.004 (0) notch\nmark 2 (0.5) 112.001\nmark 3 1 2\n");
  ASSERT_TRUE(c) << c.error().message;
  ASSERT_EQ(c->marks.size(), 3u);
  EXPECT_EQ(c->marks[0].coordinates, MarkCoordinates::kX);
  EXPECT_EQ(c->marks[0].film_mm, Eigen::Vector2d(-112.004, 0));
  EXPECT_EQ(c->marks[1].coordinates, MarkCoordinates::kY);
  EXPECT_EQ(c->marks[1].film_mm.x(), 0.5);
  EXPECT_EQ(c->marks[2].coordinates, MarkCoordinates::kBoth);
  const auto again = parse_film_calibration(text_of(*c));
  ASSERT_TRUE(again) << again.error().message;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(again->marks[i].coordinates, c->marks[i].coordinates);
    EXPECT_EQ(again->marks[i].film_mm, c->marks[i].film_mm);
  }
  for (const char* bad : {"mark 1 (1) (2)", "mark 1 () 2", "mark 1 (1 2", "mark 1 (a) 2"})
    EXPECT_NE(parse_film_calibration(bad).error().message.find("line 1"), std::string::npos) << bad;
}

TEST(FilmCalibrationFile, ATableOfTheDistortionIsMinusTheCorrection) {
  const auto c = parse_film_calibration(
      "principal_distance_mm 152\nradial_distortion_um 50 2\nradial_distortion_um 100 -3\nradial_distortion_um 140 1\n"
      "symmetry_point_mm 0.01 0\n");
  ASSERT_TRUE(c) << c.error().message;
  const double off = corrected_mm(*c, {100.01, 0}).x() - 100.01;
  EXPECT_NEAR(off, 0.003, 1e-9);
  EXPECT_NEAR(c->radial_rms_mm, 0, 1e-9);
}

TEST(FilmCalibrationFile, ErrorsNameTheLineAndTheRemedy) {
  const auto message = [](const std::string& text) {
    const auto c = parse_film_calibration(text);
    return c ? std::string() : c.error().message;
  };
  EXPECT_NE(message("").find("principal_distance_mm"), std::string::npos);
  for (const char* bad : {"focal 152", "principal_distance_mm", "principal_distance_mm x", "principal_distance_mm -1",
                          "mark 1 2", "mark 1 2 nan", "mark 1 2 3 star", "mark 1 2 3\nmark 1 2 3", "camera a\ncamera b",
                          "radial_distortion_um -1 2", "radial_correction 1 2 3 4 5", "film_size_mm 0 230"})
    EXPECT_NE(message(bad).find("line "), std::string::npos) << bad << ": " << message(bad);
  const std::string good = "principal_distance_mm 152\n";
  EXPECT_NE(message(good + "radial_correction 1e-5\nradial_distortion_um 10 1\n").find("two forms"), std::string::npos);
  EXPECT_NE(message(good + "radial_distortion_um 0 1\n").find("radii"), std::string::npos);
  EXPECT_FALSE(read_film_calibration("/no/such/file"));
}

}  // namespace
}  // namespace collinea
