// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/pair_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/epipolar/relative_orientation.h"
#include "collinea/epipolar/relative_search.h"
#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

constexpr double kSigma = 1e-4;

bool has(const PairShape& shape, PairWeakness weakness) {
  return std::find(shape.weaknesses.begin(), shape.weaknesses.end(), weakness) != shape.weaknesses.end();
}

// Points of the world (base along x, z forward) as both images see them.
std::vector<PairPoint> seen_by(const Rigid3& motion, const std::vector<Eigen::Vector3d>& world) {
  std::vector<PairPoint> points;
  for (const Eigen::Vector3d& x : world) points.push_back({x.hnormalized(), scene::seen(motion, x), kSigma, kSigma});
  return points;
}

PairShape shape_of(const Rigid3& motion, const std::vector<Eigen::Vector3d>& world) {
  const auto points = seen_by(motion, world);
  return *pair_shape(motion, points, normal_of(motion, points));
}

Rigid3 normal_case() { return {Eigen::Quaterniond::Identity(), {-1, 0, 0}}; }

// A valley of radius r under a base on the rim of its circle, rough by +-roughness.
std::vector<Eigen::Vector3d> valley(double r, double roughness, int count, Random& random) {
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < count; ++i) {
    const double angle = random.uniform(-1.2, 1.2), radius = r + (i % 2 == 0 ? roughness : -roughness);
    out.emplace_back(random.uniform(-0.2, 1.2), radius * std::sin(angle), r + radius * std::cos(angle));
  }
  return out;
}

TEST(PairShape, NamesTheCriticalCylinder) {
  Random random(1);
  const PairShape shape = shape_of(normal_case(), valley(0.8, 0, 30, random));
  EXPECT_TRUE(has(shape, PairWeakness::kCylinder));
  EXPECT_LT(shape.epsilon, 1e-12);
  EXPECT_NEAR(shape.cylinder->radius, 0.8, 1e-9);
  EXPECT_LT(shape.cylinder->roughness, 1e-9);
}

TEST(PairShape, NamesANearCylinderAndMeasuresItsRoughness) {
  Random random(2);
  const PairShape shape = shape_of(normal_case(), valley(0.8, 0.03, 60, random));
  EXPECT_TRUE(has(shape, PairWeakness::kNearCylinder));
  EXPECT_FALSE(has(shape, PairWeakness::kCylinder));
  EXPECT_NEAR(shape.cylinder->roughness, 0.03, 0.004);
  EXPECT_GT(shape.inflation, 5);
}

