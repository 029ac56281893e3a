// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/marked_points.h"

#include <gtest/gtest.h>

#include "collinea/adjust/test_block.h"
#include "collinea/block/transform.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::plain;
using testing::test_block;
using testing::TestBlockOptions;

// The control of a block as points that are marked.
std::vector<BlockPoint> marked_in(const Block& block) {
  std::vector<BlockPoint> out;
  for (const auto& [id, point] : block.control) {
    BlockPoint marked;
    marked.surveyed = SurveyedPosition{point.position_in_world, point.sigma_m, point.correlation, point.role};
    for (const ControlObservation& seen : block.control_observations)
      if (seen.point == id) marked.marks.push_back({seen.image, seen.pixel, seen.sigma_px, seen.shape});
    out.push_back(std::move(marked));
  }
  return out;
}

// What was measured on the ground between them.
std::vector<PointLink> links_in(const Block& block) {
  const auto number_of = [&](ControlId id) {
    return std::size_t(std::distance(block.control.begin(), block.control.find(id)));
  };
  std::vector<PointLink> links;
  for (const GeodeticObservation& one : block.geodetic) links.push_back({number_of(one.from), number_of(one.to), one});
  return links;
}

TestBlockOptions small_block(std::uint64_t seed, double position_sigma_m = 0.05) {
  return {.points = 120, .sigma_px = 0.5, .position_sigma_m = position_sigma_m, .control = 9, .seed = seed};
}

AdjustedMarks adjusted_marks(const Block& block, Calibration calibration = Calibration::kNone) {
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(calibration), BlockControl::kLeftOut, {});
  EXPECT_TRUE(base);
  if (!base) return {};
  Result<AdjustedMarks> out = base->adjust(marked_in(block), {.sigma0_known = true}, links_in(block));
  EXPECT_TRUE(out);
  return out ? *std::move(out) : AdjustedMarks{};
}

// Beside the adjustment of everything together, whose tie points are linearised anew: second-order effects of moves by
// some centimetres at a distance of 60 m are a millionth of the noise; 0.2 % of a sigma are allowed. Its sigma0 is that
// of all, which that of the block without marks is not: it is divided out.
void expect_as_together(const Block& block, Calibration calibration) {
  ExamineOptions options = testing::tested(calibration);
  options.test.sigma0_known = true;
  const Result<Examined> together = examine(block, {}, options, {});
  ASSERT_TRUE(together);
  const AdjustedMarks marks = adjusted_marks(block, calibration);
  ASSERT_EQ(marks.points.size(), block.control.size());
  EXPECT_TRUE(marks.converged);
  EXPECT_TRUE(marks.placed);
  std::size_t p = 0;
  for (const ControlDifference& control : together->control) {
    const AdjustedMark& mark = marks.points[p++];
    ASSERT_TRUE(mark.position_in_world && control.covariance_m2);
    const Eigen::Matrix3d covariance = mark.covariance_m2 / (marks.sigma0 * marks.sigma0);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = std::sqrt((*control.covariance_m2)(axis, axis));
      EXPECT_NEAR((*mark.position_in_world)[axis], (*control.position_in_world)[axis], 2e-3 * sigma);
      EXPECT_NEAR(std::sqrt(covariance(axis, axis)), sigma, 2e-3 * sigma);
    }
  }
  // Marks of check points take no part there.
  std::map<std::uint32_t, std::array<const TestedObservation*, 2>> tests;
  for (const TestedObservation& one : together->reliability->others)
    if (one.group == ObservationGroup::kControlImages) tests[one.source][std::size_t(one.axis)] = &one;
  EXPECT_FALSE(tests.empty());
  std::map<ControlId, std::size_t> next;
  for (std::uint32_t k = 0; k < block.control_observations.size(); ++k) {
    const ControlId id = block.control_observations[k].point;
    const BlockMarkTest& test =
        marks.points[std::distance(block.control.begin(), block.control.find(id))].marks[next[id]++];
    if (block.control.at(id).role == ControlRole::kCheck) continue;
    for (int axis = 0; axis < 2; ++axis) {
      const TestedObservation& expected = *tests.at(k)[std::size_t(axis)];
      EXPECT_NEAR(test.residual_px[axis], expected.residual, 2e-3 * 0.5);
      EXPECT_NEAR(test.redundancy[axis], expected.redundancy, 1e-3);
      EXPECT_NEAR(test.w[axis] * marks.sigma0, expected.w, 5e-3);
    }
  }
}

