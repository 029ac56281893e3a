// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/systematic_findings.h"

#include <algorithm>
#include <numbers>

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kMostListed = 3;  // values of an error; those of additional parameters are no figures for people

Aspect aspect_of(SystematicKind kind) {
  switch (kind) {
    case SystematicKind::kTimeOffset:
      return Aspect::kTimeOffset;
    case SystematicKind::kLeverArm:
      return Aspect::kLeverArm;
    case SystematicKind::kShift:
      return Aspect::kShift;
    case SystematicKind::kDrift:
      return Aspect::kDrift;
    case SystematicKind::kBoresight:
      return Aspect::kBoresight;
    case SystematicKind::kVerticalDatum:
      return Aspect::kVerticalDatum;
    case SystematicKind::kAssignment:
      return Aspect::kAssignment;
    case SystematicKind::kBowl:
      return Aspect::kBowl;
    case SystematicKind::kAffinity:
      return Aspect::kAffinity;
    case SystematicKind::kAdditional:
      return Aspect::kAdditional;
    case SystematicKind::kRollingShutter:
      return Aspect::kRollingShutter;
    case SystematicKind::kRefraction:
      return Aspect::kRefraction;
  }
  return Aspect::kWhole;
}

// Whether all cameras were given: to give one is no remedy then.
bool are_all_given(const Block& block) {
  return !block.cameras.empty() &&
         std::ranges::none_of(block.cameras, [](const auto& one) { return one.second.prior.calibrate; });
}

// The option that takes it up, or what else to do. A camera gets more parameters where the block determines them; one
// that was given gets them from an adjustment alone.
std::vector<Remedy> remedies_of(const SystematicTest& test, const Block& block) {
  const auto camera = test.camera ? block.cameras.find(*test.camera) : block.cameras.end();
  const bool is_known = camera != block.cameras.end();
  const bool is_calibrated = is_known && camera->second.prior.calibrate, is_given = is_known && !is_calibrated;
  std::vector<Remedy> more_images = {RemedyCode::kRotateImages};
  if (!is_given) more_images.push_back(RemedyCode::kCalibrateCamera);
  const bool is_separable = test.multiple_correlation < kInseparable;
  switch (test.kind) {
    case SystematicKind::kTimeOffset:
      return {OptionName{"time_offset", ""}};
    case SystematicKind::kLeverArm:
      return {OptionName{"lever_arm", "", "estimate"}};
    case SystematicKind::kShift:
      return {OptionName{"position_shift", "", test.strip ? "strips" : "block"}};
    case SystematicKind::kDrift:
      return {OptionName{"position_drift", ""}};
    case SystematicKind::kBoresight:
      return {OptionName{"use_attitudes", ""}};
    case SystematicKind::kVerticalDatum:
      return {RemedyCode::kLookForDatum, OptionName{"position_shift", "", "block"}};
    case SystematicKind::kAssignment:
      return {RemedyCode::kLookForNames};
    case SystematicKind::kBowl:
      if (are_all_given(block)) return {RemedyCode::kAddHeightsOrOblique};
      return {RemedyCode::kCalibrateCamera, RemedyCode::kAddHeightsOrOblique};
    case SystematicKind::kAffinity:
      if (!is_known) return {RemedyCode::kCalibrateCamera};
      if (!is_separable) return more_images;
      if (is_given) return {OptionName{"additional", "adjust", std::string(word_of(AdditionalSet::kEbner))}};
      return {OptionName{"calibration", "orient", "brown_affinity"}};
    case SystematicKind::kAdditional:
      if (!is_known) return {RemedyCode::kCalibrateCamera};
      if (!is_separable) return more_images;
      if (is_given) return {OptionName{"additional", "adjust", std::string(word_of(test.additional))}};
      return {OptionName{"additional", "orient", std::string(word_of(test.additional))}};
    case SystematicKind::kRollingShutter:
      return {RemedyCode::kHoldStill};
    case SystematicKind::kRefraction:
      return {OptionName{"refraction", ""}};
  }
  return {};
}

Finding finding_of_test(const std::vector<SystematicTest>& tests, const SystematicTest& test, const Block& block) {
  Finding finding = finding_of(FindingCode::kSystematic, {subject_of(test)});
  for (const std::size_t other : test.indistinguishable) finding.subjects.push_back(subject_of(tests[other]));
  const double unit = test.unit == "rad" ? kDegrees : 1;
  if (test.values.size() <= kMostListed) {
    for (const double value : test.values) finding.figures.push_back({FigureName::kValue, unit * value});
    for (const double sigma : test.sigmas) finding.figures.push_back({FigureName::kValueSigma, unit * sigma});
  }
  finding.figures.push_back({FigureName::kChance, test.p_corrected});
  if (test.effect_unit == "px")
    finding.figures.push_back({FigureName::kOffsetPx, test.largest_effect});
  else if (test.effect_unit == "rad")
    finding.figures.push_back({FigureName::kDifferenceAngle, kDegrees * test.largest_effect});
  else
    finding.figures.push_back({FigureName::kOffset, test.largest_effect});
  finding.figures.push_back({FigureName::kDifference, test.ground_change_m});
  finding.figures.push_back({FigureName::kRatio, test.ground_change_sigmas});
  finding.remedies = remedies_of(test, block);
  if (test.ground_change_sigmas < 1) finding.severity = Severity::kNote;
  return finding;
}

}  // namespace

Subject subject_of(const SystematicTest& test) {
  Subject subject(aspect_of(test.kind));
  if (test.camera) subject = Subject(*test.camera, subject.aspect);
  if (test.strip) subject = Subject(SubjectKind::kStrip, static_cast<std::uint32_t>(*test.strip), subject.aspect);
  if (test.kind == SystematicKind::kAdditional) subject.axis = static_cast<std::uint8_t>(test.additional);
  if (test.kind == SystematicKind::kAssignment && !test.values.empty()) subject.axis = test.values[0] > 0 ? 0 : 1;
  return subject;
}

std::vector<Finding> systematic_findings(const std::vector<SystematicTest>& tests, const Block& block) {
  std::vector<const SystematicTest*> named;
  for (const SystematicTest& test : tests)
    if (test.significant && !test.explained_by) named.push_back(&test);
  std::ranges::stable_sort(named, [](const auto* a, const auto* b) { return is_stronger(*a, *b); });
  std::vector<Finding> findings;
  for (const SystematicTest* test : named) findings.push_back(finding_of_test(tests, *test, block));
  return findings;
}

Finding taken_up_finding(const std::vector<SystematicTest>& tests, const SystematicTest& test, const Block& block) {
  Finding finding = finding_of_test(tests, test, block);
  finding.code = FindingCode::kSystematicTakenUp;
  finding.severity = Severity::kNote;
  finding.remedies.clear();
  return finding;
}

}  // namespace collinea
