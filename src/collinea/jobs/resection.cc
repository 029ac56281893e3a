// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/resection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <ranges>

#include "collinea/base/file.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/danger_shape.h"
#include "collinea/jobs/internal/image_findings.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/jobs/internal/rejection.h"
#include "collinea/jobs/internal/resection_linear.h"
#include "collinea/jobs/internal/resection_matrix.h"
#include "collinea/jobs/internal/resection_station.h"
#include "collinea/jobs/internal/resection_tables.h"
#include "collinea/jobs/result_tables.h"
#include "collinea/orient/contradicting_mark.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The problem of all images: points that take part, and marks of the tables behind the marks of the adjustment.
struct Problem {
  std::vector<std::string> names;
  std::vector<ResectionPoint> points;
  std::vector<ResectionMark> marks;
  std::vector<std::size_t> rows;
};

Problem problem_of(const ResectionTables& tables, const PhotoFrame& frame) {
  Problem problem;
  std::map<std::string, std::size_t> seen, index;
  for (const ResectionRow& mark : tables.marks)
    if (!mark.is_rejected) ++seen[mark.point];
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    const GroundTablePoint* known = tables.ground.find(mark.point);
    const bool is_useful =
        tables.is_known(mark) || seen[mark.point] > 1 || (known && known->sigma.array().isFinite().any());
    if (mark.is_rejected || !is_useful) continue;
    const auto [at, is_new] = index.emplace(mark.point, problem.points.size());
    if (is_new) {
      ResectionPoint point{Vector3d::Zero(), Vector3d::Constant(INFINITY)};
      if (known) point.sigma_m = known->sigma;
      for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(point.sigma_m[axis])) point.in_world[axis] = known->position[axis];
      problem.points.push_back(point);
      problem.names.push_back(mark.point);
    }
    problem.marks.push_back({tables.image_of(mark), at->second, frame.pixel(mark.xy), mark.sigma});
    problem.rows.push_back(i);
  }
  return problem;
}

struct Starts {
  std::vector<Rigid3> poses;
  std::vector<double> scales;
  std::vector<std::vector<Rigid3>> solutions;  // of images with three points
};

Result<Starts> starts_of(ResectionTables& tables, const PhotoFrame& frame, const ResectOneOptions& options) {
  std::optional<Vector3d> near;
  if (options.near) {
    COLLINEA_TRY(const auto n, parse_numbers(*options.near));
    if (n.size() != 3) return fail(Errc::kBadInput, "X,Y,Z are wanted", {"near"_option});
    near = Vector3d(n[0], n[1], n[2]);
  }
  Starts out;
  for (const std::string& image : tables.images) {
    std::vector<Vector2d> pixels;
    std::vector<Vector3d> points;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < tables.marks.size(); ++i)
      if (const ResectionRow& mark = tables.marks[i]; mark.image == image && tables.is_known(mark)) {
        pixels.push_back(frame.pixel(mark.xy));
        points.push_back(tables.ground.find(mark.point)->position);
        rows.push_back(i);
      }
    if (points.size() < 3)
      return fail(Errc::kIllPosed,
                  fmt::format("image {} has {} points with X, Y and Z; three are needed, four to choose "
                              "between solutions",
                              image, points.size()));
    auto starts = pose_starts(frame.camera, pixels, points, options.seed, options.least_median ? 500 : 40);
    if (starts.empty())
      return fail(Errc::kIllPosed,
                  fmt::format("no pose of image {} sees three of its points: are x and y, or the points, exchanged? Is "
                              "the principal distance right?",
                              image),
                  {"principal_distance"_option});
    const auto distance = [&](const PoseStart& start) {
      return near ? (centre_of(start.cam_from_world) - *near).norm() : -centre_of(start.cam_from_world).z();
    };
    out.solutions.emplace_back();
    if (points.size() == 3) {
      std::stable_sort(starts.begin(), starts.end(),
                       [&](const PoseStart& a, const PoseStart& b) { return distance(a) < distance(b); });
      for (const PoseStart& start : starts) out.solutions.back().push_back(start.cam_from_world);
    }
    out.poses.push_back(starts[0].cam_from_world);
    const bool is_robust = options.least_median && points.size() > 4;
    out.scales.push_back(is_robust ? starts[0].scale_px : 0);
    if (!is_robust) continue;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ResectionRow& mark = tables.marks[rows[k]];
      mark.is_rejected = contradicts(frame.camera, starts[0], points[k], pixels[k], mark.sigma);
    }
  }
  return out;
}

// Of images with three points that have several poses the one by which all fit best; the others of the table decide.
void choose_solutions(const Problem& problem, const PhotoFrame& frame, Starts& starts) {
  for (std::size_t a = 0; a < starts.poses.size(); ++a) {
    std::vector<Rigid3>& solutions = starts.solutions[a];
    if (solutions.size() < 2) continue;
    double least = INFINITY;
    std::size_t best = 0;
    for (std::size_t k = 0; k < solutions.size(); ++k) {
      std::vector<Rigid3> poses = starts.poses;
      poses[a] = solutions[k];
      const auto found = space_resection(frame.camera, poses, problem.marks, problem.points);
      if (!found || found->redundancy == 0 || !(found->sigma0 < least)) continue;
      least = found->sigma0;
      best = k;
    }
    std::swap(solutions[0], solutions[best]);
    starts.poses[a] = solutions[0];
  }
}

