// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/draw_feature.h"
#include "collinea/edit/edit_cloud.h"
#include "collinea/edit/mark_point.h"
#include "collinea/edit/mask_image.h"
#include "collinea/edit/patch_seams.h"
#include "collinea/edit/remove_point.h"
#include "collinea/edit/set_attribute.h"
#include "collinea/edit/set_point.h"
#include "collinea/edit/set_role.h"
#include "collinea/edit/unmark_point.h"

namespace collinea {

/// Takes back the last edit that is in force.
struct Undo {
  static constexpr std::string_view kWord = "undo";
  static constexpr std::string_view kForm = "undo";
};

/// Puts the last edit that was undone into force again; possible until there is a new one.
struct Redo {
  static constexpr std::string_view kWord = "redo";
  static constexpr std::string_view kForm = "redo";
};

/// The closed list of what people change by hand; adding one is a struct in a file of its own and one word here. Those
/// with a member `point` change the control point of that name, and nothing else (EditsPoint); others change a part of
/// EditedWork (EditsWork), or the history.
using Edit = std::variant<MarkPoint, UnmarkPoint, SetPoint, SetRole, RemovePoint, MaskImage, UnmaskImage, PatchSeams,
                          UnpatchSeams, DrawFeature, EraseFeature, SetAttribute, SetLayer, ClassifyCloud, CutCloud,
                          CropCloud, Undo, Redo>;

/// A command that changes a control point.
template <class Kind>
concept EditsPoint = requires(const Kind kind, const EditContext context, EditedPoint point) {
  kind.apply(context, point);
};

/// A command that changes anything else.
template <class Kind>
concept EditsWork = requires(const Kind kind, const EditContext context, EditedWork& work) {
  kind.apply(context, work);
};

/// The one parser: words as a shell or a browser gives them. Errors: no such command, and what is wrong with its words.
[[nodiscard]] Result<Edit> parse_edit(std::span<const std::string> words);
/// The one spelling: parse_edit() makes the same of it.
[[nodiscard]] std::vector<std::string> words_of(const Edit& edit);
/// Undo and redo.
[[nodiscard]] bool is_of_history(const Edit& edit);
/// The name of the control point that it changes; empty of edits that change something else.
[[nodiscard]] const std::string& point_of(const Edit& edit);
/// How each command is written, in the order of the list.
[[nodiscard]] std::vector<std::string_view> edit_forms();

/// Words as one line: one that is empty, holds a space, a quotation mark or a backslash, or begins with # stands in
/// quotation marks, with a backslash before these two. For people, and for lists of commands.
[[nodiscard]] std::string line_of(std::span<const std::string> words);
/// The words of such a line. Errors: quotation marks that do not close.
[[nodiscard]] Result<std::vector<std::string>> words_in_line(std::string_view line);

}  // namespace collinea
