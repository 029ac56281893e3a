// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_orientation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/relative_search.h"
#include "collinea/epipolar/scene_for_tests.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr double kSigma = 1e-4;

// A pair of near-vertical photographs: base along x, relief of a fifth of the height.
Rigid3 vertical_motion(Random& random) {
  DependentElements elements{1, random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08)};
  elements.omega = random.uniform(-0.06, 0.06);
  elements.phi = random.uniform(-0.06, 0.06);
  elements.kappa = random.uniform(-0.06, 0.06);
  return motion_of(elements);
}

Eigen::Vector3d ground_point(Random& random) {
  return {random.uniform(-0.3, 1.3), random.uniform(-1.2, 1.2), random.uniform(1.4, 2.0)};
}

template <class PointOf>
std::vector<PairPoint> measured(const Rigid3& motion, int count, double sigma, Random& random, PointOf point_of) {
  std::vector<PairPoint> points;
  while (static_cast<int>(points.size()) < count) {
    const Eigen::Vector3d x = point_of(random);
    if ((motion * x).z() < 0.2) continue;
    const double s = std::max(sigma, 1e-9) * (points.size() % 2 == 0 ? 1 : 2);  // two classes of precision
    PairPoint point{x.hnormalized(), scene::seen(motion, x), s, 1.5 * s};
    if (sigma > 0) {
      point.first += scene::noise(random, point.sigma_first);
      point.second += scene::noise(random, point.sigma_second);
    }
    points.push_back(point);
  }
  return points;
}

// The change from the estimate to the truth.
Vector5 change_between(const Rigid3& estimate, const Rigid3& truth) {
  Vector5 change;
  change.head<3>() = rotation_vector(truth.rotation * estimate.rotation.conjugate());
  const Eigen::Vector3d base = base_in_first(estimate);
  change.tail<2>() = tangents_of(base).transpose() * base_in_first(truth) / base.dot(base_in_first(truth));
  return change;
}

RelativeOptions options_of(PairStart start, PairRejection rejection = PairRejection::kNone) {
  RelativeOptions options;
  options.start = start;
  options.rejection = rejection;
  options.sigma_known = true;
  return options;
}

TEST(RelativeOrientation, EveryStartFindsTheTruthOfANearVerticalPair) {
  Random random(1);
  const Rigid3 truth = vertical_motion(random);
  const auto points = measured(truth, 20, 0, random, ground_point);
  for (const PairStart start : {PairStart::kRobust, PairStart::kNearVertical, PairStart::kLinear, PairStart::kGrid}) {
    const auto found = relative_orientation(points, options_of(start), 1);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(change_between(found->second_from_first, truth).norm(), 1e-9);
    EXPECT_EQ(found->in_front, 20);
    EXPECT_NEAR(found->redundancy, 15, 1e-6);
  }
}

TEST(RelativeOrientation, TheRobustStartFindsAnyAttitudes) {
  for (int seed = 1; seed <= 20; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Rigid3 truth = scene::random_motion(random);
    truth.rotation = truth.rotation * rotation_by({0, 0, random.uniform(-3, 3)});
    const auto points = measured(truth, 20, 0, random, scene::random_point);
    const auto found = relative_orientation(points, options_of(PairStart::kRobust), 1);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(change_between(found->second_from_first, truth).norm(), 1e-8);
  }
}

TEST(RelativeOrientation, TheGridFindsTheFourSolutions) {
  Random random(3);
  Rigid3 truth = scene::random_motion(random);
  truth.rotation = rotation_by({0.3, 0.2, 2.5}) * truth.rotation;
  const auto points = measured(truth, 15, 0, random, scene::random_point);
  const auto search = search_relative(points);
  ASSERT_TRUE(search);
  EXPECT_EQ(search->starts, 5408);     // of 12,800 sequences: Mussio 3.1.2, E56
  EXPECT_GT(search->converged, 5000);  // 5215 of 5408 in his example
  EXPECT_EQ(search->distinct.size(), 4u);
  const auto four = relative_solutions(search->distinct[0], points);
  EXPECT_LT(change_between(four[0].second_from_first, truth).norm(), 1e-6);
  EXPECT_EQ(four[0].in_front, 15);
  EXPECT_LT(four[1].in_front, 15);
}

