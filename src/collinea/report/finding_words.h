// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/report/subject_words.h"

namespace collinea {

/// Words for findings: the only place where a finding becomes a sentence. Short declarative sentences: the finding
/// first, then the figure, then what to do.

/// The finding and its figures, one sentence or two: "Check point P7 is 0.8 m off the control points."
[[nodiscard]] std::string what_of(const Finding& finding, const Block& block);

/// Why a file or an image has no part in what follows, without its name, which stands beside it in every list: "smaller
/// than 64 x 64 pixels", "no depth map: too few tie points see it". Of findings whose first subject was skipped.
[[nodiscard]] std::string reason_of(const Finding& skipped, const Block& block);

/// What to do, one sentence: "Give a calibrated camera, or set option calibration = none."; "" when there is nothing.
/// Without `spell` an option is "option calibration = none".
[[nodiscard]] std::string remedy_of(const Finding& finding, const SpellOption& spell = {});

/// Both.
[[nodiscard]] std::string sentence_of(const Finding& finding, const Block& block, const SpellOption& spell = {});

}  // namespace collinea