// The same of a pair with turned images and an inclined base: the figure is one of the geometry.
TEST(PairShape, FindsTheCylinderAlongAnyBase) {
  Random random(3);
  const Eigen::Quaterniond turn = rotation_by({0.2, -0.3, 0.9});
  const Rigid3 first{turn, {0, 0, 0}}, second{rotation_by({0.1, 0.1, -0.5}) * turn, {0, 0, 0}};
  const Rigid3 shifted = second * Rigid3{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  std::vector<Eigen::Vector3d> in_first;
  for (const Eigen::Vector3d& x : valley(0.8, 0, 30, random))
    if (const Eigen::Vector3d p = first * x; p.z() > 0.2 && (shifted * x).z() > 0.2) in_first.push_back(p);
  ASSERT_GT(in_first.size(), 10u);
  const PairShape shape = shape_of(shifted * inverse(first), in_first);
  EXPECT_TRUE(has(shape, PairWeakness::kCylinder));
  EXPECT_NEAR(shape.cylinder->radius, 0.8, 1e-9);
}

TEST(PairShape, NamesPlanes) {
  Random random(4);
  std::vector<Eigen::Vector3d> flat, upright, high;
  for (int i = 0; i < 30; ++i) {
    const double x = random.uniform(0, 1), y = random.uniform(-1, 1);
    flat.emplace_back(x, y, 1.5 + 0.1 * x + 0.1 * y);
    upright.emplace_back(x, 0.3 * (1 + y / 2), 1.5 * (1 + y / 2));
    high.emplace_back(x, y, random.uniform(1.2, 2));
  }
  EXPECT_TRUE(has(shape_of(normal_case(), flat), PairWeakness::kPlane));
  EXPECT_TRUE(has(shape_of(normal_case(), upright), PairWeakness::kBasePlane));
  EXPECT_TRUE(shape_of(normal_case(), high).weaknesses.empty());
}

TEST(PairShape, NamesANarrowBandAndAShortBase) {
  Random random(5);
  std::vector<Eigen::Vector3d> band, far;
  for (int i = 0; i < 30; ++i) {
    band.emplace_back(random.uniform(0, 1), random.uniform(-0.1, 0.1), random.uniform(1.8, 2.2));
    far.emplace_back(random.uniform(-30, 30), random.uniform(-30, 30), random.uniform(50, 100));
  }
  EXPECT_TRUE(has(shape_of(normal_case(), band), PairWeakness::kNarrow));
  EXPECT_TRUE(has(shape_of(normal_case(), far), PairWeakness::kShortBase));
}

// 15 m of roughness at a height of 1000 m are far beyond noise: the plane is near, not true. Relief of a quarter is
// none.
TEST(PairShape, NamesANearPlane) {
  Random random(14);
  std::vector<Eigen::Vector3d> rough, relief;
  for (int i = 0; i < 60; ++i) {
    const double x = random.uniform(0, 1), y = random.uniform(-1, 1);
    rough.emplace_back(x, y, 2 + 0.1 * x + 0.03 * random.normal());
    relief.emplace_back(x, y, random.uniform(1.2, 2));
  }
  auto points = seen_by(normal_case(), rough);
  for (PairPoint& point : points) point.sigma_first = point.sigma_second = 1e-5;
  const PairShape shape = *pair_shape(normal_case(), points, normal_of(normal_case(), points));
  EXPECT_TRUE(has(shape, PairWeakness::kNearPlane));
  EXPECT_FALSE(has(shape, PairWeakness::kPlane));
  EXPECT_NEAR(shape.plane_roughness, 0.03, 4 * 0.03 / std::sqrt(120.0));  // an RMS of 60 values
  EXPECT_LT(shape.plane_normal.cross(Eigen::Vector3d(-0.1, 0, 1).normalized()).norm(), 0.05);
  EXPECT_FALSE(has(shape_of(normal_case(), relief), PairWeakness::kNearPlane));
}

TEST(PairShape, ThePlaneThroughTheBaseHasItsDirection) {
  Random random(15);
  std::vector<Eigen::Vector3d> upright;
  for (int i = 0; i < 30; ++i) {
    const double t = random.uniform(1, 2);
    upright.emplace_back(random.uniform(0, 1), 0.3 * t, 1.5 * t);
  }
  const PairShape shape = shape_of(normal_case(), upright);
  EXPECT_LT(shape.base_plane_roughness, 1e-12);
  const Eigen::Vector3d direction = shape.across_in_first * shape.base_plane_direction;
  EXPECT_LT(direction.cross(Eigen::Vector3d(0, 0.3, 1.5).normalized()).norm(), 1e-9);
}

// Points of a true plane fit two orientations to rounding; each is the second one of the other.
TEST(SecondOrientation, OfATruePlaneFitsAsWellAndIsMutual) {
  int found = 0;
  for (int seed = 0; seed < 20; ++seed) {
    Random random(500, static_cast<std::uint64_t>(seed));
    const Rigid3 truth = scene::random_motion(random);
    std::vector<Eigen::Vector3d> world;
    while (world.size() < 30)
      if (const auto x = scene::random_point_on_plane(random); (truth * x).z() > 0.5) world.push_back(x);
    const auto points = seen_by(truth, world);
    RelativeOptions options;
    options.sigma_known = true;
    const auto shape = pair_shape(truth, points, normal_of(truth, points));
    ASSERT_TRUE(shape);
    const auto second = second_orientation(truth, *shape, points, options);
    if (!second) continue;
    ++found;
    EXPECT_LT(second->sigma0, 1e-6);
    EXPECT_GT(angle_between(second->second_from_first.rotation, truth.rotation), 1e-4);
    const auto other = pair_shape(second->second_from_first, points, second->normal);
    if (!other || second->in_front < 30) continue;
    const auto back = second_orientation(second->second_from_first, *other, points, options);
    ASSERT_TRUE(back);
    EXPECT_LT(angle_between(back->second_from_first.rotation, truth.rotation), 1e-7);
  }
  EXPECT_GE(found, 18);  // of 20: a base along the normal of the plane alone has no second one
}

// The further points lie off the plane, the worse the second orientation fits.
TEST(SecondOrientation, OfANearPlaneIsToldApartByItsResiduals) {
  const Rigid3 truth{rotation_by({0.1, -0.2, 0.1}), Eigen::Vector3d(-1, 0.1, 0.3).normalized()};
  double before = 0;
  for (const double roughness : {0.0, 0.02, 0.08}) {
    Random random(16);
    std::vector<Eigen::Vector3d> world;
    for (int i = 0; i < 40; ++i)
      world.push_back(scene::random_point_on_plane(random) + Eigen::Vector3d(0, 0, roughness * random.normal()));
    const auto points = seen_by(truth, world);
    const auto shape = pair_shape(truth, points, normal_of(truth, points));
    ASSERT_TRUE(shape);
    const auto second = second_orientation(truth, *shape, points, {});
    ASSERT_TRUE(second);
    if (roughness == 0)
      EXPECT_LT(second->sigma0, 1e-6);
    else
      EXPECT_GT(second->sigma0, 2 * before);
    before = second->sigma0;
  }
}

TEST(CriticalPair, SaysWhatIsKnownWhereThereIsNoOrientation) {
  Random random(17);
  std::vector<Eigen::Vector3d> upright;
  for (int i = 0; i < 30; ++i) {
    const double t = random.uniform(1, 2);
    upright.emplace_back(random.uniform(0, 1), 0.3 * t, 1.5 * t);
  }
  RelativeOptions options;
  options.start = PairStart::kNearVertical;
  const auto cylinder = critical_pair(seen_by(normal_case(), valley(0.8, 0, 30, random)), options, 1);
  ASSERT_TRUE(cylinder);
  EXPECT_TRUE(has(cylinder->shape, PairWeakness::kCylinder));
  EXPECT_LT(cylinder->shape.epsilon, 1e-9);
  EXPECT_NEAR(cylinder->shape.cylinder->radius, 0.8, 1e-6);
  const auto plane = critical_pair(seen_by(normal_case(), upright), options, 1);
  ASSERT_TRUE(plane);
  EXPECT_TRUE(has(plane->shape, PairWeakness::kBasePlane));
  EXPECT_FALSE(critical_pair(std::vector<PairPoint>(4), options, 1));
}

// Points on a cylinder with the base leave no answer, whatever the start; the message says why.
TEST(PairShape, AnOrientationOnTheCylinderIsRefusedByName) {
  Random random(6);
  const auto points = seen_by(normal_case(), valley(0.8, 0, 30, random));
  RelativeOptions options;
  options.start = PairStart::kNearVertical;
  const auto found = relative_orientation(points, options, 1);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("cylinder"), std::string::npos) << found.error().message;
}

