// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/monoplot.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Function = std::function<double(double x, double y)>;

constexpr double kCell_m = 0.5;
constexpr int kCells = 400;  // 200 m, from -100 to 100
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A surface whose cells hold the heights of a function at their middles.
HeightField field_of(const Function& height, const Function& sigma = {}) {
  const auto raster = [](const Function& of) {
    FloatImage image(kCells, kCells, 1);
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x)
        image.at(x, y) = float(of(-100 + kCell_m * (x + 0.5), 100 - kCell_m * (y + 0.5)));
    return image;
  };
  const auto reader = [](FloatImage image) {
    return [image = std::move(image)](int column, int row, int width, int height) -> Result<FloatImage> {
      FloatImage out(width, height, 1);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) out.at(x, y) = image.at(column + x, row + y);
      return out;
    };
  };
  HeightField field{.grid = {-100, 100, kCell_m, kCells, kCells, ""}, .read = reader(raster(height)), .read_sigma = {}};
  if (sigma) field.read_sigma = reader(raster(sigma));
  return field;
}

const Camera& camera() {
  static const Camera made = ideal_camera(1000, 2000, 2000);
  return made;
}

// Looks down from a position, tilted about the y axis by an angle towards +x.
Rigid3 pose_at(const Vector3d& centre, double tilt_rad) {
  Rigid3 pose;
  const Eigen::Quaterniond ground_from_camera =
      Eigen::Quaterniond(Eigen::AngleAxisd(-tilt_rad, Vector3d::UnitY())) * Eigen::Quaterniond(0, 1, 0, 0);
  pose.rotation = ground_from_camera.conjugate().normalized();
  pose.translation = -(pose.rotation * centre);
  return pose;
}

UncertainSightLine line_to(const Rigid3& pose, const Vector3d& point) {
  return {.line = {&camera(), pose, *project(camera(), pose * point), 1, {}}};
}

MonoplotPoint plotted(const UncertainSightLine& line, const HeightField& field, std::optional<double> sigma_m = {}) {
  const auto points = monoplot(std::span(&line, 1), field, sigma_m, {});
  EXPECT_TRUE(points);
  return points->front();
}

double slope_plane(double x, double y) { return 5 + 0.25 * x - 0.125 * y; }  // exact in float at the middles of cells

TEST(Monoplot, MeetsAPlaneWhereItLies) {
  const HeightField field = field_of(slope_plane);
  for (const double tilt : {0.0, 0.5, -0.7})
    for (const Vector2d& plan : {Vector2d(0.13, 7.7), Vector2d(-31.4, 20.02), Vector2d(44.4, -55.5)}) {
      const Vector3d truth(plan.x(), plan.y(), slope_plane(plan.x(), plan.y()));
      const auto found = plotted(line_to(pose_at({-80 * std::tan(tilt), 3, 120}, tilt), truth), field);
      ASSERT_EQ(found.outcome, MonoplotOutcome::kFound);
      EXPECT_LT((found.position - truth).norm(), 1e-9);  // rounding of numbers of some hundred metres
    }
}

