// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea::bundle {

/// Side of the square tiles in which the reduced normal matrix is kept: eight poses of six unknowns.
inline constexpr int kTile = 48;
inline constexpr int kTileSize = kTile * kTile;

/// c -= a b^T. c is a tile, a and b have kTile rows and `columns` columns; all by columns.
void subtract_product(double* c, const double* a, const double* b, int columns);

/// One ray of a pose in the reduced normals: derivatives J (2 x 6 by rows), Z (6 x 3 by columns: J^T A L^-T of the point
/// whose normal matrix is L L^T) and the reduced residual r - A L^-T y.
struct PoseRay {
  double j[12];
  double z[18];
  double residual[2];
};

/// block -= z_row z_column^T for each of `count` rays; block k begins at blocks[k] and its columns are kTile apart.
void subtract_outer(double* const* blocks, const double* z_row, const PoseRay* columns, int count);

}  // namespace collinea::bundle
