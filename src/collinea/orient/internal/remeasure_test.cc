// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/remeasure.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr int kWidth = 480, kHeight = 360;
constexpr std::uint32_t kImages = 4, kPoints = 60;

// Three images of the floor z = 0, painted with waves, and one that cannot be read; positions of features are off by
// 0.3 px, poses and points are true.
class PaintedFloor : public ::testing::Test {
 protected:
  PaintedFloor() {
    const CameraId camera{0};
    block_.cameras[camera] = ideal_camera(400, kWidth, kHeight);
    for (std::uint32_t i = 0; i < kImages; ++i) {
      const Eigen::Vector3d centre(1.5 * i - 2, 0.4 * i - 0.5, 8);
      const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi - 0.15 * i + 0.2, Eigen::Vector3d::UnitY()));
      block_.images[ImageId{i}] = {.file = "", .camera = camera};
      set_pose(block_, ImageId{i}, {down, -(down * centre)});
    }
    Random random(4);
    for (std::uint32_t p = 0; p < kPoints; ++p) {
      const Eigen::Vector3d point(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), 0);
      block_.points[PointId{p}].position_in_world = point;
      for (std::uint32_t i = 0; i < kImages; ++i) {
        const Eigen::Vector2d noise(random.normal(), random.normal());
        const Eigen::Vector2d pixel = *seen_at(ImageId{i}, point) + 0.3 * noise;
        block_.observations.push_back({ImageId{i}, PointId{p}, p, pixel, 1});
      }
    }
  }

  [[nodiscard]] std::optional<Eigen::Vector2d> seen_at(ImageId image, const Eigen::Vector3d& point) const {
    return project(block_.camera_of(image), pose_of(block_, image) * point);
  }
  [[nodiscard]] Eigen::Vector3d on_floor(ImageId image, const Eigen::Vector2d& pixel) const {
    const Rigid3& pose = pose_of(block_, image);
    const Eigen::Vector3d ray = pose.rotation.conjugate() * ray_in_cam(block_.camera_of(image), pixel);
    const Eigen::Vector3d centre = centre_of(pose);
    return centre - ray * (centre.z() / ray.z());
  }
  [[nodiscard]] Result<GreyImage> image_of(ImageId image) const {
    if (image.value == kImages - 1) return fail(Errc::kNotFound, "no such image");
    GreyImage grey(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector3d at = on_floor(image, {x + 0.5, y + 0.5});
        double sum = 128;
        for (int k = 1; k <= 8; ++k) {
          const double length_m = 0.15 * k;
          sum += 12 *
                 std::sin(2 * std::numbers::pi / length_m * (at.x() * std::cos(2.1 * k) + at.y() * std::sin(2.1 * k)));
        }
        grey.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::round(sum), 0.0, 255.0));
      }
    return grey;
  }
  [[nodiscard]] std::vector<std::optional<Remeasured>> remeasured(int threads) const {
    const auto keypoints = [](ImageId) -> Result<std::vector<Keypoint>> {
      return std::vector<Keypoint>(kPoints, Keypoint{.scale_px = 2});
    };
    const auto positions =
        remeasure(block_, keypoints, [&](ImageId image) { return image_of(image); }, {.threads = threads});
    EXPECT_TRUE(positions);
    return positions.value_or(std::vector<std::optional<Remeasured>>{});
  }

  Block block_;
};

TEST_F(PaintedFloor, ObservationsOfAPointMeetWhereItsReferenceLooks) {
  const auto positions = remeasured(1);
  ASSERT_EQ(positions.size(), block_.observations.size());
  int measured = 0;
  for (std::size_t first = 0; first < positions.size(); first += kImages) {
    std::vector<Eigen::Vector3d> on_floor_at;
    for (std::size_t i = first; i < first + kImages; ++i)
      if (positions[i]) on_floor_at.push_back(on_floor(block_.observations[i].image, positions[i]->pixel));
    for (const Eigen::Vector3d& one : on_floor_at)  // a pixel is 20 mm
      EXPECT_LT((one - on_floor_at.front()).norm(), 0.0012);
    measured += static_cast<int>(on_floor_at.size());
  }
  EXPECT_GT(measured, 3 * static_cast<int>(kPoints) * 9 / 10);
}

TEST_F(PaintedFloor, ObservationsInAnImageThatCannotBeReadStay) {
  const auto positions = remeasured(1);
  for (std::size_t i = kImages - 1; i < positions.size(); i += kImages) EXPECT_FALSE(positions[i]);
}

TEST_F(PaintedFloor, ThreadsDoNotChangeTheResult) {
  const auto one = remeasured(1), three = remeasured(3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].has_value(), three[i].has_value());
    if (!one[i]) continue;
    EXPECT_EQ(one[i]->pixel, three[i]->pixel);
    EXPECT_EQ(one[i]->covariance_px2, three[i]->covariance_px2);
  }
}

// Of each point that keeps its positions the windows share no pixels with those of another, in any image; none of its
// positions is left out alone.
TEST_F(PaintedFloor, WindowsThatAreKeptLieApart) {
  const auto all = remeasured(1);
  auto apart = all;
  keep_apart(block_, apart);
  std::size_t kept = 0, left_out = 0;
  for (std::size_t i = 0; i < apart.size(); ++i) {
    kept += apart[i].has_value();
    left_out += all[i].has_value() && !apart[i].has_value();
    for (std::size_t k = i - i % kImages; k < i; ++k) {
      const bool has_both = all[i] && all[k];
      EXPECT_TRUE(!has_both || apart[i].has_value() == apart[k].has_value());
    }
    for (std::size_t k = 0; k < i; ++k) {
      const Observation &a = block_.observations[i], &b = block_.observations[k];
      if (!apart[i] || !apart[k] || a.image != b.image) continue;
      const double distance = (apart[i]->pixel - apart[k]->pixel).cwiseAbs().maxCoeff();
      EXPECT_GT(distance, apart[i]->reach_px + apart[k]->reach_px - 4);  // squares of four pixels tell
    }
  }
  EXPECT_GT(kept, 40u);
  EXPECT_GT(left_out, 40u);
}

}  // namespace
}  // namespace collinea
