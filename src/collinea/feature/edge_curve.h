// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/feature/curves.h"
#include "collinea/feature/edge_map.h"

// What describes the curve that an edge draws, with standard deviations by the noise of the grey values. Points of an
// edge err across it by their sigma, and alike where filters overlap (edge_fit.h):
//     cov(i, k) = sigma_i sigma_k exp(-d_ik^2 / (4 along^2)) cos(angle of the normals)
// The errors along the edge move a point on the curve and so do not change it.
namespace collinea {

/// psi_s() of the points, with the sigmas of direction and curvature that follow. Those of noise alone: a parabola is
/// not the curve where its window holds a corner.
[[nodiscard]] std::vector<PsiS> psi_s(std::span<const EdgePoint> edge, bool is_closed, double along_px,
                                      double window_px);

/// Fourier descriptors of a closed edge that do not depend on position, rotation, scale and first point.
struct EdgeDescriptors {
  double radius_px = 0, sigma_radius_px = 0;  ///< |c_1|
  std::vector<double> invariants, sigmas;     ///< as FourierDescriptors::invariants()
};
/// The derivatives after a shift of each point across the edge are numeric: all of resampling is in them. To first
/// order, that is for invariants of some sigmas; of a smaller one the magnitude is that of its noise. Empty: as
/// fourier_descriptors(). Cost: the square of the number of points.
[[nodiscard]] EdgeDescriptors edge_descriptors(std::span<const EdgePoint> edge, double along_px, int harmonics);

}  // namespace collinea
