// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/weak_cases.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/orient/internal/test_pairs.h"

namespace collinea {
namespace {

using testing::Matched;
using testing::matched;

Rigid3 looking(const Eigen::Vector3d& centre, const Eigen::Vector3d& at, const Eigen::Vector3d& down) {
  const Eigen::Vector3d z = (at - centre).normalized(), x = down.cross(z).normalized();
  Eigen::Matrix3d cam_from_world;
  cam_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  return {Eigen::Quaterniond(cam_from_world), -(cam_from_world * centre)};
}

// What cameras at these poses see of these points, to half a pixel.
Block seen_from(const std::vector<Rigid3>& poses, const std::vector<Eigen::Vector3d>& points) {
  Random random(4);
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(1500, 2000, 1500);
  block.cameras[CameraId{1}].prior.sigma_f_px = 75;
  block.cameras[CameraId{1}].name = "test";
  for (std::uint32_t i = 0; i < poses.size(); ++i) {
    block.images[ImageId{i}] = {"IMG_" + std::to_string(i) + ".jpg", CameraId{1}, "", {}, {}, 1};
    set_pose(block, ImageId{i}, poses[i]);
  }
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    block.points[PointId{p}].position_in_world = points[p];
    for (const auto& [id, pose] : oriented_images(block)) {
      const auto pixel = project(block.cameras.at(CameraId{1}), pose * points[p]);
      if (!pixel || !inside(block.cameras.at(CameraId{1}), *pixel)) continue;
      const double u = random.normal(), v = random.normal();
      block.observations.push_back({id, PointId{p}, 0, *pixel + 0.5 * Eigen::Vector2d(u, v), 0.5});
    }
  }
  return block;
}

std::vector<Eigen::Vector3d> box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int count) {
  Random random(2);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(low.x(), high.x()), y = random.uniform(low.y(), high.y());
    points.emplace_back(x, y, random.uniform(low.z(), high.z()));
  }
  return points;
}

std::vector<Finding> findings_of(const Matched& input) {
  const auto found = orient(input.setup, input.pairs, input.source(), {}, {});
  EXPECT_TRUE(found) << found.error().message;
  if (!found) return {};
  std::vector<Finding> findings = found->findings;
  const auto adjusted = examine(found->block, found->scope, {.adjust = found->options}, {});
  EXPECT_TRUE(adjusted) << adjusted.error().message;
  for (const Finding& more : weak_focals(found->block, input.setup.cameras, *adjusted)) findings.push_back(more);
  return findings;
}

bool mentions(const std::vector<Finding>& findings, FindingCode code) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& one) { return one.code == code; });
}

std::vector<Rigid3> nadir_grid(double height_m) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d centre(20.0 * (i % 4), 25.0 * (i / 4), height_m);
    poses.push_back(looking(centre, centre - Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()));
  }
  return poses;
}

TEST(WeakCases, EveryCameraWithAnOpenFocalLengthIsNamed) {
  Block block = seen_from(nadir_grid(60), box({-30, -30, 0}, {90, 55, 10}, 300));
  block.cameras[{2}] = block.cameras[{3}] = block.cameras.at({1});
  block.cameras[{2}].name = "second";
  block.cameras[{3}].name = "third";
  Examined adjusted;
  for (const auto& [id, camera] : block.cameras) {
    adjusted.camera_covariance[id].setZero(Camera::kParams, Camera::kParams);
    adjusted.camera_covariance[id](Camera::kF, Camera::kF) = id == CameraId{2} ? 1 : 50 * 50;
  }
  const auto findings = weak_focals(block, block.cameras, adjusted);
  const auto names = [&](CameraId camera) {
    return std::any_of(findings.begin(), findings.end(), [&](const Finding& one) {
      return one.code == FindingCode::kFocalOfFewImages && one.subjects == std::vector<Subject>{camera};
    });
  };
  EXPECT_TRUE(names({1}));
  EXPECT_FALSE(names({2}));
  EXPECT_TRUE(names({3}));
}

// 849 px in EXIF and 1145 px of the images: 35 %, where EXIF is good to 5.
TEST(WeakCases, AFocalLengthThatMovesFartherThanItsSourceAllowsIsNamed) {
  Camera given = ideal_camera(849, 1000, 800);
  given.prior = {.sigma_f_px = 0.05 * 849, .source = Provenance::kExif35mm};
  const auto named = [&](double adjusted_px) {
    Adjusted adjusted;
    adjusted.cameras[{1}] = given;
    adjusted.cameras[{1}].params[Camera::kF] = adjusted_px;
    return moved_focals({{CameraId{1}, given}}, adjusted);
  };
  ASSERT_EQ(named(1145).size(), 1u);
  const Finding found = named(1145).front();
  EXPECT_EQ(found.code, FindingCode::kFocalMoved);
  EXPECT_NEAR(*found.figure(FigureName::kRelative), 0.349, 1e-3);
  EXPECT_NEAR(*found.figure(FigureName::kRatio), 6.97, 0.01);
  EXPECT_EQ(named(700).size(), 1u);
  EXPECT_TRUE(named(970).empty());
  given.prior.source = Provenance::kAssumed;
  EXPECT_TRUE(named(1145).empty());
}

