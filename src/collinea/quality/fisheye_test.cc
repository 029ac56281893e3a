// SPDX-License-Identifier: Apache-2.0
// Blocks taken by a fisheye: the bundle finds camera and poses, and its covariances are true.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::disturbed;
using testing::normal3;
using testing::test_block;

Camera fisheye(CameraModel model) {
  Camera camera = ideal_camera(700, 2000, 1500);
  camera.model = model;
  camera.params[Camera::kCx] += 6;
  camera.params[Camera::kCy] -= 4;
  camera.params[Camera::kK1] = -0.02;
  camera.params[Camera::kK2] = 0.004;
  camera.params[Camera::kK3] = -0.001;
  if (is<KannalaBrandt>(model)) {
    camera.params[Camera::kK4] = 2e-4;
  } else {
    camera.params[Camera::kP1] = 4e-4;
    camera.params[Camera::kP2] = -3e-4;
  }
  camera.prior.sigma_f_px = 50;
  camera.name = "fisheye";
  return camera;
}

// The block of testing::test_block with another camera, whose measurements have an error of `sigma_px`.
Block block_of(const Camera& camera, double sigma_px, std::uint64_t seed, int points = 150) {
  Block block = test_block({.rows = 2, .columns = 3, .points = points, .control = 6, .tilt_rad = 0.3, .seed = seed});
  block.cameras.begin()->second = camera;
  Random random(seed, 12);
  const auto measured = [&](ImageId image, const Eigen::Vector3d& point) -> std::optional<Eigen::Vector2d> {
    const auto pixel = project(camera, pose_of(block, image) * point);
    if (!pixel || !inside(camera, *pixel)) return std::nullopt;
    const double du = random.normal(), dv = random.normal();
    return *pixel + sigma_px * Eigen::Vector2d(du, dv);
  };
  block.observations.clear();
  block.control_observations.clear();
  for (const auto& [id, point] : block.points)
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = measured(image, point.position_in_world))
        block.observations.push_back({image, id, 0, *pixel, sigma_px});
  for (auto& [id, point] : block.control) {
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = measured(image, point.position_in_world))
        block.control_observations.push_back({id, image, *pixel, sigma_px});
    point.position_in_world += 0.01 * normal3(random);
    point.sigma_m.setConstant(0.01);
  }
  return block;
}

class FisheyeBundle : public ::testing::TestWithParam<CameraModel> {};

