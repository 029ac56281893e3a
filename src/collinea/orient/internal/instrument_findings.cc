// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/instrument_findings.h"

#include <numbers>

namespace collinea {
namespace {

constexpr std::size_t kMostStrips = 6;

// Its unknowns, three or one, from the first on.
Finding finding_of_instrument(const Adjusted& adjusted, std::size_t first) {
  const auto& auxiliaries = adjusted.auxiliaries;
  const UnknownKind kind = auxiliaries[first].kind;
  const double unit = kind == UnknownKind::kBoresight ? 180 / std::numbers::pi : 1;
  const std::size_t count = kind == UnknownKind::kTimeOffset ? 1 : 3;
  Finding finding = finding_of(FindingCode::kInstrument, {subject_of(kind, auxiliaries[first].owner, 0)});
  for (std::size_t k = first; k < first + count; ++k)
    finding.figures.push_back({FigureName::kValue, unit * auxiliaries[k].value});
  for (std::size_t k = first; k < first + count; ++k)
    finding.figures.push_back({FigureName::kValueSigma, unit * auxiliaries[k].sigma * sigma_scale(adjusted)});
  return finding;
}

}  // namespace

std::vector<Finding> instrument_findings(const Examined& adjusted) {
  std::vector<Finding> findings;
  std::size_t strips = 0;
  const auto& auxiliaries = adjusted.auxiliaries;
  for (std::size_t i = 0; i < auxiliaries.size(); ++i) {
    const UnknownKind kind = auxiliaries[i].kind;
    if (kind == UnknownKind::kOrientation || is_of_shape(kind) || auxiliaries[i].axis != 0) continue;
    const bool of_strip = kind == UnknownKind::kShift || kind == UnknownKind::kDrift;
    if (of_strip && ++strips > kMostStrips) continue;
    findings.push_back(finding_of_instrument(adjusted, i));
  }
  if (strips > kMostStrips)
    findings.push_back(finding_of(FindingCode::kInstrumentsMore, {},
                                  {{FigureName::kCount, static_cast<double>(strips - kMostStrips)}}));
  findings.insert(findings.end(), adjusted.inseparable.begin(), adjusted.inseparable.end());
  if (!auxiliaries.empty() && adjusted.undetermined) findings.push_back(*adjusted.undetermined);
  return findings;
}

}  // namespace collinea
