// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// The points that carry the datum of a free network: covariances of what nothing fixes refer to these, as if they were
/// right in the mean in position, attitude and scale (inner constraints over them, S-transformation). None: all tie
/// points. Residuals, sigma0 and what does not depend on the datum (covariances of cameras) stay as they are.
///
/// Deformations are looked at so: points that are believed to stay carry the datum, and the errors of the others are
/// those of their movements.
struct DatumPoints {
  std::set<ControlId> control;  ///< also such without coordinates
  std::set<PointId> ties;

  [[nodiscard]] bool empty() const { return control.empty() && ties.empty(); }
};

/// Those of a list "A1, A2, 1017": names of control and check points, and numbers of tie points where no control point
/// is called so. Errors: kBadInput (a name that is none of both, with those nearest to it).
[[nodiscard]] Result<DatumPoints> datum_points_named(const Block& block, std::string_view names);

}  // namespace collinea
