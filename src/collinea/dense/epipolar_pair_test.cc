// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/epipolar_pair.h"
#include "collinea/dense/stereo.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "collinea/dense/internal/pinhole.h"
#include "collinea/dense/internal/test_scene.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

Camera with_distortion() {
  Camera camera = ideal_camera(400, 400, 320);
  camera.params[Camera::kK1] = -0.05;
  camera.params[Camera::kCx] += 7;
  return camera;
}

EpipolarPair pair_of(const Block& block, std::uint32_t a, std::uint32_t b) {
  const auto pair = epipolar_pair(block.camera_of(ImageId{a}), pose_of(block, ImageId{a}), block.camera_of(ImageId{b}),
                                  pose_of(block, ImageId{b}));
  EXPECT_TRUE(pair) << pair.error().message;
  return *pair;
}

TEST(EpipolarPair, PointsLieInTheSameRowAndDisparityTellsTheirDepth) {
  const test::Scene scene = test::Scene::of_four({}, with_distortion());
  for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 0u}, {0u, 3u}, {2u, 3u}}) {
    const EpipolarPair pair = pair_of(scene.block, a, b);
    const dense::Pinhole left(pair.left), right(pair.right);
    for (const auto& [id, point] : scene.block.points) {
      const Eigen::Vector3d in_left = pair.left_from_world * point.position_in_world;
      const Eigen::Vector3d in_right =
          pair.right_from_image * (pose_of(scene.block, ImageId{b}) * point.position_in_world);
      const Eigen::Vector2d p = left.project(in_left), q = right.project(in_right);
      EXPECT_NEAR(p.y(), q.y(), 1e-9);
      EXPECT_NEAR(p.x() - q.x(), pair.disparity_at(in_left.z()), 1e-9);
      EXPECT_NEAR(pair.depth_at(p.x() - q.x()), in_left.z(), 1e-9);
    }
  }
}

TEST(EpipolarPair, KeepsTheSizeOfPixels) {
  const test::Scene scene = test::Scene::of_four({}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  EXPECT_NEAR(pair.left.focal_px(), 400, 10);
  EXPECT_NEAR(pair.base_m, 2, 1e-9);
}

TEST(EpipolarPair, CamerasThatLookAtEachOtherHaveNone) {
  const Camera camera = ideal_camera(200, 200, 160);
  const Rigid3 here, ahead{Eigen::Quaterniond::Identity(), {0, 0, -3}},
      beside{Eigen::Quaterniond::Identity(), {-3, 0, 0}};
  EXPECT_TRUE(epipolar_pair(camera, here, camera, beside));
  for (const Rigid3& other : {here, ahead}) {
    const auto pair = epipolar_pair(camera, here, camera, other);
    ASSERT_FALSE(pair);
    EXPECT_EQ(pair.error().code, Errc::kIllPosed);
  }
  const Rigid3 back{Eigen::Quaterniond(Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitY())), {-3, 0, 0}};
  EXPECT_FALSE(epipolar_pair(camera, here, camera, back));
}

