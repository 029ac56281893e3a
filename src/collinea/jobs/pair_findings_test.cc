// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_findings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "collinea/epipolar/pair_shape.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Two photographs of the normal case, of hills two to three bases away.
struct PairScene {
  PairImages images;
  std::vector<MatchedPoint> points;
  PairReport report;

  // Points where `where` has them of the left image, at the depths that it has there; noise of a coordinate.
  PairScene(int count, double noise_px, const std::function<bool(const Vector2d&)>& where,
            const std::function<double(Random&)>& depth) {
    images.left_camera = images.right_camera = ideal_camera(900, 800, 600);
    const Rigid3 second_from_first{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
    Random random(5);
    while (static_cast<int>(points.size()) < count) {
      const Vector2d left(random.uniform(0, 800), random.uniform(0, 600));
      const Vector3d x = depth(random) * normalized(images.left_camera, left).homogeneous();
      const auto right = project(images.right_camera, second_from_first * x);
      if (!right || !inside(images.right_camera, *right) || !where(left)) continue;
      const auto noise = [&]() -> Vector2d { return noise_px * Vector2d(random.normal(), random.normal()); };
      points.push_back({left + noise(), *right + noise(), 0.95});
    }
    auto oriented = oriented_by("lsm", points, images, {}, 1);
    EXPECT_TRUE(oriented) << oriented.error().message;
    report.orientations.push_back(*oriented);
  }
  [[nodiscard]] std::vector<Finding> findings(const std::vector<Vector2d>& control_px = {},
                                              std::optional<double> wanted_m = {}) const {
    ModelOfPair model{.left_camera = images.left_camera, .right_camera = images.right_camera};
    model.orientation = report.orientations.back().orientation;
    model.points = points;
    return pair_findings(model, report, control_px, wanted_m);
  }
};

bool everywhere(const Vector2d&) { return true; }
double hills(Random& random) { return random.uniform(2, 3); }
PairScene good() { return {80, 0.07, everywhere, hills}; }

std::vector<FindingCode> codes_of(const std::vector<Finding>& findings) {
  std::vector<FindingCode> codes;
  for (const Finding& finding : findings) codes.push_back(finding.code);
  return codes;
}

bool has(const std::vector<Finding>& findings, FindingCode code) {
  return std::ranges::find(findings, code, &Finding::code) != findings.end();
}

const Finding& named(const std::vector<Finding>& findings, FindingCode code) {
  return *std::ranges::find(findings, code, &Finding::code);
}

TEST(PairFindings, OfAGoodPairThereAreNone) { EXPECT_EQ(codes_of(good().findings()), std::vector<FindingCode>{}); }

TEST(PairFindings, FewPointsAreCounted) {
  const auto findings = PairScene(9, 0.07, everywhere, hills).findings();
  ASSERT_TRUE(has(findings, FindingCode::kPairFewPoints));
  EXPECT_EQ(findings.front().figure(FigureName::kCount), 9);
  EXPECT_FALSE(has(PairScene(12, 0.07, everywhere, hills).findings(), FindingCode::kPairFewPoints));
}

// The overlap is about 500 of 800 columns wide: points in its upper half leave the two zones below empty.
TEST(PairFindings, ZonesOfTheOverlapWithoutPointsAreCounted) {
  const auto above = [](const Vector2d& left) { return left.y() < 390; };
  const auto findings = PairScene(80, 0.07, above, hills).findings();
  ASSERT_TRUE(has(findings, FindingCode::kPairZonesEmpty));
  const Finding& zones = named(findings, FindingCode::kPairZonesEmpty);
  EXPECT_EQ(zones.figure(FigureName::kCount), 2);
  EXPECT_EQ(zones.figure(FigureName::kOf), 6);
}

TEST(PairFindings, ParallaxesBeyondMatchingAreWrong) {
  const auto findings = PairScene(80, 0.6, everywhere, hills).findings();
  ASSERT_TRUE(has(findings, FindingCode::kPairParallax));
  EXPECT_NEAR(*named(findings, FindingCode::kPairParallax).figure(FigureName::kOffsetPx), 0.6, 0.2);
  EXPECT_FALSE(has(PairScene(80, 0.2, everywhere, hills).findings(), FindingCode::kPairParallax));
}

TEST(PairFindings, FlatGroundIsAWeakGeometry) {
  const auto flat = [](Random&) { return 2.5; };
  const auto findings = PairScene(80, 0.07, everywhere, flat).findings();
  ASSERT_TRUE(has(findings, FindingCode::kPairGeometry));
  // A narrow strip of a plane below the base is near a cylinder through it, too.
  for (const Finding& finding : findings)
    EXPECT_TRUE(finding.detail == "plane" || finding.detail == "near_cylinder") << finding.detail;
}

TEST(PairFindings, HeightsThatAreNotReachedAskForALongerBase) {
  PairScene scene = good();
  scene.report.has_base = true;
  scene.report.median_sigma_z = 0.3;
  EXPECT_FALSE(has(scene.findings(), FindingCode::kPairBase));
  EXPECT_FALSE(has(scene.findings({}, 0.31), FindingCode::kPairBase));
  const auto findings = scene.findings({}, 0.1);
  ASSERT_TRUE(has(findings, FindingCode::kPairBase));
  EXPECT_NEAR(*named(findings, FindingCode::kPairBase).figure(FigureName::kRatio), 1 / 2.5, 0.05);
  scene.report.has_base = false;  // in bases: nothing to compare
  EXPECT_FALSE(has(scene.findings({}, 0.1), FindingCode::kPairBase));
}

TEST(PairFindings, ControlIsToLieInAllQuartersAndToAgree) {
  PairScene scene = good();
  AbsoluteOrientation absolute;
  absolute.redundancy = 5;
  absolute.residuals.resize(4);
  scene.report.absolute = absolute;
  scene.report.control_names = {"A", "B", "C", "D"};
  const std::vector<Vector2d> corners{{450, 100}, {760, 100}, {450, 500}, {760, 500}};
  EXPECT_EQ(codes_of(scene.findings(corners)), std::vector<FindingCode>{});
  const std::vector<Vector2d> above{{450, 100}, {760, 100}, {500, 120}, {760, 150}};
  const auto apart = scene.findings(above);
  ASSERT_TRUE(has(apart, FindingCode::kPairControlApart));
  EXPECT_EQ(apart.front().figure(FigureName::kCount), 2);
  scene.report.absolute->residuals[2].misfit = {0, 0.4, 0};
  scene.report.absolute->residuals[2].w = {0, 6, 0};
  const auto contradicts = scene.findings(corners);
  ASSERT_EQ(codes_of(contradicts), std::vector<FindingCode>{FindingCode::kControlContradicts});
  EXPECT_EQ(contradicts.front().subjects.front().name, "C");
}

TEST(PairFindings, DroppedLevelsAndInterpolatedMapsAreNamed) {
  PairScene scene = good();
  scene.report.levels = {
      {.threshold = 900, .interest = 90, .matched = 70, .least = 40},
      {.threshold = 700, .interest = 90, .matched = 30, .spikes = 5, .least = 40, .is_dropped = true}};
  scene.report.map = PairMap{.cell_m = 1, .width = 10, .height = 10, .measured_cells = 60};
  const auto dropped = scene.findings();
  ASSERT_EQ(codes_of(dropped), std::vector<FindingCode>{FindingCode::kPairLevelsDropped});
  EXPECT_EQ(dropped.front().figure(FigureName::kCount), 1);
  EXPECT_EQ(dropped.front().figure(FigureName::kOf), 2);
  EXPECT_EQ(dropped.front().figure(FigureName::kLimit), 40);
  scene.report.levels.clear();
  scene.report.map->measured_cells = 40;
  EXPECT_EQ(codes_of(scene.findings()), std::vector<FindingCode>{FindingCode::kPairCellsMeasured});
}

}  // namespace
}  // namespace collinea
