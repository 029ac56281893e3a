// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/hough.h"

#include "collinea/feature/edges.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "collinea/feature/ellipse.h"
#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The mean of chi-squared over its degrees of freedom and the share within the limit of 95 %.
struct ChiSquared {
  double limit = 0, dof = 0, sum = 0, within = 0, count = 0;
  void add(double value) {
    sum += value / dof;
    within += value < limit;
    ++count;
  }
  void expect() const {
    EXPECT_GE(sum / count, 0.8);  // 1 +- 3 sqrt(1 / 200)
    EXPECT_LE(sum / count, 1.2);
    EXPECT_GE(within / count, 0.92);
    EXPECT_LE(within / count, 0.98);
  }
};

EdgeMap edges_of(const FloatImage& image, double noise) { return detect_edges(image, {.noise_grey = noise}); }

TEST(HoughLines, FindsTheSidesOfASquareThroughGaps) {
  const auto square = [](const Vector2d& p) {
    const Vector2d q = (p - Vector2d(60.3, 58.8)).cwiseAbs();
    const bool is_gap = std::abs(p.y() - 58) < 6;
    return is_gap ? 0.0 : blurred_step(30 - q.x(), 0.7) * blurred_step(25 - q.y(), 0.7);
  };
  const EdgeMap map = edges_of(render_shape(120, 120, square, 2), 2);
  const auto lines = hough_lines(edge_points_of(map), {});
  ASSERT_GE(lines.size(), 4u);
  const auto has = [&](double theta, double r) {
    return std::any_of(lines.begin(), lines.end(), [&](const FoundLine& l) {
      return std::abs(std::remainder(l.line.theta_rad - theta, 2 * std::numbers::pi)) < 0.01 &&
             std::abs(l.line.r_px - r) < 0.3;
    });
  };
  EXPECT_TRUE(has(0, 30.3));  // x cos + y sin = r, bright beyond
  EXPECT_TRUE(has(std::numbers::pi, -90.3));
  EXPECT_TRUE(has(std::numbers::pi / 2, 33.8));
  EXPECT_TRUE(has(-std::numbers::pi / 2, -83.8));
}

TEST(HoughLines, CovariancesAreTheErrors) {
  ChiSquared chi{5.991, 2};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const double theta = std::remainder(0.37 * double(seed), 2 * std::numbers::pi);
    const Vector2d normal(std::cos(theta), std::sin(theta));
    const double r = normal.dot(Vector2d(30.2, 31.1));
    const EdgeMap map = edges_of(render_shape(62, 62, half_plane(theta, r, 0.8), 5, seed), 5);
    const auto lines = hough_lines(edge_points_of(map), {});
    ASSERT_GE(lines.size(), 1u) << seed;
    const EdgeLine& line = lines[0].line;
    const Vector2d error(std::remainder(line.theta_rad - theta, 2 * std::numbers::pi), line.r_px - r);
    chi.add(error.dot(line.covariance.inverse() * error));
  }
  chi.expect();
}

TEST(HoughCircles, FindsBrightAndDarkOnesAmongLines) {
  const auto world = [](const Vector2d& p) {
    const double bright = disc({40.4, 45.2}, 18, 0.7)(p), dark = disc({100.7, 60.1}, 25, 0.7)(p);
    const double bar = blurred_step(4 - std::abs(p.y() - 108), 0.7);
    return 0.5 + 0.5 * bright - 0.5 * dark + 0.5 * bar;
  };
  const EdgeMap map = edges_of(render_shape(150, 120, world, 2), 2);
  const auto circles = hough_circles(edge_points_of(map), {});
  ASSERT_EQ(circles.size(), 2u);
  for (const FoundCircle& c : circles) {
    const Vector3d truth = c.circle.is_bright ? Vector3d(40.4, 45.2, 18) : Vector3d(100.7, 60.1, 25);
    EXPECT_LT((c.circle.centre - truth.head<2>()).norm(), 0.06);
    EXPECT_NEAR(c.circle.radius_px, truth[2], 0.1);
    EXPECT_GT(c.circle.arc_rad, 6);
  }
}

// The centre; the radius has in addition what smoothing shifts a curved edge.
TEST(HoughCircles, CovariancesOfCentresAreTheErrors) {
  ChiSquared chi{5.991, 2};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed, 5);
    const Vector2d centre(24 + random.uniform(), 24 + random.uniform());
    const EdgeMap map = edges_of(render_shape(48, 48, disc(centre, 14, 0.8), 5, seed), 5);
    const auto circles = hough_circles(edge_points_of(map), {.largest_radius_px = 20});
    ASSERT_EQ(circles.size(), 1u);
    const EdgeCircle& c = circles[0].circle;
    const Vector2d error = c.centre - centre;
    chi.add(error.dot(c.covariance.topLeftCorner<2, 2>().inverse() * error));
  }
  chi.expect();
}

