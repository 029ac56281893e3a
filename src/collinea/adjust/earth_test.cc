// SPDX-License-Identifier: Apache-2.0
// High flights and long blocks: the curvature of the Earth is in the frame, refraction in the rays.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/refraction.h"
#include "collinea/adjust/test_block.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/refraction.h"

namespace collinea {
namespace {

const Georeference kPosition{"EPSG:32633", 48.2, 15.63, 300};

struct Flight {
  double length_m = 50000, base_m = 2200, spacing_m = 4500, height_m = 5500;  // height above the ellipsoid
  int strips = 2;
};

// Looks down along the plumb line of its own position.
Rigid3 nadir_pose(const LocalFrame& frame, const Eigen::Vector3d& map, Random& random) {
  const Eigen::Vector3d centre = frame.local_from_map(map);
  const Eigen::Vector3d down = (frame.local_from_map(map - Eigen::Vector3d(0, 0, 1000)) - centre).normalized();
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(down, Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond rotation = (rotation_by(0.03 * testing::normal3(random)) * level).normalized();
  return {rotation, -(rotation * centre)};
}

// Country whose height in the map is the same everywhere but for some metres, seen by a mapping camera; control at both
// ends and in the middle of the block's two edges.
Block long_block(const LocalFrame& frame, const Flight& flight, double sigma_px) {
  Random random(3);
  Block block;
  block.georeference = kPosition;
  Camera camera = ideal_camera(1500, 2000, 1500);
  camera.prior.calibrate = false;
  block.cameras[{0}] = camera;
  const Eigen::Vector3d middle = frame.map_from_local(Eigen::Vector3d(0, 0, 0));
  const auto at = [&](double along, double across, double height) {
    return Eigen::Vector3d(middle.x() + along, middle.y() + across, height);
  };
  std::uint32_t number = 0;
  for (int strip = 0; strip < flight.strips; ++strip)
    for (double along = -flight.length_m / 2; along <= flight.length_m / 2; along += flight.base_m) {
      const ImageId id{number++};
      block.images[id].file = std::to_string(id.value);
      block.images[id].camera = {0};
      set_pose(block, id,
               nadir_pose(frame, at(along, (strip - 0.5 * (flight.strips - 1)) * flight.spacing_m, flight.height_m),
                          random));
    }
  const auto measure = [&](const Eigen::Vector3d& point, const auto& add) {
    for (const auto& [id, pose] : oriented_images(block)) {
      const auto pixel = project(camera, pose * point);
      if (!pixel || !inside(camera, *pixel)) continue;
      const double du = random.normal(), dv = random.normal();
      add(id, Eigen::Vector2d(*pixel + sigma_px * Eigen::Vector2d(du, dv)));
    }
  };
  number = 0;
  for (double along = -flight.length_m / 2; along <= flight.length_m / 2; along += 900)
    for (double across = -4500; across <= 4500; across += 900) {
      const PointId id{number++};
      const Eigen::Vector3d map = at(along + random.uniform(-300, 300), across, 300 + 40 * random.normal());
      block.points[id].position_in_world = frame.local_from_map(map);
      measure(block.points[id].position_in_world, [&](ImageId image, const Eigen::Vector2d& pixel) {
        block.observations.push_back({image, id, 0, pixel, sigma_px});
      });
    }
  number = 0;
  for (const double along : {-0.49, 0.0, 0.49})
    for (const double across : {-3500.0, 0.0, 3500.0}) {
      const ControlId id{number++};
      ControlPoint& point = block.control[id];
      point.name = std::to_string(id.value);
      point.position_in_map = at(along * flight.length_m, across, 310 + across / 100);
      point.position_in_world = frame.local_from_map(point.position_in_map);
      point.sigma_m.setConstant(0.02);
      measure(point.position_in_world, [&](ImageId image, const Eigen::Vector2d& pixel) {
        block.control_observations.push_back({id, image, pixel, sigma_px});
      });
    }
  return block;
}

double largest_height_error(const Adjusted& adjusted, const Block& truth) {
  double largest = 0;
  for (const auto& [id, position] : adjusted.points)
    largest = std::max(largest, std::abs((position - truth.points.at(id).position_in_world).z()));
  return largest;
}

const AdjustOptions kPlain{.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone};

// From map coordinates to the frame and back the points of 50 km agree to a tenth of a millimetre, and the bundle keeps
// them: the frame is Cartesian. Had the map's coordinates been taken for Cartesian ones, the same rays would not meet:
// the Earth falls by 49 m over 25 km.
TEST(Earth, ABlockOf50KilometresIsNotBent) {
  const auto frame = world_frame(kPosition);
  ASSERT_TRUE(frame);
  const Block truth = long_block(*frame, {}, 1e-3);
  ASSERT_GT(count_oriented(truth), 40u);
  for (const auto& [id, point] : truth.points)
    EXPECT_LT((frame->local_from_map(frame->map_from_local(point.position_in_world)) - point.position_in_world).norm(),
              1e-4);
  const auto adjusted = adjust(testing::disturbed(truth, 1e-4, 1), {}, kPlain, {});
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_NEAR(adjusted->sigma0, 1, 4 / std::sqrt(2.0 * double(adjusted->redundancy)));
  EXPECT_LT(largest_height_error(*adjusted, truth), 0.15);
  Block in_map = truth;
  const Eigen::Vector3d offset = frame->map_from_local(Eigen::Vector3d(0, 0, 0));
  for (auto& [id, point] : in_map.control) point.position_in_world = point.position_in_map - offset;
  const auto bent = adjust(in_map, {}, kPlain, {});
  ASSERT_TRUE(bent);
  EXPECT_GT(bent->sigma0, 10);
}

// Measurements as the atmosphere bends them, found by the rule of refraction at the true angles: corrected, they fit
// within their noise; as they are, with a known camera, the projection centres come out too low: a wider image is one
// from nearer, by 75e-6 of 8.7 km.
TEST(Earth, RefractionIsTakenOffTheRays) {
  const auto frame = world_frame(kPosition);
  const Block truth = long_block(*frame, {.length_m = 9000, .height_m = 9000}, 0.02);
  Block bent = truth;
  const auto bend = [&](ImageId image, const Eigen::Vector3d& point, Eigen::Vector2d& pixel) {
    const Rigid3& pose = pose_of(truth, image);
    const Eigen::Vector3d centre = centre_of(pose), position = frame->geographic_from_local(centre);
    const Eigen::Vector3d down =
        pose.rotation *
        (frame->local_from_geographic({position.x(), position.y(), position.z() - 1000}) - centre).normalized();
    const Eigen::Vector3d ray = (pose * point).normalized();
    const double angle = std::acos(ray.dot(down));
    const double bow = refraction_rad(position.z(), frame->geographic_from_local(point).z()) * std::tan(angle);
    const Eigen::Vector3d seen = Eigen::AngleAxisd(-bow, ray.cross(down).normalized()) * ray;
    const Camera& camera = truth.cameras.begin()->second;
    pixel += *project(camera, seen) - *project(camera, ray);
  };
  for (Observation& o : bent.observations) bend(o.image, truth.points.at(o.point).position_in_world, o.pixel);
  for (ControlObservation& o : bent.control_observations)
    bend(o.image, truth.control.at(o.point).position_in_world, o.pixel);
  Block corrected = testing::disturbed(bent, 1e-4, 2);
  const auto done = correct_refraction(corrected);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(done->corrected, bent.observations.size() + bent.control_observations.size());
  EXPECT_EQ(done->left, 0u);
  EXPECT_GT(done->largest_px, 0.05);
  for (std::size_t i = 0; i < truth.observations.size(); ++i)
    EXPECT_LT((corrected.observations[i].pixel - truth.observations[i].pixel).norm(), 2e-3);
  // Photographs show a point where it was measured.
  for (std::size_t i = 0; i < truth.observations.size(); i += 97) {
    const Observation& seen = bent.observations[i];
    const Eigen::Vector3d ray = pose_of(truth, seen.image) * truth.points.at(seen.point).position_in_world;
    const Eigen::Vector3d shown = corrected.images.at(seen.image).bend.bent(ray);
    const Camera& camera = truth.cameras.begin()->second;
    const Eigen::Vector2d noise_px = truth.observations[i].pixel - *project(camera, ray);
    EXPECT_LT((*project(camera, shown) + noise_px - seen.pixel).norm(), 5e-3);
    EXPECT_GT((*project(camera, shown) - *project(camera, ray)).norm(), 0);
  }
  EXPECT_NEAR(largest_refraction_px(bent), done->largest_px, 0.2 * done->largest_px);
  EXPECT_EQ(largest_refraction_px(testing::test_block()), 0);
  const auto right = adjust(corrected, {}, kPlain, {}), wrong = adjust(bent, {}, kPlain, {});
  ASSERT_TRUE(right && wrong);
  EXPECT_NEAR(right->sigma0, 1, 4 / std::sqrt(2.0 * double(right->redundancy)));
  const auto mean_height_error = [&](const Adjusted& adjusted) {
    double sum = 0;
    for (const auto& [id, pose] : adjusted.cam_from_world) sum += (centre_of(pose) - centre_of(pose_of(truth, id))).z();
    return sum / double(adjusted.cam_from_world.size());
  };
  EXPECT_LT(std::abs(mean_height_error(*right)), 0.1);
  EXPECT_LT(mean_height_error(*wrong), -0.4);
}

TEST(Earth, RefractionNeedsALocationOnEarth) {
  Block block = testing::test_block();
  EXPECT_EQ(correct_refraction(block).error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
