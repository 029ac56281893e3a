// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/drawing_now.h"

#include <gtest/gtest.h>

#include "collinea/marking/test_marking.h"
#include "collinea/restitution/drawn_vertex.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::marking_scene;
using testing::MarkingScene;

/// A vertex by exact marks of a control point, as it is drawn in the block.
DrawnVertex drawn_at(const MarkingScene& scene, VertexPlotter& plotter, ControlId id, std::size_t count) {
  MarkedVertex asked;
  Random random(4);
  for (const ImageId image : testing::images_of(scene, id, random))
    if (asked.marks.size() < count) asked.marks.push_back({image, *scene.seen(image, id), 0.5});
  const auto plotted = plotter.plot(asked);
  EXPECT_TRUE(plotted) << plotted.error().message;
  return drawn_vertex(plotter, asked, *plotted, scene.block);
}

// In the same block nothing moves, to the last bit; in one that lies elsewhere what has marks moves with it, and only
// what was edited since is computed again.
TEST(DrawingNow, VerticesWithMarksFollowTheBlock) {
  const MarkingScene scene = marking_scene(3, false);
  const MarkingBlock marking = scene.marking_together();
  VertexPlotter plotter(marking, nullptr, nullptr);
  const DrawnVertex a = drawn_at(scene, plotter, ControlId{0}, 3), b = drawn_at(scene, plotter, ControlId{1}, 2);
  const DrawnVertex typed{.position = {1, 2, 3}, .covariance_m2 = {}};
  Drawing drawing;
  drawing.features = {{"F1", "a", VectorKind::kLine, {{"code", "R"}}, {a, typed}},
                      {"F2", "a", VectorKind::kPoint, {}, {b}},
                      {"F3", "a", VectorKind::kPoint, {}, {typed}}};
  int asked = 0;
  DrawingComputer computer;
  const auto same = computer.drawing_now(
      drawing, [&] { return ++asked, &plotter; }, images_by_file(scene.block));
  ASSERT_TRUE(same);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(same->features.size(), 2u);
  for (const auto& [id, now] : same->features) {
    EXPECT_EQ(now.computed, 1u);
    EXPECT_EQ(now.moved_m, 0) << id;
    EXPECT_EQ(now.vertices, drawing.features.find(id)->vertices) << id;
  }
  EXPECT_EQ(same->drawing.features.find("F1")->attributes.at("code"), "R");
  // Nothing was edited: nothing is plotted. One feature was: that alone is.
  ASSERT_TRUE(computer.drawing_now(
      drawing, [&] { return ++asked, &plotter; }, images_by_file(scene.block)));
  EXPECT_EQ(asked, 1);
  drawing.features.find("F2")->vertices[0].marks[0].pixel.x() += 1;
  const auto edited = computer.drawing_now(
      drawing, [&] { return ++asked, &plotter; }, images_by_file(scene.block));
  ASSERT_TRUE(edited);
  EXPECT_EQ(asked, 2);
  EXPECT_GT(edited->features.at("F2").moved_m, 0);
  EXPECT_EQ(edited->features.at("F1").moved_m, 0);

  Block moved = scene.block;
  const Vector3d shift(0.4, -0.3, 1.2);
  for (const OrientedImage& one : oriented_images(scene.block)) {
    const Vector3d centre = centre_of(one.cam_from_world) + shift;
    set_pose(moved, one.image, {one.cam_from_world.rotation, -(one.cam_from_world.rotation * centre)});
  }
  VertexPlotter elsewhere({moved, scene.observations, scene.poses}, nullptr, nullptr);
  const FeatureNow now = feature_now(*drawing.features.find("F1"), elsewhere, images_by_file(moved));
  EXPECT_LT((now.vertices[0].position - a.position - shift).norm(), 1e-6);
  EXPECT_EQ(now.vertices[1], typed);
  EXPECT_NEAR(now.moved_m, shift.norm(), 1e-6);
  EXPECT_NEAR(now.moved_sigmas, (shift.cwiseAbs().cwiseQuotient(*a.sigma_m())).maxCoeff(), 1e-3);
  EXPECT_TRUE(now.kept.empty());
}

TEST(DrawingNow, WhatCannotBeComputedStaysAsItWasDrawn) {
  const MarkingScene scene = marking_scene(3, false);
  VertexPlotter plotter(scene.marking(), nullptr, nullptr);
  const DrawnVertex a = drawn_at(scene, plotter, ControlId{0}, 2);
  DrawnVertex removed = a, mono = a;
  removed.marks[1].image = "removed.jpg";
  mono.marks.pop_back();
  mono.source = VertexSource::kMono;
  const FeatureNow now =
      feature_now({"F1", "a", VectorKind::kPolygon, {}, {removed, a, mono}}, plotter, images_by_file(scene.block));
  EXPECT_EQ(now.computed, 1u);
  EXPECT_EQ(now.vertices, (std::vector<DrawnVertex>{removed, a, mono}));
  ASSERT_EQ(now.kept.size(), 2u);
  EXPECT_EQ(now.kept[0].vertex, 0u);
  EXPECT_EQ(now.kept[0].why, "there is no image removed.jpg");
  EXPECT_EQ(now.kept[1].vertex, 2u);
  EXPECT_NE(now.kept[1].why.find("no surface"), std::string::npos);
  // What plots cannot be had: the error is handed on.
  DrawingComputer computer;
  Drawing drawing;
  drawing.features = {{"F1", "a", VectorKind::kPoint, {}, {a}}};
  const auto failed = computer.drawing_now(
      drawing, []() -> Result<VertexPlotter*> { return fail(Errc::kIllPosed, "no"); }, images_by_file(scene.block));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "no");
}

}  // namespace
}  // namespace collinea
