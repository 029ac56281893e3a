// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/models_of_block.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "collinea/geometry/rotation.h"
#include "collinea/math/fisher.h"
#include "collinea/math/random.h"
#include "collinea/models/model_block.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

constexpr double kSigmaPx = 0.4;

// A strip of nadir photographs with 60 % forward overlap, over four full control points.
struct Strip {
  Block block;
  std::map<std::string, Vector3d> truth;
};

Strip strip(std::uint64_t seed, int images = 4, double noise_px = kSigmaPx) {
  Random world(11), noise(seed, 3);
  Strip made;
  const double height_m = 1000, base_m = 600;
  made.block.cameras[CameraId{1}] = ideal_camera(1000, 1500, 1500);
  std::map<ImageId, Rigid3> poses;
  for (int i = 0; i < images; ++i) {
    const ImageId id{static_cast<std::uint32_t>(i + 1)};
    made.block.images[id] = Image{"i" + std::to_string(i), CameraId{1}, "", {}, {}, 1};
    const Vector3d turn(0.02 * world.normal(), 0.02 * world.normal(), 0.02 * world.normal());
    const Eigen::Quaterniond rotation = rotation_by(turn) * Eigen::Quaterniond(0, 1, 0, 0);
    const Vector3d centre(base_m * i, 5 * world.normal(), height_m + 5 * world.normal());
    poses[id] = {rotation, -(rotation * centre)};
    made.truth["i" + std::to_string(i)] = centre;
  }
  const auto measure = [&](const Vector3d& point, auto&& add) {
    for (const auto& [id, pose] : poses) {
      const auto pixel = project(made.block.camera_of(id), pose * point);
      const double du = noise.normal(), dv = noise.normal();
      if (pixel && inside(made.block.camera_of(id), *pixel)) add(id, *pixel + noise_px * Eigen::Vector2d(du, dv));
    }
  };
  for (std::uint32_t n = 0; n < 12 * static_cast<std::uint32_t>(images); ++n) {
    const double x = base_m * int(n / 12) + 60 * world.normal(), y = -650 + 1300 * (n % 12) / 11.0;
    const Vector3d point(x, y, 60 * world.normal());
    made.truth[std::to_string(n)] = point;
    measure(point, [&](ImageId id, const Eigen::Vector2d& pixel) {
      made.block.observations.push_back({id, PointId{n}, 0, pixel, kSigmaPx});
    });
  }
  for (std::uint32_t n = 0; n < 4; ++n) {
    ControlPoint control;
    control.name = "C" + std::to_string(n);
    control.position_in_world = Vector3d(n % 2 ? base_m * (images - 1) : 0, n < 2 ? -600 : 600, 10.0 * n);
    control.sigma_m.setZero();
    made.truth[control.name] = control.position_in_world;
    made.block.control[ControlId{n}] = control;
    measure(control.position_in_world, [&](ImageId id, const Eigen::Vector2d& pixel) {
      made.block.control_observations.push_back({ControlId{n}, id, pixel, kSigmaPx});
    });
  }
  return made;
}

TEST(ModelsOfBlock, NeighboursInTheStripMakePairs) {
  const auto pairs = model_pairs(strip(1).block, {});
  ASSERT_EQ(pairs.size(), 3);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(pairs[i], std::pair(ImageId{i + 1}, ImageId{i + 2}));
}

TEST(ModelsOfBlock, ExactMeasurementsGiveTheTruth) {
  const Strip made = strip(1, 4, 0);
  const auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
  ASSERT_TRUE(formed) << formed.error().message;
  const auto block = join_models(formed->models, formed->control, {}, {});
  ASSERT_TRUE(block) << block.error().message;
  for (const JoinedPoint& point : block->points)
    EXPECT_LT((point.position - made.truth.at(point.name)).norm(), 1e-4) << point.name;
}

// One model by itself has no image in common with another: its covariance is that of the whole pair.
TEST(ModelsOfBlock, CovarianceOfAPairTellsTheTruth) {
  double sum = 0, within = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Strip made = strip(seed, 2);
    const auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
    ASSERT_TRUE(formed) << formed.error().message;
    const auto block = join_models(formed->models, formed->control, {}, {});
    ASSERT_TRUE(block) << block.error().message;
    for (const JoinedPoint& point : block->points) {
      if (point.name != "3" && point.name != "17" && point.name != "i1") continue;
      const Vector3d error = point.position - made.truth.at(point.name);
      const double chi_squared = error.dot(point.covariance.inverse() * error);
      sum += chi_squared / 3;
      within += fisher_tail(chi_squared / 3, 3, INFINITY) > 0.05 ? 1 : 0;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 1, 0.15);  // three points share a pair: about 100 independent values of 3
  EXPECT_NEAR(within / count, 0.95, 0.04);
}

TEST(ModelsOfBlock, WhatMakesNoModelIsNamed) {
  Strip made = strip(1);
  EXPECT_FALSE(models_of_block(made.block, {}, {}, true, {}));
  const auto far = models_of_block(made.block, {{ImageId{1}, ImageId{2}}, {ImageId{1}, ImageId{4}}}, {}, true, {});
  ASSERT_TRUE(far);
  EXPECT_EQ(far->models.size(), 1);
  EXPECT_FALSE(far->pairs[1].failure.empty());
  made.block.control[ControlId{0}].name = "i0";
  EXPECT_EQ(models_of_block(made.block, model_pairs(made.block, {}), {}, true, {}).error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
