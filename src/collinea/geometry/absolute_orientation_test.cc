// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/absolute_orientation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "collinea/geometry/closed_similarity.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d random_vector(Random& random, double size) {
  return {size * random.normal(), size * random.normal(), size * random.normal()};
}

Matrix3d random_covariance(Random& random, double sigma) {
  Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i / 3, i % 3) = random.normal();
  return sigma * sigma * (0.3 * root * root.transpose() + 0.5 * Matrix3d::Identity());
}

Vector3d error_of(const Matrix3d& covariance, Random& random) {
  return covariance.llt().matrixL() * random_vector(random, 1);
}

// Points of a model, where they are on the ground without errors, and how well both are known.
struct Scene {
  Similarity3 truth;
  std::vector<AbsoluteControl> pairs;

  explicit Scene(std::uint64_t seed, int points = 8, double error = 1) {
    Random random(seed);
    truth = {std::exp(0.5 * random.normal()), rotation_by(random_vector(random, 1)),
             Vector3d(5e5, 5e6, 300) + random_vector(random, 10)};
    for (int i = 0; i < points; ++i) {
      AbsoluteControl pair;
      pair.in_model = random_vector(random, 100) + Vector3d(20, 30, 900);
      pair.in_ground = truth * pair.in_model;
      pair.model_covariance = error * error * random_covariance(random, 0.05);
      pair.ground_covariance = error * error * random_covariance(random, 0.03);
      pairs.push_back(pair);
    }
  }
  [[nodiscard]] std::vector<AbsoluteControl> measured(std::uint64_t seed) const {
    Random random(seed, 77);
    std::vector<AbsoluteControl> out = pairs;
    for (AbsoluteControl& pair : out) {
      pair.in_model += error_of(pair.model_covariance, random);
      pair.in_ground += error_of(pair.ground_covariance, random);
    }
    return out;
  }
};

// Estimate minus truth in the parameters of the covariance.
Eigen::Matrix<double, 7, 1> error_of(const AbsoluteOrientation& found, const Similarity3& truth) {
  Eigen::Matrix<double, 7, 1> error;
  error.head<3>() = found.ground_from_model * found.centroid_in_model - truth * found.centroid_in_model;
  error.segment<3>(3) = rotation_vector(found.ground_from_model.rotation * truth.rotation.conjugate());
  error[6] = std::log(found.ground_from_model.scale / truth.scale);
  return error;
}

void expect_same(const Similarity3& found, const Similarity3& truth, double tolerance) {
  EXPECT_NEAR(found.scale / truth.scale, 1, tolerance);
  EXPECT_LT(angle_between(found.rotation, truth.rotation), tolerance);
}

// Mussio D.8: the five points of the linear solution; without the factor 1/2, so that R' has (a, b, c) = twice ours.
TEST(ClosedSimilarity, LinearSolutionReturnsTheNumbersOfMussioD8) {
  const std::vector<Vector3d> model{{0, 0, 0}, {10, 0, 1}, {0, 8, -1}, {10, 8, 2}, {5, 4, 3}};
  const std::vector<Vector3d> ground{{100, 200, 50},
                                     {110.657894737, 193.355263158, 50.263157895},
                                     {104.561403509, 207.346491228, 44.824561404},
                                     {115.921052632, 201.447368421, 47.368421053},
                                     {108.662280702, 201.469298246, 50.964912281}};
  const auto fit = align_by_rodrigues(model, ground);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->b_from_a.scale, 1.25, 1e-9);
  EXPECT_LT((fit->abc - Vector3d(0.2, -0.1, 0.3)).norm(), 1e-9);
  EXPECT_LT((fit->b_from_a.translation - Vector3d(100, 200, 50)).norm(), 1e-8);
  EXPECT_FALSE(fit->was_turned_first);
}

TEST(ClosedSimilarity, AllThreeAgreeOnExactPoints) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Scene scene(seed, 3 + int(seed % 5));
    std::vector<Vector3d> model, ground;
    for (const AbsoluteControl& pair : scene.pairs) {
      model.push_back(pair.in_model);
      ground.push_back(pair.in_ground);
    }
    const auto quaternion = align_by_quaternion(model, ground);
    const auto rodrigues = align_by_rodrigues(model, ground);
    ASSERT_TRUE(quaternion && rodrigues);
    expect_same(*quaternion, scene.truth, 1e-7);
    expect_same(rodrigues->b_from_a, scene.truth, 1e-7);
  }
}

