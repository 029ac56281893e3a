// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation_derivatives.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Matrix3d matrix_of(const VectorXd& p, const CardanAngles&) { return rotation_matrix(CardanAngles{p[0], p[1], p[2]}); }
Matrix3d matrix_of(const VectorXd& p, const EulerAngles&) { return rotation_matrix(EulerAngles{p[0], p[1], p[2]}); }
Matrix3d matrix_of(const VectorXd& p, const TopographicAngles&) {
  return rotation_matrix(TopographicAngles{p[0], p[1], p[2]});
}
Matrix3d matrix_of(const VectorXd& p, const GeodeticAngles&) {
  return rotation_matrix(GeodeticAngles{p[0], p[1], p[2]});
}
Matrix3d matrix_of(const VectorXd& p, const RodriguesParameters&) {
  return rotation_matrix(RodriguesParameters{p[0], p[1], p[2]});
}
Matrix3d matrix_of(const VectorXd& p, const Eigen::Quaterniond&) {
  return rotation_matrix(Eigen::Quaterniond(p[0], p[1], p[2], p[3]));
}
Matrix3d matrix_of(const VectorXd& p, const Matrix3d&) {
  return *rotation_nearest_to(p.reshaped<Eigen::RowMajor>(3, 3));
}

// Central differences of step 1e-6 are good to 1e-9 of angles and parameters of size 1.
template <class Form>
void expect_turn(const VectorXd& parameters, const Form& form, const MatrixXd& turn) {
  constexpr double kStep = 1e-6;
  const Matrix3d rotation = matrix_of(parameters, form);
  for (Eigen::Index k = 0; k < parameters.size(); ++k) {
    const VectorXd step = kStep * VectorXd::Unit(parameters.size(), k);
    const Matrix3d by =
        (matrix_of(parameters + step, form) - matrix_of(parameters - step, form)) / (2 * kStep) * rotation.transpose();
    EXPECT_LT((turn.col(k) - Eigen::Vector3d(by(2, 1), by(0, 2), by(1, 0))).norm(), 1e-8) << k;
  }
}

TEST(RotationDerivatives, EveryFormAgreesWithDifferences) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const double a = random.uniform(-3, 3), b = random.uniform(0.2, 1.4), c = random.uniform(-3, 3);
    const VectorXd three = Eigen::Vector3d(a, b, c);
    expect_turn(three, CardanAngles{}, turn_by(CardanAngles{a, b, c}));
    expect_turn(three, EulerAngles{}, turn_by(EulerAngles{a, b, c}));
    expect_turn(three, TopographicAngles{}, turn_by(TopographicAngles{a, b, c}));
    expect_turn(three, RodriguesParameters{}, turn_by(RodriguesParameters{a, b, c}));
    expect_turn(Eigen::Vector3d(b, a, c), GeodeticAngles{}, turn_by(GeodeticAngles{b, a, c}));
    const Eigen::Quaterniond q(a, b, c, 1.5);
    expect_turn(Eigen::Vector4d(a, b, c, 1.5), q, turn_by(q));
    const Matrix3d matrix = rotation_matrix(CardanAngles{a, b, c});
    expect_turn(matrix.reshaped<Eigen::RowMajor>(), matrix, turn_by(matrix));
    const Eigen::Quaterniond unit = unit_quaternion(matrix);
    EXPECT_LT((turn_by(unit) * by_rotation(unit) - Matrix3d::Identity()).norm(), 1e-13);
    EXPECT_LT((turn_by(matrix) * by_rotation(matrix) - Matrix3d::Identity()).norm(), 1e-13);
  }
}

TEST(RotationDerivatives, SingularAttitudesHaveNoInverse) {
  EXPECT_LT(std::abs(turn_by(CardanAngles{0.3, M_PI / 2, 0.1}).determinant()), 1e-15);
  EXPECT_LT(std::abs(turn_by(EulerAngles{0.3, 0, 0.1}).determinant()), 1e-15);
}

}  // namespace
}  // namespace collinea
