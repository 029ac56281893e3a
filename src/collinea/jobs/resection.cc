// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/resection.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/projection_matrix.h"
#include "collinea/geometry/planar_resection.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/ground_table.h"
#include "collinea/jobs/internal/pose_estimates.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;

// A row of the table of measurements; of a station x is the direction.
struct Measured {
  std::string image, point;
  Vector2d xy = Vector2d::Zero();
  double sigma = 1;
  bool is_rejected = false;
};

struct Tables {
  std::vector<Measured> marks;
  std::vector<std::string> images;  // in order of appearance
  GroundTable ground;
  std::string unit;
  bool sigmas_are_stated = false;

  [[nodiscard]] std::size_t image_of(const Measured& mark) const {
    return static_cast<std::size_t>(std::find(images.begin(), images.end(), mark.image) - images.begin());
  }
  [[nodiscard]] bool is_known(const Measured& mark) const {
    const GroundTablePoint* found = ground.find(mark.point);
    return found && found->sigma.allFinite();
  }
};

std::string unit_of(const TextTable& table, const ResectOneOptions& options) {
  if (options.method == ResectionMethod::kStation) return "rad";
  const std::string unit = table.unit_of("x");
  return unit.empty() || unit == "px" ? "px" : "mm";
}

// What a measurement has as its sigma where nothing states one, in the unit that it is kept in.
double default_sigma(const ResectOneOptions& options, const TextTable& table, const std::string& unit) {
  if (options.method != ResectionMethod::kStation) {
    if (!options.sigma) return unit == "mm" ? 0.01 : 1;
    const std::string given = table.unit_of("x");
    return *options.sigma * (unit == "mm" ? unit_factor(given, "mm").value_or(1) : 1);
  }
  const std::string given = table.unit_of("direction");
  return options.sigma.value_or(0.001) * unit_factor(given.empty() ? "deg" : given, "rad").value_or(1 / kDegrees);
}

Result<Tables> read_tables(const std::filesystem::path& measurements, const std::filesystem::path& ground,
                           const ResectOneOptions& options) {
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  const bool is_station = options.method == ResectionMethod::kStation;
  Tables tables;
  tables.unit = unit_of(table, options);
  tables.sigmas_are_stated = table.has("sigma") || options.sigma.has_value();
  COLLINEA_TRY(const auto points, table.words("point").map_error(in_file));
  const char* image_column = is_station ? "station" : "image";
  std::vector<std::string> images(points.size(), is_station ? "station" : "1");
  if (table.has(image_column)) {
    COLLINEA_TRY(images, table.words(image_column).map_error(in_file));
  }
  const bool in_degrees = is_station && table.unit_of("direction").empty();
  COLLINEA_TRY(auto x, table.numbers(is_station ? "direction" : "x", tables.unit).map_error(in_file));
  std::vector<double> y(x.size(), 0);
  if (!is_station) {
    COLLINEA_TRY(y, table.numbers("y", tables.unit).map_error(in_file));
  }
  COLLINEA_TRY(const auto sigmas,
               table.numbers_or("sigma", tables.unit, default_sigma(options, table, tables.unit)).map_error(in_file));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (in_degrees) x[i] /= kDegrees;
    if (!(sigmas[i] > 0))
      return fail(Errc::kBadFormat, fmt::format("{}: row {}: sigma is not above 0", measurements.string(), i + 1));
    for (const Measured& other : tables.marks)
      if (other.image == images[i] && other.point == points[i])
        return fail(Errc::kBadFormat,
                    fmt::format("{}: point {} is measured twice in {}", measurements.string(), points[i], images[i]));
    tables.marks.push_back({images[i], points[i], {x[i], y[i]}, sigmas[i]});
    if (std::find(tables.images.begin(), tables.images.end(), images[i]) == tables.images.end())
      tables.images.push_back(images[i]);
  }
  const bool needs_height = options.method == ResectionMethod::kDlt || options.method == ResectionMethod::kCollinearity;
  COLLINEA_TRY(tables.ground, read_ground_table(ground, options.sigma_ground.value_or(0), needs_height));
  if (tables.marks.empty()) return fail(Errc::kBadInput, measurements.string() + " has no measurements");
  return tables;
}

// --- collinearity ----------------------------------------------------------------------------------------------------

