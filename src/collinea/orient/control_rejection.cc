// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/control_rejection.h"

#include <map>
#include <optional>
#include <utility>

#include "collinea/block/world_frame.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/quality/control_check.h"
#include "collinea/quality/mark_check.h"

namespace collinea {
namespace {

constexpr double kFar_m = 1e5;

ControlDiagnosis diagnosis_of(const Block& block, bool expects_shift, std::uint64_t seed) {
  ControlDiagnosis diagnosis = check_control(block, seed);
  if (expects_shift) expect_shift(diagnosis);
  return diagnosis;
}

// Control whose columns are in the other order, put right; nothing where that leads far from the position of the block.
std::optional<std::map<ControlId, ControlPoint>> with_exchanged_axes(const Block& setup) {
  const auto frame = world_frame(*setup.georeference);
  if (!frame) return std::nullopt;
  auto control = setup.control;
  for (auto& [id, point] : control) {
    std::swap(point.position_in_map.x(), point.position_in_map.y());
    std::swap(point.sigma_m.x(), point.sigma_m.y());
    std::swap(point.correlation[1], point.correlation[2]);
    point.position_in_world = frame->local_from_map(point.position_in_map);
    if (!(point.position_in_world.norm() < kFar_m)) return std::nullopt;
  }
  return control;
}

// Marks that were counted otherwise, brought into the images where that is certain; what lies outside them is left out.
std::vector<Finding> with_marks_in_images(Block& block, Block& setup) {
  const MarkDiagnosis marks = check_marks(block);
  for (Block* one : {&block, &setup}) {
    correct_marks(marks.findings, *one);
    remove_marks_outside(*one);
  }
  return marks.findings;
}

}  // namespace

CheckedSetup reject_wrong_control(Block block, Block setup, bool expects_shift, std::uint64_t seed) {
  CheckedSetup checked{.findings = with_marks_in_images(block, setup)};
  ControlDiagnosis diagnosis = diagnosis_of(block, expects_shift, seed);
  if (diagnosis.axes_swapped)
    if (auto control = with_exchanged_axes(setup)) {
      for (const Finding& finding : diagnosis.findings)
        if (finding.code == FindingCode::kControlAxesSwapped) {
          checked.findings.push_back(finding);
          checked.findings.push_back(finding_of(FindingCode::kControlAxesExchanged));
        }
      block.control = setup.control = *std::move(control);
      diagnosis = diagnosis_of(block, expects_shift, seed);
    }
  checked.findings.insert(checked.findings.end(), diagnosis.findings.begin(), diagnosis.findings.end());
  checked.excluded = diagnosis.excluded_points;
  apply(diagnosis, setup);
  if (diagnosis.axes_swapped) setup.control_observations.clear();
  checked.setup = std::move(setup);
  return checked;
}

}  // namespace collinea
