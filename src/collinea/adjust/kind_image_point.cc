// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/kind_image_point.h"

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"

namespace collinea::bundle {

double linearise_other(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                       LinearRay* out) {
  return linearise_as<false>(ray, frame, lens, point, loss, out);
}

void ImagePoint::observe_motions(const Problem& problem, const State& state, std::size_t p,
                                 std::vector<DatumPart>& parts) {
  const ProblemPoint& point = problem.point(p);
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p]);
  if (point.is_fixed) {
    for (std::uint32_t r = point.first_free; r < problem.end_ray(p); ++r) {
      DatumPart& seeing = parts[problem.part_of_pose[problem.rays[r].image]];
      seeing.add(position);
      seeing.sources.fixed = true;
    }
  } else if (point.first_ray < point.first_free) {
    DatumPart& its = parts[problem.part_of_point[p]];
    for (std::uint32_t r = point.first_ray; r < point.first_free; ++r) {
      const Eigen::Vector3d ray = (position - centre_in(state, problem.rays[r].image)).normalized();
      const Matrix37 g =
          (Eigen::Matrix3d::Identity() - ray * ray.transpose()) * motion_of(position, its.centre, its.size);
      its.seen += g.transpose() * g;
    }
    its.sources.fixed = true;
  }
}

}  // namespace collinea::bundle
