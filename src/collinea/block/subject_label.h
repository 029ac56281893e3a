// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// The subject by its words and its name in the block, for messages of errors and logs: "lever_arm of camera FC6310",
/// "image DSC_1.jpg". Sentences for people name it in `report`.
[[nodiscard]] std::string label_of(const Subject& subject, const Block& block);

/// The finding by its words: "inseparable: shift of strip 1, drift of strip 1; correlation 0.998"; "" without one.
[[nodiscard]] std::string label_of(const Finding& finding, const Block& block);
[[nodiscard]] std::string label_of(const std::optional<Finding>& finding, const Block& block);

/// The name of the subject's thing alone: a file, the name of a camera or a point; a number from 1 where it has none.
[[nodiscard]] std::string name_in_block(const Subject& subject, const Block& block);

}  // namespace collinea