// Check points are left out of what is together compared: they take no part in either, and move nothing.
TEST(MarkedBlock, IsTheAdjustmentOfEverythingTogether) {
  Block block = test_block(small_block(3));
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  expect_as_together(block, Calibration::kNone);
  expect_as_together(block, Calibration::kFocalRadial);
  // Positions that know little: without its control the block would lie metres away, where equations are others.
  Block loose = test_block(small_block(3, 3.0));
  for (auto& [id, point] : loose.control) point.role = ControlRole::kControl;
  expect_as_together(loose, Calibration::kNone);
}

// Distances, height differences, directions of a set-up, an azimuth, a plane and a common height: what is measured on
// the ground tells as much as in the adjustment of everything, also of a block that nothing else fixes, and check
// points that it is measured to take part as they do there.
TEST(MarkedBlock, MeasurementsOnTheGroundTakePart) {
  for (const double position_sigma_m : {0.05, 0.0}) {
    Block block = test_block(small_block(9, position_sigma_m));
    testing::Marked made{std::move(block), {}};
    for (auto& [id, point] : made.block.control) {
      made.truth[id] = point.position_in_world;
      point.role = id.value % 4 == 3 ? ControlRole::kCheck : ControlRole::kControl;
      point.sigma_m.setConstant(0.05);
    }
    Random random(9, 3);
    made.measure(GeodeticKind::kDistance, 0, 1, 0.003, &random);
    made.measure(GeodeticKind::kDistance, 1, 3, 0.003, &random);
    made.measure(GeodeticKind::kHeightDifference, 0, 2, 0.002, &random);
    made.measure(GeodeticKind::kZenithAngle, 2, 4, 2e-4, &random);
    made.measure(GeodeticKind::kAzimuth, 0, 5, 5e-4, &random);
    for (const std::uint32_t to : {1u, 2u, 7u}) {
      made.measure(GeodeticKind::kDirection, 4, to, 3e-4, &random);
      made.block.geodetic.back().setup = 1;
    }
    if (position_sigma_m > 0)
      for (const std::uint32_t on : {0u, 1u, 2u, 4u, 5u}) {
        made.block.geodetic.push_back(
            {.kind = GeodeticKind::kOnPlane, .from = {on}, .to = {on}, .sigma = 4, .setup = 2});
        made.block.geodetic.push_back(
            {.kind = GeodeticKind::kAtHeight, .from = {on}, .to = {on}, .sigma = 3, .setup = 3});
      }
    made.measure(GeodeticKind::kDistance, 5, 6, 0.003);
    made.block.geodetic.back().value += 3;  // only compared: it moves nothing
    made.block.geodetic.back().role = ControlRole::kCheck;
    expect_as_together(made.block, Calibration::kNone);
    // They do tell something.
    const AdjustedMarks with = adjusted_marks(made.block);
    made.block.geodetic.clear();
    const AdjustedMarks without = adjusted_marks(made.block);
    EXPECT_LT(with.points[0].covariance_m2.trace(), 0.8 * without.points[0].covariance_m2.trace());
  }
}

// A line has two coordinates across it, each with two unknowns of its own.
TEST(MarkedBlock, PointsOnALineTakePart) {
  const auto onto_line = [](std::vector<Vector3d>& positions) {
    for (Vector3d& position : positions) position = Vector3d(5, 5, 1) + 0.8 * position.x() * Vector3d(0.8, 0.6, 0.05);
  };
  testing::Marked made =
      testing::marked({.points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .seed = 11}, 9, onto_line);
  Random random(11, 4);
  for (auto& [id, point] : made.block.control) {
    point.position_in_world += 0.05 * testing::normal3(random);
    point.sigma_m.setConstant(0.05);
    for (const int axis : {0, 1})
      made.block.geodetic.push_back(
          {.kind = GeodeticKind::kOnLine, .from = id, .to = id, .sigma = 0.01, .setup = 1, .axis = axis});
  }
  expect_as_together(made.block, Calibration::kNone);
  // Across it they know more then, along it they may know as much.
  const Vector3d along = Vector3d(0.8, 0.6, 0.05).normalized();
  const auto across = [&](const AdjustedMarks& marks) {
    const Eigen::Matrix3d& covariance = marks.points[0].covariance_m2;
    return covariance.trace() - along.dot(covariance * along);
  };
  const AdjustedMarks with = adjusted_marks(made.block);
  made.block.geodetic.clear();
  EXPECT_LT(across(with), 0.95 * across(adjusted_marks(made.block)));
}

