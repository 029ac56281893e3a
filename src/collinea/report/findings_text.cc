// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/findings_text.h"

#include <fmt/format.h>

#include "collinea/report/finding_words.h"

namespace collinea {

std::string findings_text(std::span<const Finding> findings) {
  std::string text;
  for (const Severity severity : {Severity::kWrong, Severity::kWeak, Severity::kNote})
    for (const Finding& finding : findings)
      if (finding.severity == severity)
        text += fmt::format("  {}: {}\n", word_of(severity), sentence_of(finding, Block{}));
  return text.empty() ? text : "findings\n" + text;
}

}  // namespace collinea