TEST(ClosedSimilarity, ARotationByPiIsTurnedFirst) {
  const Similarity3 truth{2, rotation_by({0, M_PI, 0}), {1, 2, 3}};
  std::vector<Vector3d> a{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, b;
  for (const Vector3d& point : a) b.push_back(truth * point);
  const auto fit = align_by_rodrigues(a, b);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->was_turned_first);
  expect_same(fit->b_from_a, truth, 1e-12);
}

TEST(ClosedSimilarity, PointsOnALineHaveNone) {
  const std::vector<Vector3d> line{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {5, 5, 0}};
  EXPECT_FALSE(align_by_quaternion(line, line));
  EXPECT_FALSE(align_by_rodrigues(line, line));
}

TEST(AbsoluteOrientation, ExactControlGivesTheTruth) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Scene scene(seed, 3 + int(seed % 4));
    const auto found = absolute_orientation(scene.pairs);
    ASSERT_TRUE(found) << found.error().message;
    expect_same(found->ground_from_model, scene.truth, 1e-9);
    EXPECT_LT((found->ground_from_model * scene.pairs[0].in_model - scene.pairs[0].in_ground).norm(), 1e-6);
    EXPECT_EQ(found->redundancy, 3 * int(scene.pairs.size()) - 7);
    EXPECT_LT(found->sigma0, 1e-3);
  }
}

// The error of the parameters is chi-squared with 7 degrees of freedom under their covariance; errors on both sides,
// correlated. 400 seeds: the mean of chi2/7 has a standard deviation of 0.027.
TEST(AbsoluteOrientation, CovarianceMatchesTheRealErrors) {
  constexpr int kSeeds = 400;
  double sum = 0, squares = 0, redundancy = 0, ground = 0, parameters = 0;
  int inside = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Scene scene(static_cast<std::uint64_t>(seed), 7);
    const auto found = absolute_orientation(scene.measured(static_cast<std::uint64_t>(seed)));
    ASSERT_TRUE(found);
    const auto error = error_of(*found, scene.truth);
    const double chi2 = error.dot(found->covariance.ldlt().solve(error));
    sum += chi2 / 7;
    inside += chi2 < 14.067;
    squares += found->sigma0 * found->sigma0 * found->redundancy;
    redundancy += found->redundancy;
    const Vector3d at(300, -200, 700);
    const GroundPoint point = on_ground(*found, at);
    const Vector3d off = point.position - scene.truth * at;
    ground += off.dot(point.covariance.ldlt().solve(off)) / 3;
    const AbsoluteParameters read = parameters_of(*found);
    const Vector3d shift = read.origin_on_ground - scene.truth.translation;
    parameters += shift.dot(Matrix3d(read.covariance.topLeftCorner<3, 3>()).ldlt().solve(shift)) / 3;
  }
  EXPECT_NEAR(sum / kSeeds, 1, 0.1);
  EXPECT_GE(inside, 0.93 * kSeeds);
  EXPECT_LE(inside, 0.97 * kSeeds);
  EXPECT_NEAR(squares / redundancy, 1, 0.05);
  EXPECT_NEAR(ground / kSeeds, 1, 0.15);
  EXPECT_NEAR(parameters / kSeeds, 1, 0.15);
}