// Real errors of image point, orientation and height beside the covariance: it has rank 3 where the height has a sigma,
// so that e' C^-1 e has the mean 3, and over n = 2000 the standard deviation sqrt(6 / n); four of them.
TEST(Monoplot, CovarianceMatchesTheRealErrors) {
  const HeightField exact = field_of(slope_plane);
  const Rigid3 pose = pose_at({-60, 10, 130}, 0.45);
  const Vector3d truth(12.25, -8.5, slope_plane(12.25, -8.5));
  UncertainSightLine line = line_to(pose, truth);
  line.line.sigma_px = 0.7;
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << 0.0008, 0.0005, 0.001, 0.06, 0.08, 0.1;
  line.pose_covariance = sigmas.cwiseAbs2().asDiagonal();
  constexpr double kHeightSigma_m = 0.15;
  constexpr int kTrials = 2000;
  double sum = 0;
  for (int n = 0; n < kTrials; ++n) {
    Random random(11, std::uint64_t(n));
    UncertainSightLine seen = line;
    for (int k = 0; k < 2; ++k) seen.line.pixel[k] += line.line.sigma_px * random.normal();
    Vector3d turn, shift;
    for (int k = 0; k < 3; ++k) turn[k] = sigmas[k] * random.normal();
    for (int k = 0; k < 3; ++k) shift[k] = sigmas[3 + k] * random.normal();
    const Vector3d centre = centre_of(pose) + shift;
    seen.line.cam_from_world.rotation = (pose.rotation * rotation_by(turn).conjugate()).normalized();
    // The surface is too high by e: the same as a camera that is too low, and a point that is lifted back.
    const Vector3d lift(0, 0, kHeightSigma_m * random.normal());
    seen.line.cam_from_world.translation = -(seen.line.cam_from_world.rotation * (centre - lift));
    MonoplotPoint found = plotted(seen, exact, kHeightSigma_m);
    ASSERT_EQ(found.outcome, MonoplotOutcome::kFound);
    const Vector3d error = found.position + lift - truth;
    sum += error.dot(found.covariance.ldlt().solve(error)) / kTrials;
  }
  EXPECT_NEAR(sum, 3, 4 * std::sqrt(6.0 / kTrials));
}

TEST(Monoplot, TheFirstSurfaceHidesWhatLiesBehind) {
  // A ridge of 40 m across the way of a flat ray; behind it the ground.
  const auto ridge = [](double x, double) { return std::max(0.0, 40 - 4 * std::abs(x)); };
  const HeightField field = field_of(ridge);
  const Rigid3 pose = pose_at({-90, 0, 50}, 1.1);
  const auto found = plotted(line_to(pose, {30, 0, 0}), field);  // a line of sight through the ridge
  ASSERT_EQ(found.outcome, MonoplotOutcome::kFound);
  const double slope = -50.0 / 120;
  const double x = (50 + 90 * slope - 40) / (4 - slope);  // 50 + slope (x + 90) = 40 + 4 x
  EXPECT_NEAR(found.position.x(), x, 1e-6);
  EXPECT_LT(x, 0);
}

TEST(Monoplot, HeightsWithoutASigmaLeaveItUnknown) {
  const auto sigma = [](double x, double) { return x < 0 ? 0.25 : double(kNan); };
  const HeightField field = field_of(slope_plane, sigma);
  const Rigid3 pose = pose_at({0, 0, 150}, 0);
  const auto stated = plotted(line_to(pose, {-20, 5, slope_plane(-20, 5)}), field);
  EXPECT_EQ(stated.height_sigma_m, 0.25);
  const UncertainSightLine other = line_to(pose, {20, 5, slope_plane(20, 5)});
  EXPECT_TRUE(std::isnan(plotted(other, field).height_sigma_m));
  EXPECT_EQ(plotted(other, field, 0.5).height_sigma_m, 0.5);
  // Straight down a height is as wrong as it is, and wrong plan positions follow from it along the ray.
  const auto down =
      plotted(line_to(pose, {0, 0, slope_plane(0, 0)}), field_of([](double, double) { return 5.0; }), 0.5);
  EXPECT_NEAR(std::sqrt(down.covariance(2, 2)), 0.5, 1e-9);
}

