// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/precision_layers.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(ErrorEllipse, HasTheAxesAndTheAzimuthOfItsCovariance) {
  const ErrorEllipse north = error_ellipse(Eigen::Vector2d(0.01, 0.04).asDiagonal());
  EXPECT_NEAR(north.semi_major_m, 0.2, 1e-12);
  EXPECT_NEAR(north.semi_minor_m, 0.1, 1e-12);
  EXPECT_NEAR(north.azimuth_deg, 0, 1e-9);
  EXPECT_NEAR(error_ellipse(Eigen::Vector2d(0.04, 0.01).asDiagonal()).azimuth_deg, 90, 1e-9);
  const Eigen::Matrix2d north_east = (Eigen::Matrix2d() << 2, 1, 1, 2).finished();
  EXPECT_NEAR(error_ellipse(north_east).azimuth_deg, 45, 1e-9);
  const Eigen::Matrix2d south_east = (Eigen::Matrix2d() << 2, -1, -1, 2).finished();
  EXPECT_NEAR(error_ellipse(south_east).azimuth_deg, 135, 1e-9);
  EXPECT_TRUE(std::isnan(error_ellipse(Eigen::Matrix2d::Constant(std::nan(""))).semi_major_m));
}

// Of 4000 positions with that covariance 95 % lie inside, within four standard deviations of that share.
TEST(ErrorEllipse, ItsOutlineHoldsNineteenOfTwenty) {
  const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << 4e-4, -2.5e-4, -2.5e-4, 9e-4).finished();
  const Eigen::Vector3d centre(100, 200, 30);
  const auto outline = ellipse_outline(centre, error_ellipse(covariance), 10);
  const Eigen::LLT<Eigen::Matrix2d> root(covariance);
  Random random(4);
  constexpr int kTrials = 4000;
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double a = random.normal(), b = random.normal();
    const Eigen::Vector2d standard = root.matrixL() * Eigen::Vector2d(a, b), error = 10 * standard;
    bool is_inside = true;  // of the convex outline, whichever way round it goes
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d from = (outline[i] - centre).head<2>(),
                            to = (outline[(i + 1) % outline.size()] - centre).head<2>();
      const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
        return p.x() * q.y() - p.y() * q.x();
      };
      is_inside &= cross(to - from, error - from) * cross(to - from, -from) >= 0;
    }
    held += is_inside;
  }
  EXPECT_NEAR(held / double(kTrials), 0.95, 4 * std::sqrt(0.05 * 0.95 / kTrials) + 0.003);  // 36 corners cut a little
}

TEST(PrecisionLayers, EllipsesAndResidualsAreEnlargedByARoundFactorThatIsStated) {
  AdjustmentReport report;
  AdjustmentProducts products;
  report.block.images[{0}] = {.file = "a.jpg"};
  report.block.control[{7}].name = "G7";
  ControlDifference difference;
  difference.point = {7};
  difference.used = true;
  difference.difference_m = {0.02, -0.01, 0.04};
  report.adjusted.positions.push_back({{0}, {0.03, 0, std::nan("")}});
  ProductImage image{};
  image.image = {0};
  image.centre_m = {0, 0, 100};
  image.covariance_m2 = 4e-4 * Eigen::Matrix3d::Identity();
  products.images.push_back(image);
  products.control.push_back({&difference, {90, 120, 3}, 1e-4 * Eigen::Matrix3d::Identity()});
  ProductPoint unknown{};
  unknown.position_m = {50, 50, 0};
  unknown.covariance_m2.setConstant(std::nan(""));
  products.points.push_back(unknown);
  const auto layers = precision_layers(report, products);
  ASSERT_EQ(layers.size(), 2u);
  EXPECT_EQ(layers[0].name, "error_ellipses");
  ASSERT_EQ(layers[0].rows.size(), 2u);  // nothing is drawn of what is not known
  EXPECT_TRUE(layers[0].style);
  const double times = std::get<double>(layers[0].rows[0].values.back());
  // The block is 150 m across, a thirtieth of that 5 m; the median ellipse at 95 % has 2.448 * 1.5 cm.
  EXPECT_EQ(times, 100);
  EXPECT_NE(layers[0].description.find("100 times"), std::string::npos) << layers[0].description;
  EXPECT_EQ(layers[1].name, "residuals");
  ASSERT_EQ(layers[1].rows.size(), 2u);
  const VectorRow& control = layers[1].rows[0];
  const double enlarged = std::get<double>(control.values.back());
  EXPECT_EQ(std::get<std::string>(control.values[1]), "G7");
  EXPECT_NEAR(std::get<double>(control.values[2]), -0.02, 1e-12);
  EXPECT_LT((control.positions[1] - control.positions[0] - enlarged * Eigen::Vector3d(-0.02, 0.01, 0)).norm(), 1e-9);
}

TEST(PrecisionLayers, NothingKnownIsNoLayer) { EXPECT_TRUE(precision_layers({}, {}).empty()); }

}  // namespace
}  // namespace collinea
