// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/store/sqlite.h"

namespace collinea {

// Tables of what is known of a block before its orientation. Cameras and control observations have the same columns in
// tables of an orientation. Errors of reading: rows that are damaged.

/// Replaces the cameras of a table.
Result<> write_cameras(sqlite::Database& db, const std::string& table, const std::map<CameraId, Camera>& cameras);
Result<> read_cameras(sqlite::Database& db, const std::string& table, std::map<CameraId, Camera>& cameras);

/// Replaces the control observations of a table.
Result<> write_control_observations(sqlite::Database& db, const std::string& table,
                                    const std::vector<ControlObservation>& observations);
/// Appends them to those of the block.
Result<> read_control_observations(sqlite::Database& db, const std::string& table, Block& block);

/// The same as a replacement; rows alone that differ are written.
Result<> update_control_observations(sqlite::Database& db, const std::string& table,
                                     const std::vector<ControlObservation>& observations);

/// Adds the control points of a table.
Result<> read_control(sqlite::Database& db, const std::string& table, std::map<ControlId, ControlPoint>& control);
/// Replaces them; rows alone that differ are written.
Result<> update_control(sqlite::Database& db, const std::string& table,
                        const std::map<ControlId, ControlPoint>& control);

/// Georeference, cameras, images, control, its observations and what was measured on the ground.
Result<> write_setup_tables(sqlite::Database& db, const Block& block);
/// The same without control observations: an orientation has its own.
Result<> read_setup_tables(sqlite::Database& db, Block& block);

/// Whether there is a table of what was measured on the ground: projects of older versions that cannot be written have
/// none.
Result<bool> has_geodetic(sqlite::Database& db);

}  // namespace collinea
