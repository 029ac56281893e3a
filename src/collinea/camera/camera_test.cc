// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <numbers>

#include "collinea/math/random.h"

namespace collinea {
namespace {

struct Tested {
  CameraModel model;
  AdditionalSet additional;
};

Camera distorted_camera(Tested tested) {
  Camera camera = ideal_camera(1000, 1200, 900);
  camera.model = tested.model;
  const std::array<double, Camera::kParams> values = {1000, 611, 447, -0.12, 0.05, -0.01, 0.002, -0.001, 3, 1.5, 0.004};
  for (const int k : params_of(camera)) camera.params[std::size_t(k)] = values[std::size_t(k)];
  camera.additional = tested.additional;
  Random random(7);
  for (std::size_t k = 0; k < count_of(camera.additional); ++k)
    camera.params[Camera::kParams + k] = random.uniform(-2, 2);
  return camera;
}

// Laws of every model of the list with every set of additional parameters: a model added to it is tested without
// another line here.
class CameraLaws : public ::testing::TestWithParam<Tested> {
 protected:
  const Camera camera = distorted_camera(GetParam());
};

std::vector<Tested> all_cameras() {
  std::vector<Tested> all;
  for (const CameraModel& model : kCameraModels)
    for (std::size_t a = 0; a < kAdditionalNames.size(); ++a) all.push_back({model, AdditionalSet(a)});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Models, CameraLaws, ::testing::ValuesIn(all_cameras()), [](const auto& tested) {
  return std::string(name_of(tested.param.model)) + "_" +
         std::string(kAdditionalNames[std::size_t(tested.param.additional)]);
});

TEST_P(CameraLaws, OpticalAxisMeetsThePrincipalPoint) {
  const Eigen::Vector2d principal(611, 447);
  const AdditionalShift shift =
      additional_shift(camera.additional, camera.params.data() + Camera::kParams, {1200, 900}, principal);
  EXPECT_EQ(*project(camera, {0, 0, 5}), principal + shift.shift_px);
}

TEST_P(CameraLaws, DistanceAlongTheRayDoesNotMatter) {
  EXPECT_LT((*project(camera, {0.2, 0.3, 1}) - *project(camera, {0.4, 0.6, 2})).norm(), 1e-9);
}

TEST_P(CameraLaws, PointsBehindHaveNoImage) {
  EXPECT_FALSE(project(camera, {0, 0, -1}));
  EXPECT_FALSE(project(camera, {0, 0, 0}));
  EXPECT_FALSE(project(camera, {NAN, 0, 1}));
}

TEST_P(CameraLaws, RaysAreThoseOfTheirPixels) {
  for (double column = 0; column <= 1200; column += 75)
    for (double row = 0; row <= 900; row += 75) {
      const Eigen::Vector3d ray = ray_in_cam(camera, {column, row});
      EXPECT_NEAR(ray.norm(), 1, 1e-12);
      const auto back = project(camera, 7 * ray);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Eigen::Vector2d(column, row)).norm(), 1e-8);
    }
}

TEST_P(CameraLaws, ParametersAreCalledByName) {
  for (const int k : params_of(camera)) EXPECT_EQ(param_named(camera, param_name(k)), k);
  for (int k = 0; k < Camera::kParams; ++k)
    EXPECT_EQ(param_named(camera, param_name(k)).has_value(), std::ranges::count(params_of(camera.model), k) == 1);
  EXPECT_EQ(params_of(camera).size(), params_of(camera.model).size() + count_of(camera.additional));
  EXPECT_TRUE(std::ranges::is_sorted(params_of(camera)));
}

TEST_P(CameraLaws, ModelsAreCalledByName) {
  const auto named = model_named(name_of(camera.model));
  ASSERT_TRUE(named);
  EXPECT_EQ(named->index(), camera.model.index());
  EXPECT_EQ(std::ranges::count(kCameraModelNames, name_of(camera.model)), 1);
}

// Every camera has a focal length, a principal point and an affinity; of the additional parameters only those of its
// set.
TEST_P(CameraLaws, DerivativesAreByTheParametersOfItsSet) {
  for (const int k : {Camera::kF, Camera::kCx, Camera::kCy, Camera::kB1, Camera::kB2})
    EXPECT_TRUE(param_named(camera, param_name(k)));
  Matrix23 by_point;
  Matrix2P by_params;
  ASSERT_TRUE(project(camera, {0.2, -0.1, 1}, &by_point, &by_params));
  const std::vector<int> has = params_of(camera);
  for (int k = Camera::kParams; k < Camera::kAllParams; ++k)
    EXPECT_TRUE(std::ranges::count(has, k) == 1 || by_params.col(k).isZero(0)) << k;
}