TEST(MarkedBlock, MeasurementsOnTheGroundAreOfPointsThatThereAre) {
  const Block block = test_block(small_block(9));
  auto base = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {});
  ASSERT_TRUE(base);
  const std::vector<BlockPoint> points = marked_in(block);
  const GeodeticObservation distance{.kind = GeodeticKind::kDistance, .value = 10, .sigma = 0.01},
      plane{.kind = GeodeticKind::kOnPlane, .sigma = 0.01};
  GeodeticObservation exact = distance;
  exact.sigma = 0;
  for (const PointLink& wrong :
       {PointLink{0, 99, distance}, PointLink{2, 2, distance}, PointLink{0, 1, plane}, PointLink{0, 1, exact}}) {
    const auto refused = base->adjust(points, {}, {&wrong, 1});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
  }
  // Of a point that has no position nothing is taken.
  std::vector<BlockPoint> some = points;
  some[1].marks.clear();
  const auto alone = base->adjust(some), linked = base->adjust(some, {}, std::vector{PointLink{0, 1, distance}});
  ASSERT_TRUE(alone && linked);
  EXPECT_EQ(*alone->points[0].position_in_world, *linked->points[0].position_in_world);
}

TEST(MarkedBlock, CheckPointsMoveNothing) {
  const Block block = test_block(small_block(4));
  Block without = block;
  std::erase_if(without.control, [](const auto& one) { return one.second.role == ControlRole::kCheck; });
  std::erase_if(without.control_observations,
                [&](const ControlObservation& seen) { return !without.control.contains(seen.point); });
  const AdjustedMarks with = adjusted_marks(block), only = adjusted_marks(without);
  std::size_t k = 0, p = 0, checks = 0;
  for (const auto& [id, point] : block.control) {
    const AdjustedMark& mark = with.points[p++];
    ASSERT_TRUE(mark.position_in_world);
    if (point.role == ControlRole::kControl)
      EXPECT_LT((*mark.position_in_world - *only.points[k++].position_in_world).norm(), 1e-3) << point.name;
    else
      ++checks;
  }
  EXPECT_EQ(checks, 3u);
}

// A block in a frame of its own: control places it, as in the adjustment of everything, however far it is off.
TEST(MarkedBlock, ABlockWithoutDatumIsPlacedByItsControl) {
  Block block = test_block(small_block(5, 0));
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  expect_as_together(block, Calibration::kNone);
  transform(block, Similarity3{1.02, rotation_by({0.02, -0.01, 0.05}), {3, -2, 5}});
  expect_as_together(block, Calibration::kNone);
}

TEST(MarkedBlock, TooLittleControlLeavesABlockInItsOwnDatum) {
  Block block = test_block(small_block(6, 0));
  while (block.control.size() > 2) block.control.erase(std::prev(block.control.end()));
  std::erase_if(block.control_observations,
                [&](const ControlObservation& seen) { return !block.control.contains(seen.point); });
  const AdjustedMarks marks = adjusted_marks(block);
  EXPECT_FALSE(marks.placed);
  for (const AdjustedMark& mark : marks.points) EXPECT_TRUE(mark.position_in_world);
}