TEST(RelativeOrientation, TheExhaustiveStartReportsItsSearch) {
  Random random(13);
  const auto points = measured(vertical_motion(random), 10, 0, random, ground_point);
  const auto by_grid = relative_orientation(points, options_of(PairStart::kGrid), 1);
  ASSERT_TRUE(by_grid && by_grid->search);
  const auto search = search_relative(points);
  EXPECT_EQ(by_grid->search->starts, 5408);
  EXPECT_EQ(by_grid->search->converged, search->converged);
  EXPECT_EQ(by_grid->search->distinct.size(), 4u);
  EXPECT_FALSE(relative_orientation(points, options_of(PairStart::kLinear), 1)->search);
}

TEST(RelativeOrientation, SixPointsAreOrientedByTheGrid) {
  Random random(9);
  const Rigid3 truth = vertical_motion(random);
  const auto found =
      relative_orientation(measured(truth, 7, 0, random, ground_point), options_of(PairStart::kRobust), 1);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(change_between(found->second_from_first, truth).norm(), 1e-7);
}

// e' C^-1 e is chi-squared with 5 degrees of freedom, in every parametrisation; sigma0^2 r with r.
TEST(RelativeOrientation, CovariancesMatchTheRealErrors) {
  constexpr int kSeeds = 400;
  double sum = 0, sum_symmetric = 0, sum_sigma = 0, sum_model = 0;
  int within = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(100, static_cast<std::uint64_t>(seed));
    const Rigid3 truth = vertical_motion(random);
    Random noise(200, static_cast<std::uint64_t>(seed));
    const Eigen::Vector3d target = ground_point(noise);
    const auto points = measured(truth, 18, kSigma, noise, [&, first = true](Random& r) mutable {
      return std::exchange(first, false) ? target : ground_point(r);
    });
    const auto found = relative_orientation(points, options_of(PairStart::kLinear), 1);
    ASSERT_TRUE(found) << found.error().message;
    const Vector5 e = change_between(found->second_from_first, truth);
    const double chi2 = e.dot(found->covariance.ldlt().solve(e));
    sum += chi2;
    within += chi2 < 11.0705;
    const Matrix5 by = symmetric_by_change(found->second_from_first);
    const Vector5 es = symmetric_elements(truth).values() - symmetric_elements(found->second_from_first).values();
    sum_symmetric += es.dot((by * found->covariance * by.transpose()).ldlt().solve(es));
    sum_sigma += found->sigma0 * found->sigma0;
    const PairModel model = model_points(*found, points);
    const Eigen::Vector3d em = model.points[0]->position - target;
    sum_model += em.dot(model.points[0]->covariance.ldlt().solve(em));
  }
  EXPECT_NEAR(sum / kSeeds / 5, 1, 0.1);
  EXPECT_NEAR(sum_symmetric / kSeeds / 5, 1, 0.1);
  EXPECT_NEAR(static_cast<double>(within) / kSeeds, 0.95, 0.02);
  EXPECT_NEAR(sum_sigma / kSeeds, 1, 4 * std::sqrt(2.0 / 13 / kSeeds));
  EXPECT_NEAR(sum_model / kSeeds / 3, 1, 4 * std::sqrt(6.0 / kSeeds) / 3);
}

// What two points and the second centre have in common: the covariance of a distance between them.
TEST(RelativeOrientation, TheFullCovarianceOfAModelMatchesItsErrors) {
  constexpr int kSeeds = 400;
  double sum = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(300, static_cast<std::uint64_t>(seed));
    const Rigid3 truth = vertical_motion(random);
    std::vector<Eigen::Vector3d> ground;
    const auto points =
        measured(truth, 10, kSigma, random, [&](Random& r) { return ground.emplace_back(ground_point(r)); });
    const auto found = relative_orientation(points, options_of(PairStart::kLinear), 1);
    ASSERT_TRUE(found);
    const PairModel model = model_points(*found, points, 2, true);
    const Eigen::MatrixXd full = full_covariance(model, found->stated_covariance());
    ASSERT_EQ(full.rows(), 33);
    Eigen::VectorXd error(33);
    const auto photo = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(2 * p.x(), -2 * p.y(), -2 * p.z()); };
    for (int i = 0; i < 10; ++i)
      error.segment<3>(3 * i) =
          model.points[static_cast<std::size_t>(i)]->position - photo(ground[static_cast<std::size_t>(i)]);
    error.tail<3>() = model.second_centre.position - photo(base_in_first(truth));
    const Eigen::VectorXd part = error.head<9>();  // three points: what they have in common counts, too
    sum += part.dot(full.topLeftCorner<9, 9>().ldlt().solve(part));
  }
  EXPECT_NEAR(sum / kSeeds / 9, 1, 4 * std::sqrt(18.0 / kSeeds) / 9);
}

