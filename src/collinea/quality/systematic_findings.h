// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/quality/systematics.h"

namespace collinea {

/// What a test is of.
[[nodiscard]] Subject subject_of(const SystematicTest& test);

/// One finding for each significant test that no other explains, the strongest first, with those that cannot be told
/// from it as further subjects. It is a note when it moves no point by more than its standard deviation.
[[nodiscard]] std::vector<Finding> systematic_findings(const std::vector<SystematicTest>& tests, const Block& block);

/// That of a test for which the next adjustment has an unknown.
[[nodiscard]] Finding taken_up_finding(const std::vector<SystematicTest>& tests, const SystematicTest& test,
                                       const Block& block);

}  // namespace collinea
