// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/edges.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "collinea/feature/internal/edge_filters.h"
#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Mussio D.5 (tables A.1 and A.2): every mask is zero on uniform regions; his second Roberts mask is printed like the
// first (erratum E49).
TEST(EdgeMasks, AreThoseOfMussioD5) {
  for (const auto& entry : kEdgeOperatorWords)
    for (const EdgeMask& mask : edge_masks(entry.value))
      EXPECT_NEAR(std::accumulate(mask.begin(), mask.end(), 0.0), 0, 1e-15) << entry.word;
  constexpr double kRoot = std::numbers::sqrt2;
  using Pair = std::vector<EdgeMask>;
  EXPECT_EQ(edge_masks(EdgeOperator::kRoberts), (Pair{{0, 1, 0, -1, 0, 0, 0, 0, 0}, {1, 0, 0, 0, -1, 0, 0, 0, 0}}));
  EXPECT_EQ(edge_masks(EdgeOperator::kPrewitt), (Pair{{-1, 0, 1, -1, 0, 1, -1, 0, 1}, {-1, -1, -1, 0, 0, 0, 1, 1, 1}}));
  EXPECT_EQ(edge_masks(EdgeOperator::kSobel), (Pair{{-1, 0, 1, -2, 0, 2, -1, 0, 1}, {-1, -2, -1, 0, 0, 0, 1, 2, 1}}));
  EXPECT_EQ(edge_masks(EdgeOperator::kIsotropic),
            (Pair{{-1, 0, 1, -kRoot, 0, kRoot, -1, 0, 1}, {-1, -kRoot, -1, 0, 0, 0, 1, kRoot, 1}}));
  EXPECT_EQ(edge_masks(EdgeOperator::kPrewittCompass)[0], (EdgeMask{1, 1, 1, 1, -2, 1, -1, -1, -1}));
  EXPECT_EQ(edge_masks(EdgeOperator::kRobinson3)[0], (EdgeMask{1, 1, 1, 0, 0, 0, -1, -1, -1}));
  EXPECT_EQ(edge_masks(EdgeOperator::kRobinson5)[0], (EdgeMask{1, 2, 1, 0, 0, 0, -1, -2, -1}));
  // Kirsch: one step is 45 degrees, two are 90.
  const auto kirsch = edge_masks(EdgeOperator::kKirsch);
  EXPECT_EQ(kirsch[0], (EdgeMask{5, 5, 5, -3, 0, -3, -3, -3, -3}));
  EXPECT_EQ(kirsch[1], (EdgeMask{5, 5, -3, 5, 0, -3, -3, -3, -3}));
  EXPECT_EQ(kirsch[2], (EdgeMask{5, -3, -3, 5, 0, -3, 5, -3, -3}));
  EXPECT_EQ(edge_masks(EdgeOperator::kPrewittCompass)[4], (EdgeMask{-1, -1, -1, 1, -2, 1, 1, 1, 1}));
}

class EveryEdgeOperator : public testing::TestWithParam<EdgeOperator> {};

TEST_P(EveryEdgeOperator, MeasuresTheSlopeOfARamp) {
  FloatImage ramp(40, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) ramp.at(x, y) = float(3 * x + 3 * y);
  const EdgeMap map = detect_edges(ramp, {.edge_operator = GetParam()});
  const bool is_compass = edge_masks(GetParam()).size() == 8;
  EXPECT_NEAR(map.amplitude.at(20, 15), 3 * std::numbers::sqrt2, is_compass ? 1.3 : 1e-3);
  EXPECT_NEAR(map.direction_rad.at(20, 15), std::numbers::pi / 4, 1e-4);
}

TEST_P(EveryEdgeOperator, FindsAStraightEdgeWhereItIs) {
  for (const double degrees : {0.0, 17.0, 45.0, 113.0, 200.0, 290.0}) {
    const double theta = degrees * std::numbers::pi / 180;
    const Vector2d normal(std::cos(theta), std::sin(theta));
    const double r = normal.dot(Vector2d(24.3, 21.8));
    const EdgeMap map = detect_edges(render_shape(48, 44, half_plane(theta, r, 0.7)), {.edge_operator = GetParam()});
    ASSERT_EQ(map.chains.size(), 1u) << degrees;
    EXPECT_GT(map.points.size(), 25u);
    EXPECT_FALSE(map.chains[0].is_closed);
    for (const EdgePoint& p : map.points) {
      EXPECT_NEAR(normal.dot(p.at), r, GetParam() == EdgeOperator::kHaralick ? 0.06 : 0.03) << degrees;
      EXPECT_GT(normal.dot(p.normal), 0.98);
      EXPECT_NEAR(p.amplitude, 36, 18);
    }
  }
}