// Model coordinates that share an error: with their full covariance the parameters pass, point by point they do not.
TEST(AbsoluteOrientation, FullCovarianceOfTheModelCounts) {
  constexpr int kSeeds = 300, kPoints = 6;
  double full_sum = 0, single_sum = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Scene scene(static_cast<std::uint64_t>(seed), kPoints);
    Random random(static_cast<std::uint64_t>(seed), 5);
    Eigen::MatrixXd covariance = 1e-4 * Eigen::MatrixXd::Identity(3 * kPoints, 3 * kPoints);
    Eigen::VectorXd common(3 * kPoints);  // a bend that all points share
    for (int i = 0; i < kPoints; ++i) {
      const Vector3d& p = scene.pairs[std::size_t(i)].in_model;
      common.segment<3>(3 * i) = Vector3d(0, 0, 1e-5 * p.x() * p.x());
    }
    covariance += common * common.transpose();
    const Eigen::VectorXd error =
        covariance.llt().matrixL() * Eigen::VectorXd::NullaryExpr(3 * kPoints, [&](auto) { return random.normal(); });
    for (int i = 0; i < kPoints; ++i) {
      AbsoluteControl& pair = scene.pairs[std::size_t(i)];
      pair.in_model += error.segment<3>(3 * i);
      pair.model_covariance = covariance.block<3, 3>(3 * i, 3 * i);
      pair.ground_covariance = 1e-6 * Matrix3d::Identity();
      pair.in_ground += random_vector(random, 1e-3);
    }
    const auto full = absolute_orientation(scene.pairs, {.start = {}, .model_covariance = &covariance});
    const auto single = absolute_orientation(scene.pairs);
    ASSERT_TRUE(full && single);
    const auto off = error_of(*full, scene.truth), other = error_of(*single, scene.truth);
    full_sum += off.dot(full->covariance.ldlt().solve(off)) / 7;
    single_sum += other.dot(single->covariance.ldlt().solve(other)) / 7;
  }
  EXPECT_NEAR(full_sum / kSeeds, 1, 0.1);
  EXPECT_GT(std::abs(single_sum / kSeeds - 1), 0.15);
}

TEST(AbsoluteOrientation, FullCovarianceOfIndependentPointsChangesNothing) {
  const Scene scene(4, 5);
  const auto pairs = scene.measured(4);
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(15, 15);
  for (int i = 0; i < 5; ++i) full.block<3, 3>(3 * i, 3 * i) = pairs[std::size_t(i)].model_covariance;
  const auto a = absolute_orientation(pairs), b = absolute_orientation(pairs, {.start = {}, .model_covariance = &full});
  ASSERT_TRUE(a && b);
  EXPECT_LT((a->covariance - b->covariance).norm(), 1e-9 * a->covariance.norm());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_LT((a->residuals[i].w - b->residuals[i].w).norm(), 1e-6);
    EXPECT_LT((a->residuals[i].model_correction - b->residuals[i].model_correction).norm(), 1e-9);
  }
}

// X + vX = T + m R (u + vu) holds, redundancy numbers add up, and w of right points is standard normal.
TEST(AbsoluteOrientation, ResidualsCloseAndTheirTestsAreNormal) {
  double squares = 0, components = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Scene scene(seed, 6);
    const auto pairs = scene.measured(seed);
    const auto found = absolute_orientation(pairs);
    ASSERT_TRUE(found);
    double redundancy = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const ControlResidual& residual = found->residuals[i];
      const Vector3d left = pairs[i].in_ground + residual.ground_correction;
      const Vector3d right = found->ground_from_model * (pairs[i].in_model + residual.model_correction);
      EXPECT_LT((left - right).norm(), 1e-6);
      redundancy += residual.redundancy.sum();
      squares += residual.w.squaredNorm();
      components += 3;
    }
    EXPECT_NEAR(redundancy, found->redundancy, 1e-6);
  }
  EXPECT_NEAR(squares / components, 1, 0.08);
}

TEST(AbsoluteOrientation, AGrossErrorHasTheLargestTest) {
  int found_right = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    auto pairs = Scene(seed, 8).measured(seed);
    pairs[3].in_ground.y() += 1.5;
    const auto found = absolute_orientation(pairs);
    ASSERT_TRUE(found);
    std::size_t worst = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (found->residuals[i].w.cwiseAbs().maxCoeff() > found->residuals[worst].w.cwiseAbs().maxCoeff()) worst = i;
    found_right += worst == 3;
    const auto wrong = contradicting_control(pairs, 1);
    ASSERT_TRUE(wrong);
    EXPECT_TRUE(std::find(wrong->begin(), wrong->end(), 3u) != wrong->end());
  }
  EXPECT_GE(found_right, 48);
}

