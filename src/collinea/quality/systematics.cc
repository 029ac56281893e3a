// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/systematics.h"

#include <algorithm>

namespace collinea {
namespace {

bool is_of_instrument(const SystematicTest& test) {
  return test.kind == SystematicKind::kTimeOffset || test.kind == SystematicKind::kLeverArm ||
         test.kind == SystematicKind::kShift;
}

bool is_deformation(const SystematicTest& test) {
  return test.kind == SystematicKind::kAffinity || test.kind == SystematicKind::kAdditional;
}

bool is_given(const SystematicTest& test, const InstrumentOptions& options) {
  if (test.kind == SystematicKind::kTimeOffset) return options.time_offset;
  if (test.kind == SystematicKind::kLeverArm)  // also one that is given: that is for its giver to judge
    return options.lever_arm && !options.lever_arm->text().empty() && options.lever_arm->word() != LeverArmWord::kNone;
  return options.position_shift != PositionShift::kNone;
}

// Control places the block when positions are shifted: those of one strip alone follow from the others, but not all.
bool is_placed_by_control(const std::vector<SystematicTest>& tests) {
  return std::ranges::any_of(tests, [](const SystematicTest& test) {
    return test.kind == SystematicKind::kShift && !test.strip && test.determined;
  });
}

// Nothing but what cannot be told from it explains it.
bool stands(const SystematicTest& test) {
  return !test.explained_by ||
         std::ranges::find(test.indistinguishable, *test.explained_by) != test.indistinguishable.end();
}

bool is_beyond_doubt(const SystematicTest& test) {
  return test.p_value < kTakenUpBelow && test.significant && stands(test);
}

bool can_be_taken_up(const std::vector<SystematicTest>& tests, const SystematicTest& test,
                     const InstrumentOptions& options) {
  if (test.kind == SystematicKind::kShift && !is_placed_by_control(tests)) return false;
  return is_of_instrument(test) && test.determined && is_beyond_doubt(test) && !is_given(test, options);
}

}  // namespace

bool is_stronger(const SystematicTest& a, const SystematicTest& b) {
  if (a.explained_by.has_value() != b.explained_by.has_value()) return !a.explained_by;
  if (a.p_value != b.p_value) return a.p_value < b.p_value;
  return a.statistic / a.degrees > b.statistic / b.degrees;
}

InstrumentOptions taken_up(const std::vector<SystematicTest>& tests, const InstrumentOptions& current) {
  const SystematicTest* first = nullptr;
  for (const SystematicTest& test : tests)
    if (can_be_taken_up(tests, test, current) && (!first || is_stronger(test, *first))) first = &test;
  InstrumentOptions options = current;
  if (!first) return options;
  // Of what cannot be told apart that with the fewest parameters: the others fit chance besides.
  const SystematicTest& strongest = *first;
  for (const std::size_t other : strongest.indistinguishable)
    if (tests[other].degrees < first->degrees && can_be_taken_up(tests, tests[other], current)) first = &tests[other];
  if (first->kind == SystematicKind::kTimeOffset) options.time_offset = true;
  if (first->kind == SystematicKind::kLeverArm) options.lever_arm = LeverArmOption(LeverArmWord::kEstimate);
  if (first->kind == SystematicKind::kShift)
    options.position_shift = first->strip ? PositionShift::kStrips : PositionShift::kBlock;
  return options;
}

std::optional<std::size_t> deformation_taken_up(const std::vector<SystematicTest>& tests,
                                                const std::set<CameraId>& cameras) {
  const auto can_be = [&](const SystematicTest& test) {
    return is_deformation(test) && test.multiple_correlation < kInseparable && test.camera &&
           cameras.contains(*test.camera) && is_beyond_doubt(test) && test.ground_change_sigmas >= 1;
  };
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < tests.size(); ++i)
    if (can_be(tests[i]) && (!first || is_stronger(tests[i], tests[*first]))) first = i;
  if (!first) return first;
  for (const std::size_t other : tests[*first].indistinguishable)
    if (can_be(tests[other]) && tests[other].values.size() < tests[*first].values.size()) first = other;
  return first;
}

}  // namespace collinea