// Mussio D.8: R = 500, b = 600, six points (0, 0), (b, 0), (0, +-a), (b, +-a), a = 400: rank 4, the null vector of
// (by, bz, omega, phi, kappa) is (-1000, 0, 1, 0, 0) in metres and radians, with the signs of the collinearity
// equations (E31: 3.4.2 prints the other one).
TEST(PairShape, SixPointsOnACylinderHaveThePublishedNullVector) {
  const double b = 600, a = 400, r = 500, deep = 2 * r, at_side = r + std::sqrt(r * r - a * a);
  std::vector<Eigen::Vector3d> world;
  for (const double x : {0.0, b})
    for (const double y : {-a, 0.0, a}) world.emplace_back(x / b, y / b, (y == 0 ? deep : at_side) / b);
  const Rigid3 motion = normal_case();
  const auto points = seen_by(motion, world);
  const Matrix5 by = dependent_by_change(motion).inverse();
  const Matrix5 normal = by.transpose() * normal_of(motion, points) * by;
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(normal);
  EXPECT_LT(solver.eigenvalues()(0), 1e-12 * solver.eigenvalues()(4));
  EXPECT_GT(solver.eigenvalues()(1), 1e-6 * solver.eigenvalues()(4));
  const Vector5 null = solver.eigenvectors().col(0) / solver.eigenvectors()(2, 0);
  EXPECT_LT((null - (Vector5() << -1000 / b, 0, 1, 0, 0).finished()).norm(), 1e-9);
}

// The linear equation of y-parallaxes of a point (x, y) at the distance h from a base b, at the scale of the object:
// its coefficients of by [length], bz [1], omega, phi, kappa [rad].
Vector5 parallax_at_object(double x, double y, double h, double b) {
  Vector5 row = -h * parallax_equation({{x / h, -y / h}, {(x - b) / h, -y / h}}).coefficients;
  row(0) /= b;
  row(1) /= b;
  return row;
}

