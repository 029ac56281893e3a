// SPDX-License-Identifier: Apache-2.0
#include <sqlite3.h>

#include <memory>

#include "collinea/edit/edit_history.h"
#include "collinea/edit/journal_line.h"
#include "collinea/edit/read_edits.h"
#include "collinea/project/seamlines_file.h"
#include "collinea/project/settings.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

// What was read can be written, and that is read as the same.
bool accepts_settings(std::string_view bytes) {
  const auto settings = read_settings(file_of(bytes, "project.json").parent_path());
  if (!settings) return false;
  COLLINEA_CHECK(write_settings(folder(), *settings));
  const auto again = read_settings(folder());
  COLLINEA_CHECK(again && again->photos == settings->photos && chosen_options(*again) == chosen_options(*settings));
  return true;
}

std::string settings_seed(const Settings& settings) {
  return write_settings(folder(), settings) ? bytes_of(folder() / "project.json") : "";
}

std::vector<std::string> settings_seeds() {
  Settings chosen;
  chosen.photos = "/flights/2024-05-17";
  chosen.seed = 7;
  chosen.orient.max_error_px = 2.5;
  return {settings_seed(chosen),
          R"({"photos": "/a", "seed": 3, "options": {"detect": {}, "orient": {"max_error_px": 2}, "ortho": {}}})"};
}

// Each line of it, one after the other; what was read is written as the same.
bool accepts_journal(std::string_view bytes) {
  EditHistory history;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = bytes.find('\n', begin)) != std::string_view::npos; begin = end + 1) {
    const auto line = parse_journal_line(bytes.substr(begin, end - begin));
    if (!line) return false;
    const auto again = parse_journal_line(text_of(*line));
    COLLINEA_CHECK(again && again->number == line->number && again->time == line->time &&
                   again->replaced == line->replaced && words_of(again->edit) == words_of(line->edit));
    if (!history.add(line->edit, line->time)) return false;
  }
  return history.number() > 0;
}

std::string journal_seed() {
  const Edit mark = MarkPoint{.point = "P 1", .image = "a.jpg", .pixel = {1200.31, 800.2}, .sigma_px = 0.05};
  const Edit point = SetPoint{.point = "N", .position_in_map = {500100.5, {}, -4.0}, .sigma_m = {}};
  std::uint64_t number = 0;
  std::string text;
  for (const Edit& edit : {mark, point, Edit(Undo{}), Edit(Redo{}), Edit(RemovePoint{"N"})})
    text += text_of({++number, "2026-11-28T01:02:03Z", edit, {{"unmark", "P 1", "a.jpg"}}}) + "\n";
  return text;
}

// A list of commands, or a journal: what is in force can be said again as a list, which reads as the same.
bool accepts_edits(std::string_view bytes) {
  const auto edits = read_edits(bytes);
  if (!edits) return false;
  std::string list;
  for (const Edit& edit : *edits) list += line_of(words_of(edit)) + "\n";
  const auto again = read_edits(list);
  COLLINEA_CHECK(again && again->size() == edits->size());
  for (std::size_t i = 0; i < edits->size(); ++i) COLLINEA_CHECK(words_of((*again)[i]) == words_of((*edits)[i]));
  return true;
}

Block two_images() {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 1200, 800);
  for (std::uint32_t i = 0; i < 2; ++i) {
    block.images[{i}].file = i ? "b.jpg" : "a.jpg";
    block.images[{i}].camera = {0};
  }
  return block;
}

const std::vector<ImageId> kSources = {{0}, {1}};

bool accepts_seamlines(const std::filesystem::path& path) {
  static const Block block = two_images();
  const auto seamlines = read_seamlines(path, block, kSources, "");
  if (!seamlines) return false;
  for (const SeamPolygon& polygon : *seamlines) {
    COLLINEA_CHECK(polygon.source >= 1 && polygon.source <= kSources.size() && !polygon.rings.empty());
    for (const MapRing& ring : polygon.rings) COLLINEA_CHECK(ring.size() >= 3);
  }
  return true;
}

// No more than a GeoPackage must have, in small pages: the one that GDAL writes is twenty times as long.
constexpr const char* kSmallest = R"(
PRAGMA page_size = 512; PRAGMA application_id = 1196444487; PRAGMA user_version = 10300; PRAGMA journal_mode = OFF;
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT, srs_id INTEGER PRIMARY KEY, organization TEXT,
  organization_coordsys_id INTEGER, definition TEXT, description TEXT);
