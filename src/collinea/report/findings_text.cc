// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/findings_text.h"

#include <fmt/format.h>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/finding_json.h"

namespace collinea {

std::string findings_text(std::span<const Finding> findings) {
  std::string text;
  for (const Severity severity : {Severity::kWrong, Severity::kWeak, Severity::kNote})
    for (const Finding& finding : findings)
      if (finding.severity == severity)
        text += fmt::format("  {}: {}\n", word_of(severity), sentence_of(finding, Block{}));
  return text.empty() ? text : "findings\n" + text;
}

std::string findings_json_text(std::span<const Finding> findings) {
  nlohmann::ordered_json all;
  all["findings"] = findings_json({findings.begin(), findings.end()}, Block{});
  return all.dump(2) + "\n";
}

}  // namespace collinea
