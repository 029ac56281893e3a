// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/point_precision.h"

#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea {
namespace {

constexpr std::size_t kMostPoints =
    2000;  // the covariance changes over the breadth of an image, not from point to point
constexpr std::uint32_t kFewestRays = 3;  // as dense matching asks for

}  // namespace

// The covariance of a point is L^-T (I + Z' Q Z) L^-1: the first part comes from its own rays, the second from images
// and cameras.
std::vector<PointPrecision> point_precisions(const Solved& solved, const bundle::FreeNetwork& free_network,
                                             bundle::TileCholesky& inverse, const Run& run) {
  const bundle::Problem& problem = solved.problem();
  const bundle::State& state = solved.state();
  std::vector<PointPrecision> precisions;
  std::vector<std::size_t> eligible;
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (problem.point(p).control < 0 && problem.point(p).eliminated() &&
        problem.end_ray(p) - problem.point(p).first_ray >= kFewestRays)
      eligible.push_back(p);
  const std::size_t stride = (eligible.size() + kMostPoints - 1) / kMostPoints;
  if (stride == 0) return precisions;
  precisions.resize((eligible.size() + stride - 1) / stride);
  parallel_for(run, precisions.size(), [&](std::size_t i) {
    const std::size_t p = eligible[i * stride];
    const bundle::PointSystem system(problem, state, p);
    Eigen::Matrix3d own;
    for (int axis = 0; axis < 3; ++axis) own.col(axis) = system.solve_own(Eigen::Vector3d::Unit(axis));
    precisions[i] = {Eigen::Vector3d(state.points[3 * p], state.points[3 * p + 1], state.points[3 * p + 2]),
                     free_network.of_point(system.covariance(inverse), system, p) - own};
  });
  return precisions;
}

}  // namespace collinea