// The joint covariance of up to nine points that were not surveyed: e' C^-1 e is chi-squared with three degrees of
// freedom a point, some 800 of 30 blocks, so that its mean over them is 1 with a standard deviation of 0.05.
TEST(MarkedBlock, CovariancesAreThoseOfTheErrors) {
  constexpr int kBlocks = 30;
  double sum = 0, degrees = 0;
  for (int seed = 1; seed <= kBlocks; ++seed) {
    const testing::Marked made = testing::marked(small_block(std::uint64_t(seed)));
    std::vector<BlockPoint> points = marked_in(made.block);
    for (BlockPoint& point : points) point.surveyed.reset();
    Result<MarkedBlock> base = MarkedBlock::of(made.block, {}, plain(), BlockControl::kLeftOut, {});
    ASSERT_TRUE(base);
    const Result<AdjustedMarks> marks = base->adjust(points);
    ASSERT_TRUE(marks);
    Eigen::VectorXd error(marks->covariance_m2.rows());
    Eigen::Index row = 0;
    for (std::size_t p = 0; p < marks->points.size(); ++p) {
      if (!marks->points[p].position_in_world) continue;  // fewer than two images show it
      error.segment<3>(row) = *marks->points[p].position_in_world - made.truth.at(ControlId{std::uint32_t(p)});
      row += 3;
    }
    ASSERT_EQ(row, error.size());
    sum += error.dot(marks->covariance_m2.ldlt().solve(error));
    degrees += double(row);
  }
  EXPECT_GT(degrees, 700);
  EXPECT_NEAR(sum / degrees, 1, 4 * 0.05);
}

// Differences of check points in their predicted standard deviations: 30 blocks of three points of three axes, which
// are correlated within a block; without correlation their mean square scatters by 0.09.
TEST(MarkedBlock, CheckPointsDifferAsPredicted) {
  constexpr int kBlocks = 30;
  double sum = 0;
  for (int seed = 1; seed <= kBlocks; ++seed) {
    const Block block = test_block(small_block(std::uint64_t(seed)));
    const AdjustedMarks marks = adjusted_marks(block);
    std::size_t p = 0;
    for (const auto& [id, point] : block.control) {
      const AdjustedMark& mark = marks.points[p++];
      if (point.role == ControlRole::kCheck)
        sum += mark.difference_m.cwiseQuotient(mark.difference_sigma_m).squaredNorm();
    }
  }
  EXPECT_NEAR(sum / (kBlocks * 9), 1, 0.4);
}

// What came before changes nothing: marks one by one, in any order, end where all at once do.
TEST(MarkedBlock, MarksOneByOneAreAllAtOnce) {
  const Block block = test_block(small_block(7));
  const std::vector<BlockPoint> all = marked_in(block);
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {}),
                      fresh = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {});
  ASSERT_TRUE(base && fresh);
  std::vector<BlockPoint> some;
  for (const BlockPoint& point : all) {
    some.push_back({{}, point.surveyed});
    for (const BlockMark& mark : point.marks) {
      some.back().marks.push_back(mark);
      ASSERT_TRUE(base->adjust(some));
    }
  }
  const Result<AdjustedMarks> last = base->adjust(some), at_once = fresh->adjust(all);
  ASSERT_TRUE(last && at_once);
  for (std::size_t p = 0; p < all.size(); ++p)
    EXPECT_EQ(*last->points[p].position_in_world, *at_once->points[p].position_in_world);
}

// A wrong mark has the largest test, and its redundancy says how much of it shows.
TEST(MarkedBlock, AWrongMarkIsSeenAtOnce) {
  const Block block = test_block(small_block(8));
  std::vector<BlockPoint> points = marked_in(block);
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {});
  ASSERT_TRUE(base);
  const Result<AdjustedMarks> right = base->adjust(points);
  points[0].marks[2].pixel.x() += 30;
  const Result<AdjustedMarks> wrong = base->adjust(points);
  ASSERT_TRUE(right && wrong);
  double largest = 0;
  for (const AdjustedMark& point : wrong->points)
    for (const BlockMarkTest& test : point.marks) largest = std::max(largest, test.w.cwiseAbs().maxCoeff());
  const BlockMarkTest &before = right->points[0].marks[2], &after = wrong->points[0].marks[2];
  EXPECT_EQ(std::abs(after.w.x()), largest);
  EXPECT_NEAR(after.residual_px.x() - before.residual_px.x(), 30 * before.redundancy.x(), 0.02 * 30);
  EXPECT_NEAR(before.minimal_detectable_bias_px.x(), 4.13 * 0.5 * right->sigma0 / std::sqrt(before.redundancy.x()),
              0.01);
}