TEST(CameraModels, KannalaAndBrandtHaveAFourthCoefficientAndNoDecentring) {
  Camera camera = ideal_camera(1000, 1200, 900);
  EXPECT_TRUE(param_named(camera, "p1") && !param_named(camera, "k4"));
  camera.model = KannalaBrandt{};
  EXPECT_TRUE(!param_named(camera, "p1") && param_named(camera, "k4"));
  EXPECT_EQ(params_of(camera).size(), 9u);
}

TEST_P(CameraLaws, ResampledImagesHaveTheScaledCamera) {
  Camera half = camera;
  half.width_px /= 2;
  half.height_px /= 2;
  scale_params(half, 0.5);
  const Eigen::Vector3d point(0.3, -0.2, 1);
  EXPECT_LT((*project(half, point) - *project(camera, point) / 2).norm(), 1e-9);
}

// The polynomial of a lens of measured coordinates, taken as it stands in the report of another program, in mm: focal
// length 7.457 mm, a pixel of 0.0032 mm, y upwards, image coordinates from the principal point.
TEST(Camera, CorrectsMeasuredCoordinatesInMillimetres) {
  const double c = 7.457, pixel = 0.0032, k1 = 4.6e-3, k2 = -4.5e-5, k3 = -2e-6, p1 = -6.1e-5, p2 = -4.4e-5;
  Camera camera = ideal_camera(c / pixel, 2272, 1704);
  camera.model = BrownOfMeasured{};
  camera.params[Camera::kK1] = k1 * c * c;
  camera.params[Camera::kK2] = k2 * c * c * c * c;
  camera.params[Camera::kK3] = k3 * c * c * c * c * c * c;
  camera.params[Camera::kP1] = p1 * c;
  camera.params[Camera::kP2] = -p2 * c;                // y is turned round
  const double x = 2.9, y = -1.7, r2 = x * x + y * y;  // mm
  const double radial = r2 * (k1 + r2 * (k2 + r2 * k3));
  const double x_corrected = x + x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
  const double y_corrected = y + y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
  const Eigen::Vector2d measured(1136 + x / pixel, 852 - y / pixel);
  EXPECT_LT((normalized(camera, measured) - Eigen::Vector2d(x_corrected, -y_corrected) / c).norm(), 1e-14);
  const auto pixel_of = project(camera, {x_corrected, -y_corrected, c});
  ASSERT_TRUE(pixel_of);
  EXPECT_LT((*pixel_of - measured).norm(), 1e-9);
}

TEST(Camera, CorrectionsBeyondTheFoldHaveNoImage) {
  Camera camera = ideal_camera(1000, 1000, 1000);
  camera.model = BrownOfMeasured{};
  camera.params[Camera::kK1] = -0.3;  // grows until r = 1/sqrt(0.9), to 2/3 of that
  EXPECT_TRUE(project(camera, {0.6, 0, 1}));
  EXPECT_TRUE(project(camera, {0.70, 0, 1}));
  EXPECT_FALSE(project(camera, {0.71, 0, 1}));
  EXPECT_FALSE(project(camera, {5, 5, 1}));
}

TEST(Camera, PointsBeyondTheFoldHaveNoImage) {
  Camera camera = ideal_camera(1000, 1000, 1000);
  camera.params[Camera::kK1] = -0.3;  // grows until r = 1/sqrt(0.9)
  EXPECT_TRUE(project(camera, {1.0, 0, 1}));
  EXPECT_FALSE(project(camera, {1.1, 0, 1}));
  EXPECT_FALSE(project(camera, {5, 5, 1}));
}

TEST_P(CameraLaws, NormalizedUndoesProject) {
  for (double column = 0; column <= 1200; column += 75)
    for (double row = 0; row <= 900; row += 75) {
      const auto back = project(camera, normalized(camera, {column, row}).homogeneous());
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Eigen::Vector2d(column, row)).norm(), 1e-8);
    }
}

// Central differences of step h have error h^2/6 times the third derivative plus rounding 1e-16/h: 1e-6 relative is
// safe.
TEST_P(CameraLaws, DerivativesAgreeWithNumericOnes) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d point(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 4));
    Matrix23 by_point;
    Matrix2P by_params;
    ASSERT_TRUE(project(camera, point, &by_point, &by_params));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      const Eigen::Vector2d numeric = (*project(camera, point + step) - *project(camera, point - step)) / 2e-5;
      EXPECT_LT((numeric - by_point.col(k)).norm(), 1e-5);
    }
    for (const int k : params_of(camera)) {
      Camera plus = camera, minus = camera;
      plus.params[k] += 1e-5;
      minus.params[k] -= 1e-5;
      const Eigen::Vector2d numeric = (*project(plus, point) - *project(minus, point)) / 2e-5;
      EXPECT_LT((numeric - by_params.col(k)).norm(), 1e-5) << param_name(k);
    }
  }
}

