// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/base/words.h"

namespace collinea {

/// The steps in their order.
enum class Step : std::uint8_t {
  kImport,
  kDetect,
  kMatch,
  kOrient,
  kAdjust,
  kDensify,
  kSurface,
  kTerrain,
  kOrtho,
  kFrames,
  kReport,
};
inline constexpr Word<Step> kStepWords[] = {
    {Step::kImport, "import"}, {Step::kDetect, "detect"},   {Step::kMatch, "match"},     {Step::kOrient, "orient"},
    {Step::kAdjust, "adjust"}, {Step::kDensify, "densify"}, {Step::kSurface, "surface"}, {Step::kTerrain, "terrain"},
    {Step::kOrtho, "ortho"},   {Step::kFrames, "frames"},   {Step::kReport, "report"}};
[[nodiscard]] constexpr std::span<const Word<Step>> words(Step) { return kStepWords; }

}  // namespace collinea
