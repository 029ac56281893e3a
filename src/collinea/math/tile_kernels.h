// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea::bundle {

/// Side of the square tiles in which the reduced normal matrix is kept: four poses of six unknowns. Larger tiles would
/// hold more zeros, smaller ones would leave vector registers empty.
inline constexpr int kTile = 24;
inline constexpr int kTileSize = kTile * kTile;
inline constexpr int kPosesOfTile = kTile / 6;

/// c -= a b^T. c is a tile, a and b have kTile rows and `columns` columns; all by columns.
void subtract_product(double* c, const double* a, const double* b, int columns);

/// c -= a b, all tiles by columns.
void subtract_plain_product(double* c, const double* a, const double* b);

/// y -= tile x and y -= tile^T x.
void subtract_times(double* y, const double* tile, const double* x);
void subtract_transposed_times(double* y, const double* tile, const double* x);

/// One ray of a pose in the reduced normals: derivatives J (2 x 6 by rows), Z (6 x 3 by columns: J^T A L^-T of the
/// point whose normal matrix is L L^T) and the reduced residual r - A L^-T y.
struct PoseRay {
  double j[12];
  double z[18];
  double residual[2];
};

/// What a ray adds to the row of its pose: diagonal_block += J^T J (columns kTile apart), right += J^T residual,
/// diagonal += the diagonal of J^T J; then blocks[k] -= Z Z_k^T for the `count` rays that see the same point in images
/// up to this one.
void add_pose_ray(const PoseRay& ray, double* diagonal_block, double* right, double* diagonal, double* const* blocks,
                  const PoseRay* partners, int count);

/// The part of a ray that ties its pose to `count` camera unknowns, in columns of six: columns += J^T B, B being 2 x
/// count by rows.
void add_pose_camera(double* columns, const PoseRay& ray, const double* b, int count);

/// columns -= Z Zc^T, Zc being count x 3 by rows.
void subtract_pose_camera(double* columns, const PoseRay& ray, const double* zc, int count);

}  // namespace collinea::bundle
