// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/store/project_store.h"
#include "collinea/store/sqlite.h"

namespace collinea {

/// Tables of the covariances of an adjusted block. Replaces all of them.
Result<> write_covariance_tables(sqlite::Database& db, const BlockCovariances& covariances);
/// Errors: rows that are damaged.
Result<BlockCovariances> read_covariance_tables(sqlite::Database& db);

}  // namespace collinea
