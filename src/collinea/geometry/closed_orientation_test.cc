// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/closed_orientation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
constexpr ClosedForm kForms[] = {ClosedForm::kUmeyama, ClosedForm::kQuaternion, ClosedForm::kRodrigues};

Vector3d normal(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

// A covariance with correlations, of standard deviations that differ by a factor of three.
Matrix3d covariance_like(double sigma, Random& random) {
  Matrix3d root;
  root << 1, 0, 0, 0.5, 0.8, 0, -0.3, 0.4, 1;
  const double size = sigma * random.uniform(0.5, 1.5);
  return size * size * root * root.transpose();
}

struct Survey {
  Similarity3 truth;
  std::vector<AbsoluteControl> pairs;

  Survey(std::uint64_t seed, std::size_t count, double turn, double sigma) {
    Random random(seed);
    truth = {2.5, rotation_by(turn * normal(random).normalized()), {1e4, 2e4, 300}};
    for (std::size_t i = 0; i < count; ++i) {
      AbsoluteControl pair;
      pair.in_model = 40 * normal(random) + Vector3d(100, -50, 20);
      pair.in_ground = truth * pair.in_model;
      pair.model_covariance = covariance_like(sigma / 2.5, random);
      pair.ground_covariance = covariance_like(sigma, random);
      pair.in_model += pair.model_covariance.llt().matrixL() * normal(random);
      pair.in_ground += pair.ground_covariance.llt().matrixL() * normal(random);
      pairs.push_back(pair);
    }
  }
  [[nodiscard]] double chi_squared(const AbsoluteOrientation& found) const {
    Eigen::Matrix<double, 7, 1> error;
    const Eigen::AngleAxisd turn(found.ground_from_model.rotation * truth.rotation.conjugate());
    error << found.ground_from_model * found.centroid_in_model - truth * found.centroid_in_model,
        turn.angle() * turn.axis(), std::log(found.ground_from_model.scale / truth.scale);
    return error.dot(found.covariance.ldlt().solve(error));
  }
};

// Rotations by 20 to 175 degrees. 400 seeds: the mean of chi-squared/7 scatters by sqrt(2/7/400) = 0.027, of its share
// below the 95 % bound by 0.011, of sigma0^2 by sqrt(2/17/400) = 0.017, of 24 w^2 by no more than sqrt(2/17/400)
// either: four of each.
TEST(ClosedOrientation, CovariancesMatchTheRealErrors) {
  for (const ClosedForm form : kForms) {
    constexpr int kSeeds = 400;
    double sum = 0, squares = 0, tests = 0;
    int inside = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      const Survey survey(static_cast<std::uint64_t>(seed), 8, 0.35 + 2.7 * seed / kSeeds, 0.05);
      const auto found = closed_orientation(survey.pairs, form);
      ASSERT_TRUE(found);
      const double chi2 = survey.chi_squared(*found);
      sum += chi2 / 7;
      inside += chi2 < 14.067;
      squares += found->sigma0 * found->sigma0;
      double redundancy = 0;
      for (const ControlResidual& residual : found->residuals) {
        tests += residual.w.squaredNorm() / 24;
        redundancy += residual.redundancy.sum();
      }
      EXPECT_NEAR(redundancy, 17, 1e-9);
    }
    EXPECT_NEAR(sum / kSeeds, 1, 0.108) << int(form);
    EXPECT_NEAR(double(inside) / kSeeds, 0.95, 0.044) << int(form);
    EXPECT_NEAR(squares / kSeeds, 1, 0.068) << int(form);
    EXPECT_NEAR(tests / kSeeds, 1, 0.068) << int(form);
  }
}

// An error that all points of the model share (a bend) is in the covariance only where it is stated.
TEST(ClosedOrientation, TheFullCovarianceOfTheModelCounts) {
  constexpr int kSeeds = 400;
  double with = 0, without = 0, squares = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Survey survey(static_cast<std::uint64_t>(seed), 8, 1, 0.02);
    const auto size = static_cast<Eigen::Index>(3 * survey.pairs.size());
    Eigen::VectorXd bend = Eigen::VectorXd::Zero(size);
    MatrixXd full = MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < survey.pairs.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      full.block<3, 3>(at, at) = survey.pairs[i].model_covariance;
      bend[at + 2] = 0.1 * std::pow(survey.pairs[i].in_model.x() / 100, 2);
    }
    full += bend * bend.transpose();
    const double amount = Random(static_cast<std::uint64_t>(seed) + 5000).normal();
    for (std::size_t i = 0; i < survey.pairs.size(); ++i)
      survey.pairs[i].in_model.z() += amount * bend[Eigen::Index(3 * i + 2)];
    const auto whole = closed_orientation(survey.pairs, ClosedForm::kUmeyama, &full);
    const auto single = closed_orientation(survey.pairs, ClosedForm::kUmeyama);
    ASSERT_TRUE(whole && single);
    with += survey.chi_squared(*whole) / 7 / kSeeds;
    without += survey.chi_squared(*single) / 7 / kSeeds;
    squares += whole->sigma0 * whole->sigma0 / kSeeds;
  }
  EXPECT_NEAR(with, 1, 0.108);
  EXPECT_GT(without, 1.5);
  EXPECT_NEAR(squares, 1, 0.068);
}

// Where all points are as good as each other in all directions the closed form is the least squares one.
TEST(ClosedOrientation, EqualWeightsGiveWhatLeastSquaresGives) {
  Survey survey(3, 6, 1, 1e-6);
  for (AbsoluteControl& pair : survey.pairs) {
    pair.model_covariance.setZero();
    pair.ground_covariance = 1e-12 * Matrix3d::Identity();
  }
  const auto least = absolute_orientation(survey.pairs);
  ASSERT_TRUE(least);
  for (const ClosedForm form : {ClosedForm::kUmeyama, ClosedForm::kQuaternion}) {
    const auto closed = closed_orientation(survey.pairs, form);
    ASSERT_TRUE(closed);
    EXPECT_LT((closed->covariance - least->covariance).norm(), 1e-6 * least->covariance.norm());
    EXPECT_NEAR(closed->sigma0, least->sigma0, 1e-6 * least->sigma0);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_LT((closed->residuals[i].w - least->residuals[i].w).norm(), 1e-3) << i;
  }
}

TEST(ClosedOrientation, ThreePointsAreEnoughAndALineIsNot) {
  for (const ClosedForm form : kForms) {
    const Survey survey(1, 3, 1, 0.01);
    const auto found = closed_orientation(survey.pairs, form);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->redundancy, 2);
    std::vector<AbsoluteControl> line(4);
    for (std::size_t i = 0; i < line.size(); ++i) line[i].in_model = line[i].in_ground = double(i) * Vector3d(1, 2, 3);
    EXPECT_FALSE(closed_orientation(line, form));
    auto exact = survey.pairs;
    exact[1].model_covariance.setZero();
    exact[1].ground_covariance.setZero();
    EXPECT_FALSE(closed_orientation(exact, form));
  }
}

}  // namespace
}  // namespace collinea