TEST(HoughShapes, FindsATurnedAndScaledShape) {
  // A drop: a disc and a smaller one beside it.
  const auto drop = [](const Vector2d& at, double angle, double scale) {
    const Vector2d along(std::cos(angle), std::sin(angle));
    return [=](const Vector2d& p) {
      return std::max(disc(at, 16 * scale, 0.7)(p), disc(at + 20 * scale * along, 8 * scale, 0.7)(p));
    };
  };
  const EdgeMap map = edges_of(render_shape(90, 70, drop({35, 35}, 0, 1)), 1);
  const auto table = ShapeTable::create(map.points, {35, 35});
  ASSERT_TRUE(table);
  const EdgeMap scene = edges_of(render_shape(150, 130, drop({70.3, 62.6}, 0.7, 1.1), 2), 2);
  ShapeSearch search;
  for (int k = -12; k < 12; ++k) search.rotations_rad.push_back(k * std::numbers::pi / 12);
  search.scales = {1, 1.15};
  const auto found = hough_shapes(edge_points_of(scene), *table, search, {});
  ASSERT_GE(found.size(), 1u);
  EXPECT_LT((found[0].at - Vector2d(70.3, 62.6)).norm(), 0.15);
  EXPECT_NEAR(found[0].rotation_rad, 0.7, 0.01);
  EXPECT_NEAR(found[0].scale, 1.1, 0.01);
  EXPECT_EQ(found[0].covariance.rows(), 4);
  EXPECT_FALSE(ShapeTable::create({}, {0, 0}));
}

// A drop whose edge points are exact, from the formula of its two discs (those of one that lie in the other left out).
std::vector<EdgePoint> drop_points(double large_px, double small_px, double apart_px) {
  std::vector<EdgePoint> points;
  const auto add = [&](const Vector2d& c, double radius, const Vector2d& other, double other_radius) {
    const int count = int(2 * std::numbers::pi * radius);
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      const Vector2d out(std::cos(angle), std::sin(angle)), at = c + radius * out;
      if ((at - other).norm() > other_radius + 2) points.push_back({.at = at, .normal = -out, .sigma_px = 1});
    }
  };
  add({0, 0}, large_px, {apart_px, 0}, small_px);
  add({apart_px, 0}, small_px, {0, 0}, large_px);
  return points;
}

// x, y, rotation and scale, without knowing any: e' C^-1 e has four degrees of freedom, its mean over n is 4 with a
// standard deviation of sqrt(8 / n). The table is that of the shape without noise: smoothing moves edges of curvature k
// by some k / 2 px, which then is in the table, too, but for the change of k with a scale of 0.93 to 1.07 (0.003 px).
TEST(HoughShapes, CovarianceWithRotationAndScaleIsThatOfTheErrors) {
  constexpr int kScenes = 60;
  const auto drop = [](const Vector2d& at, double angle, double scale) {
    const Vector2d beside = at + 24 * scale * Vector2d(std::cos(angle), std::sin(angle));
    return [=](const Vector2d& p) { return std::max(disc(at, 20 * scale, 0.7)(p), disc(beside, 11 * scale, 0.7)(p)); };
  };
  const EdgeMap map = edges_of(render_shape(125, 115, drop({60, 55}, 0.3, 1)), 1);
  const auto table = ShapeTable::create(map.points, {60, 55});
  ASSERT_TRUE(table);
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Random random(seed, 9);
    const double angle = random.uniform(-0.25, 0.25), scale = random.uniform(0.93, 1.07);
    const Vector2d at(60 + random.uniform(), 55 + random.uniform());
    const EdgeMap scene = edges_of(render_shape(125, 115, drop(at, 0.3 + angle, scale), 12, seed), 12);
    const auto found = hough_shapes(edge_points_of(scene), *table, shape_search(*table, 0.3, 0.9, 1.1), {.most = 1});
    ASSERT_GE(found.size(), 1u) << seed;
    ASSERT_EQ(found[0].covariance.rows(), 4);
    Eigen::Vector4d error;
    error << found[0].at - at, found[0].rotation_rad - angle, found[0].scale - scale;
    sum += error.dot(found[0].covariance.inverse() * error);
  }
  EXPECT_NEAR(sum / kScenes, 4, 4 * std::sqrt(8.0 / kScenes));
}