INSTANTIATE_TEST_SUITE_P(Models, FisheyeBundle, ::testing::Values(Equidistant{}, Equisolid{}, KannalaBrandt{}),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

// From a camera without distortion and a focal length 3 % off. With 1e-4 px nothing but rounding and the
// pseudo-observations of the parameters is left: these are of 0.2 to 0.5 where measurements give 1e-6.
TEST_P(FisheyeBundle, FindsTheCamera) {
  const Camera camera = fisheye(GetParam());
  const Block truth = block_of(camera, 1e-4, 1);
  Block start = disturbed(truth, 0.005, 0.3);
  Camera first = ideal_camera(680, 2000, 1500);
  first.model = camera.model;
  first.prior.sigma_f_px = 1e6;
  start.cameras.begin()->second = first;
  for (auto& [id, point] : start.control) point.sigma_m.setConstant(0.01);
  const auto adjusted =
      examine(start, {},
              {.adjust = {.calibration = Calibration::kBrown, .loss = Loss::kNone, .position_loss = Loss::kNone}}, {});
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  const Camera& found = adjusted->cameras.begin()->second;
  const MatrixPd& covariance = adjusted->camera_covariance.begin()->second;
  for (const int k : params_of(camera)) {
    if (k == Camera::kB1 || k == Camera::kB2) continue;
    EXPECT_GT(covariance(k, k), 0) << param_name(k);
    EXPECT_NEAR(found.params[std::size_t(k)], camera.params[std::size_t(k)], 5 * std::sqrt(covariance(k, k)) + 1e-7)
        << param_name(k);
    EXPECT_LT(std::sqrt(covariance(k, k)), param_unit(k) == "px" ? 0.01 : 1e-3) << param_name(k);
  }
}

// e' C^-1 e of the camera is chi-squared with as many degrees of freedom as it has free parameters, that of a pose with
// six; sigma0^2 r with r. Mean and four of its standard deviations over independent blocks.
TEST_P(FisheyeBundle, CovariancesAreTrue) {
  const Camera camera = fisheye(GetParam());
  constexpr int kBlocks = 60;
  double cameras = 0, cameras2 = 0, poses = 0, poses2 = 0, variances = 0, redundancies = 0;
  int freedom = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block truth = block_of(camera, 0.5, seed, 80);
    const auto adjusted = examine(
        truth, {.first_cameras = truth.cameras},
        {.adjust = {.calibration = Calibration::kBrown, .loss = Loss::kNone, .position_loss = Loss::kNone}}, {});
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    const MatrixPd& all = adjusted->camera_covariance.begin()->second;
    std::vector<int> free;
    for (const int k : params_of(camera))
      if (all(k, k) > 0) free.push_back(k);
    freedom = int(free.size());
    const MatrixPd covariance = all(free, free);
    Eigen::VectorXd error(freedom);
    for (int i = 0; i < freedom; ++i)
      error[i] = adjusted->cameras.begin()->second.params[std::size_t(free[std::size_t(i)])] -
                 camera.params[std::size_t(free[std::size_t(i)])];
    const double of_camera = error.dot(covariance.inverse() * error);
    double of_poses = 0;
    for (const auto& [id, pose] : adjusted->cam_from_world) {
      const Rigid3& exact = pose_of(truth, id);
      Eigen::Matrix<double, 6, 1> e;
      e << rotation_vector(pose.rotation.conjugate() * exact.rotation), centre_of(exact) - centre_of(pose);
      of_poses += e.dot(adjusted->pose_covariance.at(id).inverse() * e) / double(adjusted->cam_from_world.size());
    }
    cameras += of_camera / kBlocks, cameras2 += of_camera * of_camera / kBlocks;
    poses += of_poses / kBlocks, poses2 += of_poses * of_poses / kBlocks;
    variances += adjusted->sigma0 * adjusted->sigma0 * double(adjusted->redundancy);
    redundancies += double(adjusted->redundancy);
  }
  EXPECT_EQ(freedom, is<KannalaBrandt>(GetParam()) ? 7 : 8);
  const auto four = [&](double mean, double mean2) { return 4 * std::sqrt((mean2 - mean * mean) / kBlocks); };
  EXPECT_NEAR(cameras, freedom, four(cameras, cameras2));
  EXPECT_LT(four(cameras, cameras2), 0.5 * freedom);
  EXPECT_NEAR(poses, 6, four(poses, poses2));
  EXPECT_LT(four(poses, poses2), 2);
  EXPECT_NEAR(variances / redundancies, 1, 4 * std::sqrt(2 / redundancies));
}

// More than a hemisphere: points beside and behind the plane of the camera take part.
TEST(Fisheye, PointsBehindThePlaneOfTheCameraAreAdjusted) {
  Camera camera = fisheye(Equidistant{});
  camera.params[Camera::kF] = 420;  // 136 degrees from the axis in the middle of a side
  Block truth = block_of(camera, 0.3, 2);
  Random random(5);
  for (std::uint32_t i = 0; i < 60; ++i) {  // a wall round the block, up to twice its height
    const double angle = random.uniform(0, 6.28);
    const PointId id{5000 + i};
    truth.points[id].position_in_world = {15 + 60 * std::cos(angle), 10 + 60 * std::sin(angle),
                                          random.uniform(20, 110)};
    for (const auto& [image, pose] : oriented_images(truth)) {
      const auto pixel = project(camera, pose * truth.points[id].position_in_world);
      if (!pixel || !inside(camera, *pixel)) continue;
      const double du = random.normal(), dv = random.normal();
      truth.observations.push_back({image, id, 0, *pixel + 0.3 * Eigen::Vector2d(du, dv), 0.3});
    }
  }
  std::size_t behind = 0;
  for (const Observation& o : truth.observations)
    behind += (pose_of(truth, o.image) * truth.points.at(o.point).position_in_world).z() < 0;
  EXPECT_GT(behind, 50u);
  const auto adjusted =
      adjust(disturbed(truth, 0.003, 0.1), {}, {.calibration = Calibration::kNone, .loss = Loss::kNone}, {});
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_NEAR(adjusted->sigma0, 1, 4 / std::sqrt(2.0 * double(adjusted->redundancy)));
}

}  // namespace
}  // namespace collinea
