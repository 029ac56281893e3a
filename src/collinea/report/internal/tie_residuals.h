// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "collinea/base/words.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {

/// What became of a measurement of a tie point.
enum class TieState : std::uint8_t { kUsed, kSuspected, kNotSeen, kNoPart, kMismatch, kWithMismatch, kGrossError };
inline constexpr Word<TieState> kTieStateWords[] = {
    {TieState::kUsed, "used"},
    {TieState::kSuspected, "suspected", "its test is beyond the limit"},
    {TieState::kNotSeen, "not_seen", "its point lies where the image does not see it"},
    {TieState::kNoPart, "no_part", "its point or image has too few measurements"},
    {TieState::kMismatch, "mismatch", "rejected: probably of another point"},
    {TieState::kWithMismatch, "with_mismatch", "rejected: it, or the one that is, or the last one left"},
    {TieState::kGrossError, "gross_error", "rejected by data snooping"}};
[[nodiscard]] constexpr std::span<const Word<TieState>> words(TieState) { return kTieStateWords; }

/// Writes a row for every measurement of a tie point (AdjustmentReport::measured_ties), in the order of points and
/// images: column and row [px, (0.5, 0.5) is the centre of the first pixel; corrected for refraction where that was],
/// its standard deviation [px], residuals (observed minus adjusted [px]), redundancy numbers, standardised residuals
/// w as tested (TestedObservation::w) and their limit, the weight that the loss gives it (1: full; 0: it takes no
/// part), and its state. Of what takes no part residuals are against the adjusted point, where there is one; what is
/// not known is empty. Written piece by piece: memory does not grow with the number of rows. Errors: disk.
[[nodiscard]] Result<> write_tie_residuals(const AdjustmentReport& report, const std::filesystem::path& file);

}  // namespace collinea
