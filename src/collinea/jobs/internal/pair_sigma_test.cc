// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_sigma.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/dense/working_images.h"
#include "collinea/geometry/rotation.h"
#include "collinea/jobs/internal/pair_exterior.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kFocal_px = 1500, kHeight_m = 1000, kBase_m = 550, kPointSigma_px = 0.1, kControlSigma_px = 0.3,
                 kGroundSigma_m = 0.05;
constexpr int kSide_px = 2000, kPoints = 120, kControl = 6;

// A pair that looks down, a little tilted, at hills.
struct Flight {
  PairImages images;
  std::array<Rigid3, 2> cam_from_ground;
  std::vector<Eigen::Vector3d> ground;  // points of the orientation, then the control, then those to be judged

  Flight() {
    images.left_camera = images.right_camera = ideal_camera(kFocal_px, kSide_px, kSide_px);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Quaterniond down(0, 1, 0, 0);
      const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.02 - 0.05 * i, Eigen::Vector3d(1, 2, -1).normalized()));
      Rigid3& pose = cam_from_ground[std::size_t(i)];
      pose.rotation = (tilt * down).normalized();
      pose.translation = -(pose.rotation * Eigen::Vector3d((i - 0.5) * kBase_m, 10.0 * i, kHeight_m + 5 * i));
    }
    Random random(3);
    while (ground.size() < kPoints + kControl + 9) {
      const std::size_t n = ground.size();
      double x = random.uniform(-350, 350), y = random.uniform(-600, 600);
      if (n >= kPoints + kControl) {  // a grid, also between and beyond the control
        x = 170.0 * double(int(n - kPoints - kControl) % 3 - 1);
        y = 400.0 * double(int(n - kPoints - kControl) / 3 - 1);
      }
      ground.emplace_back(x, y, 60 * std::sin(x / 150) * std::cos(y / 210));
    }
  }

  [[nodiscard]] Rigid3 right_from_left() const { return cam_from_ground[1] * inverse(cam_from_ground[0]); }
  [[nodiscard]] Eigen::Vector2d pixel(int image, std::size_t point) const {
    return *project(images.left_camera, cam_from_ground[std::size_t(image)] * ground[point]);
  }
};

Eigen::Vector2d noise(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal();
  return sigma * Eigen::Vector2d(x, y);
}

Result<RelativeOrientation> measured_orientation(const Flight& flight, Random& random) {
  std::vector<PairPoint> points;
  const double sigma = kPointSigma_px / kFocal_px;
  for (std::size_t i = 0; i < kPoints; ++i)
    points.push_back({normalized(flight.images.left_camera, flight.pixel(0, i) + noise(random, kPointSigma_px)),
                      normalized(flight.images.right_camera, flight.pixel(1, i) + noise(random, kPointSigma_px)), sigma,
                      sigma});
  RelativeOptions options;
  options.rejection = PairRejection::kNone;
  options.sigma_known = true;
  Rigid3 start = flight.right_from_left();
  start.translation.normalize();
  return relative_orientation(points, options, 1, start);
}

PairControl measured_control(const Flight& flight, Random& random) {
  PairControl control{.file = {}, .pixels = {}, .sigma_px = kControlSigma_px, .fit = {}};
  for (std::size_t i = kPoints; i < kPoints + kControl; ++i) {
    control.fit.names.push_back(std::to_string(i));
    control.pixels.push_back(
        {flight.pixel(0, i) + noise(random, kControlSigma_px), flight.pixel(1, i) + noise(random, kControlSigma_px)});
    AbsoluteControl point;
    const Eigen::Vector2d plan = noise(random, kGroundSigma_m);
    point.in_ground = flight.ground[i] + Eigen::Vector3d(plan.x(), plan.y(), kGroundSigma_m * random.normal());
    point.ground_covariance = kGroundSigma_m * kGroundSigma_m * Eigen::Matrix3d::Identity();
    control.fit.pairs.push_back(point);
    control.fit.is_check.push_back(false);
    control.fit.is_rejected.push_back(false);
  }
  return control;
}

ModelOfPair model_with(const Flight& flight, const RelativeOrientation& orientation, const EpipolarPair& cameras,
                       std::vector<LevelPoint> points) {
  ModelOfPair model{.left_camera = flight.images.left_camera, .right_camera = flight.images.right_camera};
  model.orientation = orientation;
  model.epipolar = cameras;
  model.in_epipolar = std::move(points);
  return model;
}

