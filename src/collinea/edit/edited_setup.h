// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edit_history.h"
#include "collinea/edit/journal_line.h"
#include "collinea/edit/unfit_edit.h"
#include "collinea/store/editable_setup.h"

namespace collinea {

/// A setup as edits make it.
struct EditsInForce {
  EditedControl edited;
  std::vector<UnfitEdit> unfit;  ///< of the points that were looked at, by ascending number
};

/// Points of a setup as edits make them. A point is what was imported of its name, with the edits of it that are in
/// force, in their order: so an edit that is undone leaves no trace, and all hold for photographs and control that were
/// imported anew. A point that an edit added has the number behind those imported that its name has among all names
/// ever given, so that no number comes to mean another point.
class PointsInForce {
 public:
  /// Refers to both.
  PointsInForce(const EditableSetup& setup, const EditHistory& history);

  [[nodiscard]] const EditContext& context() const { return context_; }
  /// The point now; nothing: there is none, and never was. `unfit`: takes the edits that do not fit.
  [[nodiscard]] EditedPoint point(const std::string& name, std::vector<UnfitEdit>* unfit = nullptr) const;
  /// Its number; nothing: none was imported or added by this name.
  [[nodiscard]] std::optional<ControlId> id_of(const std::string& name) const;

 private:
  const EditableSetup& setup_;
  const EditHistory& history_;
  EditContext context_;
  std::map<std::string, ControlId> id_of_;
};

/// The setup with all edits of a history. Only points that edits have changed since those that the setup holds are
/// looked at.
[[nodiscard]] EditsInForce edits_in_force(const EditableSetup& setup, const EditHistory& history);

/// The commands that make `before` of `after`, as far as commands can say it.
[[nodiscard]] std::vector<Words> restoring(const std::string& name, const EditedPoint& before, const EditedPoint& after,
                                           const Block& block);

}  // namespace collinea
