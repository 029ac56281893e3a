// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/io/internal/dbat_project.h"

namespace collinea {

/// Reads the tables that a script names: images, control, check points, prior orientations and marks. An element may
/// name several files; their rows are one table. What fields are is said by `format`, which names every one of them
/// (`ignored` or `dummy`: of no use here).
///
/// - ctrl_pts, check_pts: id, label, x, y, z; sx, sy, sz, sxy, sxyz (none: fixed). Elements `filter id="1,2"` keep or
///   remove points of those files, one filter after the other. Check points take part as DBAT lets them: with their
///   marks, as tie points of the same number, and never with their coordinates.
/// - image_pts: im, id, x, y; sx, sy, sxy. What the attributes sxy, sx and sy of `file` say goes before the columns.
/// One
///   standard deviation in x and y.
/// - prior_eo: id, x, y, z, omega, phi, kappa in the unit of the attribute units (degrees, radian, gon). Standard
///   deviations of them are not used, as DBAT does not; nor are positions of a table without angles, which are no
///   poses to begin with.
[[nodiscard]] Result<> read_dbat_tables(const XmlElement& input, DbatProject& project);

}  // namespace collinea