TEST(EpipolarPair, TheRangeHoldsEveryTiePoint) {
  const test::Scene scene = test::Scene::of_four({.roof = 1.5}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  std::vector<Eigen::Vector3d> points;
  for (const auto& [id, point] : scene.block.points) points.push_back(point.position_in_world);
  const auto range = range_of(pair, points);
  ASSERT_TRUE(range);
  for (const Eigen::Vector3d& point : points) {
    const double disparity = pair.disparity_at((pair.left_from_world * point).z());
    EXPECT_GE(disparity, range->low);
    EXPECT_LE(disparity, range->high);
  }
  EXPECT_FALSE(range_of(pair, std::span(points).first(7)));
}

// From images to the cloud: a slope and a block on it, both lenses distorted.
TEST(EpipolarPair, TheCloudLiesOnTheSurface) {
  const test::Scene scene = test::Scene::of_four({.roof = 1.5, .noise = 2}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  const auto image = [&](std::uint32_t id) { return *scene.pixels()(ImageId{id}, 1); };
  const GreyImage left = resampled(image(0), with_distortion(), pair.left_from_image, pair.left, {});
  const GreyImage right = resampled(image(1), with_distortion(), pair.right_from_image, pair.right, {});
  std::vector<Eigen::Vector3d> points;
  for (const auto& [id, point] : scene.block.points) points.push_back(point.position_in_world);
  const auto range = range_of(pair, points);
  ASSERT_TRUE(range);
  const auto map = match_pair(left, right, *range, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  const auto cloud = cloud_of(pair, *map, {});
  ASSERT_GT(cloud.size(), 40'000u);
  double squares = 0, relative = 0;
  int good = 0, up = 0;
  for (const FusedPoint& point : cloud) {
    const Eigen::Vector3d& p = point.position_in_world;
    const bool on_roof = std::abs(p.x()) < 1 && std::abs(p.y()) < 0.8;
    const double off = p.z() - (on_roof ? 1.5 : 0.1 * p.x());
    if (std::abs(off) > 0.2) continue;
    ++good;
    up += point.normal_in_world.z() > 0.8f;
    squares += off * off;
    relative += std::pow(off / point.sigma, 2);
  }
  EXPECT_GT(good, 0.97 * double(cloud.size()));
  EXPECT_GT(up, 0.9 * good);
  // a tenth of a pixel of disparity: z^2 / (f b) = 12.5 cm a pixel
  EXPECT_LT(std::sqrt(squares / good), 0.0125 * 1.5);
  EXPECT_LT(std::sqrt(relative / good), 1.4);
}

// Karfis W9: a pair by its relative orientation, coordinates in mm, and the same in epipolar images.
struct PublishedPair {
  double c_mm, base_at_image_mm;
  std::array<double, 9> right_from_left, epipolar_from_left, epipolar_from_right;
  double by, bz, base;
  struct Row {
    Eigen::Vector2d left;
    double depth, depth_printed;  // over that of the first row; as printed, with its sign turned
    Eigen::Vector2d right, epipolar_left, epipolar_right;
    double px_mm, base_depth;
  };
  std::array<Row, 4> rows;
  double phi_deg = 0, kappa_deg = 0, omega_deg = 0;  // of the base
};

const PublishedPair kVolos{153.353,
                           582 / 6.8,
                           {0.9994332072, 0.0317482902, -0.0111942098, -0.0315516317, 0.9993519182, 0.0173273797,
                            0.0117370697, -0.0169643631, 0.9997872031},
                           {0.9992359765, 0.0381708143, -0.0083935822, -0.0380968390, 0.9992352732, 0.0088033838,
                            0.0087231957, -0.0084768889, 0.9999260214},
                           {0.9999754344, 0.0064731122, 0.0026887627, -0.0064497815, 0.9999422441, -0.0085970248,
                            -0.0027442569, 0.0085794716, 0.9999594300},
                           0.0382,
                           -0.0084,
                           1.000764607687542,
                           {{{{0, 0},
                              1,
                              1.791753,
                              {-83.826856, -3.207517},
                              {1.287276, -1.350125},
                              {-84.372737, -1.350125},
                              85.660014,
                              1.79162071},
                             {{80, 60},
                              1,
                              1.791753,
                              {-2.071617, 54.127716},
                              {83.625691, 55.629107},
                              {-2.140168, 55.629107},
                              85.765859,
                              1.78940963},
                             {{-20, -90},
                              1.05,
                              1.881341,
                              {-103.447910, -93.167428},
                              {-22.219819, -90.874696},
                              {-104.115061, -90.874696},
                              81.895242,
                              1.87398255},
                             {{100, -100},
                              0.95,
                              1.702166,
                              {8.472589, -108.208376},
                              {98.505827, -106.283172},
                              {7.314513, -106.283172},
                              91.191314,
                              1.68294817}}},
                           0.481273229,
                           2.187557996,
                           0.48605};

const PublishedPair kKea{152.52,
                         82.9,
                         {0.9989809981, -0.0451312892, -0.0003636471, 0.0451223582, 0.9985455404, 0.0295089239,
                          -0.0009686576, -0.0294952628, 0.9995644507},
                         {0.9989530215, -0.0449528860, -0.0084911007, 0.0450717366, 0.9988804420, 0.0143666657,
                          0.0078357713, -0.0147343328, 0.9998607404},
                         {0.9999669559, -0.0000629510, -0.0081291486, -0.0000601781, 0.9998852986, -0.0151454919,
                          0.0081291696, 0.0151454806, 0.9998522546},
                         -0.0450,
                         -0.0085,
                         1.0010480757685916,
                         {{{{0, 0},
                            1,
                            1.839807,
                            {-83.333569, -4.517426},
                            {1.295243, -2.191509},
                            {-81.703201, -2.191509},
                            82.998444,
                            1.83955079},
                           {{80, 60},
                            1,
                            1.839807,
                            {-5.676905, 58.602027},
                            {78.392852, 61.252600},
                            {-4.465845, 61.252600},
                            82.858698,
                            1.84265330},
                           {{-20, -90},
                            1.05,
                            1.931797,
                            {-97.047350, -97.428211},
                            {-14.753407, -93.723511},
                            {-94.410361, -93.723511},
                            79.656954,
                            1.91671719},
                           {{100, -100},
                            0.95,
                            1.747817,
                            {17.532139, -102.271057},
                            {107.288260, -99.051647},
                            {18.609007, -99.051647},
                            88.679253,
                            1.72170883}}},
                         0.487002397,
                         -2.576478882,
                         0.8451};

// A rotation between photographs (y up, z backward) as one between cameras, and a position of the image [mm].
Eigen::Matrix3d of_cameras(const std::array<double, 9>& rows) {
  const Eigen::Matrix3d turned = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return turned * Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data()) * turned;
}
Eigen::Vector2d photo_mm(const Eigen::Vector3d& in_camera, double c_mm) {
  return c_mm * Eigen::Vector2d(in_camera.x(), -in_camera.y()) / in_camera.z();
}

// The epipolar images of the text turn about the base by the mean of both omegas, ours look midway between the optical
// axes: a turn about x lies between them, after which everything is as printed. Half a unit of the last digit, and what
// ten digits of the rotations leave of 150 mm.
TEST(EpipolarPair, IsThatOfKarfisW9) {
  for (const PublishedPair& published : {kVolos, kKea}) {
    const Camera camera = ideal_camera(published.c_mm, 240, 240);  // a pixel is a millimetre
    const Eigen::Matrix3d right_from_left = of_cameras(published.right_from_left);
    Rigid3 right;
    right.rotation = Eigen::Quaterniond(right_from_left).normalized();
    right.translation = -(right.rotation * Eigen::Vector3d(1, -published.by, -published.bz));
    const auto pair = epipolar_pair(camera, Rigid3{}, camera, right);
    ASSERT_TRUE(pair) << pair.error().message;
    EXPECT_NEAR(pair->base_m, published.base, 1e-14);
    const Eigen::Matrix3d turn =
        pair->left_from_image.toRotationMatrix() * of_cameras(published.epipolar_from_left).transpose();
    EXPECT_LT((turn.col(0) - Eigen::Vector3d::UnitX()).norm(), 2e-10);
    EXPECT_LT((turn - pair->right_from_image.toRotationMatrix() * of_cameras(published.epipolar_from_right).transpose())
                  .norm(),
              5e-10);
    // His angles of the base, from ours (camera axes: y down, z forward), and R_b = R_omega R_kappa R_phi of them.
    const Eigen::Vector3d base = pair->left_from_image.toRotationMatrix().row(0);
    constexpr double kDegrees = 180 / std::numbers::pi;
    EXPECT_NEAR(-std::atan(-base.z() / base.x()) * kDegrees, published.phi_deg, 5e-10);
    EXPECT_NEAR(std::atan(-base.y() / std::hypot(base.x(), base.z())) * kDegrees, published.kappa_deg, 5e-10);
    const auto about = [&](const Eigen::Vector3d& axis, double deg) { return rotation_by(-deg / kDegrees * axis); };
    const Eigen::Quaterniond of_angles = about(Eigen::Vector3d::UnitX(), published.omega_deg) *
                                         about(Eigen::Vector3d::UnitZ(), published.kappa_deg) *
                                         about(Eigen::Vector3d::UnitY(), published.phi_deg);
    EXPECT_LT((of_angles.toRotationMatrix() -
               Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(published.epipolar_from_left.data()))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10);
    const dense::Pinhole left_pinhole(pair->left), right_pinhole(pair->right);
    for (const PublishedPair::Row& row : published.rows) {
      const double depth = row.depth * published.c_mm / published.base_at_image_mm;
      EXPECT_NEAR(depth, row.depth_printed, 5e-7);
      const Eigen::Vector3d point =
          depth * Eigen::Vector3d(row.left.x(), -row.left.y(), published.c_mm) / published.c_mm;
      EXPECT_LT((photo_mm(right * point, published.c_mm) - row.right).cwiseAbs().maxCoeff(), 5.5e-7);
      const Eigen::Vector2d p = left_pinhole.project(pair->left_from_image * point),
                            q = right_pinhole.project(pair->right_from_image * (right * point));
      EXPECT_NEAR(p.y(), q.y(), 1e-9);
      const Eigen::Vector3d found = turn.transpose() * (left_pinhole.ray(p.x(), p.y()) * pair->depth_at(p.x() - q.x()));
      const Eigen::Vector3d found_right = found - Eigen::Vector3d(pair->base_m, 0, 0);
      EXPECT_LT((photo_mm(found, published.c_mm) - row.epipolar_left).cwiseAbs().maxCoeff(), 5.5e-7);
      EXPECT_LT((photo_mm(found_right, published.c_mm) - row.epipolar_right).cwiseAbs().maxCoeff(), 5.5e-7);
      EXPECT_NEAR(photo_mm(found, published.c_mm).x() - photo_mm(found_right, published.c_mm).x(), row.px_mm, 5.5e-7);
      EXPECT_NEAR(found.z(), row.base_depth, 5.5e-9);
    }
  }
}

}  // namespace
}  // namespace collinea
