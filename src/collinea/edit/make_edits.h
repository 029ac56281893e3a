// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edited_setup.h"
#include "collinea/edit/journal.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// What became of edits that were asked for.
struct EditsMade {
  std::uint64_t number = 0;      ///< of the last entry of the journal
  std::optional<Error> waiting;  ///< why the project's database does not hold them yet: it will before the next step
};

/// Appends edits to the journal of a project, all of them or none, and brings them into its database where another
/// program's writing does not keep that busy: a step that is at work keeps nobody waiting. Errors: no project, or
/// nothing imported; an edit that does not fit, by what it says and what there is (index: of the edit, from 0); nothing
/// to undo.
[[nodiscard]] Result<EditsMade> make_edits(const std::filesystem::path& project, Journal& journal,
                                           std::span<const Edit> edits);

/// Brings what is in the journal into the database, where it is not yet. Returns the edits of changed points that do
/// not fit. Errors: the journal cannot be read, or the database cannot be written.
[[nodiscard]] Result<std::vector<UnfitEdit>> apply_edits(ProjectStore& store, Journal& journal);

/// Writes a setup that was imported, with all edits of the journal that are in force. Returns those that do not fit.
[[nodiscard]] Result<std::vector<UnfitEdit>> write_setup_with_edits(ProjectStore& store, const Block& setup,
                                                                    Journal& journal);

}  // namespace collinea