// --- fisheyes --------------------------------------------------------------------------------------------------------

Camera fisheye(CameraModel model) {
  Camera camera = ideal_camera(400, 1400, 1400);
  camera.model = model;
  return camera;
}

std::vector<CameraModel> fisheyes() {
  std::vector<CameraModel> all;
  for (const CameraModel& model : kCameraModels)
    if (is_fisheye(model)) all.push_back(model);
  return all;
}

// The derivative and the inverse of each law. Central differences err by h^2/6 times the third derivative, which is
// below 100, and by rounding of 1e-11.
TEST(Fisheye, LawsAreInvertedAndDifferentiated) {
  for (const CameraModel& model : fisheyes())
    std::visit(
        []<class Model>(const Model&) {
          if constexpr (Model::kIsFisheye)
            for (const double t : {0.01, 0.4, 1.2, 1.7, 2.4}) {
              const FisheyeRadius radius = Model::radius(t);
              EXPECT_NEAR(Model::angle_rad(radius.g), t, 1e-12) << Model::kName;
              EXPECT_NEAR((Model::radius(t + 1e-5).g - Model::radius(t - 1e-5).g) / 2e-5, radius.by_angle, 1e-8);
              EXPECT_NEAR(2 * Model::kFocalPerDiagonal * Model::radius(std::numbers::pi / 2).g, 1, 1e-12);
            }
        },
        model);
}

TEST(Fisheye, RadiusIsThatOfItsLaw) {
  for (const double angle : {0.1, 0.7, 1.5, 1.7, 2.4}) {
    const Eigen::Vector3d point(std::sin(angle) * 0.6, std::sin(angle) * 0.8, std::cos(angle));
    const auto radius = [&](const Camera& camera) {
      return (*project(camera, 3 * point) - Eigen::Vector2d(700, 700)).norm();
    };
    EXPECT_NEAR(radius(fisheye(Equidistant{})), 400 * angle, 1e-9);
    EXPECT_NEAR(radius(fisheye(Equisolid{})), 800 * std::sin(angle / 2), 1e-9);
    Camera kannala = fisheye(KannalaBrandt{});
    kannala.params[Camera::kK1] = 0.03;
    kannala.params[Camera::kK4] = 1e-4;
    EXPECT_NEAR(radius(kannala), 400 * angle * (1 + 0.03 * angle * angle + 1e-4 * std::pow(angle, 8)), 1e-9);
  }
}

// Beyond a right angle from the axis there is an image still, and its rays point backwards.
TEST(Fisheye, SeesBehindItsPlane) {
  for (const CameraModel& model : fisheyes()) {
    const Camera camera = fisheye(model);
    const Eigen::Vector3d point(1, 0.3, -0.25);
    const auto pixel = project(camera, point);
    ASSERT_TRUE(pixel);
    EXPECT_LT((ray_in_cam(camera, *pixel) - point.normalized()).norm(), 1e-9);
    EXPECT_FALSE(in_plane(camera, *pixel));
    EXPECT_NEAR(normalized(camera, *pixel).norm(), std::tan(kWidestPlane_rad), 1e-9);
    EXPECT_NEAR(normalized(camera, *pixel).y() / normalized(camera, *pixel).x(), 0.3, 1e-9);
    Matrix23 by_point;
    ASSERT_TRUE(project(camera, point, &by_point, nullptr));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      EXPECT_LT(((*project(camera, point + step) - *project(camera, point - step)) / 2e-5 - by_point.col(k)).norm(),
                1e-5);
    }
  }
}

TEST(Fisheye, HasNoImageBeyondItsFold) {
  Camera camera = fisheye(KannalaBrandt{});
  camera.params[Camera::kK1] = -0.15;  // grows until 1 = 0.45 t^2, t = 1.49
  EXPECT_TRUE(project(camera, {std::sin(1.45), 0, std::cos(1.45)}));
  EXPECT_FALSE(project(camera, {std::sin(1.55), 0, std::cos(1.55)}));
}