TEST(HoughShapes, SearchLeavesNoGapAndNoOtherScale) {
  const auto table = ShapeTable::create(drop_points(30, 16, 36), {0, 0});
  ASSERT_TRUE(table);
  const ShapeSearch search = shape_search(*table, 4, 0.5, 2);  // more than half a turn: all
  EXPECT_DOUBLE_EQ(search.rotations_rad.front(), -std::numbers::pi);
  EXPECT_DOUBLE_EQ(search.scales.front(), 0.5);
  EXPECT_NEAR(search.scales.back(), 2, 1e-12);
  const double radius = table->radius_px();
  for (std::size_t i = 1; i < search.scales.size(); ++i)
    EXPECT_LE(radius * (search.scales[i] - search.scales[i - 1]), 4 + 1e-9);
  for (std::size_t i = 1; i < search.rotations_rad.size(); ++i)
    EXPECT_LE(2 * radius * (search.rotations_rad[i] - search.rotations_rad[i - 1]), 4 + 1e-9);
  const ShapeSearch known = shape_search(*table, 0, 1.2, 1.2);
  EXPECT_EQ(known.rotations_rad, std::vector<double>{0});
  EXPECT_EQ(known.scales, std::vector<double>{1.2});
  // A shape of another size than was searched is none of it.
  const auto scene = [](const Vector2d& p) {
    return std::max(disc({90, 85}, 42, 0.7)(p), disc({90 + 50.4, 85}, 22.4, 0.7)(p));
  };
  const EdgeMap map = edges_of(render_shape(190, 170, scene, 2), 2);
  for (const FoundShape& found : hough_shapes(edge_points_of(map), *table, shape_search(*table, 0, 0.8, 1.1), {}))
    EXPECT_LE(found.scale, 1.1 * (1 + 4 / radius));
  const auto right = hough_shapes(edge_points_of(map), *table, shape_search(*table, 0, 0.8, 1.5), {});
  ASSERT_GE(right.size(), 1u);
  EXPECT_NEAR(right[0].scale, 1.4, 0.01);
  // Rotation of a disc is not determined.
  std::vector<EdgePoint> round;
  for (int k = 0; k < 120; ++k) {
    const Vector2d out(std::cos(k * std::numbers::pi / 60), std::sin(k * std::numbers::pi / 60));
    round.push_back({.at = 20 * out, .normal = -out, .sigma_px = 1});
  }
  const auto circle = ShapeTable::create(round, {0, 0});
  const EdgeMap of_disc = edges_of(render_shape(80, 80, disc({40, 40}, 20, 0.7), 2), 2);
  EXPECT_TRUE(hough_shapes(edge_points_of(of_disc), *circle, shape_search(*circle, 0.5, 1, 1), {}).empty());
  EXPECT_EQ(hough_shapes(edge_points_of(of_disc), *circle, shape_search(*circle, 0, 0.8, 1.2), {}).size(), 1u);
}

TEST(EdgeFits, RefuseWhatDeterminesNothing) {
  EXPECT_FALSE(fit_line({}, 1));
  std::vector<EdgePoint> same(6, EdgePoint{{3, 4}, {1, 0}, 10, 0.1});
  EXPECT_FALSE(fit_line(same, 1));
  EXPECT_FALSE(fit_circle(same, 1));
  EXPECT_FALSE(fit_ellipse(same, 1));
  std::vector<EdgePoint> straight;
  for (int i = 0; i < 20; ++i) straight.push_back({{double(i), 5.0}, {0, 1}, 10, 0.1});
  EXPECT_FALSE(fit_circle(straight, 1));
  EXPECT_FALSE(fit_ellipse(straight, 1));
  EXPECT_TRUE(hough_lines({{}, 10, 10, 1}, {}).empty());
  EXPECT_TRUE(hough_circles({{}, 10, 10, 1}, {}).empty());
}

std::vector<EdgePoint> points_on(const Ellipse& e, int count, double arc = 2 * std::numbers::pi) {
  std::vector<EdgePoint> out;
  for (int i = 0; i < count; ++i) {
    const Vector2d at = e.at(0.3 + arc * i / count);
    out.push_back({at, (e.centre - at).normalized(), 20, 0.05});
  }
  return out;
}

