// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/bundle_of_models.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/models/test_strip.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::strip;
using testing::Strip;

struct Both {
  ModelsOfBlock formed;
  JoinedBlock models;
  BundleOfModels bundle;
};

Both both(const Strip& made) {
  Both found;
  auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
  if (!formed) return ADD_FAILURE() << formed.error().message, found;
  found.formed = *std::move(formed);
  auto joined = join_models(found.formed.models, found.formed.control, {}, {});
  if (!joined) return ADD_FAILURE() << joined.error().message, found;
  found.models = *std::move(joined);
  auto bundle = bundle_of_models(made.block, found.formed, found.formed.control, found.models, true, {});
  if (!bundle) return ADD_FAILURE() << bundle.error().message, found;
  found.bundle = *std::move(bundle);
  return found;
}

// One pair is one model: relative and absolute orientation with all covariances are the bundle in two steps, up to
// second order in the noise (0.4 px: 0.3 mrad), and with the same redundancy.
TEST(BundleOfModels, IsTheModelItselfWhereThereIsOne) {
  const Strip made = strip(1, 2);
  const Both found = both(made);
  const BundleComparison beside = compare(found.models, found.bundle);
  EXPECT_EQ(beside.points, static_cast<int>(found.models.points.size()));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(beside.apart_in_sigmas[axis], 0.01);
    EXPECT_NEAR(beside.ratio[axis], 1, 0.01);
  }
  // Of a pair with n points 4 n observations; 3 n - 12 coordinates of four fixed points and 12 of images are unknown.
  const long rays = found.bundle.observations, points = rays / 4;
  EXPECT_EQ(found.bundle.redundancy, 4 * points - 3 * (points - 4) - 12);
}

TEST(BundleOfModels, ExactMeasurementsGiveTheTruth) {
  const Strip made = strip(1, 4, 0);
  const Both found = both(made);
  ASSERT_GT(found.bundle.points.size(), 20);
  for (const auto& [name, point] : found.bundle.points)
    EXPECT_LT((point.position - made.truth.at(name)).norm(), 1e-4) << name;  // models and bundle end at 1e-7 of 1 km
}

// Both tell the truth of a strip of three models; the bundle is the better one. Of what models lose see the theory
// page.
TEST(BundleOfModels, CovariancesTellTheTruth) {
  double sum = 0, count = 0;
  Vector3d of_models = Vector3d::Zero(), of_bundle = Vector3d::Zero();
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Strip made = strip(seed);
    const Both found = both(made);
    for (const JoinedPoint& point : found.models.points) {
      if (!found.bundle.points.contains(point.name)) continue;
      const BundlePoint& other = found.bundle.points.at(point.name);
      if (!(other.covariance.diagonal().minCoeff() > 0)) continue;  // fixed control
      const Vector3d error = other.position - made.truth.at(point.name);
      of_bundle += error.cwiseAbs2();
      of_models += (point.position - made.truth.at(point.name)).cwiseAbs2();
      if (point.name != "3" && point.name != "17" && point.name != "i1") continue;
      sum += error.dot(other.covariance.inverse() * error) / 3;
      ++count;
    }
  }
  EXPECT_EQ(count, 120);
  // Three points of a strip are nearly independent: chi-squared of 360 over 360 has a sigma of 0.075; three of those.
  EXPECT_NEAR(sum / count, 1, 0.22);
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(of_bundle[axis], of_models[axis]) << axis;
}

// What relative orientation rejects is in neither adjustment.
TEST(BundleOfModels, GrossErrorsTakeNoPart) {
  Strip made = strip(1, 2);
  made.block.observations[10].pixel += Eigen::Vector2d(0, 40);
  const Both found = both(made);
  EXPECT_EQ(found.formed.pairs[0].rejected, 1);
  EXPECT_LT(found.bundle.sigma0, 1.5);
}

TEST(BundleOfModels, WithoutControlThereIsNoFrameInCommon) {
  Strip made = strip(1);
  auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
  ASSERT_TRUE(formed);
  const auto joined = join_models(formed->models, {}, {}, {});
  ASSERT_TRUE(joined);
  const auto bundle = bundle_of_models(made.block, *formed, {}, *joined, true, {});
  ASSERT_FALSE(bundle);
  EXPECT_EQ(bundle.error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
