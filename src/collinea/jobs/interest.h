// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/feature/interest.h"
#include "collinea/report/interest_report.h"

namespace collinea {

/// Of which operators the repeatability is tried.
enum class RepeatabilityOf { kThis, kAll };
inline constexpr Word<RepeatabilityOf> kRepeatabilityOfWords[] = {
    {RepeatabilityOf::kThis, "this", "of the operator chosen"}, {RepeatabilityOf::kAll, "all", "of all operators"}};
[[nodiscard]] constexpr std::span<const Word<RepeatabilityOf>> words(RepeatabilityOf) { return kRepeatabilityOfWords; }

struct InterestJobOptions {
  InterestOptions points;
  std::optional<RepeatabilityOf> repeatability = {};
  double tolerance_px = 1.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = InterestJobOptions;
    visit(Part{&O::points});
    visit(Field{"repeatability", &O::repeatability, "",
                "also render the image turned, at other scales and with noise, and count the points found again"});
    visit(Field{"tolerance_px", &O::tolerance_px, "px", "of repeatability: largest distance of a point found again",
                0.01, 100});
  }
};

/// Finds the interest points of an image and writes into `folder`: points.txt, points.png (the image with them),
/// map.tif (responses, float) and map.png (their square roots, to look at); repeatability.txt and .svg where asked
/// for. Errors: files, options.
[[nodiscard]] Result<InterestReport> find_interest(const std::filesystem::path& image,
                                                   const std::filesystem::path& folder,
                                                   const InterestJobOptions& options, const Run& run);

}  // namespace collinea
