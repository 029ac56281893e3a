// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/scaled_pair.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

constexpr double kSigma = 1e-4, kBase = 600;

struct Survey {
  Rigid3 truth;
  std::vector<Eigen::Vector3d> ground;  // in bases
  std::vector<PairPoint> points;
  std::vector<PairDistance> distances;
};

Survey survey(std::uint64_t seed, int count, double sigma_m) {
  Random random(500, seed);
  Survey out{motion_of(DependentElements{1, 0.05, -0.03, 0.02, -0.01, 0.03}), {}, {}, {}};
  while (out.points.size() < 12) {
    const Eigen::Vector3d x(random.uniform(-0.2, 1.2), random.uniform(-1, 1), random.uniform(1.4, 1.9));
    out.ground.push_back(x);
    out.points.push_back({x.hnormalized() + scene::noise(random, kSigma),
                          scene::seen(out.truth, x) + scene::noise(random, kSigma), kSigma, kSigma});
  }
  for (int k = 0; k < count; ++k) {  // a chain, whose neighbours share a point
    const double length =
        kBase * (out.ground[static_cast<std::size_t>(k)] - out.ground[static_cast<std::size_t>(k + 1)]).norm();
    out.distances.push_back({k, k + 1, length + sigma_m * random.normal(), sigma_m});
  }
  return out;
}

RelativeOrientation oriented(const Survey& survey) {
  RelativeOptions options;
  options.start = PairStart::kLinear;
  options.rejection = PairRejection::kNone;
  options.sigma_known = true;
  return *relative_orientation(survey.points, options, 1);
}

TEST(ScaledPair, OneDistanceGivesTheBase) {
  Survey exact = survey(1, 1, 1e-9);
  for (std::size_t i = 0; i < exact.points.size(); ++i) {
    exact.points[i].first = exact.ground[i].hnormalized();
    exact.points[i].second = scene::seen(exact.truth, exact.ground[i]);
  }
  const auto scaled = scaled_pair(oriented(exact), exact.points, exact.distances);
  ASSERT_TRUE(scaled);
  EXPECT_NEAR(scaled->base, kBase, 1e-6);
  EXPECT_EQ(scaled->redundancy, 0);
  EXPECT_LT((scaled->model.points[5]->position - kBase * exact.ground[5]).norm(), 1e-5);
}

// Base and orientation together, the model's points, and the distances among themselves.
TEST(ScaledPair, CovariancesMatchTheRealErrors) {
  constexpr int kSeeds = 400;
  double sum = 0, sum_point = 0, sum_sigma = 0, sum_test = 0;
  int tests = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Survey made = survey(static_cast<std::uint64_t>(seed), 6, 0.05);
    const auto scaled = scaled_pair(oriented(made), made.points, made.distances);
    ASSERT_TRUE(scaled);
    Eigen::Matrix<double, 6, 1> e;
    e.head<3>() = rotation_vector(made.truth.rotation * scaled->second_from_first.rotation.conjugate());
    const Eigen::Vector3d base = base_in_first(scaled->second_from_first);
    e.segment<2>(3) = tangents_of(base).transpose() * base_in_first(made.truth);
    e(5) = kBase - scaled->base;
    sum += e.dot(scaled->covariance.ldlt().solve(e));
    const ModelPoint& point = *scaled->model.points[9];  // no distance ends there
    const Eigen::Vector3d off = point.position - kBase * made.ground[9];
    sum_point += off.dot(point.covariance.ldlt().solve(off));
    sum_sigma += scaled->sigma0 * scaled->sigma0;
    for (const double t : scaled->standardised) {
      sum_test += t * t;
      ++tests;
    }
  }
  EXPECT_NEAR(sum / kSeeds / 6, 1, 0.1);
  EXPECT_NEAR(sum_point / kSeeds / 3, 1, 4 * std::sqrt(6.0 / kSeeds) / 3);
  EXPECT_NEAR(sum_sigma / kSeeds, 1, 4 * std::sqrt(2.0 / 5 / kSeeds));
  EXPECT_NEAR(sum_test / tests, 1, 0.12);
}

TEST(ScaledPair, AWrongDistanceShows) {
  Survey made = survey(3, 6, 0.05);
  made.distances[2].length += 8;
  const auto scaled = scaled_pair(oriented(made), made.points, made.distances);
  ASSERT_TRUE(scaled);
  EXPECT_GT(scaled->sigma0, 3);
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_LE(std::abs(scaled->standardised[k]), std::abs(scaled->standardised[2]));
}

TEST(ScaledPair, RefusesDistancesThatAreNone) {
  const Survey made = survey(4, 2, 0.05);
  const RelativeOrientation orientation = oriented(made);
  EXPECT_FALSE(scaled_pair(orientation, made.points, {}));
  for (const PairDistance& bad :
       {PairDistance{0, 0, 10, 1}, PairDistance{0, 99, 10, 1}, PairDistance{-1, 2, 10, 1}, PairDistance{0, 1, 10, 0},
        PairDistance{0, 1, -1, 1}, PairDistance{0, 1, std::nan(""), 1}})
    EXPECT_FALSE(scaled_pair(orientation, made.points, std::vector<PairDistance>{bad}));
}

}  // namespace
}  // namespace collinea
