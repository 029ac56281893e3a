// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// A systematic error: "a time offset of the positions of FC6310".
[[nodiscard]] std::string systematic_name(const Subject& subject, const Block& block);

/// The sentences of FindingCode::kSystematic: what it is, its size and evidence, what it displaces, what it changes on
/// the ground and what else it may be.
[[nodiscard]] std::string systematic_words(const Finding& finding, const Block& block);

}  // namespace collinea