// The error across the edge over its standard deviation is a standard normal variable. With much noise: the systematic
// errors of a facet, which is no edge, are 0.02 px.
TEST_P(EveryEdgeOperator, ItsSigmasAreTheErrors) {
  double sum = 0, within = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const double theta = 0.37 * double(seed);
    const Vector2d normal(std::cos(theta), std::sin(theta));
    const double r = normal.dot(Vector2d(45.2, 44.7));
    const FloatImage image = render_shape(90, 90, half_plane(theta, r, 0.8), 8, seed);
    for (const EdgePoint& p : detect_edges(image, {.edge_operator = GetParam(), .noise_grey = 8}).points) {
      const double ratio = (normal.dot(p.at) - r) / p.sigma_px;
      if (std::abs(ratio) > 6) continue;  // an edge of the noise
      sum += ratio * ratio;
      within += std::abs(ratio) < 1.96;
      ++count;
    }
  }
  EXPECT_GT(count, 2000);
  EXPECT_NEAR(sum / count, 1, 0.12);
  EXPECT_NEAR(within / count, 0.95, 0.025);
}

// Smoothing by s moves an edge of radius R by s^2 / 2R: zeros of the Laplacian outwards, maxima of the slope inwards.
TEST_P(EveryEdgeOperator, ADiscHasOneClosedEdge) {
  const EdgeMap map = detect_edges(render_shape(50, 50, disc({24.6, 25.3}, 14, 0.7)), {.edge_operator = GetParam()});
  ASSERT_EQ(map.chains.size(), 1u);
  EXPECT_TRUE(map.chains[0].is_closed);
  for (const EdgePoint& p : map.points) EXPECT_NEAR((p.at - Vector2d(24.6, 25.3)).norm(), 14, 0.25);
}

TEST_P(EveryEdgeOperator, NoEdgesWhereThereAreNone) {
  EXPECT_TRUE(detect_edges(FloatImage(50, 40, 1, 80), {.edge_operator = GetParam()}).points.empty());
  EXPECT_TRUE(detect_edges(with_noise(FloatImage(60, 60, 1, 80), 4, 7), {.edge_operator = GetParam()}).points.empty());
  for (const int size : {0, 1, 2, 6})
    EXPECT_TRUE(detect_edges(FloatImage(size, size, 1, 80), {.edge_operator = GetParam()}).points.empty());
}

INSTANTIATE_TEST_SUITE_P(Edges, EveryEdgeOperator,
                         testing::Values(EdgeOperator::kRoberts, EdgeOperator::kPrewitt, EdgeOperator::kSobel,
                                         EdgeOperator::kIsotropic, EdgeOperator::kPrewittCompass, EdgeOperator::kKirsch,
                                         EdgeOperator::kRobinson3, EdgeOperator::kRobinson5, EdgeOperator::kLog,
                                         EdgeOperator::kHaralick),
                         [](const auto& tested) {
                           std::string name(word_of(tested.param));
                           std::erase(name, '-');
                           return name;
                         });

TEST(Edges, NoiseIsEstimatedBesideEdges) {
  const FloatImage image = render_shape(80, 80, half_plane(0.5, 50, 0.7), 5, 3);
  EXPECT_NEAR(noise_of(image), 5, 0.4);
}

// A weak part of an edge is kept because it hangs together with a strong one.
TEST(Edges, HysteresisFollowsAnEdgeThatFades) {
  const auto fading = [](const Vector2d& p) { return blurred_step(p.x() - 30, 0.7) * (1 - p.y() / 70); };
  const FloatImage image = render_shape(60, 60, fading);
  const auto points = [&](double high, double low) {
    return detect_edges(image, {.high = high, .low = low}).points.size();
  };
  EXPECT_GT(points(26, 10), 40u);
  EXPECT_LT(points(26, 26), 35u);
  EXPECT_EQ(points(100, 10), 0u);
}

}  // namespace
}  // namespace collinea
