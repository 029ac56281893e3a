// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/unseen_control.h"

#include <map>
#include <set>

namespace collinea {
namespace {

// With one ray a control point still holds its image, but nobody would notice a gross error in it.
Finding hardly_seen(ControlId id, const ControlPoint& point, int images) {
  if (images == 0) return finding_of(FindingCode::kControlUnseen, {id});
  if (point.role == ControlRole::kCheck) return finding_of(FindingCode::kCheckSeenOnce, {id});
  return finding_of(FindingCode::kControlSeenOnce, {id}, {}, {RemedyCode::kMeasureInAnother});
}

bool is_of_unseen(const Finding& finding) {
  return finding.code == FindingCode::kControlUnseen || finding.code == FindingCode::kCheckSeenOnce ||
         finding.code == FindingCode::kControlSeenOnce;
}

}  // namespace

std::vector<Finding> unseen_control(const Block& setup) {
  std::map<ControlId, int> seen;
  for (const ControlObservation& observation : setup.control_observations) ++seen[observation.point];
  std::set<ControlId> on_ground;  // there it may be placed without any image
  for (const GeodeticObservation& one : setup.geodetic) on_ground.insert({one.from, one.to});
  std::vector<Finding> findings;
  for (const auto& [id, point] : setup.control)
    if (seen[id] < 2 && !on_ground.contains(id)) findings.push_back(hardly_seen(id, point, seen[id]));
  return findings;
}

std::vector<Finding> with_unseen_control(std::vector<Finding> findings, const Block& setup) {
  std::erase_if(findings, is_of_unseen);
  for (Finding& one : unseen_control(setup)) findings.push_back(std::move(one));
  return findings;
}

}  // namespace collinea
