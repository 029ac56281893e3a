// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/projection_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

Matrix3d calibration() {
  Matrix3d k;
  k << 3000, 12, 2010, 0, 2950, 1490, 0, 0, 1;
  return k;
}

struct Truth {
  Rigid3 cam_from_object;
  Matrix34 matrix;
  std::vector<ProjectedPoint> points;

  Truth(std::uint64_t seed, int count, double sigma, bool is_plane = false) {
    Random random(seed);
    cam_from_object = {rotation_by(scene::random_vector(random, 0.5)), {0.4, -0.3, 12}};
    matrix << calibration() * cam_from_object.rotation.toRotationMatrix(), calibration() * cam_from_object.translation;
    for (int i = 0; i < count; ++i) {
      ProjectedPoint point;
      point.in_object = scene::random_vector(random, 3);
      if (is_plane) point.in_object.z() = 0;
      point.in_image = (matrix * point.in_object.homogeneous()).hnormalized() + scene::noise(random, sigma);
      point.sigma = sigma > 0 ? sigma : 1;
      points.push_back(point);
    }
  }
  [[nodiscard]] Matrix34 unit() const { return matrix / matrix.norm(); }
};

TEST(ProjectionMatrix, ExactPointsGiveInteriorAndExteriorOrientation) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Truth truth(seed, 6 + int(seed % 5), 0);
    const auto fit = fit_projection(truth.points);
    ASSERT_TRUE(fit);
    const auto parts = decomposed(fit->matrix);
    ASSERT_TRUE(parts);
    EXPECT_LT((parts->calibration - calibration()).norm(), 1e-3);
    EXPECT_LT(angle_between(parts->cam_from_object.rotation, truth.cam_from_object.rotation), 1e-7);
    EXPECT_LT((*projection_centre(fit->matrix) - centre_of(truth.cam_from_object)).norm(), 1e-5);
    const Vector3d ray = *ray_of(fit->matrix, truth.points[0].in_image);
    EXPECT_LT(scene::angle_between_vectors(ray, truth.points[0].in_object - centre_of(truth.cam_from_object)), 1e-8);
  }
}

// 11 degrees of freedom: the error of the matrix across itself over its covariance.
TEST(ProjectionMatrix, CovariancesMatchTheRealErrors) {
  for (const bool is_plane : {false, true}) {
    constexpr int kSeeds = 300;
    const int freedom = is_plane ? 8 : 11;
    double sum = 0, squares = 0, tests = 0;
    int inside = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      const Truth truth(static_cast<std::uint64_t>(seed), 16, 0.5, is_plane);
      const auto fit = is_plane ? fit_plane_projection(truth.points) : fit_projection(truth.points);
      ASSERT_TRUE(fit);
      Eigen::Matrix<double, 3, Eigen::Dynamic> real = truth.matrix;
      if (is_plane) {
        real.resize(3, 3);
        real << truth.matrix.col(0), truth.matrix.col(1), truth.matrix.col(3);
      }
      real /= real.norm();
      const Eigen::Matrix<double, Eigen::Dynamic, 3> error = (fit->matrix - real).transpose();
      const Eigen::Map<const Eigen::VectorXd> stacked(error.data(), error.size());
      const Eigen::VectorXd unit = fit->covariance.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd scaled = unit.asDiagonal() * fit->covariance * unit.asDiagonal();
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse(scaled);
      inverse.setThreshold(1e-9);
      EXPECT_EQ(inverse.rank(), freedom);
      const Eigen::VectorXd e = unit.asDiagonal() * stacked;
      const double chi2 = e.dot(inverse.solve(e));
      sum += chi2 / freedom;
      inside += chi2 < (is_plane ? 15.507 : 19.675);
      squares += fit->sigma0 * fit->sigma0;
      for (const Vector2d& w : fit->w) tests += w.squaredNorm() / 32;
    }
    EXPECT_NEAR(sum / kSeeds, 1, 0.1) << is_plane;
    EXPECT_NEAR(double(inside) / kSeeds, 0.95, 0.03);
    EXPECT_NEAR(squares / kSeeds, 1, 0.06);
    EXPECT_NEAR(tests / kSeeds, 1, 0.06);
  }
}

TEST(ProjectionMatrix, PlaneGivesThePoseOfAKnownCamera) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Truth truth(seed, 5, 0, true);
    const auto fit = fit_plane_projection(truth.points);
    ASSERT_TRUE(fit);
    const auto pose = pose_of_plane(fit->matrix, calibration());
    ASSERT_TRUE(pose);
    EXPECT_LT(angle_between(pose->rotation, truth.cam_from_object.rotation), 1e-7);
    EXPECT_LT((pose->translation - truth.cam_from_object.translation).norm(), 1e-5);
  }
}

TEST(ProjectionMatrix, PointsThatLeaveItOpenAreRefused) {
  EXPECT_FALSE(fit_projection(Truth(1, 5, 0).points));
  EXPECT_FALSE(fit_projection(Truth(1, 12, 0, true).points));
  EXPECT_FALSE(fit_plane_projection(Truth(1, 3, 0, true).points));
  Truth line(1, 8, 0, true);
  for (ProjectedPoint& point : line.points) {
    point.in_object.y() = 2 * point.in_object.x();
    point.in_image = (line.matrix * point.in_object.homogeneous()).hnormalized();
  }
  EXPECT_FALSE(fit_plane_projection(line.points));
  EXPECT_FALSE(decomposed(Matrix34::Zero()));
  EXPECT_FALSE(projection_centre(Matrix34::Zero()));
}

}  // namespace
}  // namespace collinea
