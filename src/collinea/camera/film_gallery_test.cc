// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_gallery.h"

#include <gtest/gtest.h>

#include "collinea/camera/film_fit.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// The marks 1 to 8 of an RC30 by its certificate (the pair 27/28): the nominal ones lie within their sigma of 0.02 mm.
const Vector2d kCertified[] = {{-105.997, -105.995}, {106.004, 106.008}, {-106.000, 106.009}, {106.012, -105.995},
                               {-112.000, 0.007},    {112.006, 0.007},   {0.005, 112.007},    {0.002, -111.998}};

TEST(FilmGallery, ACertificateOfAnRc30LiesWithinItsSigma) {
  const FilmCalibration c = nominal_calibration(FilmCameraType::kRc30);
  ASSERT_EQ(c.marks.size(), std::size(kCertified));
  for (std::size_t i = 0; i < c.marks.size(); ++i)
    EXPECT_LT((c.marks[i].film_mm - kCertified[i]).cwiseAbs().maxCoeff(), c.marks[i].sigma_mm) << c.marks[i].name;
}

TEST(FilmGallery, MarksOfEveryTypeDetermineAnAffinity) {
  for (const auto& entry : words(FilmCameraType{})) {
    const FilmCalibration c = nominal_calibration(entry.value);
    EXPECT_GE(c.marks.size(), 4u) << entry.word;
    EXPECT_EQ(c.principal_distance_mm, 0) << entry.word;
    std::vector<FilmMark> marks;
    for (const CalibratedMark& mark : c.marks)
      marks.push_back({.name = mark.name,
                       .film_mm = mark.film_mm,
                       .pixel = Vector2d(100 * mark.film_mm.x(), -90 * mark.film_mm.y())});
    const auto fit = fit_film(marks, FilmModel::kAffine, {});
    ASSERT_TRUE(fit) << entry.word;
    EXPECT_NEAR(fit->transformation.parameters[3], 100, 1e-9);
    EXPECT_NEAR(fit->transformation.parameters[4], 90, 1e-9);
  }
}

}  // namespace
}  // namespace collinea
