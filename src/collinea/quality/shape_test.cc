// SPDX-License-Identifier: Apache-2.0
// Points that are known to lie on a plane, on a line or at one height.
#include <gtest/gtest.h>

#include <cmath>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/block/geodetic_words.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/variance_components.h"

namespace collinea {
namespace {

using testing::Marked;
using testing::marked;
using testing::normal3;
using testing::tested;

const Run kRun;
constexpr double kSigma_m = 0.01;
constexpr GeodeticKind kShapes[] = {GeodeticKind::kAtHeight, GeodeticKind::kOnPlane, GeodeticKind::kOnLine};

// Points move onto the shape, but for an error of that sigma.
Marked on_shape(GeodeticKind kind, double sigma_m, std::uint64_t seed, double sigma_px = 0.5, double position_m = 0.05,
                std::uint32_t points = 8) {
  Random random(seed, 21);
  const auto move = [&](std::vector<Eigen::Vector3d>& positions) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.4, 0.2, 1).normalized(), along(0.8, 0.6, 0.05);
    for (Eigen::Vector3d& position : positions) {
      if (kind == GeodeticKind::kAtHeight) position.z() = 2;
      if (kind == GeodeticKind::kOnPlane) position -= normal * normal.dot(position - Eigen::Vector3d(20, 15, 0));
      if (kind == GeodeticKind::kOnLine) position = Eigen::Vector3d(5, 5, 1) + along * (position.x() * 0.8);
      position += sigma_m * normal3(random);
    }
  };
  Marked made = marked({.points = 80, .sigma_px = sigma_px, .position_sigma_m = position_m, .seed = seed},
                       static_cast<int>(points), move);
  for (std::uint32_t i = 0; i < points; ++i)
    for (int axis = 0; axis < (kind == GeodeticKind::kOnLine ? 2 : 1); ++axis)
      made.block.geodetic.push_back(
          {.kind = kind, .name = "wall", .from = {i}, .to = {i}, .sigma = kSigma_m, .setup = 0, .axis = axis});
  return made;
}

TEST(Shape, DerivativesAreThoseOfDifferences) {
  Random random(3);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 6; ++i) points.push_back(Eigen::Vector3d(30, 20, 10).cwiseProduct(normal3(random)));
  for (const GeodeticKind kind : kShapes) {
    const auto shape = shape_through(kind, points);
    ASSERT_TRUE(shape);
    for (int axis = 0; axis < (kind == GeodeticKind::kOnLine ? 2 : 1); ++axis) {
      const GeodeticObservation one{.kind = kind, .axis = axis};
      double unknowns[3] = {0.3, 0.2, -0.15};
      const Eigen::Vector3d point = 20 * normal3(random);
      const GeodeticModel model = shape_model(one, *shape, unknowns, point, {});
      constexpr double kStep = 1e-5;
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
        const double slope = (shape_model(one, *shape, unknowns, point + step, {}).computed -
                              shape_model(one, *shape, unknowns, point - step, {}).computed) /
                             (2 * kStep);
        EXPECT_NEAR(slope, model.by_from[c], 1e-8) << words_of(one, {.control = {{ControlId{}, {}}}});
      }
      for (int k = 0; k < model.auxiliaries; ++k) {
        const auto at = [&](double by) {
          unknowns[k] += by;
          const double computed = shape_model(one, *shape, unknowns, point, {}).computed;
          unknowns[k] -= by;
          return computed;
        };
        EXPECT_NEAR((at(kStep) - at(-kStep)) / (2 * kStep), model.by_auxiliary[static_cast<std::size_t>(k)], 1e-6);
      }
    }
  }
}

TEST(Shape, BeginsAtItsBestFit) {
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_FALSE(shape_through(GeodeticKind::kOnPlane, line));  // any plane about it would do
  EXPECT_TRUE(shape_through(GeodeticKind::kOnLine, line));
  EXPECT_FALSE(shape_through(GeodeticKind::kOnLine, {{1, 2, 3}, {1, 2, 3}}));
  // Sideways is level, upwards is up; of a plumb line these are east and north.
  const auto sloping = shape_through(GeodeticKind::kOnLine, {{0, 0, 0}, {3, 0, 1}});
  EXPECT_NEAR(sloping->axes(2, 0), 0, 1e-12);
  EXPECT_GT(sloping->axes(2, 1), 0.9);
  const auto plumb = shape_through(GeodeticKind::kOnLine, {{0, 0, 0}, {0, 0, -4}});
  EXPECT_NEAR(plumb->axes(0, 0), 1, 1e-9);
  EXPECT_NEAR(plumb->axes(1, 1), 1, 1e-9);
}