// The exact points of the ground that took no part in the orientation, in epipolar images.
std::vector<LevelPoint> new_points(const Flight& flight, const EpipolarPair& cameras) {
  std::vector<LevelPoint> points;
  for (std::size_t i = kPoints + kControl; i < flight.ground.size(); ++i) {
    const Eigen::Vector2d left =
        in_epipolar(flight.images.left_camera, cameras.left_from_image, cameras.left, flight.pixel(0, i));
    const Eigen::Vector2d right =
        in_epipolar(flight.images.right_camera, cameras.right_from_image, cameras.right, flight.pixel(1, i));
    points.push_back({left, left.x() - right.x(), 0, 1, 0});
  }
  return points;
}

// Errors of nine ground points whose image points are exact: all that is wrong comes from the orientations.
struct Judged {
  double squares = 0;  // mean of error over sigma, of heights
  double sigma_m = 0;  // quadratic mean
};
std::optional<Judged> judged(const Flight& flight, Random& random, bool has_control) {
  const auto orientation = measured_orientation(flight, random);
  if (!orientation) return std::nullopt;
  const double base = has_control ? 1 : flight.right_from_left().translation.norm();
  std::optional<PairControl> control;
  std::optional<AbsoluteOrientation> absolute;
  Rigid3 found = orientation->second_from_first;
  found.translation *= base;
  if (has_control) {
    control = measured_control(flight, random);
    absolute = *oriented_absolutely(*control, model_with(flight, *orientation, {}, {}), found);
  }
  const EpipolarPair cameras = *epipolar_pair(flight.images.left_camera, {}, flight.images.right_camera, found);
  const std::vector<LevelPoint> points = new_points(flight, cameras);
  const auto sigma = PairOrientationSigma::of(model_with(flight, *orientation, cameras, points), control, absolute);
  if (!sigma) return std::nullopt;
  Judged result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d in_left =
        inverse(cameras.left_from_world) *
        (cameras.depth_at(points[i].disparity_px) * normalized(cameras.left, points[i].left_px).homogeneous());
    const Eigen::Vector3d truth = flight.ground[kPoints + kControl + i];
    const double error = has_control ? (absolute->ground_from_model * in_left - truth).z()
                                     : (in_left - flight.cam_from_ground[0] * truth).z();
    const double variance = sigma->covariance(points[i].left_px, points[i].disparity_px)(2, 2);
    result.squares += error * error / variance / double(points.size());
    result.sigma_m += variance / double(points.size());
  }
  result.sigma_m = std::sqrt(result.sigma_m);
  return result;
}

// Over 200 flights the mean square of error over sigma is 1. Heights of one flight hang together: about three of nine
// are independent, so that the mean has the standard deviation sqrt(2 / 600) = 0.058; four of them.
void expect_true_sigmas(bool has_control) {
  const Flight flight;
  constexpr int kFlights = 200;
  double sum = 0, sigmas = 0;
  for (int i = 0; i < kFlights; ++i) {
    Random random(17, std::uint64_t(i));
    const auto found = judged(flight, random, has_control);
    ASSERT_TRUE(found);
    sum += found->squares / kFlights;
    sigmas += found->sigma_m / kFlights;
  }
  EXPECT_NEAR(sum, 1, 0.23);
  EXPECT_GT(sigmas, 0.02);  // a tenth of a pixel is 0.12 m of height; of many points less
  EXPECT_LT(sigmas, 0.5);
}

TEST(PairSigma, OrientationErrorsOnTheGroundAreAsLargeAsStated) { expect_true_sigmas(true); }
TEST(PairSigma, WithoutControlTheyAreThoseOfTheModel) { expect_true_sigmas(false); }

// Six points of control alone fix heights worse than what the sigmas without the orientation say: the part by the
// relative orientation counts.
TEST(PairSigma, IsLargerBeyondTheControl) {
  const Flight flight;
  Random random(5);
  const auto orientation = measured_orientation(flight, random);
  ASSERT_TRUE(orientation);
  PairControl control = measured_control(flight, random);
  const auto absolute =
      oriented_absolutely(control, model_with(flight, *orientation, {}, {}), orientation->second_from_first);
  ASSERT_TRUE(absolute);
  const EpipolarPair cameras =
      *epipolar_pair(flight.images.left_camera, {}, flight.images.right_camera, orientation->second_from_first);
  const double disparity = cameras.disparity_at(kHeight_m / kBase_m);
  const auto sigma = PairOrientationSigma::of(
      model_with(flight, *orientation, cameras, {{{0, 0}, disparity, 0, 1, 0}, {{0, 0}, 1.05 * disparity, 0, 1, 0}}),
      control, *absolute);
  ASSERT_TRUE(sigma);
  const Eigen::Vector2d middle(cameras.left.width_px * 0.6, cameras.left.height_px * 0.5);
  EXPECT_GT(sigma->covariance({middle.x(), 0}, disparity)(2, 2), sigma->covariance(middle, disparity)(2, 2));
}