// Two full points and a height: seven components for seven unknowns, one solution with the model upright.
TEST(AbsoluteOrientation, TwoPointsAndAHeightAreEnough) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Scene scene(seed, 3);
    Random random(seed, 3);
    scene.truth.rotation = rotation_by({0.1 * random.normal(), 0.1 * random.normal(), 3 * random.normal()});
    for (AbsoluteControl& pair : scene.pairs) pair.in_ground = scene.truth * pair.in_model;
    scene.pairs[2].has_plan = false;
    scene.pairs[2].in_ground.head<2>().setConstant(std::nan(""));
    const Vector3d a = scene.pairs[1].in_model - scene.pairs[0].in_model;
    const Vector3d b = scene.pairs[2].in_model - scene.pairs[0].in_model;
    if (std::abs(a.normalized().cross(b.normalized()).z()) < 0.5) continue;  // a steep triangle has another as upright
    const auto found = absolute_orientation(scene.pairs);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->redundancy, 0);
    EXPECT_EQ(found->solutions, 2);
    expect_same(found->ground_from_model, scene.truth, 1e-7);
  }
}

// Control of plan and of height at different points, as maps and levelling give it.
TEST(AbsoluteOrientation, PlanAndHeightAtDifferentPoints) {
  double sum = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Scene scene(seed, 8);
    Random random(seed, 3);
    scene.truth.rotation = rotation_by({0.05 * random.normal(), 0.05 * random.normal(), 3 * random.normal()});
    for (AbsoluteControl& pair : scene.pairs) pair.in_ground = scene.truth * pair.in_model;
    auto pairs = scene.measured(seed);
    for (std::size_t i = 0; i < pairs.size(); ++i) (i % 2 ? pairs[i].has_plan : pairs[i].has_height) = false;
    const auto found = absolute_orientation(pairs);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->redundancy, 4 * 2 + 4 - 7);
    const auto error = error_of(*found, scene.truth);
    sum += error.dot(found->covariance.ldlt().solve(error)) / 7;
  }
  EXPECT_NEAR(sum / kSeeds, 1, 0.15);
}

TEST(AbsoluteOrientation, TooLittleControlIsRefused) {
  Scene scene(1, 3);
  auto pairs = scene.pairs;
  pairs[2].has_height = false;
  EXPECT_FALSE(absolute_orientation(pairs));
  pairs = scene.pairs;
  for (AbsoluteControl& pair : pairs) pair.has_plan = false;
  EXPECT_FALSE(absolute_orientation(pairs));
  EXPECT_FALSE(absolute_orientation({}));
}

TEST(AbsoluteOrientation, ControlOnALineIsRefused) {
  auto pairs = Scene(1, 5).pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].in_model = Vector3d(100 * double(i), 50 * double(i), 3 * double(i));
    pairs[i].in_ground = 2 * pairs[i].in_model;
  }
  EXPECT_FALSE(absolute_orientation(pairs));
}

TEST(AbsoluteOrientation, CoordinatesThatAreNoNumbersAreRefused) {
  auto pairs = Scene(1, 4).pairs;
  pairs[1].in_ground.x() = std::nan("");
  EXPECT_FALSE(absolute_orientation(pairs));
  pairs = Scene(1, 4).pairs;
  pairs[1].ground_covariance = pairs[1].model_covariance = Matrix3d::Zero();
  EXPECT_FALSE(absolute_orientation(pairs));
}

// Bolognesi T4: coordinates of millions of metres cost an absolute orientation nothing: a model of the network at
// 1 : 500, turned, comes to its marks within rounding.
TEST(ClosedSimilarity, NetworkOfBolognesiT4) {
  const std::vector<Vector3d> ground{
      {723086.306, 4958051.929, 3.7293}, {723173.734, 4958102.953, 3.7927}, {723176.585, 4958305.682, 2.2066},
      {723153.588, 4958343.333, 2.3287}, {723035.859, 4958316.980, 2.4483}, {723022.282, 4958255.515, 2.8022},
      {723046.694, 4958216.423, 2.6171}, {723099.278, 4958255.343, 2.3288}, {723076.170, 4958293.478, 2.3856},
      {723040.695, 4958284.795, 2.9456}, {723189.045, 4958340.444, 2.5069}};
  const Similarity3 truth{500, rotation_by({0.3, -0.2, 1.9}), {723100, 4958251, 3}};
  std::vector<Vector3d> model;
  for (const Vector3d& point : ground)
    model.push_back(truth.rotation.conjugate() * (point - truth.translation) / truth.scale);
  for (const auto& fit :
       {align_by_quaternion(model, ground), std::optional(align_by_rodrigues(model, ground)->b_from_a)}) {
    ASSERT_TRUE(fit);
    for (std::size_t i = 0; i < model.size(); ++i) EXPECT_LT((*fit * model[i] - ground[i]).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace collinea