TEST(Shape, ExactTruthComesBack) {
  for (const GeodeticKind kind : kShapes) {
    const Marked made = on_shape(kind, 0, 1, 0, 0.001);
    Block start = testing::disturbed(made.block, 0.003, 0.2);
    for (auto& [id, image] : start.images)
      image.position = PositionPrior{centre_of(pose_of(made.block, id)), Eigen::Vector3d::Constant(0.001)};
    const auto adjusted = examine(start, {}, tested(), kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    EXPECT_TRUE(adjusted->converged);
    for (const ControlDifference& point : adjusted->control)
      EXPECT_LT((*point.position_in_world - made.truth.at(point.point)).norm(), 1e-6);
    for (const GeodeticDifference& one : adjusted->geodetic) EXPECT_NEAR(one.difference, 0, 1e-7);
    EXPECT_NEAR(adjusted->reliability->redundancy_sum, double(adjusted->redundancy), 1e-4);
    EXPECT_EQ(adjusted->geodetic.size(), kind == GeodeticKind::kOnLine ? 16u : 8u);
  }
}

// Errors of points over their sigmas, and residuals over theirs, of 60 blocks: squares of standard normal variables,
// eight points of three axes each that are partly dependent.
TEST(Shape, ErrorsAreAsLargeAsTheirSigmas) {
  constexpr int kBlocks = 60;
  for (const GeodeticKind kind : kShapes) {
    double points = 0, residuals = 0, freedom = 0;
    ExamineOptions options = tested();
    options.test.sigma0_known = true;
    for (int i = 0; i < kBlocks; ++i) {
      const Marked made = on_shape(kind, kSigma_m, static_cast<std::uint64_t>(i + 1));
      const auto adjusted = examine(made.block, {}, options, kRun);
      ASSERT_TRUE(adjusted && !adjusted->undetermined);
      double of_block = 0;
      for (const ControlDifference& point : adjusted->control) {
        const Eigen::Vector3d error = *point.position_in_world - made.truth.at(point.point);
        of_block += error.dot(point.covariance_m2->ldlt().solve(error)) / 3;
      }
      points += of_block / static_cast<double>(adjusted->control.size());
      const GroupSums& group = adjusted->reliability->groups[static_cast<std::size_t>(group_of(kind))];
      residuals += group.squares;
      freedom += group.redundancy;
    }
    EXPECT_NEAR(points / kBlocks, 1, 4 * std::sqrt(2.0 / kBlocks)) << static_cast<int>(kind);
    EXPECT_NEAR(residuals / freedom, 1, 4 * std::sqrt(2 / freedom)) << static_cast<int>(kind);
  }
}

// What is known of the shape makes its points better.
TEST(Shape, APlaneHelpsItsPoints) {
  Marked made = on_shape(GeodeticKind::kOnPlane, kSigma_m, 2);
  const auto with = examine(made.block, {}, tested(), kRun);
  const auto without = examine(made.block, {.use_geodetic = false}, tested(), kRun);
  ASSERT_TRUE(with && without && !with->undetermined);
  EXPECT_TRUE(without->geodetic.empty());
  for (std::size_t i = 0; i < with->control.size(); ++i)
    EXPECT_LT(with->control[i].covariance_m2->trace(), without->control[i].covariance_m2->trace());
}

// Three points at one height level a block whose scale and position are fixed by nothing; planes and lines fix nothing.
TEST(Shape, HeightsLevelABlock) {
  for (const GeodeticKind kind : kShapes) {
    Marked made = on_shape(kind, 0, 1, 0, 0);
    const auto adjusted = examine(made.block, {}, tested(), kRun);
    ASSERT_TRUE(adjusted);
    EXPECT_EQ(adjusted->rank_defect, kind == GeodeticKind::kAtHeight ? 5 : 7) << static_cast<int>(kind);
  }
}

TEST(Shape, AGrossErrorIsFoundAndNamed) {
  for (const GeodeticKind kind : kShapes) {
    const Marked made = on_shape(kind, 0, 1);
    Block block = made.block;
    for (GeodeticObservation& one : block.geodetic) one.sigma = 0.005;
    const std::size_t wrong = kind == GeodeticKind::kOnLine ? 7 : 3;  // point 3, of a line upwards
    block.geodetic[wrong].value = 0.15;                               // what is written there is not so
    const auto adjusted = examine(block, {}, tested(), kRun);
    ASSERT_TRUE(adjusted && adjusted->reliability && !adjusted->reliability->suspects.empty());
    const TestedObservation& worst = adjusted->reliability->suspects[0];
    EXPECT_EQ(worst.group, group_of(kind));
    EXPECT_EQ(worst.source, wrong);
    EXPECT_NEAR(std::abs(worst.gross_error), 0.15, 0.05);
    EXPECT_EQ(words_of(block.geodetic[wrong], block), kind == GeodeticKind::kAtHeight  ? "gcp3 at height wall"
                                                      : kind == GeodeticKind::kOnPlane ? "gcp3 on plane wall"
                                                                                       : "gcp3 on line wall, upwards");
  }
}

TEST(Shape, VarianceComponentsFindTheirSigma) {
  Marked made = on_shape(GeodeticKind::kOnPlane, 0.06, 5, 0.2, 0.02, 40);
  for (GeodeticObservation& one : made.block.geodetic) one.sigma = 0.02;
  const auto found = estimate_variance_components(made.block, {}, tested(), kRun);
  ASSERT_TRUE(found) << found.error().message;
  const auto group = static_cast<std::size_t>(ObservationGroup::kOnPlane);
  EXPECT_NEAR(found->factors[group], 3, 4 * found->sigma[group]);
}

TEST(Shape, WhatSaysNothingIsLeftOutAndNamed) {
  for (const GeodeticKind kind : kShapes) {
    Marked made = on_shape(kind, kSigma_m, 1);
    const auto few = static_cast<std::uint32_t>(points_of_shape(kind));
    std::erase_if(made.block.geodetic, [&](const GeodeticObservation& one) { return one.from.value >= few; });
    const auto adjusted = examine(made.block, {}, tested(), kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    EXPECT_TRUE(adjusted->geodetic.empty());
    EXPECT_TRUE(!adjusted->undetermined);
    ASSERT_EQ(adjusted->weaknesses.size(), 1u);
    EXPECT_EQ(adjusted->weaknesses[0].code, FindingCode::kGeodeticLeftOut);
  }
  // A line is no plane.
  Marked line = on_shape(GeodeticKind::kOnLine, 0, 1);
  for (GeodeticObservation& one : line.block.geodetic) one.kind = GeodeticKind::kOnPlane;
  std::erase_if(line.block.geodetic, [](const GeodeticObservation& one) { return one.axis == 1; });
  const auto adjusted = examine(line.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted);
  EXPECT_TRUE(adjusted->geodetic.empty());
  Marked two = on_shape(GeodeticKind::kOnPlane, kSigma_m, 1);
  two.block.geodetic[0].to = {5};
  EXPECT_EQ(examine(two.block, {}, tested(), kRun).error().code, Errc::kBadInput);
}

// A check observation is compared with the shape of the others.
TEST(Shape, WhatIsOnlyComparedDoesNotBendTheShape) {
  Marked made = on_shape(GeodeticKind::kOnPlane, 0, 4, 0.3);
  made.block.geodetic[2].role = ControlRole::kCheck;
  made.block.geodetic[2].value = 1;
  const auto adjusted = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted);
  EXPECT_FALSE(adjusted->geodetic[2].used);
  EXPECT_NEAR(adjusted->geodetic[2].difference, -1, 0.1);
  EXPECT_LT(std::abs(adjusted->geodetic[2].difference + 1), 4 * adjusted->geodetic[2].difference_sigma);
}

}  // namespace
}  // namespace collinea
