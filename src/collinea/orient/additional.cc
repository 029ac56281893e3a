// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/additional.h"

#include <fmt/format.h>

#include "collinea/quality/additional_choice.h"

namespace collinea {

std::map<CameraId, CameraSigmas> add_additional(AdditionalSet set, Calibration calibration,
                                                std::map<CameraId, Camera>& cameras) {
  std::map<CameraId, CameraSigmas> sigmas;
  for (auto& [id, camera] : cameras) {
    if (!camera.prior.calibrate || calibration == Calibration::kNone) continue;
    camera.additional = set;
    const auto all = with_additional(calibration_sigmas(calibration, camera), camera, {});
    COLLINEA_CHECK(all.has_value());
    sigmas[id] = *all;
  }
  return sigmas;
}

std::vector<Finding> additional_findings(const Block& block, const Examined& adjusted) {
  constexpr double kLevel = 0.01;
  std::vector<Finding> findings;
  for (const AdditionalTest& test : test_additional(block, adjusted, false, kLevel))
    findings.push_back(finding_of(FindingCode::kAdditionalSignificant, {test.camera},
                                  {{FigureName::kCount, static_cast<double>(test.kept)},
                                   {FigureName::kOf, static_cast<double>(test.parameters.size())}},
                                  {RemedyCode::kSeeAdjustment}));
  return findings;
}

}  // namespace collinea