INSERT INTO gpkg_spatial_ref_sys VALUES ('Undefined Cartesian SRS', -1, 'NONE', -1, 'undefined', '');
CREATE TABLE gpkg_contents (table_name TEXT PRIMARY KEY, data_type TEXT, identifier TEXT, description TEXT,
  last_change DATETIME, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER);
INSERT INTO gpkg_contents VALUES ('seamlines', 'features', '', '', '2000-01-01T00:00:00.000Z', 0, 0, 10, 10, -1);
CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER,
  z TINYINT, m TINYINT);
INSERT INTO gpkg_geometry_columns VALUES ('seamlines', 'geom', 'GEOMETRY', -1, 2, 2);
CREATE TABLE seamlines (fid INTEGER PRIMARY KEY, geom BLOB, photo TEXT);
ATTACH '$' AS written; INSERT INTO seamlines SELECT fid, geom, photo FROM written.seamlines; DETACH written;)";

using Database = std::unique_ptr<sqlite3, int (*)(sqlite3*)>;
using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

Database opened(const std::filesystem::path& path) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  return {database, sqlite3_close};
}

Statement prepared(sqlite3* database, const char* text) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, text, -1, &statement, nullptr);
  return {statement, sqlite3_finalize};
}

std::filesystem::path small_geopackage(const char* name) {
  const MapRing square = {{0, 0}, {0, 10}, {10, 10}, {10, 0}}, hole = {{2, 2}, {3, 2}, {3, 3}};
  const std::filesystem::path written = folder() / "written.gpkg", path = folder() / name;
  COLLINEA_CHECK(write_seamlines(written, {{1, {square, hole}}, {2, {hole}}}, two_images(), kSources, ""));
  std::filesystem::remove(path);
  std::string text = kSmallest;
  text.replace(text.find('$'), 1, written.string());
  COLLINEA_CHECK(sqlite3_exec(opened(path).get(), text.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  return path;
}

// The name and the geometry of one row of a GeoPackage that is whole otherwise.
bool accepts_row(std::string_view bytes) {
  static const std::filesystem::path path = small_geopackage("rows.gpkg");
  static const Database database = opened(path);
  static const Statement change =
      prepared(database.get(), "UPDATE seamlines SET photo = CAST(? AS TEXT), geom = ? WHERE fid = 1");
  const auto parts = parts_of(bytes);
  for (int i = 0; i < 2; ++i) {
    const std::string_view part = i < int(parts.size()) ? parts[std::size_t(i)] : std::string_view{};
    sqlite3_bind_blob(change.get(), i + 1, part.data() ? part.data() : "", int(part.size()), SQLITE_STATIC);
  }
  COLLINEA_CHECK(sqlite3_step(change.get()) == SQLITE_DONE && sqlite3_changes(database.get()) == 1);
  sqlite3_reset(change.get());
  return accepts_seamlines(path);
}

std::string row_seed() {
  const Database database = opened(small_geopackage("seed.gpkg"));
  const Statement row = prepared(database.get(), "SELECT geom FROM seamlines WHERE fid = 1");
  if (sqlite3_step(row.get()) != SQLITE_ROW) return "";
  const auto* geometry = static_cast<const char*>(sqlite3_column_blob(row.get(), 0));
  return "a.jpg" + std::string(kCut) + std::string(geometry, std::size_t(sqlite3_column_bytes(row.get(), 0)));
}

}  // namespace

std::vector<Target> project_targets() {
  return {{"project_json", accepts_settings, settings_seeds()},
          {"journal", accepts_journal, {journal_seed()}},
          {"edits",
           accepts_edits,
           {"# by hand\nmark \"P 1\" a.jpg 1200.31 800.2 0.05\npoint N check 500100.5 - 420 0.02 - 0.03\nundo\nredo\n",
            journal_seed()}},
          {"geopackage",
           [](std::string_view bytes) { return accepts_seamlines(file_of(bytes, "a.gpkg")); },
           {bytes_of(small_geopackage("seed.gpkg"))}},
          {"seamlines", accepts_row, {row_seed()}}};
}

}  // namespace collinea::fuzz
