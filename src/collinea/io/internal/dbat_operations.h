// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/io/internal/dbat_project.h"

namespace collinea {

/// Does to a project of DBAT what the operations of its script say, one after the other: which parameters are
/// estimated, what they begin with, what fixes the datum, how many rays a point needs at least. Resection, intersection
/// and bundle are what an adjustment does anyway. Errors: an operation that this reader does not know, or cannot
/// honour; one behind the last bundle that would change it.
[[nodiscard]] Result<> apply_dbat_operations(const XmlElement& operations, DbatProject& project);

}  // namespace collinea