// Control that is kept holds the block as the adjustment of everything has it, and a check point beside it is where it
// would be as a tie point: in the adjustment with the rays of check points.
TEST(MarkedBlock, APointBesideControlIsWhereTheAdjustmentHasIt) {
  Block block = test_block(small_block(10));
  const auto last = std::prev(block.control.end());
  for (auto& [id, point] : block.control) point.role = id == last->first ? ControlRole::kCheck : ControlRole::kControl;
  const Result<Examined> together = examine(block, {.use_check_rays = true}, testing::examined(), {});
  ASSERT_TRUE(together);
  BlockPoint point = marked_in(block).back();
  point.surveyed.reset();
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(), BlockControl::kKept, {});
  ASSERT_TRUE(base);
  const Result<AdjustedMarks> marks = base->adjust(std::vector{point});
  ASSERT_TRUE(marks);
  const ControlDifference& expected = together->control.back();
  for (int axis = 0; axis < 3; ++axis) {
    const double sigma = std::sqrt((*expected.covariance_m2)(axis, axis));
    EXPECT_NEAR((*marks->points[0].position_in_world)[axis], (*expected.position_in_world)[axis], 2e-3 * sigma);
    EXPECT_NEAR(std::sqrt(marks->points[0].covariance_m2(axis, axis)) / marks->sigma0, sigma, 2e-3 * sigma);
  }
}

TEST(MarkedBlock, WhatDeterminesNothingHasNoPosition) {
  const Block block = test_block(small_block(9));
  const std::vector<BlockPoint> all = marked_in(block);
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {});
  ASSERT_TRUE(base);
  BlockPoint one_ray{{all[0].marks[0]}}, nothing, by_survey{{all[0].marks[0]}, all[0].surveyed},
      elsewhere{{{ImageId{9999}, {10, 10}}, {ImageId{9998}, {10, 10}}}};
  const Result<AdjustedMarks> found = base->adjust(std::vector{one_ray, nothing, by_survey, elsewhere, all[1]});
  ASSERT_TRUE(found);
  for (const std::size_t p : {0u, 1u, 3u}) EXPECT_FALSE(found->points[p].position_in_world);
  EXPECT_TRUE(std::isnan(found->points[0].marks[0].residual_px.x()));
  for (const std::size_t p : {2u, 4u}) EXPECT_TRUE(found->points[p].position_in_world);
  EXPECT_EQ(found->covariance_m2.rows(), 6);
  EXPECT_TRUE(base->adjust({}));
  one_ray.marks[0].sigma_px = 0;
  const Result<AdjustedMarks> bad = base->adjust(std::vector{one_ray});
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, Errc::kBadInput);
}

// Marks that a hand slipped with: rays that do not meet, or meet anywhere. All other points have their position.
TEST(MarkedBlock, MarksThatMeetNowhereKeepNobodyElseFromHisPosition) {
  const Block block = test_block(small_block(9));
  const std::vector<BlockPoint> all = marked_in(block);
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, plain(), BlockControl::kLeftOut, {});
  ASSERT_TRUE(base);
  Random random(4);
  std::vector<ImageId> images;
  for (const auto& [id, image] : block.images) images.push_back(id);
  const auto any_mark = [&] {
    const ImageId image = images[random.below(std::uint32_t(images.size()))];
    const Camera& camera = block.camera_of(image);
    return BlockMark{image, {camera.width_px * random.uniform(), camera.height_px * random.uniform()}, 0.5};
  };
  int without = 0;
  for (int i = 0; i < 300; ++i) {
    BlockPoint wrong{{any_mark(), any_mark()}};
    if (i % 3 == 0) wrong.marks.push_back(any_mark());
    const Result<AdjustedMarks> found = base->adjust(std::vector{all[0], wrong, all[1]});
    ASSERT_TRUE(found) << i << ": " << found.error().message;
    for (const std::size_t p : {0u, 2u}) EXPECT_TRUE(found->points[p].position_in_world) << i;
    without += !found->points[1].position_in_world;
  }
  EXPECT_GT(without, 10);
}

}  // namespace
}  // namespace collinea
