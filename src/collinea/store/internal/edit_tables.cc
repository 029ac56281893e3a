// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/internal/edit_tables.h"

#include <string>

#include "collinea/store/internal/setup_tables.h"

namespace collinea {

using sqlite::Database;

const char* const kEditTables = R"sql(
CREATE TABLE IF NOT EXISTS imported_control (id INTEGER PRIMARY KEY, name TEXT, role TEXT, numbers BLOB);
CREATE TABLE IF NOT EXISTS imported_control_observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE IF NOT EXISTS removed_control (id INTEGER PRIMARY KEY, name TEXT, role TEXT, numbers BLOB,
                                            used INTEGER);
CREATE TABLE IF NOT EXISTS edits (id INTEGER PRIMARY KEY CHECK (id = 0), last INTEGER);
)sql";

namespace {

Result<bool> has_edit_tables(Database& db) {
  return db.integer("SELECT count(*) FROM sqlite_master WHERE name = 'edits'").map([](auto count) {
    return count > 0;
  });
}

// What is there now becomes what was imported.
Result<> put_imported_aside(Database& db) {
  COLLINEA_TRY(const auto edited, db.integer("SELECT count(*) FROM edits"));
  if (edited > 0) return {};
  return db.execute(
      "DELETE FROM imported_control; DELETE FROM imported_control_observations; "
      "INSERT INTO imported_control SELECT * FROM control; "
      "INSERT INTO imported_control_observations SELECT * FROM control_observations;");
}

Result<> note_removed(Database& db, const EditedControl& before, const EditedControl& after) {
  COLLINEA_TRY(auto note, db.prepare("INSERT OR REPLACE INTO removed_control SELECT *, 1 FROM control WHERE id = ?"));
  for (const auto& [id, point] : before.control)
    if (!after.control.contains(id)) COLLINEA_TRY(note.bind(id.value).run());
  return {};
}

}  // namespace

Result<std::uint64_t> read_last_edit(Database& db) {
  COLLINEA_TRY(const bool there, has_edit_tables(db));
  if (!there) return 0;
  return db.integer("SELECT last FROM edits").map([](auto last) { return static_cast<std::uint64_t>(last); });
}

Result<EditableSetup> read_editable_setup(Database& db) {
  EditableSetup setup;
  COLLINEA_TRY(read_setup_tables(db, setup.imported));
  COLLINEA_TRY(read_control_observations(db, "control_observations", setup.imported));
  setup.edited.control = setup.imported.control;
  setup.edited.control_observations = setup.imported.control_observations;
  COLLINEA_TRY(const bool there, has_edit_tables(db));
  if (!there) return setup;
  COLLINEA_TRY(auto select, db.prepare("SELECT last FROM edits"));
  COLLINEA_TRY(const bool edited, select.next());
  if (!edited) return setup;
  setup.edited.last_edit = static_cast<std::uint64_t>(select.integer(0));
  setup.imported.control.clear();
  setup.imported.control_observations.clear();
  COLLINEA_TRY(read_control(db, "imported_control", setup.imported.control));
  COLLINEA_TRY(read_control_observations(db, "imported_control_observations", setup.imported));
  return setup;
}

Result<> edit_setup_tables(Database& db, const EditControl& edit) {
  COLLINEA_TRY(const EditableSetup setup, read_editable_setup(db));
  COLLINEA_TRY(const EditedControl edited, edit(setup));
  COLLINEA_TRY(put_imported_aside(db));
  COLLINEA_TRY(note_removed(db, setup.edited, edited));
  COLLINEA_TRY(update_control(db, "control", edited.control));
  COLLINEA_TRY(update_control_observations(db, "control_observations", edited.control_observations));
  COLLINEA_TRY(auto insert, db.prepare("INSERT OR REPLACE INTO edits VALUES (0, ?)"));
  return insert.bind(static_cast<std::int64_t>(edited.last_edit)).run();
}

Result<> forget_edits(Database& db) {
  return db.execute(
      "DELETE FROM edits; DELETE FROM imported_control; DELETE FROM imported_control_observations; "
      "DELETE FROM removed_control;");
}

Result<> add_removed_control(Database& db, Removed which, std::map<ControlId, ControlPoint>& control) {
  COLLINEA_TRY(const bool there, has_edit_tables(db));
  if (!there) return {};
  std::map<ControlId, ControlPoint> removed;
  COLLINEA_TRY(read_control(db, which == Removed::kAll ? "removed_control" : "removed_control WHERE used = 1", removed));
  control.merge(removed);
  return {};
}

Result<> release_removed_control(Database& db, const std::map<ControlId, ControlPoint>& control) {
  std::map<ControlId, ControlPoint> removed;
  COLLINEA_TRY(add_removed_control(db, Removed::kUsed, removed));
  COLLINEA_TRY(auto release, db.prepare("UPDATE removed_control SET used = 0 WHERE id = ?"));
  for (const auto& [id, point] : removed)
    if (!control.contains(id)) COLLINEA_TRY(release.bind(id.value).run());
  return {};
}

}  // namespace collinea
