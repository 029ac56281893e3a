// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/adjusted_findings.h"

#include "collinea/orient/additional.h"
#include "collinea/orient/internal/geodetic_findings.h"
#include "collinea/orient/internal/instrument_findings.h"
#include "collinea/orient/internal/weak_cases.h"

namespace collinea {

std::vector<Finding> adjusted_findings(const Block& block, const Examined& adjusted,
                                       const std::map<CameraId, Camera>& first_cameras,
                                       const std::set<std::size_t>& excluded_geodetic) {
  std::vector<Finding> findings = geodetic_findings(block, adjusted, excluded_geodetic);
  for (const auto& more : {instrument_findings(adjusted), additional_findings(block, adjusted),
                           weak_focals(block, first_cameras, adjusted), moved_focals(first_cameras, adjusted)})
    findings.insert(findings.end(), more.begin(), more.end());
  return findings;
}

}  // namespace collinea