Eigen::Matrix<double, 6, 1> pose_error(const Rigid3& found, const Rigid3& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << rotation_vector((found.rotation.conjugate() * truth.rotation).normalized()),
      centre_of(found) - centre_of(truth);
  return error;
}

// e' C^-1 e of six components has the mean 6 and the standard deviation sqrt(12): over 200 flights 0.245, four of them.
TEST(PairExterior, PosesOnTheGroundAreAsFarOffAsStated) {
  const Flight flight;
  constexpr int kFlights = 200;
  std::array<double, 2> sums{};
  for (int i = 0; i < kFlights; ++i) {
    Random random(23, std::uint64_t(i));
    const auto orientation = measured_orientation(flight, random);
    ASSERT_TRUE(orientation);
    const PairControl control = measured_control(flight, random);
    EpipolarPair cameras;
    cameras.base_m = 1;
    const ModelOfPair model = model_with(flight, *orientation, cameras, {});
    const auto absolute = oriented_absolutely(control, model, model.right_from_left());
    ASSERT_TRUE(absolute);
    const auto poses = exterior_poses(model, control, *absolute);
    ASSERT_TRUE(poses);
    for (std::size_t k = 0; k < 2; ++k) {
      const auto error = pose_error((*poses)[k].cam_from_world, flight.cam_from_ground[k]);
      sums[k] += error.dot((*poses)[k].covariance.ldlt().solve(error)) / kFlights;
    }
  }
  EXPECT_NEAR(sums[0], 6, 0.98);
  EXPECT_NEAR(sums[1], 6, 0.98);
}

// Without control the left image is the datum, and the length of the base has no error: five components are left, of
// which the rotation has three.
TEST(PairExterior, InTheModelTheLeftImageIsTheDatum) {
  const Flight flight;
  constexpr int kFlights = 200;
  const double base = flight.right_from_left().translation.norm();
  const Rigid3 right = moved(flight.right_from_left(), Similarity3{.rotation = Eigen::Quaterniond(0, 1, 0, 0)});
  double sum = 0;
  for (int i = 0; i < kFlights; ++i) {
    Random random(29, std::uint64_t(i));
    const auto orientation = measured_orientation(flight, random);
    ASSERT_TRUE(orientation);
    EpipolarPair cameras;
    cameras.base_m = base;
    const auto poses = exterior_poses(model_with(flight, *orientation, cameras, {}), {}, {});
    ASSERT_TRUE(poses);
    EXPECT_EQ((*poses)[0].covariance.norm(), 0);
    EXPECT_EQ(centre_of((*poses)[0].cam_from_world).norm(), 0);
    const Eigen::Vector3d error = pose_error((*poses)[1].cam_from_world, right).head<3>();
    sum += error.dot((*poses)[1].covariance.topLeftCorner<3, 3>().ldlt().solve(error)) / kFlights;
    // Along the base there is no error: to second order of its direction, some 1e-8 of it.
    const Eigen::Vector3d along = centre_of((*poses)[1].cam_from_world) / base;
    EXPECT_LT(along.dot((*poses)[1].covariance.bottomRightCorner<3, 3>() * along), 1e-6);
  }
  EXPECT_NEAR(sum, 3, 4 * std::sqrt(6.0 / kFlights));
}

