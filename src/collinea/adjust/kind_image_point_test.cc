// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/kind_image_point.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

using testing::normal3;
using testing::test_block;

struct LensCase {
  CameraModel model;
  AdditionalSet additional = AdditionalSet::kNone;
};

class LensOfModel : public ::testing::TestWithParam<LensCase> {};

TEST_P(LensOfModel, AgreesWithTheCamera) {
  Camera camera = testing::test_camera();
  camera.model = GetParam().model;
  camera.additional = GetParam().additional;
  camera.params[Camera::kB1] = 3;
  camera.params[Camera::kB2] = -2;
  Random values(9);
  for (std::size_t k = 0; k < count_of(camera.additional); ++k)
    camera.params[Camera::kParams + k] = values.uniform(-3, 3);
  const bundle::Lens lens = bundle::lens_of(camera, false);
  Random random(4);
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d point =
        normal3(random).cwiseProduct(Eigen::Vector3d(0.8, 0.6, 0)) + Eigen::Vector3d(0, 0, 1.7);
    Matrix23 by_point;
    Matrix2P by_params;
    const auto pixel = project(camera, point, &by_point, &by_params);
    bundle::Projected at{};
    const Eigen::Vector2d near = pixel.value_or(Eigen::Vector2d(1000, 750)) + Eigen::Vector2d(3, -2);
    const bool seen = bundle::project(lens, point.data(), near.data(), &at);
    if (seen != pixel.has_value()) {  // only on the very edge of the field of view, which they find in different ways
      const auto is_seen = [&](double stretch) {
        return project(camera, point.cwiseProduct(Eigen::Vector3d(stretch, stretch, 1))).has_value();
      };
      EXPECT_NE(is_seen(0.99), is_seen(1.01)) << point.transpose();
      continue;
    }
    if (!pixel) continue;
    ++compared;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> mine;
    Eigen::Matrix<double, 2, Camera::kAllParams, Eigen::RowMajor> mine_params;
    mine_params.setZero();
    bundle::derive_by_point(lens, at, point.z(), mine.data());
    bundle::derive_by_params(lens, at, mine_params.data());
    EXPECT_LT((*pixel - Eigen::Vector2d(at.pixel[0], at.pixel[1])).norm(), 1e-9);
    EXPECT_LT((by_point - mine).norm(), 1e-10 * by_point.norm());
    EXPECT_LT((by_params - mine_params).norm(), 1e-10 * by_params.norm());
  }
  EXPECT_GT(compared, 150);
  bundle::Projected at;
  const double behind[3] = {0, 0, -1}, middle[2] = {1000, 750};
  EXPECT_FALSE(bundle::project(lens, behind, middle, &at));
}

INSTANTIATE_TEST_SUITE_P(Lens, LensOfModel,
                         ::testing::Values(LensCase{Brown{}}, LensCase{BrownOfMeasured{}}, LensCase{Equidistant{}},
                                           LensCase{Equisolid{}}, LensCase{KannalaBrandt{}},
                                           LensCase{Brown{}, AdditionalSet::kGruen},
                                           LensCase{Equisolid{}, AdditionalSet::kFourier}),
                         [](const auto& tested) {
                           return std::string(name_of(tested.param.model)) + "_" +
                                  std::string(kAdditionalNames[std::size_t(tested.param.additional)]);
                         });

// The difference after correction, and its derivatives: those of the computed pixel are minus those of the difference.
TEST(Lens, ComparesAfterCorrection) {
  Camera camera = testing::test_camera();
  camera.model = BrownOfMeasured{};
  camera.params[Camera::kB1] = 3;
  camera.params[Camera::kB2] = -2;
  const Eigen::Vector3d point(0.5, -0.3, 1.4);
  const Eigen::Vector2d measured = *project(camera, point) + Eigen::Vector2d(1.5, -0.7);
  const auto difference = [&](const Camera& c, const Eigen::Vector3d& p) {
    bundle::Projected at;
    EXPECT_TRUE(bundle::project(bundle::lens_of(c, true), p.data(), measured.data(), &at));
    return Eigen::Vector2d(measured.x() - at.pixel[0], measured.y() - at.pixel[1]);
  };
  const Eigen::Vector2d expected = camera.focal_px() * (normalized(camera, measured) - point.head<2>() / point.z());
  EXPECT_LT((difference(camera, point) - expected).norm(), 1e-9);
  const bundle::Lens lens = bundle::lens_of(camera, true);
  bundle::Projected at;
  ASSERT_TRUE(bundle::project(lens, point.data(), measured.data(), &at));
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
  Eigen::Matrix<double, 2, Camera::kAllParams, Eigen::RowMajor> by_params;
  bundle::derive_by_point(lens, at, point.z(), by_point.data());
  bundle::derive_by_params(lens, at, by_params.data());
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d numeric = -(difference(camera, point + step) - difference(camera, point - step)) / 2e-6;
    EXPECT_LT((numeric - by_point.col(k)).norm(), 1e-4);
  }
  for (int k = 0; k < Camera::kParams; ++k) {
    const double h = k >= Camera::kK1 && k <= Camera::kP2 ? 1e-6 : 1e-3;
    Camera plus = camera, minus = camera;
    plus.params[std::size_t(k)] += h;
    minus.params[std::size_t(k)] -= h;
    const Eigen::Vector2d numeric = -(difference(plus, point) - difference(minus, point)) / (2 * h);
    EXPECT_LT((numeric - by_params.col(k)).norm(), 1e-6 * (1 + by_params.col(k).norm()))
        << Camera::kParamNames[std::size_t(k)];
  }
}

const PixelShape kShapes[] = {{}, {1.7F, 0}, {0.6F, -0.8F}};

