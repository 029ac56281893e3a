// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/match/multi_image_matching.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Points where rays of oriented images meet.
struct IntersectionReport {
  struct Ray {
    std::string image;
    Eigen::Vector2d misfit, redundancy, w;  ///< in the table's axes; w by VarianceTest::factor()
  };
  struct Point {
    std::string name;
    bool is_found = false;  ///< false: one ray, rays too parallel, or a point behind a camera
    std::size_t rays_given = 0;
    Eigen::Vector3d position, sigma;
    Eigen::Matrix3d covariance;
    double sigma0 = 0, max_angle_rad = 0;
    int redundancy = 0;
    std::vector<Ray> rays;
    bool has_ground = false;
    Eigen::Vector3d off_ground;  ///< given minus computed
  };
  /// A point found anew by matching its surroundings in all images.
  struct Refined {
    std::string name, reference;
    MultiImagePoint match;
    std::vector<std::string> images;                  ///< of the views
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();  ///< from the intersection [m]
    bool has_ground = false;
    Eigen::Vector3d off_ground;  ///< given minus found
  };
  std::string unit;
  bool orientations_have_sigmas = false;
  VarianceTest variance;  ///< of all points together
  std::vector<Point> points;
  std::vector<Refined> refined;
  std::vector<Finding> findings;
};

[[nodiscard]] std::string intersection_text(const IntersectionReport& report);
/// points, residuals; refined, windows where points were matched.
[[nodiscard]] std::vector<NamedTable> intersection_tables(const IntersectionReport& report);

}  // namespace collinea