Result<SpaceResection> fitted(ResectionTables& tables, const PhotoFrame& frame, Starts& starts,
                              const ResectOneOptions& options) {
  for (int pass = 0; pass < 2; ++pass) choose_solutions(problem_of(tables, frame), frame, starts);
  const auto problem = [&] { return problem_of(tables, frame); };
  return fitted_with_rejection(
      Rejection{options.reject, tables.sigmas_are_stated, options.alpha, 2},
      [&] {
        const Problem now = problem();
        return space_resection(frame.camera, starts.poses, now.marks, now.points);
      },
      [](const SpaceResection& found) { return found.marks | std::views::transform(&MarkTest::w); },
      [&](std::size_t k) -> bool& { return tables.marks[problem().rows[k]].is_rejected; });
}

// The points of an image that take part, and those with ground coordinates.
std::vector<ResectionReport::Image::Control> known_points(const ResectionTables& tables, const std::string& image) {
  std::vector<ResectionReport::Image::Control> points;
  for (const ResectionRow& mark : tables.marks)
    if (mark.image == image && !mark.is_rejected && tables.is_known(mark))
      points.push_back({mark.point, tables.ground.find(mark.point)->position});
  return points;
}

// Images at the poses from which least squares began, where it found none.
ResectionReport without_solution(const ResectionTables& tables, const Starts& starts) {
  ResectionReport report;
  for (std::size_t a = 0; a < tables.images.size(); ++a) {
    report.images.push_back({tables.images[a]});
    set_danger_cylinder(known_points(tables, tables.images[a]), centre_of(starts.poses[a]), report.images.back());
  }
  return report;
}

Result<ResectionReport> by_collinearity(ResectionTables& tables, const ResectOneOptions& options) {
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, tables.unit));
  COLLINEA_TRY(Starts starts, starts_of(tables, frame, options));
  COLLINEA_TRY(const SpaceResection found, fitted(tables, frame, starts, options).map_error([&](Error error) {
    return with_danger(std::move(error), without_solution(tables, starts), options);
  }));
  const Problem problem = problem_of(tables, frame);
  ResectionReport report;
  report.unit = tables.unit;
  report.variance = {found.sigma0, found.redundancy, tables.sigmas_are_stated, options.alpha};
  report.iterations = found.iterations;
  const double factor = report.variance.factor();
  for (std::size_t a = 0; a < tables.images.size(); ++a) {
    ResectionReport::Image image{tables.images[a], 0};
    for (const ResectionMark& mark : problem.marks) image.points += mark.image == a;
    image.exterior = estimates_of_pose(found.cam_from_world[a]);
    const auto at = 6 * static_cast<Eigen::Index>(a);
    image.covariance =
        factor * factor * covariance_of_estimates(found.cam_from_world[a], found.covariance.block<6, 6>(at, at));
    add_sigmas(image.exterior, image.covariance);
    for (const Rigid3& pose : starts.solutions[a]) image.solutions.push_back(estimates_of_pose(pose));
    image.conditioning = found.conditioning[a];
    set_danger_cylinder(known_points(tables, tables.images[a]), centre_of(found.cam_from_world[a]), image);
    image.robust_scale = starts.scales[a];
    report.images.push_back(std::move(image));
  }
  std::vector<const MarkTest*> tests(tables.marks.size(), nullptr);
  for (std::size_t k = 0; k < problem.rows.size(); ++k) tests[problem.rows[k]] = &found.marks[k];
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    ResectionReport::Mark row{mark.image,       mark.point,       Vector2d::Zero(),
                              Vector2d::Zero(), Vector2d::Zero(), tests[i] == nullptr};
    if (tests[i]) {
      row.misfit = in_table(frame, tests[i]->misfit);
      row.redundancy = tests[i]->redundancy;
      row.w = in_table(frame, tests[i]->w) / report.variance.of_tests();
    } else if (tables.is_known(mark)) {
      const auto seen =
          project(frame.camera, found.cam_from_world[tables.image_of(mark)] * tables.ground.find(mark.point)->position);
      if (seen) row.misfit = in_table(frame, frame.pixel(mark.xy) - *seen);
    } else {
      continue;  // seen once and not known
    }
    report.marks.push_back(std::move(row));
  }
  for (std::size_t p = 0; p < problem.points.size(); ++p)
    if (!problem.points[p].is_known())
      report.tie_points.push_back(
          {problem.names[p], found.points[p], factor * found.point_covariances[p].diagonal().cwiseSqrt()});
  return report;
}

Result<ResectionReport> by_method(ResectionTables& tables, const ResectOneOptions& options) {
  if (options.method == ResectionMethod::kCollinearity) return by_collinearity(tables, options);
  if (options.method == ResectionMethod::kLinear) return by_linear_pose(tables, options);
  if (options.method == ResectionMethod::kStation) return of_station(tables, options);
  return by_transformation(tables, options);
}

}  // namespace

Result<ResectionReport> resect_from_tables(const std::filesystem::path& measurements,
                                           const std::filesystem::path& ground, const ResectOneOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(ResectionTables tables, read_resection_tables(measurements, ground, options));
  COLLINEA_TRY(ResectionReport report, by_method(tables, options));
  report.findings = resection_findings(report, options);
  if (options.out) {
    COLLINEA_TRY(write_result_tables(resection_tables(report), report.findings, *options.out));
    if (const std::string drawing = danger_svg(report); !drawing.empty())
      COLLINEA_TRY(write_file(*options.out / "danger.svg", drawing));
  }
  return report;
}

}  // namespace collinea