// Mussio D.8: those points, rough by +-delta in turn, and the smallest singular values of the design matrix.
TEST(PairShape, RoughnessRaisesTheSmallestSingularValueAsInMussioD8) {
  const double b = 600, a = 400, r = 500;
  const double published[][2] = {{5, 0.001437}, {25, 0.007079}, {50, 0.013931}, {100, 0.027231}};
  for (const auto& [delta, value] : published) {
    Eigen::Matrix<double, 6, 5> design;
    const double xy[6][2] = {{0, 0}, {b, 0}, {0, a}, {b, -a}, {0, -a}, {b, a}};
    for (int i = 0; i < 6; ++i) {
      const double x = xy[i][0], y = xy[i][1];
      const double h = r + std::sqrt(r * r - y * y) - (i % 2 == 0 ? delta : -delta);
      design.row(i) = parallax_at_object(x, y, h, b).transpose();
    }
    EXPECT_NEAR(Eigen::JacobiSVD<Eigen::MatrixXd>(design).singularValues()(4), value, 5e-7);
  }
}

// Mussio D.2: the six canonical positions on the cylinder, a = b = 1 and h = 1 at the sides (R = 1, h = 2 above its
// lowest line). With by = psi1 + psi2 and 2 R omega = psi1 - psi2 (the signs of the collinearity equations: E31) the
// column of psi2 is zero and the others are those of his table; the eigenvalues of the two minors of the normal matrix
// follow (off-diagonal a^2 b, E34), and with lambda_min = n sigma^2 / h^2 the roughness at which epsilon is 0.1.
TEST(PairShape, SixCanonicalPositionsHaveTheNormalMatrixOfMussioD2) {
  const double b = 1, a = 1, r = 1, xy[6][2] = {{0, 0}, {b, 0}, {0, a}, {b, -a}, {0, -a}, {b, a}};
  const double table[6][5] = {{2, 0, 0, 0, -1}, {2, 0, 0, 0, 0},    {2, 0, 1, 1, -1},
                              {2, 0, -1, 0, 0}, {2, 0, -1, -1, -1}, {2, 0, 1, 0, 0}};  // psi1, psi2, bz, phi, kappa
  Eigen::Matrix<double, 6, 5> design;
  for (int i = 0; i < 6; ++i) {
    const double x = xy[i][0], y = xy[i][1];
    const Vector5 row = parallax_at_object(x, y, r + std::sqrt(r * r - y * y), b);
    design.row(i) << row(0) + row(2) / (2 * r), row(0) - row(2) / (2 * r), row(1), row(3), row(4);
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(design(i, k), table[i][k], 1e-15) << i << ' ' << k;
  }
  const auto minor = [&](int one, int two) {
    Eigen::Matrix<double, 6, 2> columns;
    columns << design.col(one), design.col(two);
    return Eigen::Matrix2d(columns.transpose() * columns);
  };
  EXPECT_LT((minor(2, 3) - Eigen::Matrix2d{{4, 2}, {2, 2}}).norm(), 1e-14);  // n a^2 b / 3 h^2 = 2
  const auto eigenvalues = [](const Eigen::Matrix2d& m) {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(m).eigenvalues();
  };
  const Eigen::Vector2d plan = eigenvalues(minor(0, 4)), height = eigenvalues(minor(2, 3));
  EXPECT_LT((plan - Eigen::Vector2d(1.4066133776, 25.5933866224)).cwiseAbs().maxCoeff(), 5.1e-11);
  EXPECT_LT((height - Eigen::Vector2d(0.7639320225, 5.2360679775)).cwiseAbs().maxCoeff(), 5.1e-11);
  EXPECT_NEAR(std::sqrt(0.1 * plan(1) / 6), 0.65311, 5e-6);
}

// Mussio 3.4.3: at the lowest line of the cylinder a roughness delta gives psi2 the coefficient delta / h.
TEST(PairShape, RoughnessEntersAsInMussioD2) {
  const double r = 500, h = 2 * r, b = 600;
  for (const double delta : {-20.0, 5.0, 60.0}) {
    const Vector5 row = parallax_at_object(0, 0, h - delta, b);
    EXPECT_NEAR(row(0) - row(2) / (2 * r), delta / h, 1e-15);
  }
}

}  // namespace
}  // namespace collinea