TEST(Linearise, DerivativesAreThoseOfFiniteDifferences) {
  const Block block = test_block({.tilt_rad = 0.4});
  const Camera& camera = block.cameras.begin()->second;
  const bundle::Lens lens = bundle::lens_of(camera, false);
  const Observation& observation = block.observations.front();
  const Rigid3 pose = pose_of(block, observation.image);
  const Eigen::Vector3d centre = centre_of(pose), point = block.points.at(observation.point).position_in_world;
  for (const PixelShape& shape : kShapes) {
    const bundle::Ray ray{
        {observation.pixel.x() + 1, observation.pixel.y() - 2}, 0.5, 0, 0, bundle::whitening_of(shape)};
    const auto residual = [&](const Eigen::Vector3d& rotation, const Eigen::Vector3d& move,
                              const Eigen::Vector3d& shift) {
      bundle::LinearRay out;
      const Eigen::Vector3d moved_centre = centre + move, moved_point = point + shift;
      linearise(ray, bundle::frame_of(rotation_by(rotation) * pose.rotation, moved_centre.data()), lens,
                moved_point.data(), Loss{}, &out);
      return out;
    };
    const bundle::LinearRay at = residual({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
    const Eigen::Vector2d expected = shape.whitening() * Eigen::Vector2d(0.5, -1);
    EXPECT_NEAR(at.residual[0], expected[0], 1e-6);
    EXPECT_NEAR(at.residual[1], expected[1], 1e-6);
    EXPECT_NEAR(square_of(ray, bundle::frame_of(pose.rotation, centre.data()), lens, point.data()),
                expected.squaredNorm(), 1e-6);
    EXPECT_NEAR(expected.squaredNorm(),
                Eigen::Vector2d(0.5, -1).dot(shape.covariance().inverse() * Eigen::Vector2d(0.5, -1)), 1e-9);
    for (int c = 0; c < 3; ++c) {
      const double h = 1e-5;
      const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(c), zero = Eigen::Vector3d::Zero();
      const auto rotated = residual(e, zero, zero), back = residual(-e, zero, zero);
      const auto shifted = residual(zero, zero, e), shifted_back = residual(zero, zero, -e);
      const auto moved = residual(zero, e, zero), moved_back = residual(zero, -e, zero);
      for (int row = 0; row < 2; ++row) {
        EXPECT_NEAR(at.by_rotation[3 * row + c], -(rotated.residual[row] - back.residual[row]) / (2 * h), 1e-4);
        EXPECT_NEAR(at.by_point[3 * row + c], -(shifted.residual[row] - shifted_back.residual[row]) / (2 * h), 1e-5);
        EXPECT_NEAR(-at.by_point[3 * row + c], -(moved.residual[row] - moved_back.residual[row]) / (2 * h), 1e-5);
      }
    }
    // By the principal point both coordinates move alike.
    double by_camera[4];
    linearise_camera(at, lens, {Camera::kCx, Camera::kCy}, by_camera);
    const Eigen::Matrix2d by_pixel = 0.5 * shape.whitening();
    for (int row = 0; row < 2; ++row)
      for (int c = 0; c < 2; ++c) EXPECT_NEAR(by_camera[2 * row + c], by_pixel(row, c), 1e-6);
  }
}

TEST(Loss, WeightAndCurvatureAreDerivativesOfTheCost) {
  for (const auto& [kind, word, meaning] : kLossWords) {
    Loss loss{kind, 1.5};
    loss.least_curvature = -10;
    for (const double x : {0.4, 1.3, 1.7, 6.0}) {
      const double h = 1e-4, s = x * x;
      const auto cost = [&](double at) { return loss.cost(at * at); };
      EXPECT_NEAR(loss.weight(s), (cost(x + h) - cost(x - h)) / (2 * h) / (2 * x), 1e-6);
      EXPECT_NEAR(loss.weight(s) * loss.curvature(s), (cost(x + h) - 2 * cost(x) + cost(x - h)) / (2 * h * h), 1e-6);
    }
  }
  EXPECT_FALSE(from_word<Loss::Kind>("tukey"));
}

// The gradient is that of the cost whatever curvature is assumed; J^T r = -1/2 d(cost).
TEST(Linearise, GradientIsThatOfTheRobustCost) {
  const Block block = test_block();
  const bundle::Lens lens = bundle::lens_of(block.cameras.begin()->second, false);
  const Observation& observation = block.observations.front();
  const Rigid3 pose = pose_of(block, observation.image);
  const Eigen::Vector3d centre = centre_of(pose), point = block.points.at(observation.point).position_in_world;
  const bundle::Frame frame = bundle::frame_of(pose.rotation, centre.data());
  for (const PixelShape& shape : kShapes)
    for (const double least_curvature : {1.0, 0.1}) {
      const bundle::Ray ray{
          {observation.pixel.x() + 3, observation.pixel.y() - 5}, 0.5, 0, 0, bundle::whitening_of(shape)};
      const Loss loss{Loss::kCauchy, 1, least_curvature};
      bundle::LinearRay at;
      linearise(ray, frame, lens, point.data(), loss, &at);
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d e = 1e-5 * Eigen::Vector3d::Unit(c), ahead = point + e, back = point - e;
        const double slope = (loss.cost(square_of(ray, frame, lens, ahead.data())) -
                              loss.cost(square_of(ray, frame, lens, back.data()))) /
                             2e-5;
        EXPECT_NEAR(at.by_point[c] * at.residual[0] + at.by_point[3 + c] * at.residual[1], -slope / 2, 1e-5);
      }
    }
}
}  // namespace
}  // namespace collinea
