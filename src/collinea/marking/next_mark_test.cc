// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/next_mark.h"

#include <gtest/gtest.h>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

// Control of a block with all its marks in images of their own, and of each point only the first few of them taken.
struct Marked {
  std::vector<BlockPoint> points;
  std::vector<PossibleMark> left;
};
Marked marked_in(const Block& block, std::size_t taken) {
  Marked out;
  for (const auto& [id, point] : block.control) {
    BlockPoint one;
    one.surveyed = SurveyedPosition{point.position_in_world, point.sigma_m, point.correlation, point.role};
    for (const ControlObservation& seen : block.control_observations) {
      if (seen.point != id) continue;
      const BlockMark mark{seen.image, seen.pixel, seen.sigma_px, seen.shape};
      if (one.marks.size() < taken)
        one.marks.push_back(mark);
      else
        out.left.push_back({out.points.size(), mark});
    }
    out.points.push_back(std::move(one));
  }
  return out;
}

class NextMarks : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made = MarkedBlock::of(block_, {}, testing::plain(), BlockControl::kLeftOut, {});
    ASSERT_TRUE(made) << made.error().message;
    marked_.emplace(std::move(*made));
  }
  Block block_ =
      testing::test_block({.points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 6, .seed = 5});
  std::optional<MarkedBlock> marked_;
};

TEST_F(NextMarks, TheOneChosenMakesStandardDeviationsSmallerThanAnyOther) {
  const Marked marked = marked_in(block_, 2);
  ASSERT_GT(marked.left.size(), 4u);
  const auto next = best_next_mark(*marked_, marked.points, marked.left);
  ASSERT_TRUE(next && *next);
  EXPECT_EQ((*next)->placed_before, marked.points.size());
  EXPECT_LT((*next)->rms_sigma_after_m, (*next)->rms_sigma_before_m);
  for (const PossibleMark& one : marked.left) {
    std::vector<BlockPoint> points = marked.points;
    points[one.point].marks.push_back(one.mark);
    const auto after = marked_->adjust(points);
    ASSERT_TRUE(after);
    double variances = 0;
    for (const AdjustedMark& point : after->points) variances += point.covariance_m2.trace();
    const double rms = std::sqrt(variances / (3.0 * double(points.size())));
    EXPECT_GE(rms, (*next)->rms_sigma_after_m * (1 - 1e-12));
    if (one.point == (*next)->mark.point && one.mark.image == (*next)->mark.mark.image) {
      EXPECT_NEAR(rms, (*next)->rms_sigma_after_m, 1e-12);
    }
  }
}

TEST_F(NextMarks, APointThatHasNoPositionComesFirst) {
  Marked marked = marked_in(block_, 2);
  marked.points[3].surveyed.reset();
  marked.points[3].marks.pop_back();
  const auto next = best_next_mark(*marked_, marked.points, marked.left);
  ASSERT_TRUE(next && *next);
  EXPECT_EQ((*next)->mark.point, 3u);
  EXPECT_EQ((*next)->placed_after, (*next)->placed_before + 1);
}

TEST_F(NextMarks, WithoutAnyToMakeThereIsNone) {
  const Marked marked = marked_in(block_, 2);
  const auto next = best_next_mark(*marked_, marked.points, {});
  ASSERT_TRUE(next);
  EXPECT_FALSE(*next);
}

}  // namespace
}  // namespace collinea
