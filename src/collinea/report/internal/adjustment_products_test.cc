// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/adjustment_products.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/opk.h"

namespace collinea {
namespace {

constexpr double kSigma0 = 2;

// An image, a tie point and a check point 1.1 degrees of convergence away from the middle of the zone; what is
// uncertain is so along the east of the world.
AdjustmentReport report_of_one() {
  AdjustmentReport report;
  Block& block = report.block;
  block.georeference = Georeference{"EPSG:32633", 48.2, 16.5, 300};
  block.cameras[{0}] = ideal_camera(1500, 2000, 1500);
  block.cameras[{0}].name = "camera";
  block.images[{3}] = {"IMG, \"3\".jpg", CameraId{0}, "", {}, {}, 1};
  const Eigen::Quaterniond attitude = cam_from_world(OmegaPhiKappa{3, -2, 40});
  set_pose(block, {3}, {attitude, -(attitude * Eigen::Vector3d(20, 30, 80))});
  block.points[{7}].position_in_world = {5, 6, 7};
  block.observations = {{ImageId{3}, PointId{7}, 0, {100, 100}, 1}};
  block.control[{1}] = {"K1", ControlRole::kCheck, {}, {1, 2, 3}, {0.01, 0.01, 0.01}};
  Examined& adjusted = report.adjusted;
  adjusted.sigma0 = kSigma0;
  adjusted.redundancy = 10;
  adjusted.cam_from_world[{3}] = pose_of(block, {3});
  Matrix6d pose = Matrix6d::Zero();
  pose.diagonal() << 1e-6, 4e-6, 9e-6, 4e-4, 1e-4, 9e-4;
  adjusted.pose_covariance[{3}] = pose;
  adjusted.points = {{PointId{7}, {5, 6, 7}}};
  adjusted.point_covariance = {Eigen::Vector3d(4e-4, 0, 9e-4).asDiagonal()};
  adjusted.observations = {0};
  ControlDifference& check = adjusted.control.emplace_back();
  check.point = {1};
  check.rays = 4;
  check.position_in_world = Eigen::Vector3d(1.01, 2, 3);
  check.difference_m = {0.01, 0, 0};
  check.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
  return report;
}

TEST(AdjustmentProducts, AreInTheCoordinatesAndAlongTheAxesOfTheMap) {
  const AdjustmentReport report = report_of_one();
  const AdjustmentProducts products = products_of(report).value();
  const LocalFrame frame = world_frame(*report.block.georeference).value();
  ASSERT_EQ(products.images.size(), 1u);
  const ProductImage& image = products.images[0];
  EXPECT_LT((image.centre_m - frame.map_from_local(Eigen::Vector3d(20, 30, 80))).norm(), 1e-6);
  // The quaternion is the angles, and both differ from the world's by the convergence.
  EXPECT_LT(angle_between(image.cam_from_map, cam_from_world(image.angles)), 1e-12);
  EXPECT_GE(image.cam_from_map.w(), 0);
  const double convergence = std::atan(std::tan(1.5 * 3.14159265 / 180) * std::sin(48.2 * 3.14159265 / 180));
  EXPECT_NEAR(angle_between(image.cam_from_map, pose_of(report.block, {3}).rotation), convergence, 1e-4);
  // Turned by it, east gets a little of north.
  const double c = std::cos(convergence), s = std::sin(convergence);
  EXPECT_NEAR(image.covariance_m2(0, 0), kSigma0 * kSigma0 * (c * c * 4e-4 + s * s * 1e-4), 1e-8);
  EXPECT_NEAR(image.covariance_m2(2, 2), kSigma0 * kSigma0 * 9e-4, 1e-9);
  EXPECT_NEAR(image.covariance_m2.trace(), kSigma0 * kSigma0 * 14e-4, 1e-12);

  ASSERT_EQ(products.points.size(), 1u);
  EXPECT_LT((products.points[0].position_m - frame.map_from_local(Eigen::Vector3d(5, 6, 7))).norm(), 1e-6);
  EXPECT_NEAR(std::sqrt(products.points[0].covariance_m2(1, 1)), kSigma0 * 0.02 * s, 1e-6);
  EXPECT_NEAR(products.points[0].sigma_in_world_m.y(), 0, 1e-12);
  EXPECT_EQ(products.points[0].images, 1);
  ASSERT_EQ(products.control.size(), 1u);
  EXPECT_LT((products.control[0].position_m - frame.map_from_local(Eigen::Vector3d(1.01, 2, 3))).norm(), 1e-6);
}

TEST(AdjustmentProducts, TheGeoPackageHoldsThemAsGdalReadsIt) {
  const TestFolder folder;
  const AdjustmentReport report = report_of_one();
  const AdjustmentProducts products = products_of(report).value();
  const auto written = write_products(report, products, {}, folder / "a.gpkg");
  ASSERT_TRUE(written) << written.error().message;
  struct Close {
    void operator()(void* dataset) const { GDALClose(dataset); }
  };
  const std::unique_ptr<void, Close> file(
      GDALOpenEx((folder / "a.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const auto first = [&](const char* layer, auto&& look) {
    const OGRLayerH its = GDALDatasetGetLayerByName(file.get(), layer);
    ASSERT_TRUE(its) << layer;
    EXPECT_EQ(std::string(OSRGetAuthorityCode(OGR_L_GetSpatialRef(its), nullptr)), "32633");
    const OGRFeatureH feature = OGR_L_GetNextFeature(its);
    ASSERT_TRUE(feature) << layer;
    look([&](const char* name) { return OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, name)); },
         [&](const char* name) {
           return std::string(OGR_F_GetFieldAsString(feature, OGR_F_GetFieldIndex(feature, name)));
         },
         OGR_F_GetGeometryRef(feature));
    OGR_F_Destroy(feature);
  };
  first("images", [&](auto&& number, auto&& text, OGRGeometryH geometry) {
    EXPECT_EQ(text("file"), "IMG, \"3\".jpg");
    EXPECT_EQ(OGR_G_GetX(geometry, 0), products.images[0].centre_m.x());
    EXPECT_EQ(OGR_G_GetZ(geometry, 0), products.images[0].centre_m.z());
    EXPECT_EQ(number("kappa_deg"), products.images[0].angles.kappa_deg);
    EXPECT_EQ(number("qw"), products.images[0].cam_from_map.w());
    EXPECT_EQ(number("sigma_height_m"), std::sqrt(products.images[0].covariance_m2(2, 2)));
  });
  first("tie_points", [&](auto&& number, auto&&, OGRGeometryH geometry) {
    EXPECT_EQ(number("point"), 7);
    EXPECT_EQ(OGR_G_GetY(geometry, 0), products.points[0].position_m.y());
    EXPECT_EQ(number("sigma_east_m"), std::sqrt(products.points[0].covariance_m2(0, 0)));
  });
  first("control", [&](auto&& number, auto&& text, OGRGeometryH) {
    EXPECT_EQ(text("name"), "K1");
    EXPECT_EQ(text("role"), "check");
    EXPECT_EQ(number("difference_x_m"), 0.01);
  });
}

TEST(AdjustmentProducts, TablesAndJsonSayTheSame) {
  const AdjustmentReport report = report_of_one();
  const AdjustmentProducts products = products_of(report).value();
  const auto json = nlohmann::json::parse(products_json(report, products));
  EXPECT_EQ(json.at("crs"), "EPSG:32633");
  EXPECT_EQ(json.at("images").at(0).at("file"), "IMG, \"3\".jpg");
  EXPECT_EQ(json.at("points").at(0).size(), json.at("point_columns").size());
  EXPECT_EQ(json.at("points").at(0).at(0), 7);
  EXPECT_EQ(json.at("control_points").at(0).at("difference_m").at(0), 0.01);
  const std::string poses = poses_csv(report, products);
  EXPECT_NE(poses.find("\"IMG, \"\"3\"\".jpg\","), std::string::npos) << poses;
  EXPECT_NE(points_csv(products).find("\n7,5,6,7,"), std::string::npos) << points_csv(products);
}

TEST(AdjustmentProducts, EllipsesAreDrawnInAStatedScaleAndNothingIsDrawnOfNothing) {
  const AdjustmentReport report = report_of_one();
  const std::string html = precision_section(report, products_of(report).value());
  EXPECT_NE(html.find("class=\"ellipse"), std::string::npos);
  EXPECT_NE(html.find("plan, 50 mm"), std::string::npos) << html;  // of 2 x 3 cm in height
  EXPECT_EQ(html.find("nan"), std::string::npos);
  EXPECT_EQ(precision_section({}, {}), "");
  AdjustmentReport undetermined = report_of_one();
  undetermined.adjusted.pose_covariance.clear();
  undetermined.adjusted.point_covariance.clear();
  undetermined.adjusted.control[0].covariance_m2.reset();
  EXPECT_EQ(precision_section(undetermined, products_of(undetermined).value()), "");
}

}  // namespace
}  // namespace collinea