TEST(RelativeOrientation, SumOfRedundancyNumbersIsTheRedundancy) {
  Random random(5);
  const auto points = measured(vertical_motion(random), 30, kSigma, random, ground_point);
  const auto found = relative_orientation(points, options_of(PairStart::kLinear), 1);
  ASSERT_TRUE(found);
  double sum = 0;
  for (const PairResidual& residual : found->residuals) sum += residual.redundancy;
  EXPECT_NEAR(sum, 25, 1e-7);
  EXPECT_NEAR(found->redundancy, 25, 1e-7);
}

// With a base along x the y-parallax is that of the photographs: y2 - y1 with y up.
TEST(RelativeOrientation, YParallaxesAreThoseOfTheNormalCase) {
  Random random(6);
  const Rigid3 truth{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  auto points = measured(truth, 200, 0, random, ground_point);
  for (PairPoint& point : points) point.sigma_first = point.sigma_second = kSigma;
  points[7].second.y() -= 3 * kSigma;  // up
  const auto found = relative_orientation(points, options_of(PairStart::kLinear), 1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->residuals[7].y_parallax, 3 * kSigma, 0.2 * kSigma);
  EXPECT_NEAR(found->residuals[7].first.y(), -1.5 * kSigma, 0.1 * kSigma);  // adjusted up: y down
}

TEST(RelativeOrientation, BothRulesRejectTheGrossErrorsAndNothingElse) {
  for (const PairRejection rule : {PairRejection::kSnooping, PairRejection::kResidual})
    for (const PairStart start : {PairStart::kRobust, PairStart::kLinear}) {
      Random random(7);
      const Rigid3 truth = vertical_motion(random);
      auto points = measured(truth, 40, kSigma, random, ground_point);
      for (const std::size_t i : {3u, 11u, 30u}) points[i].second.y() += 60 * kSigma;
      RelativeOptions options = options_of(start, rule);
      options.sigma_known = false;
      const auto found = relative_orientation(points, options, 1);
      ASSERT_TRUE(found) << found.error().message;
      std::vector<int> rejected = found->rejected;
      std::sort(rejected.begin(), rejected.end());
      EXPECT_EQ(rejected, (std::vector<int>{3, 11, 30}));
      EXPECT_NEAR(found->sigma0, 1, 0.3);
      EXPECT_FALSE(found->residuals[3].used);
      EXPECT_GT(std::abs(found->residuals[3].standardised), 10);
    }
}

TEST(RelativeOrientation, TheRobustStartStandsAThirdOfWrongPoints) {
  Random random(8);
  const Rigid3 truth = vertical_motion(random);
  auto points = measured(truth, 60, kSigma, random, ground_point);
  for (std::size_t i = 0; i < 20; ++i) points[i].second = ground_point(random).hnormalized();
  const auto found = relative_orientation(points, options_of(PairStart::kRobust, PairRejection::kSnooping), 1);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_GE(found->rejected.size(), 18u);
  EXPECT_LE(found->rejected.size(), 21u);
  EXPECT_LT(change_between(found->second_from_first, truth).norm(), 1e-2);
}

// Weights by distribution cost precision, and the covariance says how much.
TEST(RelativeOrientation, CovariancesOfWeightsByDistributionMatchTheRealErrors) {
  constexpr int kSeeds = 300;
  for (const PairWeights weights : {PairWeights::kCells, PairWeights::kGruber}) {
    double sum = 0, sum_sigma = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      Random random(400, static_cast<std::uint64_t>(seed));
      const Rigid3 truth = vertical_motion(random);
      const auto points = measured(truth, 40, kSigma, random, [](Random& r) {
        Eigen::Vector3d p = ground_point(r);
        if (r.uniform() < 0.6) p.head<2>() *= 0.3;  // a crowd
        return p;
      });
      RelativeOptions options = options_of(PairStart::kLinear);
      options.weights = weights;
      const auto found = relative_orientation(points, options, 1);
      ASSERT_TRUE(found);
      const Vector5 e = change_between(found->second_from_first, truth);
      sum += e.dot(found->covariance.ldlt().solve(e));
      sum_sigma += found->sigma0 * found->sigma0;
    }
    EXPECT_NEAR(sum / kSeeds / 5, 1, 0.1);
    EXPECT_NEAR(sum_sigma / kSeeds, 1, 0.05);
  }
}

