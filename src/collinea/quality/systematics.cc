// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/systematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kMostListed = 3;  // values of an error; those of additional parameters are no figures for people

bool is_of_instrument(const SystematicTest& test) {
  return test.kind == SystematicKind::kTimeOffset || test.kind == SystematicKind::kLeverArm ||
         test.kind == SystematicKind::kShift;
}

bool is_given(const SystematicTest& test, const InstrumentOptions& options) {
  if (test.kind == SystematicKind::kTimeOffset) return options.time_offset;
  if (test.kind == SystematicKind::kLeverArm)  // also one that is given: that is for its giver to judge
    return options.lever_arm && !options.lever_arm->text().empty() && options.lever_arm->word() != LeverArmWord::kNone;
  return options.position_shift != PositionShift::kNone;
}

// It can be taken up, and nothing but what cannot be told from it explains it.
bool can_be_taken_up(const SystematicTest& test, const InstrumentOptions& options) {
  const bool stands = !test.explained_by ||
                      std::ranges::find(test.indistinguishable, *test.explained_by) != test.indistinguishable.end();
  return is_of_instrument(test) && test.determined && test.p_value < kTakenUpBelow && test.significant && stands &&
         !is_given(test, options);
}

// An error that stands for itself goes first, then what is alike; among these the larger statistic for its degrees.
bool is_before(const SystematicTest& a, const SystematicTest& b) {
  if (a.explained_by.has_value() != b.explained_by.has_value()) return !a.explained_by;
  if (a.p_value != b.p_value) return a.p_value < b.p_value;
  return a.statistic / a.degrees > b.statistic / b.degrees;
}

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

Subject subject_of(const SystematicTest& test) {
  Subject subject(aspect_of(test.kind));
  if (test.camera) subject = Subject(*test.camera, subject.aspect);
  if (test.strip) subject = Subject(SubjectKind::kStrip, static_cast<std::uint32_t>(*test.strip), subject.aspect);
  if (test.kind == SystematicKind::kAdditional) subject.axis = static_cast<std::uint8_t>(test.additional);
  if (test.kind == SystematicKind::kAssignment && !test.values.empty()) subject.axis = test.values[0] > 0 ? 0 : 1;
  return subject;
}

std::vector<Remedy> remedies_of(const SystematicTest& test) {
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
      return {RemedyCode::kCalibrateCamera, RemedyCode::kAddHeightsOrOblique};
    case SystematicKind::kAffinity:
      return {OptionName{"calibration", "orient", "brown_affinity"}};
    case SystematicKind::kAdditional:
      return {OptionName{"additional", "orient", std::string(word_of(test.additional))}};
    case SystematicKind::kRollingShutter:
      return {RemedyCode::kHoldStill};
    case SystematicKind::kRefraction:
      return {OptionName{"refraction", ""}};
  }
  return {};
}

Finding finding_of_test(const std::vector<SystematicTest>& tests, const SystematicTest& test) {
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
  finding.remedies = remedies_of(test);
  if (test.ground_change_sigmas < 1) finding.severity = Severity::kNote;
  return finding;
}

}  // namespace

InstrumentOptions taken_up(const std::vector<SystematicTest>& tests, const InstrumentOptions& current) {
  const SystematicTest* first = nullptr;
  for (const SystematicTest& test : tests)
    if (can_be_taken_up(test, current) && (!first || is_before(test, *first))) first = &test;
  InstrumentOptions options = current;
  if (!first) return options;
  if (first->kind == SystematicKind::kTimeOffset) options.time_offset = true;
  if (first->kind == SystematicKind::kLeverArm) options.lever_arm = LeverArmOption(LeverArmWord::kEstimate);
  if (first->kind == SystematicKind::kShift)
    options.position_shift = first->strip ? PositionShift::kStrips : PositionShift::kBlock;
  return options;
}

std::vector<Finding> systematic_findings(const std::vector<SystematicTest>& tests) {
  std::vector<const SystematicTest*> named;
  for (const SystematicTest& test : tests)
    if (test.significant && !test.explained_by) named.push_back(&test);
  std::ranges::stable_sort(named, [](const auto* a, const auto* b) { return is_before(*a, *b); });
  std::vector<Finding> findings;
  for (const SystematicTest* test : named) findings.push_back(finding_of_test(tests, *test));
  return findings;
}

std::vector<Finding> taken_up_findings(const std::vector<SystematicTest>& tests) {
  std::vector<Finding> findings;
  for (const SystematicTest& test : tests) {
    SystematicTest alone = test;
    alone.indistinguishable.clear();  // they count in the list of tests that it was in
    Finding& finding = findings.emplace_back(finding_of_test({}, alone));
    finding.code = FindingCode::kSystematicTakenUp;
    finding.severity = Severity::kNote;
    finding.remedies.clear();
  }
  return findings;
}

}  // namespace collinea
