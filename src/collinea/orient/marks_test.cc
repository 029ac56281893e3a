// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/adjust/test_block.h"
#include "collinea/orient/internal/test_pairs.h"
#include "collinea/orient/orient.h"
#include "collinea/quality/mark_systems.h"

namespace collinea {
namespace {

using testing::centre_rms_m;
using testing::kPixel_m;
using testing::Matched;
using testing::matched;

// A block on the map whose marks were counted otherwise, one of them gross besides.
Matched marked_in(const MarkHypothesis& written, std::uint64_t seed = 3) {
  Matched input = matched(
      testing::test_block({.rows = 2, .columns = 4, .points = 500, .sigma_px = 0.5, .control = 9, .seed = seed}));
  input.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  input.setup.control_observations[1].pixel.x() += 60;
  for (ControlObservation& seen : input.setup.control_observations) {
    const Camera& camera = input.setup.camera_of(seen.image);
    const MarkMap map = map_of(written, camera.width_px, camera.height_px);
    seen.pixel = map.linear.inverse() * (seen.pixel - map.origin);
  }
  return input;
}

std::size_t count_of(const std::vector<Finding>& findings, FindingCode code) {
  return static_cast<std::size_t>(std::ranges::count(findings, code, &Finding::code));
}

TEST(OrientMarks, MarksThatWereCountedOtherwiseAreCorrectedAndNamed) {
  for (const MarkHypothesis written : {MarkHypothesis{MarkSystem::kRowsUp},
                                       {MarkSystem::kResampled, 1.92},
                                       {MarkSystem::kCentre},
                                       {MarkSystem::kScaledCentreRowsUp, 250}}) {
    const Matched input = marked_in(written);
    const auto found = orient(input.setup, input.pairs, input.source(), {}, {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(count_of(found->findings, FindingCode::kMarksCountedOtherwise), 1u) << word_of(written.system);
    EXPECT_EQ(count_of(found->findings, FindingCode::kMarksCorrected), 1u) << word_of(written.system);
    EXPECT_EQ(count_of(found->findings, FindingCode::kControlMeasurement), 1u);  // the gross one
    EXPECT_EQ(count_of(found->findings, FindingCode::kControlMeasurementsDisagree), 0u);
    EXPECT_TRUE(found->georeferenced);
    EXPECT_TRUE(found->gauge.by_control);
    EXPECT_LT(centre_rms_m(found->block, input.truth, false), 5 * kPixel_m);
  }
}

TEST(OrientMarks, MarksOutsideTheirImagesTakeNoPart) {
  Matched input = marked_in({});
  const std::size_t before = input.setup.control_observations.size();
  input.setup.control_observations[5].pixel = {-400, 100};
  for (const bool use_control : {true, false}) {
    const auto found = orient(input.setup, input.pairs, input.source(), {.use_control = use_control}, {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(found->block.control_observations.size(), before);
    for (const ControlObservation& seen : found->block.control_observations)
      EXPECT_TRUE(inside(found->block.camera_of(seen.image), seen.pixel));
  }
}

}  // namespace
}  // namespace collinea
