// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/value_words.h"

#include <gtest/gtest.h>

#include <set>

#include "collinea/report/plan_words.h"
#include "collinea/report/product_words.h"

namespace collinea {
namespace {

TEST(ValueWords, EveryGroupOfObservationsHasItsOwn) {
  std::set<std::string_view> seen;
  for (std::size_t g = 0; g < kObservationGroups; ++g) {
    const std::string_view words = words_of(ObservationGroup(g));
    EXPECT_FALSE(words.empty()) << g;
    EXPECT_TRUE(seen.insert(words).second) << words;
  }
  EXPECT_EQ(words_of(ObservationGroup::kTieImages), "tie points in images");
  EXPECT_EQ(words_of(ObservationGroup::kPositionHeight), "positions, height");
  EXPECT_EQ(words_of(ObservationGroup::kAttitudeHeading), "attitudes, heading");
}

TEST(ValueWords, OriginsOfFocalLengthsAreNamedButForTheUnknown) {
  EXPECT_EQ(words_of(Provenance::kUnknown), "");
  for (const auto& [source, word, meaning] : words(Provenance{}))
    EXPECT_EQ(words_of(source).empty(), source == Provenance::kUnknown) << word;
  EXPECT_EQ(words_of(Provenance::kExifPixelPitch), "EXIF focal length and pixel pitch");
}

TEST(ValueWords, JudgementsNameOnlyWhatChanged) {
  SigmaFactors factors = as_given();
  EXPECT_EQ(judgement_words(factors, {0, 0, 0}), "");
  EXPECT_EQ(judgement_words(factors, {0.1, -0.02, 1.3}), "positions shifted by +0.10, -0.02, +1.30 m");
  factors[std::size_t(ObservationGroup::kControlPlan)] = 1.72;
  EXPECT_EQ(judgement_words(factors, {0, 0, 1}),
            "sigmas of \"control, plan\" times 1.7, positions shifted by +0.00, +0.00, +1.00 m");
}

TEST(ValueWords, WithoutAChoiceOptionsAreAsByDefault) {
  ReportInput input;
  EXPECT_EQ(chosen_options(input), NamedValues());
  input.options.emplace();
  EXPECT_EQ(chosen_options(input), (NamedValues{{"all", "as by default"}}));
  input.options->emplace_back("seed", "2");
  EXPECT_EQ(chosen_options(input), (NamedValues{{"seed", "2"}}));
}

TEST(ProductWords, ContentsComeFromTheRecordsOfTheSteps) {
  std::vector<StepRecord> steps(3);
  steps[0].outcome = DensifyRecord{.points = 34412345};
  steps[1].outcome = SurfaceRecord{.cell_m = 0.03, .width = 4021, .height = 3877};
  steps[2].outcome = TerrainRecord{.cell_m = 0.1, .contour_m = 2.5};
  EXPECT_EQ(content_of(ProductFile::kCloudCopc, steps),
            "34,412,345 points, COPC 1.0 (LAZ 1.4) in the map, with sigmas");
  EXPECT_EQ(content_of(ProductFile::kSurface, steps), "cells of 0.03 m, 4021 x 3877");
  EXPECT_EQ(content_of(ProductFile::kContoursDxf, steps), "every 2.5 m, with heights, DXF");
  EXPECT_EQ(content_of(ProductFile::kSurfaceSigma, steps), "m");
  EXPECT_EQ(content_of(ProductFile::kOrthophoto, {}), "cells of 0 m, 0 x 0, Cloud-Optimised GeoTIFF");
}

TEST(ProductWords, EveryProductHasAFileOfItsOwn) {
  std::set<std::string_view> files;
  for (std::size_t i = 0; i < kProductFiles; ++i) {
    const auto product = static_cast<ProductFile>(i);
    EXPECT_TRUE(files.insert(path_of(product)).second) << path_of(product);
    EXPECT_TRUE(path_of(product).starts_with("products/"));
    EXPECT_FALSE(name_of(product).empty());
  }
  EXPECT_EQ(path_of(ProductFile::kOrthophotoSource), "products/ortho_source.tif");
}

TEST(PlanWords, GainsAndRulesAreNamed) {
  EXPECT_EQ(words_of(Gain{.by = GainBy::kPositions, .sigma_m = {0.02, 0.02, 0.03}}),
            "projection centres by RTK (20, 20, 30 mm)");
  EXPECT_EQ(words_of(Gain{.by = GainBy::kControlPoint}), "one more control point");
  for (std::size_t i = 0; i < kPlanRules; ++i) {
    EXPECT_FALSE(words_of(PlanRule(i)).empty()) << i;
    EXPECT_FALSE(formula_of(PlanRule(i)).empty()) << i;
  }
  EXPECT_EQ(formula_of(PlanRule::kSignalisedHeightSuperWide), "0.08 ‰ * h (super-wide)");
  EXPECT_EQ(words_of(PlanRule::kContours), "contours on gentle slopes");
  for (int i = 0; i <= int(PlanCustom::kControlAtCorners); ++i) EXPECT_FALSE(words_of(PlanCustom(i)).empty()) << i;
}

}  // namespace
}  // namespace collinea
