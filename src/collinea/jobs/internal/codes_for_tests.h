// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <span>
#include <string>

#include "collinea/base/finding.h"

namespace collinea {

/// The words of the codes of findings.
[[nodiscard]] inline std::set<std::string> codes_of(std::span<const Finding> findings) {
  std::set<std::string> codes;
  for (const Finding& finding : findings) codes.emplace(word_of(finding.code));
  return codes;
}

/// The first finding of that code; an empty one where there is none.
[[nodiscard]] inline Finding first_of(std::span<const Finding> findings, FindingCode code) {
  for (const Finding& finding : findings)
    if (finding.code == code) return finding;
  return {};
}

using Codes = std::set<std::string>;

}  // namespace collinea
