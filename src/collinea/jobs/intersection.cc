// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/intersection.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "collinea/epipolar/oriented_intersection.h"
#include "collinea/jobs/internal/exterior_table.h"
#include "collinea/jobs/internal/ground_table.h"
#include "collinea/jobs/internal/image_findings.h"
#include "collinea/jobs/internal/refine_points.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Rays {
  std::vector<std::string> names;  // of points, in order of appearance
  std::map<std::string, std::vector<std::pair<std::string, UncertainSightLine>>> of;
};

Result<Rays> read_rays(const TextTable& table, const PhotoFrame& frame, double sigma,
                       const std::map<std::string, UncertainPose>& orientations) {
  COLLINEA_TRY(const auto images, table.words("image"));
  COLLINEA_TRY(const auto points, table.words("point"));
  COLLINEA_TRY(const auto x, table.numbers("x", frame.unit()));
  COLLINEA_TRY(const auto y, table.numbers("y", frame.unit()));
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", frame.unit(), sigma));
  Rays rays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(sigmas[i] > 0)) return fail(Errc::kBadFormat, fmt::format("row {}: sigma is not above 0", i + 1));
    auto [at, is_new] = rays.of.try_emplace(points[i]);
    if (is_new) rays.names.push_back(points[i]);
    const auto orientation = orientations.find(images[i]);
    if (orientation == orientations.end()) continue;
    for (const auto& [image, line] : at->second)
      if (image == images[i])
        return fail(Errc::kBadFormat, fmt::format("point {} is measured twice in image {}", points[i], images[i]));
    UncertainSightLine line;
    line.line = {&frame.camera, orientation->second.cam_from_world, frame.pixel({x[i], y[i]}), sigmas[i], {}};
    line.pose_covariance = orientation->second.covariance;
    at->second.emplace_back(images[i], line);
  }
  return rays;
}

IntersectionReport::Point point_of(const std::string& name,
                                   const std::vector<std::pair<std::string, UncertainSightLine>>& rays,
                                   const PhotoFrame& frame) {
  IntersectionReport::Point point;
  point.name = name;
  point.rays_given = rays.size();
  std::vector<UncertainSightLine> lines;
  for (const auto& [image, line] : rays) lines.push_back(line);
  const auto found = intersect_oriented(lines);
  if (!found) return point;
  point.is_found = true;
  point.position = found->point_in_world;
  point.covariance = found->covariance;
  point.sigma0 = found->sigma0;
  point.redundancy = found->redundancy;
  point.max_angle_rad = found->max_angle_rad;
  const Vector2d axes(1, frame.y_up ? -1 : 1);
  for (std::size_t i = 0; i < rays.size(); ++i)
    point.rays.push_back({rays[i].first, found->rays[i].misfit.cwiseProduct(axes), found->rays[i].redundancy,
                          found->rays[i].w.cwiseProduct(axes)});
  return point;
}

// sigma0 over all points; standard deviations and tests by it where none were stated.
void settle(IntersectionReport& report) {
  double squares = 0;
  for (const IntersectionReport::Point& point : report.points) {
    squares += point.sigma0 * point.sigma0 * point.redundancy;
    report.variance.redundancy += point.redundancy;
  }
  if (report.variance.redundancy > 0) report.variance.sigma0 = std::sqrt(squares / report.variance.redundancy);
  const double factor = report.variance.factor();
  for (IntersectionReport::Point& point : report.points) {
    if (!point.is_found) continue;
    point.covariance *= factor * factor;
    point.sigma = point.covariance.diagonal().cwiseSqrt();
    for (IntersectionReport::Ray& ray : point.rays) ray.w /= report.variance.of_tests();
  }
}

Result<> match_points(IntersectionReport& report, const Rays& rays, const PhotoFrame& frame,
                      const std::map<std::string, UncertainPose>& orientations, const IntersectTableOptions& options,
                      const Run& run) {
  if (frame.y_up)
    return fail(Errc::kBadInput, "points are matched in the pixels of image files: give measurements in px",
                {"images"_option});
  std::vector<PointToRefine> points;
  for (const IntersectionReport::Point& point : report.points)
    if (const auto& of_point = rays.of.at(point.name); point.is_found)
      points.push_back({point.name, of_point.front().first, of_point.front().second.line.pixel, point.position});
  std::map<std::string, Rigid3> poses;
  for (const auto& [name, orientation] : orientations) poses.emplace(name, orientation.cam_from_world);
  COLLINEA_TRY(report.refined, refine_points(points, poses, frame.camera, *options.images, options.matching, run));
  return {};
}

void compare(IntersectionReport& report, const GroundTable& ground) {
  for (IntersectionReport::Point& point : report.points)
    if (const GroundTablePoint* known = ground.find(point.name); known && point.is_found) {
      point.has_ground = true;
      point.off_ground = known->position - point.position;
    }
  for (IntersectionReport::Refined& point : report.refined)
    if (const GroundTablePoint* known = ground.find(point.name);
        known && point.match.outcome == MultiImageOutcome::kFound) {
      point.has_ground = true;
      point.off_ground = known->position - point.match.point_in_world;
    }
}

}  // namespace

Result<IntersectionReport> intersect_from_tables(const std::filesystem::path& measurements,
                                                 const std::filesystem::path& orientation,
                                                 const IntersectTableOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, table.unit_of("x")).map_error(in_file));
  IntersectionReport report;
  COLLINEA_TRY(const ExteriorTable exterior, read_exterior_table(orientation));
  const std::map<std::string, UncertainPose>& orientations = exterior.images;
  report.orientations_have_sigmas = exterior.has_sigmas;
  report.unit = frame.unit();
  report.variance.alpha = options.alpha;
  report.variance.sigmas_are_stated =
      table.has("sigma") || options.sigma.has_value() || report.orientations_have_sigmas;
  const double given = options.sigma.value_or(frame.y_up ? 0.01 : 1);
  const double sigma = options.sigma && frame.y_up ? given * unit_factor(table.unit_of("x"), "mm").value_or(1) : given;
  COLLINEA_TRY(const Rays rays, read_rays(table, frame, sigma, orientations).map_error(in_file));
  GroundTable ground;
  if (options.ground) {
    COLLINEA_TRY(ground, read_ground_table(*options.ground, 0, true));
  }
  for (const std::string& name : rays.names) report.points.push_back(point_of(name, rays.of.at(name), frame));
  settle(report);
  if (rays.names.empty()) return fail(Errc::kBadInput, measurements.string() + " has no measurements");
  if (options.images) {
    COLLINEA_TRY(match_points(report, rays, frame, orientations, options, run));
  }
  compare(report, ground);
  report.findings = intersection_findings(report);
  return report;
}

}  // namespace collinea
