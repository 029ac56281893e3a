// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edited_setup.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace collinea {
namespace {

using Marks = std::vector<ControlObservation>;
using MarkKey = std::pair<ControlId, ImageId>;

// Undone or not, an edit that is gone from the list counts as a change of its point.
std::set<std::string> changed_points(const EditableSetup& setup, const EditHistory& history) {
  std::set<std::string> names;
  std::uint64_t from = setup.edited.last_edit;
  if (from > history.number()) from = 0;  // the setup holds edits of another history
  for (const EditEntry& entry : history.entries().subspan(from))
    if (const std::string& name = point_of(entry.target > 0 ? history.at(entry.target).edit : entry.edit);
        !name.empty())
      names.insert(name);
  return names;
}

// In the order of what was imported; what edits added comes behind it, by point and image.
Marks in_order(const std::map<MarkKey, Marks>& marks, const Marks& imported) {
  Marks all;
  std::map<MarkKey, std::size_t> taken;
  for (const ControlObservation& one : imported) {
    const MarkKey key{one.point, one.image};
    const auto found = marks.find(key);
    if (found == marks.end()) continue;
    if (std::size_t& next = taken[key]; next < found->second.size()) all.push_back(found->second[next++]);
  }
  for (const auto& [key, some] : marks)
    if (!taken.contains(key)) all.insert(all.end(), some.begin(), some.end());
  return all;
}

bool is_same(const ControlPoint& a, const ControlPoint& b) {
  return a.position_in_map == b.position_in_map && a.sigma_m == b.sigma_m && a.correlation == b.correlation;
}

bool is_same(const Marks& a, const Marks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.pixel == other.pixel && one.sigma_px == other.sigma_px && one.shape.is_round() && other.shape.is_round();
  });
}

}  // namespace

PointsInForce::PointsInForce(const EditableSetup& setup, const EditHistory& history)
    : setup_(setup), history_(history), context_(setup.imported) {
  const auto& control = setup.imported.control;
  for (const auto& [id, point] : control) id_of_.emplace(point.name, id);
  std::uint32_t next = control.empty() ? 0 : control.rbegin()->first.value + 1;
  for (const std::string& name : history.set_points())
    if (id_of_.emplace(name, ControlId{next}).second) ++next;
}

std::optional<ControlId> PointsInForce::id_of(const std::string& name) const {
  const auto found = id_of_.find(name);
  return found == id_of_.end() ? std::nullopt : std::optional(found->second);
}

EditedPoint PointsInForce::point(const std::string& name, std::vector<UnfitEdit>* unfit) const {
  EditedPoint edited;
  if (const auto id = id_of(name)) {
    const Block& imported = setup_.imported;
    if (const auto known = imported.control.find(*id); known != imported.control.end()) edited.point = known->second;
    for (const ControlObservation& mark : imported.control_observations)
      if (mark.point == *id) edited.marks[mark.image].push_back(mark);
    edited.is_measured_on_ground = std::ranges::any_of(
        imported.geodetic, [&](const GeodeticObservation& one) { return one.from == *id || one.to == *id; });
  }
  for (const std::uint64_t number : history_.edits_of(name)) {
    const EditEntry& entry = history_.at(number);
    if (entry.undone) continue;
    const Result<> applied = std::visit(
        [&](const auto& kind) -> Result<> {
          if constexpr (EditsPoint<std::decay_t<decltype(kind)>>) return kind.apply(context_, edited);
          return {};
        },
        entry.edit);
    if (!applied && unfit) unfit->push_back({number, name, line_of(words_of(entry.edit)), applied.error()});
  }
  return edited;
}

EditsInForce edits_in_force(const EditableSetup& setup, const EditHistory& history) {
  EditsInForce out;
  const PointsInForce points(setup, history);
  const bool is_of_other_history = setup.edited.last_edit > history.number();
  out.edited =
      is_of_other_history ? EditedControl{setup.imported.control, setup.imported.control_observations} : setup.edited;
  out.edited.last_edit = history.number();
  std::map<MarkKey, Marks> marks;
  for (const ControlObservation& one : out.edited.control_observations) marks[{one.point, one.image}].push_back(one);
  for (const std::string& name : changed_points(setup, history)) {
    EditedPoint edited = points.point(name, &out.unfit);
    const auto id = points.id_of(name);
    if (!id) continue;  // marks of a point that is gone
    const auto first = marks.lower_bound({*id, ImageId{0}});
    marks.erase(first, std::find_if(first, marks.end(), [&](const auto& one) { return one.first.first != *id; }));
    out.edited.control.erase(*id);
    if (!edited.point) continue;
    out.edited.control.emplace(*id, *std::move(edited.point));
    for (auto& [image, some] : edited.marks) {
      for (ControlObservation& one : some) one.point = *id;
      marks[{*id, image}] = std::move(some);
    }
  }
  out.edited.control_observations = in_order(marks, setup.imported.control_observations);
  std::ranges::sort(out.unfit, {}, &UnfitEdit::number);
  return out;
}

std::vector<Words> restoring(const std::string& name, const EditedPoint& before, const EditedPoint& after,
                             const Block& block) {
  if (!before.point) return {words_of(RemovePoint{name})};
  std::vector<Words> commands;
  if (!after.point || !is_same(*before.point, *after.point))
    commands.push_back(words_of(set_point_of(*before.point)));
  else if (before.point->role != after.point->role)
    commands.push_back(words_of(SetRole{name, before.point->role}));
  for (const auto& [image, marks] : after.marks)
    if (!before.marks.contains(image)) commands.push_back(words_of(UnmarkPoint{name, block.images.at(image).file}));
  for (const auto& [image, marks] : before.marks) {
    const auto now = after.marks.find(image);
    if (marks.empty() || (now != after.marks.end() && is_same(marks, now->second))) continue;
    const ControlObservation& mark = marks.front();
    commands.push_back(words_of(MarkPoint{name, block.images.at(image).file, mark.pixel, mark.sigma_px}));
  }
  return commands;
}

}  // namespace collinea
