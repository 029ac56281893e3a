// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/instrument_findings.h"

#include <fmt/format.h>

#include <numbers>

namespace collinea {
namespace {

constexpr std::size_t kMostStrips = 6;

struct Words {
  const char* what;
  const char* axes;  ///< behind the three numbers
  double unit = 1;
  int decimals = 3;
};

Words words_of(UnknownKind kind) {
  switch (kind) {
    case UnknownKind::kLeverArm:
      return {"the lever arm", "m to the right, downwards and along the axis"};
    case UnknownKind::kShift:
      return {"the shift of positions", "m east, north and up"};
    case UnknownKind::kDrift:
      return {"the drift of positions", "m/s east, north and up", 1, 5};
    case UnknownKind::kBoresight:
      return {"the boresight", "degrees about x, y and the optical axis", 180 / std::numbers::pi, 4};
    default:
      return {"the time offset of positions", "s after the picture", 1, 4};
  }
}

}  // namespace

std::vector<std::string> instrument_findings(const Block& block, const Examined& adjusted) {
  std::vector<std::string> findings;
  std::size_t strips = 0;
  const auto& extras = adjusted.extras;
  for (std::size_t i = 0; i < extras.size(); ++i) {
    const UnknownKind kind = extras[i].kind;
    if (kind == UnknownKind::kOrientation || is_of_shape(kind) || extras[i].axis != 0) continue;
    const bool of_strip = kind == UnknownKind::kShift || kind == UnknownKind::kDrift;
    if (of_strip && ++strips > kMostStrips) continue;
    const Words words = words_of(kind);
    const std::size_t count = kind == UnknownKind::kTimeOffset ? 1 : 3;
    std::string values, sigmas;
    for (std::size_t k = i; k < i + count; ++k) {
      values += fmt::format("{}{:+.{}f}", k > i ? ", " : "", words.unit * extras[k].value, words.decimals);
      sigmas += fmt::format("{}{:.{}f}", k > i ? ", " : "", words.unit * extras[k].sigma * sigma_scale(adjusted),
                            words.decimals);
    }
    findings.push_back(fmt::format(
        "{} of {} is {} {} (sigma {})", words.what,
        of_strip ? fmt::format("strip {}", extras[i].owner + 1) : block.cameras.at(CameraId{extras[i].owner}).name,
        values, words.axes, sigmas));
  }
  if (strips > kMostStrips)
    findings.push_back(fmt::format("and {} shifts and drifts of other strips", strips - kMostStrips));
  for (const std::string& pair : adjusted.inseparable) findings.push_back(pair);
  if (!extras.empty() && !adjusted.undetermined.empty()) findings.push_back(adjusted.undetermined);
  return findings;
}

}  // namespace collinea