// Pixels outside the image circle of a lens have no ray: they get the outermost one.
TEST(Fisheye, PixelsOutsideTheCircleHaveFiniteRays) {
  for (const CameraModel& model : fisheyes()) {
    Camera camera = fisheye(model);
    camera.params[Camera::kF] = 150;
    camera.params[Camera::kK1] = -0.03;
    EXPECT_TRUE(ray_in_cam(camera, {0, 0}).allFinite());
    EXPECT_TRUE(normalized(camera, {0, 0}).allFinite());
  }
}

TEST(Fisheye, PixelsPerUnitAreTheMeanStretch) {
  for (const CameraModel& model : fisheyes()) {
    const Camera camera = fisheye(model);
    for (const double t : {0.0, 0.3, 1.5, 4.0}) {
      const Eigen::Vector2d at(0.6 * t, -0.8 * t);
      Eigen::Matrix2d stretch;
      for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d step = 1e-5 * Eigen::Vector2d::Unit(k);
        stretch.col(k) = (*project(camera, Eigen::Vector2d(at + step).homogeneous()) -
                          *project(camera, Eigen::Vector2d(at - step).homogeneous())) /
                         2e-5;
      }
      EXPECT_NEAR(pixels_per_unit(camera, at), std::sqrt(std::abs(stretch.determinant())), 1e-4);
    }
  }
}

// --- additional parameters -------------------------------------------------------------------------------------------

// Ebner's twelve as they are printed, b = 1, of a square image.
TEST(Additional, EbnerIsThatOfHisPaper) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), k = x * x - 2.0 / 3, l = y * y - 2.0 / 3;
    const double dx[12] = {x, y, -2 * k, x * y, l, 0, x * l, 0, k * y, 0, k * l, 0};
    const double dy[12] = {-y, x, x * y, -2 * l, 0, k, 0, k * y, 0, x * l, 0, k * l};
    AdditionalEffect effect;
    additional_effect(AdditionalSet::kEbner, {1000, 1000}, {500 + 500 * x, 500 + 500 * y}, effect);
    for (std::size_t i = 0; i < 12; ++i) {
      EXPECT_NEAR(effect.column[i], dx[i], 1e-14) << i + 1;
      EXPECT_NEAR(effect.row[i], dy[i], 1e-14) << i + 1;
    }
  }
}

// At the positions they are made for, the functions are orthogonal to each other and to what shift, turn, scale and
// tilts of the image do; the sets are as large as the papers say.
TEST(Additional, FunctionsAreOrthogonalOnTheirPositions) {
  const std::pair<AdditionalSet, int> sets[] = {{AdditionalSet::kEbner, 3}, {AdditionalSet::kGruen, 5}};
  for (const auto& [set, side] : sets)
    for (const ImageExtent size : {ImageExtent{1000, 1000}, ImageExtent{1500, 1000}}) {
      const auto count = Eigen::Index(count_of(set));
      const int coordinates = 2 * side * side;
      Eigen::MatrixXd functions(coordinates, count + 6);
      for (int i = 0; i < side * side; ++i) {
        const double x = (2.0 * (i % side) / (side - 1) - 1) * size.width_px / 2;
        const double y = (2.0 * (i / side) / (side - 1) - 1) * size.height_px / 2;
        AdditionalEffect effect;
        additional_effect(set, size, {size.width_px / 2 + x, size.height_px / 2 + y}, effect);
        for (Eigen::Index k = 0; k < count; ++k) {
          functions(2 * i, k) = effect.column[std::size_t(k)];
          functions(2 * i + 1, k) = effect.row[std::size_t(k)];
        }
        const double u = x / 500, v = y / 500;
        functions.block<2, 6>(2 * i, count) << 1, 0, u, -v, u * u, u * v, 0, 1, v, u, u * v, v * v;
      }
      EXPECT_EQ(functions.colPivHouseholderQr().rank(), set == AdditionalSet::kEbner ? 18 : 50);
      const Eigen::MatrixXd products = functions.leftCols(count).transpose() * functions;
      for (Eigen::Index a = 0; a < count; ++a)
        for (Eigen::Index b = 0; b < count + 6; ++b) {
          if (a == b) continue;
          EXPECT_LT(std::abs(products(a, b)), 1e-12 * coordinates) << a << " " << b;
        }
    }
  EXPECT_EQ(count_of(AdditionalSet::kEbner), 12u);
  EXPECT_EQ(count_of(AdditionalSet::kGruen), 44u);
  EXPECT_EQ(count_of(AdditionalSet::kPolynomial), 14u);
  EXPECT_EQ(count_of(AdditionalSet::kFourier), 16u);
}

}  // namespace
}  // namespace collinea