TEST(RelativeOrientation, TheLimitOfManyPointsIsPopesTau) {
  Random random(11);
  const auto points = measured(vertical_motion(random), 100, kSigma, random, ground_point);
  RelativeOptions options = options_of(PairStart::kLinear);
  options.sigma_known = false;
  const auto found = relative_orientation(points, options, 1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->limit, tau_limit(options.alpha, 95), 1e-7);
}

TEST(RelativeOrientation, RefusesWhatItCannotSolve) {
  Random random(10);
  const Rigid3 truth = vertical_motion(random);
  auto points = measured(truth, 20, 0, random, ground_point);
  EXPECT_FALSE(relative_orientation(std::span(points).first(4), {}, 1));
  points[2].sigma_first = 0;
  EXPECT_FALSE(relative_orientation(points, {}, 1));
  points[2].sigma_first = std::nan("");
  EXPECT_FALSE(relative_orientation(points, {}, 1));
  // One and the same point
  EXPECT_FALSE(relative_orientation(std::vector<PairPoint>(20, points[0]), {}, 1));
  // Points in a plane with the base
  const auto flat = measured(truth, 20, 0, random, [&](Random& r) {
    return Eigen::Vector3d(base_in_first(truth) * r.uniform(-0.2, 1.2) +
                           Eigen::Vector3d(0.1, 0.2, 2) * r.uniform(0.7, 1));
  });
  for (const PairStart start : {PairStart::kRobust, PairStart::kNearVertical, PairStart::kLinear})
    EXPECT_FALSE(relative_orientation(flat, options_of(start), 1));
}

// Attitudes of 1e-4 rad: what the linear equations neglect is below 1e-7, a thousandth of the sigmas of coordinates.
// e' C^-1 e is chi-squared with 5 degrees of freedom: mean 5 within 4 sqrt(10 / n); sigma0^2 is 1 within 4 sqrt(2 / 15
// n).
TEST(LinearOrientation, CovarianceMatchesTheRealErrorsOfANormalPair) {
  constexpr int kSeeds = 400;
  const DependentElements truth{1, 1e-4, -1e-4, 5e-5, -1e-4, 1e-4};
  double sum = 0, sum_sigma = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(600, static_cast<std::uint64_t>(seed));
    const auto points = measured(motion_of(truth), 20, kSigma, random, ground_point);
    const auto found = linear_orientation(points);
    ASSERT_TRUE(found);
    const Vector5 e = found->elements.values() - truth.values();
    sum += e.dot(found->covariance.ldlt().solve(e));
    sum_sigma += found->sigma0 * found->sigma0;
    EXPECT_EQ(found->redundancy, 15);
  }
  EXPECT_NEAR(sum / kSeeds, 5, 4 * std::sqrt(10.0 / kSeeds));
  EXPECT_NEAR(sum_sigma / kSeeds, 1, 4 * std::sqrt(2.0 / 15 / kSeeds));
}

// Without noise the difference to the truth is of second order: with half the elements it is a quarter, up to the third
// order, which is a tenth of it at most here (elements of 0.05).
TEST(LinearOrientation, DiffersFromTheRigorousOneInTheSecondOrder) {
  const auto difference = [](double size) {
    Random random(18);
    const DependentElements truth{1, size, -size, 0.7 * size, -size, 0.9 * size};
    const auto points = measured(motion_of(truth), 40, 0, random, ground_point);
    return (linear_orientation(points)->elements.values() - truth.values()).norm();
  };
  const double whole = difference(0.02), half = difference(0.01);
  EXPECT_GT(whole, 1e-4);
  EXPECT_NEAR(whole / half, 4, 0.4);
}

TEST(LinearOrientation, NeedsFivePointsThatDetermineIt) {
  Random random(19);
  const auto points = measured(vertical_motion(random), 6, 0, random, ground_point);
  EXPECT_FALSE(linear_orientation(std::span(points).first(4)));
  EXPECT_FALSE(linear_orientation(std::vector<PairPoint>(10, points[0])));
  EXPECT_EQ(linear_orientation(std::span(points).first(5))->redundancy, 0);
}

}  // namespace
}  // namespace collinea