// A raster of 20 km, never held as a whole: a ray that runs flat over all of it, crosswise, is followed piece by piece,
// and meets the plane as exactly as a steep one.
TEST(Monoplot, OfALargeRasterOnlyPiecesAreHeld) {
  constexpr int kMany = 40'000;
  std::int64_t largest = 0;
  const auto height = [](double x, double y) { return 0.001 * x - 0.002 * y; };
  const MapGrid grid{0, 0, kCell_m, kMany, kMany, ""};
  HeightField field{.grid = grid, .read = {}, .read_sigma = {}};
  field.read = [&](int column, int row, int width, int rows) -> Result<FloatImage> {
    largest = std::max(largest, std::int64_t(width) * rows);
    FloatImage out(width, rows, 1);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < width; ++x)
        out.at(x, y) = float(height(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5)));
    return out;
  };
  const Vector3d from(500, -500, 1900), to(18'000, -17'000, height(18'000, -17'000));
  const HeightSpan span{0, 60};
  const auto met = meeting({from, (to - from) / 100}, field, {0, 2000}, {});
  ASSERT_TRUE(met) << met.error().message;
  ASSERT_EQ(met->outcome, MonoplotOutcome::kFound);
  EXPECT_LT((from + met->t * (to - from) / 100 - to).norm(), 0.2);  // heights as floats, at 4.4 degrees
  EXPECT_NEAR(met->slope.x(), 0.001, 1e-4);
  EXPECT_NEAR(met->slope.y(), -0.002, 1e-4);
  EXPECT_LT(largest, 300 * 300);
  EXPECT_EQ(meeting({from, (to - from) / 100}, field, span, {})->outcome, MonoplotOutcome::kFound);
  // Pieces end somewhere: what is met does not depend on where the ray begins.
  for (const double ahead : {1.0, 77.7, 500.25}) {
    const Vector3d later = from + ahead * (to - from).normalized();
    const auto again = meeting({later, (to - from) / 100}, field, {0, 2000}, {});
    ASSERT_TRUE(again);
    EXPECT_LT((later + again->t * (to - from) / 100 - to).norm(), 0.2) << ahead;
  }
}

TEST(Monoplot, TellsWhyThereIsNoPoint) {
  const auto flat = [](double, double) { return 10.0; };
  const auto hole = [](double x, double y) { return std::hypot(x, y) < 10 ? double(kNan) : 10.0; };
  const Rigid3 down = pose_at({0, 0, 150}, 0);
  EXPECT_EQ(plotted(line_to(down, {140, 0, 10}), field_of(flat)).outcome, MonoplotOutcome::kMisses);
  EXPECT_EQ(plotted(line_to(down, {2, 3, 10}), field_of(hole)).outcome, MonoplotOutcome::kHole);
  const Rigid3 flat_view = pose_at({-90, 0, 40}, 1.2);
  // Into the hole: above the surface before it, below it behind it.
  const auto slanting = [](double x, double y) { return std::hypot(x, y) < 10 ? double(kNan) : 0.05 * x; };
  EXPECT_EQ(plotted(line_to(flat_view, {0, 0, 0}), field_of(slanting)).outcome, MonoplotOutcome::kHole);
  EXPECT_EQ(plotted(line_to(pose_at({0, 0, 5}, 0), {3, 0, 0}), field_of(flat)).outcome, MonoplotOutcome::kMisses);
  // Half a metre above a plane, that comes down to it over 96 m: 0.3 degrees.
  const auto plane = [](double x, double) { return 0.0625 * x; };
  const Rigid3 along = pose_at({-90, 0, 0.0625 * -90 + 0.5}, 1.5);
  EXPECT_EQ(plotted(line_to(along, {6, 0, 0.0625 * 6}), field_of(plane)).outcome, MonoplotOutcome::kGrazes);
  // A cliff between the camera and the raster's border: the ray comes in below it.
  const auto cliff = [](double x, double) { return x < 0 ? 50.0 : 0.0; };
  EXPECT_EQ(plotted(line_to(pose_at({-150, 0, 40}, 1.2), {50, 0, 0}), field_of(cliff)).outcome,
            MonoplotOutcome::kBelow);
  const auto empty = monoplot({}, field_of([](double, double) { return double(kNan); }), {}, {});
  EXPECT_FALSE(empty);
}

}  // namespace
}  // namespace collinea
