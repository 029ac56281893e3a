// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_points.h"

#include <string>
#include <vector>

#include "collinea/camera/camera.h"
#include "collinea/jobs/internal/pose_estimates.h"

namespace collinea {

Result<> read_pair_points(const TextTable& table, const RelativePairOptions& options, RelativeReport& report) {
  const std::string stated = table.unit_of("x_left");
  const std::string unit = stated.empty() || stated == "px" ? "px" : "mm";
  COLLINEA_TRY(report.frame, photo_frame(options.photo, unit));
  COLLINEA_TRY(report.names, table.words("point"));
  COLLINEA_TRY(const auto x1, table.numbers("x_left", unit));
  COLLINEA_TRY(const auto y1, table.numbers("y_left", unit));
  COLLINEA_TRY(const auto x2, table.numbers("x_right", unit));
  COLLINEA_TRY(const auto y2, table.numbers("y_right", unit));
  const bool all_given = table.has("sigma") || options.sigma.has_value();
  const double usual = options.sigma.value_or(unit == "px" ? 0.5 : 0.005);
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", unit, usual));
  report.sigma_is_given = all_given;
  report.sigma = table.has("sigma") ? 0 : usual;
  const Camera& camera = report.frame.camera;
  for (std::size_t i = 0; i < x1.size(); ++i) {
    if (!(sigmas[i] > 0)) return fail(Errc::kBadInput, "point " + report.names[i] + ": its sigma is not above zero");
    const double sigma = sigmas[i] / camera.focal_px();
    report.points.push_back({normalized(camera, report.frame.pixel({x1[i], y1[i]})),
                             normalized(camera, report.frame.pixel({x2[i], y2[i]})), sigma, sigma});
  }
  return {};
}

void set_right_pose(const Eigen::Matrix<double, 6, 6>& of_change, RelativeReport& report) {
  const Rigid3 first_from_model{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  Rigid3 pose = report.orientation.second_from_first;
  pose.translation *= report.base;
  pose = pose * first_from_model;
  const auto estimates = estimates_of_pose(pose);
  for (std::size_t k = 0; k < 6; ++k) report.right_pose[Eigen::Index(k)] = estimates[k].value;
  const Eigen::Matrix<double, 6, 6> by = pose_by_change(report.orientation.second_from_first, report.base);
  report.right_covariance = covariance_of_estimates(pose, by * of_change * by.transpose());
}

}  // namespace collinea