TEST(Ellipses, DerivativesAreTheNumericOnes) {
  const Ellipse e{{3, 4}, 7, 5, 0.4};
  for (const double t : {0.1, 1.3, 2.9, -2.0})
    for (int k = 0; k < 5; ++k) {
      const auto moved = [&](double by) {
        Ellipse m = e;
        double* parameters[] = {&m.centre.x(), &m.centre.y(), &m.major_px, &m.minor_px, &m.angle_rad};
        *parameters[k] += by;
        return m.at(t);
      };
      EXPECT_LT((e.derivatives_at(t).col(k) - (moved(1e-5) - moved(-1e-5)) / 2e-5).norm(), 1e-8) << k;
    }
  for (const Vector2d& p : {Vector2d(12, 9), Vector2d(3.5, 4.1), Vector2d(3, 4), Vector2d(-6, 1)}) {
    const Vector2d foot = e.at(e.foot_of(p));
    double least = 1e9;
    for (double t = 0; t < 6.3; t += 1e-3) least = std::min(least, (e.at(t) - p).norm());
    EXPECT_NEAR((foot - p).norm(), least, 1e-5);
  }
}

TEST(Ellipses, ExactPointsGiveTheEllipse) {
  for (const Ellipse& truth : {Ellipse{{103.2, 55.1}, 40, 12, -1.1}, Ellipse{{50, 50}, 20, 20, 0},
                               Ellipse{{50, 50}, 20, 19.5, 1.4}, Ellipse{{1000, 2000}, 8, 3, 0.2}}) {
    const auto fit = fit_ellipse(points_on(truth, 144), 1);
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->ellipse.centre - truth.centre).norm(), 1e-7);
    EXPECT_NEAR(fit->ellipse.major_px, truth.major_px, 1e-7);
    EXPECT_NEAR(fit->ellipse.minor_px, truth.minor_px, 1e-7);
    if (truth.major_px > truth.minor_px) {
      EXPECT_NEAR(fit->ellipse.angle_rad, truth.angle_rad, 1e-7);
    }
    EXPECT_TRUE(fit->is_bright);
    EXPECT_NEAR(fit->arc_rad, 2 * std::numbers::pi, 0.8);
  }
  EXPECT_TRUE(fit_ellipse(points_on({{50, 50}, 30, 20, 0.3}, 40, 2.5), 1));
  EXPECT_FALSE(fit_ellipse(points_on({{50, 50}, 30, 20, 0.3}, 4), 1));
}

TEST(Ellipses, CovariancesOfRenderedOnesAreTheErrors) {
  ChiSquared chi{5.991, 2};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed, 9);
    const Vector2d centre(28 + random.uniform(), 26 + random.uniform());
    const double angle = random.uniform(-1.5, 1.5), c = std::cos(angle), s = std::sin(angle);
    const auto white = [&](const Vector2d& p) {  // quick: the distance to first order
      const Vector2d d = p - centre;
      const Vector2d q((c * d.x() + s * d.y()) / 18, (-s * d.x() + c * d.y()) / 11);
      const double f = q.norm(), slope = Vector2d(q.x() / 18, q.y() / 11).norm() / std::max(f, 1e-9);
      return f < 0.3 ? 1.0 : blurred_step((1 - f) / slope, 0.8);
    };
    const EdgeMap map = edges_of(render_shape(56, 52, white, 5, seed), 5);
    ASSERT_FALSE(map.chains.empty());
    const auto fit = fit_ellipse(map.points_of(map.chains[0]), map.along_px);
    ASSERT_TRUE(fit);
    const Vector2d error = fit->ellipse.centre - centre;
    chi.add(error.dot(fit->centre_covariance().inverse() * error));
    EXPECT_LT(error.norm(), 0.15);
  }
  chi.expect();
}

// The circle of radius 1 in a plane seen obliquely: the image of its centre against its points.
TEST(Ellipses, TheCentreOfTheEllipseIsNotThatOfTheCircle) {
  Matrix3d h;
  h << 1000, 200, 3000, 50, 900, 2500, 0.1, 0.2, 5;
  const auto image = image_of_circle(h, {0.5, -0.2}, 0.8);
  ASSERT_TRUE(image);
  for (double t = 0; t < 6.2; t += 0.3) {
    const Vector2d on_circle(0.5 + 0.8 * std::cos(t), -0.2 + 0.8 * std::sin(t));
    EXPECT_NEAR(image->ellipse.distance_px((h * on_circle.homogeneous()).hnormalized()), 0, 1e-7);
  }
  EXPECT_GT(image->eccentricity().norm(), 0.1);
  EXPECT_FALSE(image_of_circle(h, {0, -25}, 3));  // beyond the horizon
  h.row(2) << 0, 0, 5;
  EXPECT_LT(image_of_circle(h, {0.5, -0.2}, 0.8)->eccentricity().norm(), 1e-9);
}

}  // namespace
}  // namespace collinea