// The problem of all images: points that take part, and marks of the tables behind the marks of the adjustment.
struct Problem {
  std::vector<std::string> names;
  std::vector<ResectionPoint> points;
  std::vector<ResectionMark> marks;
  std::vector<std::size_t> rows;
};

Problem problem_of(const Tables& tables, const PhotoFrame& frame) {
  Problem problem;
  std::map<std::string, std::size_t> seen, index;
  for (const Measured& mark : tables.marks)
    if (!mark.is_rejected) ++seen[mark.point];
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const Measured& mark = tables.marks[i];
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

Result<Starts> starts_of(Tables& tables, const PhotoFrame& frame, const ResectOneOptions& options) {
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
      if (const Measured& mark = tables.marks[i]; mark.image == image && tables.is_known(mark)) {
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
      const auto seen = project(frame.camera, starts[0].cam_from_world * points[k]);
      const double limit = 3.04 * std::max(starts[0].scale_px, tables.marks[rows[k]].sigma);
      tables.marks[rows[k]].is_rejected = !seen || (*seen - pixels[k]).norm() > limit;
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

Result<SpaceResection> fitted(Tables& tables, const PhotoFrame& frame, Starts& starts,
                              const ResectOneOptions& options) {
  for (int pass = 0; pass < 2; ++pass) choose_solutions(problem_of(tables, frame), frame, starts);
  while (true) {
    const Problem problem = problem_of(tables, frame);
    COLLINEA_TRY(SpaceResection found, space_resection(frame.camera, starts.poses, problem.marks, problem.points));
    if (!options.reject || found.redundancy <= 2) return found;
    const VarianceTest variance{found.sigma0, found.redundancy, tables.sigmas_are_stated, options.alpha};
    std::size_t worst = 0;
    for (std::size_t k = 0; k < found.marks.size(); ++k)
      if (found.marks[k].w.cwiseAbs().maxCoeff() > found.marks[worst].w.cwiseAbs().maxCoeff()) worst = k;
    if (!(found.marks[worst].w.cwiseAbs().maxCoeff() / variance.factor() > variance.limit())) return found;
    Tables without = tables;
    without.marks[problem.rows[worst]].is_rejected = true;
    const Problem smaller = problem_of(without, frame);
    if (!space_resection(frame.camera, starts.poses, smaller.marks, smaller.points)) return found;
    tables = std::move(without);
  }
}

Vector2d in_table(const PhotoFrame& frame, const Vector2d& difference) {
  return {difference.x(), frame.y_up ? -difference.y() : difference.y()};
}

// The points of an image that take part, and those with ground coordinates.
std::vector<Vector3d> known_points(const Tables& tables, const std::string& image) {
  std::vector<Vector3d> points;
  for (const Measured& mark : tables.marks)
    if (mark.image == image && !mark.is_rejected && tables.is_known(mark))
      points.push_back(tables.ground.find(mark.point)->position);
  return points;
}

Result<ResectionReport> by_collinearity(Tables& tables, const ResectOneOptions& options) {
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, tables.unit));
  COLLINEA_TRY(Starts starts, starts_of(tables, frame, options));
  COLLINEA_TRY(const SpaceResection found, fitted(tables, frame, starts, options));
  const Problem problem = problem_of(tables, frame);
  ResectionReport report;
  report.unit = tables.unit;
  report.variance = {found.sigma0, found.redundancy, tables.sigmas_are_stated, options.alpha};
  report.iterations = found.iterations;
  const double factor = report.variance.factor();
  for (std::size_t a = 0; a < tables.images.size(); ++a) {
    const std::vector<Vector3d> points = known_points(tables, tables.images[a]);
    ResectionReport::Image image{tables.images[a], 0};
    for (const ResectionMark& mark : problem.marks) image.points += mark.image == a;
    image.exterior = estimates_of_pose(found.cam_from_world[a]);
    const auto at = 6 * static_cast<Eigen::Index>(a);
    image.covariance =
        factor * factor * covariance_of_estimates(found.cam_from_world[a], found.covariance.block<6, 6>(at, at));
    add_sigmas(image.exterior, image.covariance);
    for (const Rigid3& pose : starts.solutions[a]) image.solutions.push_back(estimates_of_pose(pose));
    image.conditioning = found.conditioning[a];
    image.danger = danger_cylinder(points, centre_of(found.cam_from_world[a]));
    image.robust_scale = starts.scales[a];
    report.images.push_back(std::move(image));
  }
  std::vector<const MarkTest*> tests(tables.marks.size(), nullptr);
  for (std::size_t k = 0; k < problem.rows.size(); ++k) tests[problem.rows[k]] = &found.marks[k];
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const Measured& mark = tables.marks[i];
    ResectionReport::Mark row{mark.image,       mark.point,       Vector2d::Zero(),
                              Vector2d::Zero(), Vector2d::Zero(), tests[i] == nullptr};
    if (tests[i]) {
      row.misfit = in_table(frame, tests[i]->misfit);
      row.redundancy = tests[i]->redundancy;
      row.w = in_table(frame, tests[i]->w) / factor;
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

// --- direct linear transformation ------------------------------------------------------------------------------------

// Interior and exterior orientation of a matrix in the axes of the table: numbers in a fixed order.
using Elements = Eigen::Matrix<double, 11, 1>;  // c_x, c_y, angle of the axes, x0, y0, X, Y, Z, omega, phi, kappa

std::optional<Elements> elements_of(const Eigen::Matrix<double, 3, 4>& matrix, bool y_up, Rigid3* pose = nullptr) {
  const auto parts = decomposed(matrix);
  if (!parts) return std::nullopt;
  const Matrix3d& k = parts->calibration;
  const double skew = y_up ? -k(0, 1) : k(0, 1), angle = std::atan2(k(0, 0), -skew);  // K(0,1) = -c_x cot(angle)
  const OmegaPhiKappa angles = omega_phi_kappa(parts->cam_from_object.rotation);
  Elements out;
  out << k(0, 0), k(1, 1) * std::sin(angle), angle * kDegrees, k(0, 2), y_up ? -k(1, 2) : k(1, 2),
      centre_of(parts->cam_from_object), angles.omega_deg, angles.phi_deg, angles.kappa_deg;
  if (pose) *pose = parts->cam_from_object;
  return out;
}

// Their covariance by differences of the matrix' elements along the axes of its own covariance.
MatrixXd covariance_of_elements(const ProjectionFit& fit, bool y_up) {
  MatrixXd by = MatrixXd::Zero(11, 12);
  for (int k = 0; k < 12; ++k) {
    const double step = std::max(1e-12, 1e-3 * std::sqrt(std::max(0.0, fit.covariance(k, k))));
    Eigen::Matrix<double, 3, 4> before = fit.matrix, after = fit.matrix;
    before(k / 4, k % 4) -= step;
    after(k / 4, k % 4) += step;
    const auto low = elements_of(before, y_up), high = elements_of(after, y_up);
    if (!low || !high) continue;
    Elements change = *high - *low;
    for (int angle = 8; angle < 11; ++angle) change[angle] = std::remainder(change[angle], 360);
    by.col(k) = change / (2 * step);
  }
  return by * fit.covariance * by.transpose();
}

void add_matrix(const ProjectionFit& fit, double factor, ResectionReport::Image& image) {
  const Eigen::Index columns = fit.matrix.cols();
  const double last = fit.matrix(2, columns - 1);  // the usual form has 1 here
  const auto number = static_cast<int>(3 * columns - 1);
  for (int k = 0; k < number; ++k) {
    const double value = fit.matrix(k / columns, k % columns);
    Eigen::RowVectorXd by = Eigen::RowVectorXd::Zero(number + 1);
    by[k] = 1 / last;
    by[number] = -value / (last * last);
    image.elements.push_back({fmt::format("L{}", k + 1), "", value / last,
                              factor * std::sqrt((by * fit.covariance * by.transpose())(0, 0))});
  }
}

// M taken apart in the axes of the table: with F = diag(1, -1, 1) of an image with y up and G = diag(1, -1, -1) of its
// space F M = (F K G) (G [R | t]), whose K has -c in its diagonal after division by its corner.
std::optional<ResectionReport::MatrixParts> parts_of(const ProjectionFit& fit, double factor, bool y_up) {
  const auto found = decomposed(fit.matrix);
  const auto centre = projection_centre(fit.matrix);
  if (!found || !centre) return std::nullopt;
  const Vector3d image_axes(1, y_up ? -1 : 1, 1), space_axes(1, y_up ? -1 : 1, y_up ? -1 : 1);
  ResectionReport::MatrixParts parts;
  parts.calibration = image_axes.asDiagonal() * found->calibration * space_axes.asDiagonal();
  parts.calibration /= parts.calibration(2, 2);
  parts.rotation = space_axes.asDiagonal() * found->cam_from_object.rotation.toRotationMatrix();
  parts.translation = space_axes.cwiseProduct(found->cam_from_object.translation);
  parts.centre = *centre;
  // The ray of the principal point is the third row of R.
  const auto axis_of = [](const Eigen::Matrix<double, 3, 4>& matrix) -> Vector3d {
    const Vector3d third = matrix.row(2).head<3>().transpose();
    return (matrix.leftCols<3>().determinant() > 0 ? third : Vector3d(-third)).normalized();
  };
  const Eigen::Matrix<double, 3, 4> matrix = fit.matrix;
  parts.axis = axis_of(matrix);
  // Derivative of the unit vector of the row's first three elements.
  const double length = matrix.row(2).head<3>().norm();
  const Matrix3d by = (Matrix3d::Identity() - parts.axis * parts.axis.transpose()) / length;
  parts.sigma_axis =
      factor * (by * fit.covariance.block<3, 3>(8, 8) * by.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  return parts;
}

// The ray of an image point away from the camera, whatever the sign of the matrix.
std::optional<Vector3d> ray_from_centre(const Eigen::Matrix<double, 3, 4>& matrix, const Vector2d& pixel) {
  auto ray = ray_of(matrix, pixel);
  if (ray && matrix.leftCols<3>().determinant() < 0) *ray = -*ray;
  return ray;
}

void add_space(const ProjectionFit& fit, double factor, const PhotoFrame& frame, const std::string& unit,
               ResectionReport::Image& image) {
  const auto elements = elements_of(fit.matrix, frame.y_up);
  if (!elements) return;
  const MatrixXd covariance = factor * factor * covariance_of_elements(fit, frame.y_up);
  const std::array<const char*, 5> interior{"c_x", "c_y", "axes", "x0", "y0"};
  const std::array<const char*, 6> exterior{"X", "Y", "Z", "omega", "phi", "kappa"};
  for (int k = 0; k < 5; ++k)
    image.interior.push_back(
        {interior[std::size_t(k)], k == 2 ? "deg" : unit, (*elements)[k], std::sqrt(covariance(k, k))});
  for (int k = 0; k < 6; ++k)
    image.exterior.push_back(
        {exterior[std::size_t(k)], k < 3 ? "m" : "deg", (*elements)[5 + k], std::sqrt(covariance(5 + k, 5 + k))});
  image.covariance = covariance.bottomRightCorner<6, 6>();
  image.parts = parts_of(fit, factor, frame.y_up);
}

void add_plane(const ProjectionFit& fit, const ResectOneOptions& options, const PhotoFrame& frame,
               ResectionReport::Image& image) {
  image.is_determined = options.photo.principal_distance.has_value();
  if (!image.is_determined) return;
  Matrix3d calibration = Matrix3d::Identity();
  calibration(0, 0) = calibration(1, 1) = frame.camera.focal_px();
  calibration(0, 2) = frame.camera.params[Camera::kCx];
  calibration(1, 2) = frame.camera.params[Camera::kCy];
  if (const auto pose = pose_of_plane(fit.matrix, calibration)) image.exterior = estimates_of_pose(*pose);
}

Result<ResectionReport> by_transformation(const Tables& tables, const ResectOneOptions& options) {
  const bool is_plane = options.method == ResectionMethod::kPlane;
  PhotoOptions photo = options.photo;
  if (!photo.principal_distance) photo.principal_distance = 1;  // the transformation needs none
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(photo, tables.unit));
  if (tables.images.size() > 1)
    return fail(Errc::kBadInput,
                fmt::format("the table has {} images: a transformation is of one", tables.images.size()),
                {"method"_option});
  std::vector<ProjectedPoint> points;
  std::vector<const Measured*> used;
  for (const Measured& mark : tables.marks) {
    const GroundTablePoint* known = tables.ground.find(mark.point);
    const int wanted = is_plane ? 2 : 3;
    if (!known || !known->position.head(wanted).allFinite()) continue;
    points.push_back({frame.pixel(mark.xy), known->position, mark.sigma});
    used.push_back(&mark);
  }
  const auto fit = is_plane ? fit_plane_projection(points) : fit_projection(points);
  if (!fit)
    return fail(Errc::kIllPosed,
                is_plane
                    ? "8 parameters need four points of the plane, no three of them on a line"
                    : "11 parameters need six points that do not lie on a plane; for a plane there is another method",
                {"method"_option});
  ResectionReport report;
  report.unit = tables.unit;
  report.variance = {fit->sigma0, fit->redundancy, tables.sigmas_are_stated, options.alpha};
  report.kind = is_plane ? ResectionReport::Kind::kPlane : ResectionReport::Kind::kDlt;
  report.iterations = fit->iterations;
  const double factor = report.variance.factor();
  ResectionReport::Image image{tables.images[0], points.size()};
  // Elements are those of the table's axes.
  ProjectionFit in_axes = *fit;
  if (frame.y_up) {
    const Eigen::Index columns = fit->matrix.cols();
    in_axes.matrix.row(1) *= -1;
    in_axes.covariance.middleRows(columns, columns) *= -1;
    in_axes.covariance.middleCols(columns, columns) *= -1;
  }
  add_matrix(in_axes, factor, image);
  if (is_plane)
    add_plane(*fit, options, frame, image);
  else
    add_space(*fit, factor, frame, tables.unit, image);
  report.images.push_back(std::move(image));
  for (std::size_t i = 0; i < used.size(); ++i) {
    report.marks.push_back({used[i]->image, used[i]->point, in_table(frame, fit->misfits[i]), fit->redundancies[i],
                            in_table(frame, fit->w[i]) / factor});
    if (!is_plane) report.marks.back().ray = ray_from_centre(fit->matrix, frame.pixel(used[i]->xy));
  }
  return report;
}

// --- station in the plane --------------------------------------------------------------------------------------------

Result<ResectionReport> of_station(const Tables& tables, const ResectOneOptions& options) {
  if (tables.images.size() > 1)
    return fail(Errc::kBadInput, fmt::format("the table has {} stations: give one", tables.images.size()));
  std::vector<PlanarDirection> directions;
  std::vector<const Measured*> used;
  std::vector<Vector3d> points;
  for (const Measured& mark : tables.marks) {
    const GroundTablePoint* known = tables.ground.find(mark.point);
    if (!known || !known->position.head<2>().allFinite()) continue;
    directions.push_back({known->position.head<2>(), mark.xy.x(), mark.sigma});
    used.push_back(&mark);
  }
  const auto found = planar_resection(directions);
  if (!found)
    return fail(Errc::kIllPosed,
                fmt::format("{} directions do not determine the station: three to points apart are needed, and it must "
                            "not lie on the circle through them",
                            directions.size()));
  ResectionReport report;
  report.unit = "mgon";
  report.variance = {found->sigma0, found->redundancy, tables.sigmas_are_stated, options.alpha};
  report.kind = ResectionReport::Kind::kStation;
  const double factor = report.variance.factor();
  ResectionReport::Image image{tables.images[0], directions.size()};
  Matrix3d by = Matrix3d::Identity();
  by(2, 2) = kDegrees;
  image.covariance = factor * factor * by * found->covariance * by;
  image.exterior = {{"X", "m", found->station.x()},
                    {"Y", "m", found->station.y()},
                    {"orientation", "deg", found->orientation_rad * kDegrees}};
  add_sigmas(image.exterior, image.covariance);
  image.danger = DangerCylinder{found->danger_radius, 0, found->danger_off};
  report.images.push_back(std::move(image));
  const double mgon = 200e3 / std::numbers::pi;
  for (std::size_t i = 0; i < used.size(); ++i)
    report.marks.push_back({used[i]->image, used[i]->point, Vector2d(mgon * found->misfits_rad[i], 0),
                            Vector2d(found->redundancies[i], 0), Vector2d(found->w[i] / factor, 0)});
  return report;
}

}  // namespace

Result<ResectionReport> resect_from_tables(const std::filesystem::path& measurements,
                                           const std::filesystem::path& ground, const ResectOneOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(Tables tables, read_tables(measurements, ground, options));
  if (options.method == ResectionMethod::kCollinearity) return by_collinearity(tables, options);
  if (options.method == ResectionMethod::kStation) return of_station(tables, options);
  return by_transformation(tables, options);
}

}  // namespace collinea
