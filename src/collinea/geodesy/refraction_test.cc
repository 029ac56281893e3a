// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/refraction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

// The short form printed in textbooks, 13e-6 (H - h) (1 - 0.02 (2 H + h)), heights in km: good to a few per cent for
// flights below 9 km.
TEST(Refraction, AgreesWithTheShortFormula) {
  for (const double h : {0.0, 0.5, 1.5})
    for (const double camera : {2.0, 3.0, 5.0, 8.0}) {
      const double expected = 13e-6 * (camera - h) * (1 - 0.02 * (2 * camera + h));
      EXPECT_NEAR(refraction_rad(1000 * camera, 1000 * h), expected, 0.05 * expected) << camera << " " << h;
    }
}

// A ray through thin layers by Snell's law alone: what it is off the straight line, as an angle at the camera.
TEST(Refraction, IsThatOfARayThroughLayers) {
  const auto index = [](double z_km) {
    const double below = std::min(z_km, 11.0), t = 1 - 6.5 / 288.15 * below;
    return 1 + 277e-6 * std::pow(t, 4.2559) * std::exp(-(z_km - below) / 6.3416);
  };
  for (const double camera_km : {1.0, 5.0, 9.0, 14.0})
    for (const double angle : {0.2, 0.6, 1.0}) {
      constexpr int kLayers = 20000;
      const double sine = index(camera_km) * std::sin(angle), step = (camera_km - 0.4) / kLayers;
      double across = 0;
      for (int i = 0; i < kLayers; ++i) across += step * std::tan(std::asin(sine / index(0.4 + (i + 0.5) * step)));
      const double seen = angle - std::atan(across / (camera_km - 0.4));
      EXPECT_NEAR(refraction_rad(1000 * camera_km, 400) * std::tan(angle), seen, 0.002 * seen + 1e-10);
    }
}

TEST(Refraction, VanishesWithoutAWay) {
  EXPECT_EQ(refraction_rad(300, 300), 0);
  EXPECT_NEAR(refraction_rad(301, 300), 0, 3e-8);
  EXPECT_LT(refraction_rad(300, 3000), 0);  // looking up the air gets thinner
}

}  // namespace
}  // namespace collinea