TEST(WeakCases, AFlatSceneFromOneHeightLeavesTheFocalLengthOpen) {
  const auto findings = findings_of(matched(seen_from(nadir_grid(60), box({-30, -30, 0}, {90, 55, 0.2}, 600))));
  EXPECT_TRUE(mentions(findings, FindingCode::kFocalOfFlatScene));
}

TEST(WeakCases, ReliefAndConvergentImagesAreNoWeakness) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < 8; ++i) {
    const double a = i * std::numbers::pi / 4;
    poses.push_back(looking({40 * std::cos(a), 40 * std::sin(a), 30.0 + 4 * (i % 2)}, {0, 0, 0}, {0, 0, -1}));
  }
  EXPECT_EQ(findings_of(matched(seen_from(poses, box({-12, -12, -5}, {12, 12, 5}, 500)))), std::vector<Finding>{});
}

TEST(WeakCases, MotionAlongTheViewIsNamed) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < 8; ++i) poses.push_back(looking({0, 0, 2.0 * i}, {0.1 * i, 0, 100}, {0, 1, 0}));
  const auto findings = findings_of(matched(seen_from(poses, box({-12, -9, 20}, {12, 9, 60}, 800))));
  EXPECT_TRUE(mentions(findings, FindingCode::kMovedAlongView));
}

TEST(WeakCases, PairsThatContradictTheBlockAreNamedAsRepeatedStructure) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < 10; ++i) poses.push_back(looking({15.0 * i, 0, 60}, {15.0 * i, 0, 0}, {0, -1, 0}));
  Matched input = matched(seen_from(poses, box({-30, -25, -6}, {165, 25, 6}, 900)));
  ASSERT_FALSE(mentions(findings_of(input), FindingCode::kPairsContradict));
  ImagePair wrong = input.pairs.front();
  wrong.first = ImageId{0};
  wrong.second = ImageId{9};
  wrong.matches.clear();
  for (std::uint32_t i = 0; i < 60; ++i) wrong.matches.emplace_back(i, i);
  input.pairs.push_back(wrong);
  const auto findings = findings_of(input);
  EXPECT_TRUE(mentions(findings, FindingCode::kPairsContradict));
  const auto named = std::find_if(findings.begin(), findings.end(),
                                  [](const Finding& one) { return one.code == FindingCode::kPairsContradict; });
  EXPECT_EQ(named->subjects, (std::vector<Subject>{ImageId{0}, ImageId{9}}));
  EXPECT_EQ(named->figure(FigureName::kMatches), 60);
}

std::vector<Finding> weakness_of(const Block& block) { return weak_cases(block, {}); }

TEST(WeakCases, CamerasAndPointsOnOneCylinderAreACriticalSurface) {
  std::vector<Eigen::Vector3d> on_cylinder, off_it = box({-8, -8, -8}, {8, 8, 8}, 300);
  for (Eigen::Vector3d& point : off_it) {
    const double r = point.head<2>().norm();
    on_cylinder.emplace_back(10 * point.x() / r, 10 * point.y() / r, point.z());
  }
  std::vector<Rigid3> poses;
  for (int i = 0; i < 5; ++i) {
    const double a = 0.7 * i;
    poses.push_back(looking({10 * std::cos(a), 10 * std::sin(a), 2.0 * i - 4}, {0, 0, 0}, {0, 0, -1}));
  }
  EXPECT_TRUE(mentions(weakness_of(seen_from(poses, on_cylinder)), FindingCode::kCriticalSurface));
  EXPECT_FALSE(mentions(weakness_of(seen_from(poses, off_it)), FindingCode::kCriticalSurface));
}

TEST(WeakCases, ASphereIsNotRuledAndNotCritical) {
  std::vector<Eigen::Vector3d> points = box({-1, -1, -1}, {1, 1, 1}, 300);
  for (Eigen::Vector3d& point : points) point *= 10 / point.norm();
  std::vector<Rigid3> poses;
  for (int i = 0; i < 5; ++i) {
    const double a = 0.7 * i, z = 2.0 * i - 4, r = std::sqrt(100 - z * z);
    poses.push_back(looking({r * std::cos(a), r * std::sin(a), z}, {0, 0, 0}, {0, 0, -1}));
  }
  EXPECT_FALSE(mentions(weakness_of(seen_from(poses, points)), FindingCode::kCriticalSurface));
}

TEST(WeakCases, WhyNothingFitsIsToldApart) {
  ImagePair rotation;
  rotation.geometry = PairGeometry::kRotation;
  EXPECT_NE(nothing_fits(std::vector<ImagePair>{rotation}).message.find("panorama"), std::string::npos);
  EXPECT_NE(nothing_fits({}).message.find("overlapping"), std::string::npos);
}

}  // namespace
}  // namespace collinea
