// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/resection_linear.h"

#include "collinea/epipolar/linear_pose.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/jobs/internal/rejection.h"
#include "collinea/orient/contradicting_mark.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Points that take part, in units of the principal distance, and their rows in the table of measurements.
struct Points {
  std::vector<ProjectedPoint> points;
  std::vector<std::size_t> rows;
};

Points points_of(const ResectionTables& tables, const Camera& camera) {
  const Vector2d principal(camera.params[Camera::kCx], camera.params[Camera::kCy]);
  Points out;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    if (mark.is_rejected || !tables.is_known(mark)) continue;
    out.points.push_back({(mark.xy - principal) / camera.focal_px(), tables.ground.find(mark.point)->position,
                          mark.sigma / camera.focal_px()});
    out.rows.push_back(i);
  }
  return out;
}

// The rows of the table as the camera sees them: y down.
ResectionTables seen_by_camera(ResectionTables tables, const PhotoFrame& frame) {
  for (ResectionRow& mark : tables.marks) mark.xy = frame.pixel(mark.xy);
  return tables;
}

// Leaves out what the least median of squares over poses of three points contradicts; its scale.
Result<double> leave_out_by_median(ResectionTables& tables, const Camera& camera, std::uint64_t seed) {
  std::vector<Vector2d> pixels;
  std::vector<Vector3d> points;
  const std::vector<std::size_t> rows = points_of(tables, camera).rows;
  for (const std::size_t i : rows) {
    pixels.push_back(tables.marks[i].xy);
    points.push_back(tables.ground.find(tables.marks[i].point)->position);
  }
  const auto starts = points.size() > 4 ? pose_starts(camera, pixels, points, seed, 500) : std::vector<PoseStart>{};
  if (starts.empty())
    return fail(Errc::kIllPosed, "the least median of squares needs five points of which three have a pose",
                {"least_median"_option});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ResectionRow& mark = tables.marks[rows[k]];
    mark.is_rejected = contradicts(camera, starts[0], points[k], pixels[k], mark.sigma);
  }
  return starts[0].scale_px;
}

std::optional<LinearPose> fitted(ResectionTables& tables, const Camera& camera, const ResectOneOptions& options) {
  return fitted_with_rejection(
      Rejection{options.reject, tables.sigmas_are_stated, options.alpha, 2},
      [&] { return linear_pose(points_of(tables, camera).points); },
      [](const LinearPose& pose) -> const auto& { return pose.w; },
      [&](std::size_t k) -> bool& { return tables.marks[points_of(tables, camera).rows[k]].is_rejected; });
}

void add_marks(const ResectionTables& tables, const PhotoFrame& frame, const LinearPose& pose, const Points& points,
               ResectionReport& report) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    if (!tables.is_known(mark)) continue;
    ResectionReport::Mark row{mark.image,       mark.point,       Vector2d::Zero(),
                              Vector2d::Zero(), Vector2d::Zero(), mark.is_rejected};
    if (!mark.is_rejected) {
      COLLINEA_CHECK(points.rows[next] == i);
      row.misfit = in_table(frame, frame.camera.focal_px() * pose.misfits[next]);
      row.redundancy = pose.redundancies[next];
      row.w = in_table(frame, pose.w[next]) / report.variance.of_tests();
      ++next;
    } else if (const auto seen =
                   project(frame.camera, pose.cam_from_world * tables.ground.find(mark.point)->position)) {
      row.misfit = in_table(frame, mark.xy - *seen);
    }
    report.marks.push_back(std::move(row));
  }
}

}  // namespace

Result<ResectionReport> by_linear_pose(ResectionTables& given, const ResectOneOptions& options) {
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, given.unit));
  COLLINEA_TRY(check_one_image(given));
  ResectionTables tables = seen_by_camera(given, frame);
  double robust_scale = 0;
  if (options.least_median) {
    COLLINEA_TRY(robust_scale, leave_out_by_median(tables, frame.camera, options.seed));
  }
  const auto found = fitted(tables, frame.camera, options);
  if (!found)
    return fail(Errc::kIllPosed,
                "the linear pose needs six points, or four of a plane, that lie on no line and are seen neither from "
                "behind nor mirrored: is y up, and are x and y or points exchanged?",
                {"method"_option});
  const Points points = points_of(tables, frame.camera);
  ResectionReport report;
  report.kind = ResectionReport::Kind::kLinear;
  report.unit = tables.unit;
  report.variance = {found->sigma0, found->redundancy, tables.sigmas_are_stated, options.alpha};
  const double factor = report.variance.factor();
  ResectionReport::Image image{tables.images[0], points.points.size()};
  image.exterior = estimates_of_pose(found->cam_from_world);
  image.covariance = factor * factor * covariance_of_estimates(found->cam_from_world, found->covariance);
  add_sigmas(image.exterior, image.covariance);
  image.robust_scale = robust_scale;
  report.images.push_back(std::move(image));
  add_marks(tables, frame, *found, points, report);
  return report;
}

}  // namespace collinea
