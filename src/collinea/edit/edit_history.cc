// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edit_history.h"

#include <utility>

namespace collinea {
namespace {

bool undoes(const Edit& edit) { return std::holds_alternative<Undo>(edit); }
bool redoes(const Edit& edit) { return std::holds_alternative<Redo>(edit); }

}  // namespace

const EditEntry* EditHistory::next_undo() const { return to_undo_.empty() ? nullptr : &at(to_undo_.back()); }
const EditEntry* EditHistory::next_redo() const { return to_redo_.empty() ? nullptr : &at(to_redo_.back()); }

std::span<const std::uint64_t> EditHistory::edits_of(const std::string& point) const {
  const auto found = of_point_.find(point);
  return found == of_point_.end() ? std::span<const std::uint64_t>() : found->second;
}

Result<> EditHistory::check(const Edit& edit) const {
  if (undoes(edit) && to_undo_.empty()) return fail(Errc::kBadInput, "there is nothing to undo");
  if (redoes(edit) && to_redo_.empty()) return fail(Errc::kBadInput, "there is nothing to redo");
  return {};
}

Result<> EditHistory::add(Edit edit, std::string time) {
  COLLINEA_TRY(check(edit));
  EditEntry entry{.number = number() + 1, .time = std::move(time), .edit = std::move(edit), .changed = number() + 1};
  if (undoes(entry.edit) || redoes(entry.edit)) {
    auto& from = undoes(entry.edit) ? to_undo_ : to_redo_;
    auto& to = undoes(entry.edit) ? to_redo_ : to_undo_;
    entry.target = from.back();
    EditEntry& target = entries_[entry.target - 1];
    target.undone = undoes(entry.edit);
    target.changed = entry.number;
    from.pop_back();
    to.push_back(entry.target);
  } else {
    to_undo_.push_back(entry.number);
    to_redo_.clear();
    if (const std::string& point = point_of(entry.edit); !point.empty()) of_point_[point].push_back(entry.number);
    if (const auto* set = std::get_if<SetPoint>(&entry.edit); set && is_set_.insert(set->point).second)
      set_points_.push_back(set->point);
  }
  entries_.push_back(std::move(entry));
  return {};
}

}  // namespace collinea
