// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/store/project_store.h"
#include "collinea/store/sqlite.h"

namespace collinea {

/// Where an orientation lies.
struct OrientationTables {
  std::string cameras, poses, points, observations, control_observations;
  [[nodiscard]] std::array<std::string, 5> all() const {
    return {cameras, poses, points, observations, control_observations};
  }
};

/// The one that counts.
extern const OrientationTables kCurrentOrientation;
/// The one that was found, from which adjustment begins; empty before there was one.
extern const OrientationTables kFoundOrientation;

/// Cameras, poses, tie points, observations, control observations. Replaces all of it.
Result<> write_orientation_tables(sqlite::Database& db, const OrientationTables& tables, const Block& block);

/// Cameras, poses and control observations, into a block that has been set up.
Result<> read_orientation_tables(sqlite::Database& db, const OrientationTables& tables, Block& block);

/// Tie points and their observations.
Result<> read_tie_tables(sqlite::Database& db, const OrientationTables& tables, Block& block);

/// Tie points of the current orientation with their observations, one after the other: take(id, point, observations).
Result<> read_ties_in_order(sqlite::Database& db, const Block& block, const TakeTie& take);

/// Erases both orientations and the covariances.
Result<> erase_orientation(sqlite::Database& db);

/// Whether an adjustment was written.
Result<bool> is_adjusted(sqlite::Database& db);

/// The first adjustment puts aside what it began with.
Result<> put_found_aside(sqlite::Database& db);

}  // namespace collinea
