// SPDX-License-Identifier: Apache-2.0
// The block of a ProjectStore: what was set up, and what orientation and adjustment made of it.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/hash.h"
#include "collinea/store/internal/covariance_tables.h"
#include "collinea/store/internal/edit_tables.h"
#include "collinea/store/internal/orientation_tables.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/internal/setup_tables.h"
#include "collinea/store/project_store.h"

namespace collinea {
namespace {

using sqlite::Database;

// Every reference from one table to another is kept.
bool fits_together(const Block& block) {
  for (const auto& [image, pose] : oriented_images(block))
    if (!block.images.contains(image)) return false;
  PointId known;  // observations of one point follow each other: look each up once
  for (const Observation& o : block.observations) {
    if (!block.images.contains(o.image)) return false;
    if (o.point != known && !block.points.contains(o.point)) return false;
    known = o.point;
  }
  for (const ControlObservation& o : block.control_observations)
    if (!block.images.contains(o.image) || !block.control.contains(o.point)) return false;
  for (const GeodeticObservation& o : block.geodetic)
    if (!block.control.contains(o.from) || !block.control.contains(o.to)) return false;
  return true;
}

enum class Wanted { kSetup, kOrientation, kAll, kFound };

Result<Block> read_tables(Database& db, Wanted wanted) {
  Block block;
  COLLINEA_TRY(read_setup_tables(db, block));
  COLLINEA_TRY(const auto oriented, db.integer("SELECT count(*) FROM oriented"));
  if (oriented == 0) wanted = Wanted::kSetup;
  const OrientationTables* tables = &kCurrentOrientation;
  if (wanted == Wanted::kFound) {
    COLLINEA_TRY(const bool adjusted, is_adjusted(db));
    if (adjusted) tables = &kFoundOrientation;
  }
  if (wanted != Wanted::kSetup) COLLINEA_TRY(add_removed_control(db, Removed::kUsed, block.control));
  const auto read = wanted == Wanted::kSetup ? read_control_observations(db, "control_observations", block)
                                             : read_orientation_tables(db, *tables, block);
  if (!read) return tl::unexpected(read.error());
  if (wanted == Wanted::kAll || wanted == Wanted::kFound) {
    COLLINEA_TRY(read_tie_tables(db, *tables, block));
  }
  if (!fits_together(block)) return damaged("observations or poses of images or points that are not there");
  return block;
}

Result<Block> read_consistently(Database& db, Wanted wanted) {
  COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
  return read_tables(db, wanted);
}

}  // namespace

Result<std::uint64_t> ProjectStore::setup_hash() const {
  return state_->read([](Database& db) -> Result<std::uint64_t> {
    Hash hash;
    std::vector<const char*> tables = {"georeference", "cameras", "images", "control", "control_observations"};
    COLLINEA_TRY(const bool may_have_geodetic, has_geodetic(db));
    if (may_have_geodetic) {
      COLLINEA_TRY(const auto measured, db.integer("SELECT count(*) FROM ground"));
      if (measured > 0) tables.push_back("ground");  // without any, the fingerprint is that of older versions
    }
    for (const char* table : tables) {
      hash.add(std::string_view(table));
      COLLINEA_TRY(auto select, db.prepare(std::string("SELECT * FROM ") + table + " ORDER BY 1"));
      while (true) {
        COLLINEA_TRY(const bool row, select.next());
        if (!row) break;
        for (int column = 0; column < select.columns(); ++column)
          hash.add(std::uint64_t{select.is_null(column)}).add(select.blob(column));
      }
    }
    return hash.value();
  });
}

Result<> ProjectStore::write_setup(const Block& block, const EditControl& edit) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(write_setup_tables(db, block));
    COLLINEA_TRY(forget_edits(db));
    if (edit) COLLINEA_TRY(edit_setup_tables(db, edit));
    return read_tables(db, Wanted::kAll) ? Result<>{} : erase_orientation(db);  // it was of another setup
  });
}

Result<> ProjectStore::edit_setup(const EditControl& edit) {
  return state_->write([&](Database& db) { return edit_setup_tables(db, edit); });
}

Result<EditableSetup> ProjectStore::read_editable_setup() const {
  return state_->read([](Database& db) -> Result<EditableSetup> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    return collinea::read_editable_setup(db);
  });
}

Result<std::uint64_t> ProjectStore::last_edit() const {
  return state_->read([](Database& db) { return read_last_edit(db); });
}

Result<> ProjectStore::write_orientation(const Block& block) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(erase_orientation(db));
    COLLINEA_TRY(release_removed_control(db, block.control));
    COLLINEA_TRY(write_orientation_tables(db, kCurrentOrientation, block));
    return db.execute("INSERT INTO oriented VALUES (0)");
  });
}

Result<> ProjectStore::write_adjustment(const Block& block, const BlockCovariances& covariances) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(put_found_aside(db));
    COLLINEA_TRY(write_orientation_tables(db, kCurrentOrientation, block));
    return write_covariance_tables(db, covariances);
  });
}

Result<BlockCovariances> ProjectStore::read_covariances() const {
  return state_->read([](Database& db) -> Result<BlockCovariances> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    BlockCovariances covariances;
    COLLINEA_TRY(const bool adjusted, is_adjusted(db));
    if (!adjusted) return covariances;
    return read_covariance_tables(db);
  });
}

Result<Block> ProjectStore::read_found() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kFound); });
}

Result<Block> ProjectStore::read_block() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kAll); });
}

Result<Block> ProjectStore::read_orientation() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kOrientation); });
}

Result<> ProjectStore::read_ties(const Block& block, const TakeTie& take) const {
  return state_->read([&](Database& db) -> Result<> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    return read_ties_in_order(db, block, take);
  });
}

Result<Block> ProjectStore::read_setup() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kSetup); });
}

Result<Block> ProjectStore::read_setup_for_names() const {
  return state_->read([](Database& db) -> Result<Block> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    COLLINEA_TRY(Block block, read_tables(db, Wanted::kSetup));
    COLLINEA_TRY(add_removed_control(db, Removed::kAll, block.control));
    return block;
  });
}

}  // namespace collinea
