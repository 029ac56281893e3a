// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/store/editable_setup.h"
#include "collinea/store/sqlite.h"

namespace collinea {

// What edits made of the control of a setup. The tables `control` and `control_observations` hold it as it is now;
// `edits` the number of the last edit in them, without which they are as imported; `imported_...` what was imported;
// `removed_control` points that are gone, which an orientation, or what is recorded of it, may still name.

/// The tables that are made where they are missing.
extern const char* const kEditTables;

/// The setup with the control that was imported, and that which there is now.
Result<EditableSetup> read_editable_setup(sqlite::Database& db);

/// The number of the last edit; 0 without any.
Result<std::uint64_t> read_last_edit(sqlite::Database& db);

/// Makes the control what `edit` says; writes the rows alone that differ. Inside a transaction.
Result<> edit_setup_tables(sqlite::Database& db, const EditControl& edit);

/// Of a setup that is written anew: nothing was edited yet.
Result<> forget_edits(sqlite::Database& db);

/// Points that are gone: those that the orientation was made with, or all since the import.
enum class Removed { kUsed, kAll };
/// Adds them, where there is no point of their number.
Result<> add_removed_control(sqlite::Database& db, Removed which, std::map<ControlId, ControlPoint>& control);

/// An orientation was made with these points: those that are gone and not among them are not of it.
Result<> release_removed_control(sqlite::Database& db, const std::map<ControlId, ControlPoint>& control);

}  // namespace collinea
