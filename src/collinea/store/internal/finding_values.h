// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/finding.h"

namespace collinea {

// Which values the enumerations of findings have: others in stored bytes are damage (packed_fields.h).

[[nodiscard]] constexpr bool is_known(Severity severity) { return severity <= Severity::kWrong; }
[[nodiscard]] constexpr bool is_known(FindingCode code) { return std::size_t(code) < kFindingCodes; }
[[nodiscard]] constexpr bool is_known(FigureName name) { return std::size_t(name) < kFigureNames; }
[[nodiscard]] constexpr bool is_known(SubjectKind kind) { return std::size_t(kind) < kSubjectKinds; }
[[nodiscard]] constexpr bool is_known(Aspect aspect) { return std::size_t(aspect) < kAspectsOfSubjects; }
[[nodiscard]] constexpr bool is_known(RemedyCode code) { return std::size_t(code) < kRemedyCodes; }

}  // namespace collinea
