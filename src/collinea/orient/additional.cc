// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/additional.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "collinea/quality/additional_choice.h"

namespace collinea {

Result<AdditionalSet> additional_named(const std::string& name) {
  const auto known = std::ranges::find(kAdditionalNames, name);
  if (known != kAdditionalNames.end()) return AdditionalSet(known - kAdditionalNames.begin());
  return fail(Errc::kBadInput,
              fmt::format("additional = \"{}\": choose one of {}", name, fmt::join(kAdditionalNames, ", ")));
}

Result<std::map<CameraId, CameraSigmas>> add_additional(const std::string& name, const std::string& calibration,
                                                        std::map<CameraId, Camera>& cameras) {
  COLLINEA_TRY(const AdditionalSet set, additional_named(name));
  std::map<CameraId, CameraSigmas> sigmas;
  for (auto& [id, camera] : cameras) {
    if (!camera.prior.calibrate || calibration == "none") continue;
    camera.additional = set;
    const auto of_lens = calibration_named(calibration, camera);
    const auto all = with_additional(of_lens.value_or(CameraSigmas{}), camera, {});
    COLLINEA_CHECK(all.has_value());
    sigmas[id] = *all;
  }
  return sigmas;
}

std::vector<std::string> additional_findings(const Block& block, const Examined& adjusted) {
  constexpr double kLevel = 0.01;
  std::vector<std::string> findings;
  for (const AdditionalTest& test : test_additional(block, adjusted, false, kLevel))
    findings.push_back(
        fmt::format("{}: {} of {} additional parameters are significant; collinea adjust tells which, and how alike "
                    "they are",
                    block.cameras.at(test.camera).name, test.kept, test.parameters.size()));
  return findings;
}

}  // namespace collinea