TEST(PairControl, ChecksAreComparedAndWrongControlIsLeftOut) {
  const Flight flight;
  Random random(31);
  const auto orientation = measured_orientation(flight, random);
  ASSERT_TRUE(orientation);
  EpipolarPair cameras;
  cameras.base_m = 1;
  const ModelOfPair model = model_with(flight, *orientation, cameras, {});
  PairControl control = measured_control(flight, random);
  control.fit.is_check[4] = true;
  control.fit.pairs[2].in_ground.z() += 5;
  const auto kept = oriented_with_rejection(control, model, model.right_from_left(), false, 0.001);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->redundancy, 8);  // five points of three coordinates, seven parameters
  EXPECT_GT(kept->sigma0, 3);
  const auto found = oriented_with_rejection(control, model, model.right_from_left(), true, 0.001);
  ASSERT_TRUE(found);
  EXPECT_TRUE(control.fit.is_rejected[2]);
  EXPECT_EQ(found->redundancy, 5);
  EXPECT_EQ(control.used_names(), (std::vector<std::string>{"120", "121", "123", "125"}));
  const auto report = pair_control_report(control, model, *found, 0.001);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->points[4].is_check);
  EXPECT_TRUE(report->points[2].is_rejected);
  EXPECT_NEAR(report->points[2].misfit.z(), 5, 6 * report->points[2].sigma.z());
  EXPECT_LT(report->points[4].w.cwiseAbs().maxCoeff(), 4);
  // Six parameters of the exterior orientation of the left image: the model has its axes, and its centre as origin.
  const Eigen::Vector3d centre = centre_of(flight.cam_from_ground[0]);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(report->parameters[std::size_t(axis)].value, centre[axis],
                5 * *report->parameters[std::size_t(axis)].sigma);
  EXPECT_NEAR(report->parameters[6].value, flight.right_from_left().translation.norm(),
              5 * *report->parameters[6].sigma);
}

Vector5 change_to(const Rigid3& truth, const Rigid3& found) {
  const Eigen::Vector3d base = base_in_first(found);
  Vector5 change;
  change << rotation_vector((truth.rotation * found.rotation.conjugate()).normalized()),
      tangents_of(base).transpose() * (base_in_first(truth) - base);
  return change;
}

// Poses of a table with errors as large as it states: the relative orientation that follows has five components, the
// mean of e' C^-1 e over 200 flights is 5 with the standard deviation sqrt(10 / 200) = 0.22; heights as above.
TEST(PairSigma, OfGivenPosesIsAsLargeAsTheirErrors) {
  const Flight flight;
  constexpr int kFlights = 200;
  const TestFolder folder;
  double relative = 0, heights = 0;
  for (int n = 0; n < kFlights; ++n) {
    Random random(37, std::uint64_t(n));
    std::string table =
        "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg] sigma_X[m] sigma_Y[m] sigma_Z[m] sigma_omega[deg] "
        "sigma_phi[deg] sigma_kappa[deg]\n";
    for (std::size_t k = 0; k < 2; ++k) {
      const OmegaPhiKappa angles = omega_phi_kappa(flight.cam_from_ground[k].rotation);
      const Eigen::Vector3d centre = centre_of(flight.cam_from_ground[k]);
      table += k == 0 ? "left" : "right";
      for (int i = 0; i < 3; ++i) table += fmt::format(" {:.12f}", centre[i] + 0.1 * random.normal());
      for (const double angle : {angles.omega_deg, angles.phi_deg, angles.kappa_deg})
        table += fmt::format(" {:.14f}", angle + 0.003 * random.normal());
      table += " 0.1 0.1 0.1 0.003 0.003 0.003\n";
    }
    ASSERT_TRUE(write_file(folder / "exterior.txt", table));
    PairChainOptions options;
    options.exterior = folder / "exterior.txt";
    const auto given = read_given_pair("a.jpg", "b.jpg", options);
    ASSERT_TRUE(given) << given.error().message;
    EXPECT_TRUE(given->is_metric);
    Rigid3 truth = flight.right_from_left();
    truth.translation.normalize();
    const Vector5 change = change_to(truth, given->second_from_first);
    relative += change.dot(given->covariance.ldlt().solve(change)) / kFlights;

    Rigid3 motion = given->second_from_first;
    motion.translation *= given->base;
    const EpipolarPair cameras = *epipolar_pair(flight.images.left_camera, {}, flight.images.right_camera, motion);
    const std::vector<LevelPoint> points = new_points(flight, cameras);
    const auto sigma = PairOrientationSigma::of(model_with(flight, {}, cameras, points), given->poses);
    ASSERT_TRUE(sigma);
    const Similarity3 ground = given->ground_from_model().ground_from_model;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d at =
          ground *
          (cameras.depth_at(points[i].disparity_px) *
           (inverse(cameras.left_from_world) * normalized(cameras.left, points[i].left_px).homogeneous().eval()));
      const double error = (at - flight.ground[kPoints + kControl + i]).z();
      heights += error * error / sigma->covariance(points[i].left_px, points[i].disparity_px)(2, 2) /
                 double(points.size()) / kFlights;
    }
  }
  EXPECT_NEAR(relative, 5, 0.89);
  EXPECT_NEAR(heights, 1, 0.23);
}

}  // namespace
}  // namespace collinea
