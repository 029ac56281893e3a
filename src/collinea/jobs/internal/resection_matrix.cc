// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/resection_matrix.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/projection_matrix.h"
#include "collinea/epipolar/robust_projection.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/jobs/internal/rejection.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
constexpr double kDegrees = 180 / std::numbers::pi;

// Interior and exterior orientation of a matrix in the axes of the table: numbers in a fixed order.
using Elements = Eigen::Matrix<double, 11, 1>;  // X, Y, Z, omega, phi, kappa, c_x, c_y, angle of the axes, x0, y0

std::optional<Elements> elements_of(const Eigen::Matrix<double, 3, 4>& matrix, bool y_up) {
  const auto parts = decomposed(matrix);
  if (!parts) return std::nullopt;
  const Matrix3d& k = parts->calibration;
  const double skew = y_up ? -k(0, 1) : k(0, 1), angle = std::atan2(k(0, 0), -skew);  // K(0,1) = -c_x cot(angle)
  const OmegaPhiKappa angles = omega_phi_kappa(parts->cam_from_object.rotation);
  Elements out;
  out << centre_of(parts->cam_from_object), angles.omega_deg, angles.phi_deg, angles.kappa_deg, k(0, 0),
      k(1, 1) * std::sin(angle), angle * kDegrees, k(0, 2), y_up ? -k(1, 2) : k(1, 2);
  return out;
}

std::optional<VectorXd> stacked_elements(const MatrixXd& matrix, bool y_up) {
  const auto elements = elements_of(matrix, y_up);
  if (!elements) return std::nullopt;
  return VectorXd(*elements);
}

// The covariance of what `values` reads from a matrix, by differences along its elements. `is_angle`: in degrees.
template <class Values, class IsAngle>
MatrixXd covariance_by_differences(const ProjectionFit& fit, Eigen::Index count, const Values& values,
                                   const IsAngle& is_angle) {
  const Eigen::Index columns = fit.matrix.cols();
  MatrixXd by = MatrixXd::Zero(count, 3 * columns);
  for (Eigen::Index k = 0; k < by.cols(); ++k) {
    const double step = std::max(1e-12, 1e-3 * std::sqrt(std::max(0.0, fit.covariance(k, k))));
    MatrixXd before = fit.matrix, after = fit.matrix;
    before(k / columns, k % columns) -= step;
    after(k / columns, k % columns) += step;
    const std::optional<VectorXd> low = values(before), high = values(after);
    if (!low || !high) continue;
    VectorXd change = *high - *low;
    for (Eigen::Index i = 0; i < count; ++i)
      if (is_angle(i)) change[i] = std::remainder(change[i], 360);
    by.col(k) = change / (2 * step);
  }
  return by * fit.covariance * by.transpose();
}

void add_matrix(const ProjectionFit& fit, double factor, ResectionReport::Image& image) {
  const Eigen::Index columns = fit.matrix.cols(), number = 3 * columns - 1;
  const double last = fit.matrix(2, columns - 1);  // the usual form has 1 here
  MatrixXd by = MatrixXd::Zero(number, number + 1);
  for (Eigen::Index k = 0; k < number; ++k) {
    by(k, k) = 1 / last;
    by(k, number) = -fit.matrix(k / columns, k % columns) / (last * last);
  }
  image.element_covariance = factor * factor * by * fit.covariance * by.transpose();
  for (Eigen::Index k = 0; k < number; ++k)
    image.elements.push_back({fmt::format("L{}", k + 1), "", fit.matrix(k / columns, k % columns) / last,
                              std::sqrt(image.element_covariance(k, k))});
}

// M taken apart in the axes of the table: with F = diag(1, -1, 1) of an image with y up and G = diag(1, -1, -1) of its
// space F M = (F K G) (G [R | t]), whose K has -c in its diagonal after division by its corner.
std::optional<ResectionReport::MatrixParts> parts_of(const Eigen::Matrix<double, 3, 4>& matrix, bool y_up) {
  const auto found = decomposed(matrix);
  const auto centre = projection_centre(matrix);
  if (!found || !centre) return std::nullopt;
  const Vector3d image_axes(1, y_up ? -1 : 1, 1), space_axes(1, y_up ? -1 : 1, y_up ? -1 : 1);
  ResectionReport::MatrixParts parts;
  parts.calibration = image_axes.asDiagonal() * found->calibration * space_axes.asDiagonal();
  parts.calibration /= parts.calibration(2, 2);
  parts.rotation = space_axes.asDiagonal() * found->cam_from_object.rotation.toRotationMatrix();
  parts.translation = space_axes.cwiseProduct(found->cam_from_object.translation);
  parts.centre = *centre;
  // The ray of the principal point is the third row of R.
  const Vector3d third = matrix.row(2).head<3>().transpose();
  parts.axis = (matrix.leftCols<3>().determinant() > 0 ? third : Vector3d(-third)).normalized();
  return parts;
}

// K and R column by column, t, centre and axis, and where each begins.
constexpr Eigen::Index kCalibration = 0, kRotation = 9, kTranslation = 18, kCentre = 21, kAxis = 24, kPartsCount = 27;

std::optional<VectorXd> stacked_parts(const MatrixXd& matrix, bool y_up) {
  const auto parts = parts_of(matrix, y_up);
  if (!parts) return std::nullopt;
  VectorXd out(kPartsCount);
  out << parts->calibration.reshaped(), parts->rotation.reshaped(), parts->translation, parts->centre, parts->axis;
  return out;
}

std::optional<ResectionReport::MatrixParts> parts_with_sigmas(const ProjectionFit& fit, double factor, bool y_up) {
  auto parts = parts_of(fit.matrix, y_up);
  if (!parts) return std::nullopt;
  const MatrixXd covariance = covariance_by_differences(
      fit, kPartsCount, [&](const MatrixXd& matrix) { return stacked_parts(matrix, y_up); },
      [](Eigen::Index) { return false; });
  const VectorXd sigmas = factor * covariance.diagonal().cwiseMax(0).cwiseSqrt();
  parts->sigma_calibration = sigmas.segment<9>(kCalibration).reshaped(3, 3);
  parts->sigma_rotation = sigmas.segment<9>(kRotation).reshaped(3, 3);
  parts->sigma_translation = sigmas.segment<3>(kTranslation);
  parts->sigma_centre = sigmas.segment<3>(kCentre);
  parts->sigma_axis = sigmas.segment<3>(kAxis);
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
  const MatrixXd covariance = factor * factor *
                              covariance_by_differences(
                                  fit, 11, [&](const MatrixXd& matrix) { return stacked_elements(matrix, frame.y_up); },
                                  [](Eigen::Index i) { return i >= 3 && i < 6; });
  const std::array<const char*, 6> exterior{"X", "Y", "Z", "omega", "phi", "kappa"};
  const std::array<const char*, 5> interior{"c_x", "c_y", "axes", "x0", "y0"};
  for (int k = 0; k < 6; ++k)
    image.exterior.push_back(
        {exterior[std::size_t(k)], k < 3 ? "m" : "deg", (*elements)[k], std::sqrt(covariance(k, k))});
  for (int k = 0; k < 5; ++k)
    image.interior.push_back(
        {interior[std::size_t(k)], k == 2 ? "deg" : unit, (*elements)[6 + k], std::sqrt(covariance(6 + k, 6 + k))});
  image.covariance = covariance.topLeftCorner<6, 6>();
  image.joint_covariance = covariance;
  image.parts = parts_with_sigmas(fit, factor, frame.y_up);
}

// X, Y, Z, omega, phi, kappa.
std::optional<VectorXd> stacked_pose(const MatrixXd& plane_projection, const Matrix3d& calibration) {
  const auto pose = pose_of_plane(plane_projection, calibration);
  if (!pose) return std::nullopt;
  VectorXd out(6);
  const auto estimates = estimates_of_pose(*pose);
  for (std::size_t k = 0; k < 6; ++k) out[Eigen::Index(k)] = estimates[k].value;
  return out;
}

void add_plane(const ProjectionFit& fit, double factor, const ResectOneOptions& options, const PhotoFrame& frame,
               ResectionReport::Image& image) {
  image.is_determined = options.photo.principal_distance.has_value();
  if (!image.is_determined) return;
  Matrix3d calibration = Matrix3d::Identity();
  calibration(0, 0) = calibration(1, 1) = frame.camera.focal_px();
  calibration(0, 2) = frame.camera.params[Camera::kCx];
  calibration(1, 2) = frame.camera.params[Camera::kCy];
  const auto pose = pose_of_plane(fit.matrix, calibration);
  if (!pose) return;
  image.exterior = estimates_of_pose(*pose);
  image.covariance = factor * factor *
                     covariance_by_differences(
                         fit, 6, [&](const MatrixXd& matrix) { return stacked_pose(matrix, calibration); },
                         [](Eigen::Index i) { return i >= 3; });
  add_sigmas(image.exterior, image.covariance);
}

// Elements of the table's axes.
ProjectionFit in_axes(ProjectionFit fit, const PhotoFrame& frame) {
  if (!frame.y_up) return fit;
  const Eigen::Index columns = fit.matrix.cols();
  fit.matrix.row(1) *= -1;
  fit.covariance.middleRows(columns, columns) *= -1;
  fit.covariance.middleCols(columns, columns) *= -1;
  return fit;
}

// Points of the transformation, and their rows in the table of measurements.
struct Points {
  std::vector<ProjectedPoint> points;
  std::vector<std::size_t> rows;
};

Points points_of(const ResectionTables& tables, const PhotoFrame& frame, bool is_plane) {
  Points out;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    const GroundTablePoint* known = tables.ground.find(mark.point);
    if (mark.is_rejected || !known || !known->position.head(is_plane ? 2 : 3).allFinite()) continue;
    out.points.push_back({frame.pixel(mark.xy), known->position, mark.sigma});
    out.rows.push_back(i);
  }
  return out;
}

std::optional<ProjectionFit> fit_of(const Points& points, bool is_plane) {
  return is_plane ? fit_plane_projection(points.points) : fit_projection(points.points);
}

// Leaves out what the least median of squares contradicts; its scale.
Result<double> leave_out_by_median(ResectionTables& tables, const PhotoFrame& frame, bool is_plane,
                                   std::uint64_t seed) {
  const Points points = points_of(tables, frame, is_plane);
  const auto found = robust_projection(points.points, is_plane, seed);
  if (!found)
    return fail(Errc::kIllPosed,
                is_plane ? "the least median of squares needs six points of the plane, of which those that agree have "
                           "no three of four on a line"
                         : "the least median of squares needs eight points, of which those that agree do not lie on a "
                           "plane",
                {"least_median"_option});
  for (const std::size_t k : found->contradicting) tables.marks[points.rows[k]].is_rejected = true;
  return found->scale;
}

std::optional<ProjectionFit> fitted(ResectionTables& tables, const PhotoFrame& frame, bool is_plane,
                                    const ResectOneOptions& options) {
  const auto points = [&] { return points_of(tables, frame, is_plane); };
  return fitted_with_rejection(
      Rejection{options.reject, tables.sigmas_are_stated, options.alpha, 2}, [&] { return fit_of(points(), is_plane); },
      [](const ProjectionFit& fit) -> const auto& { return fit.w; },
      [&](std::size_t k) -> bool& { return tables.marks[points().rows[k]].is_rejected; });
}

// Where the matrix has a point, in its axes. Nothing behind the camera.
std::optional<Vector2d> computed(const ProjectionFit& fit, const Vector3d& point) {
  const Eigen::Index dimensions = fit.matrix.cols() - 1;
  const Vector3d at = fit.matrix.leftCols(dimensions) * point.head(dimensions) + fit.matrix.rightCols<1>();
  if (!(at.z() > 0)) return std::nullopt;
  return Vector2d(at.head<2>() / at.z());
}

void add_marks(const ResectionTables& tables, const PhotoFrame& frame, const ProjectionFit& fit, const Points& points,
               ResectionReport& report) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    const bool is_used = next < points.rows.size() && points.rows[next] == i;
    ResectionReport::Mark row{mark.image, mark.point, Vector2d::Zero(), Vector2d::Zero(), Vector2d::Zero(), !is_used};
    if (is_used) {
      row.misfit = in_table(frame, fit.misfits[next]);
      row.redundancy = fit.redundancies[next];
      row.w = in_table(frame, fit.w[next]) / report.variance.of_tests();
      ++next;
    } else if (!mark.is_rejected) {
      continue;  // not known on the ground
    } else if (const auto at = computed(fit, tables.ground.find(mark.point)->position)) {
      row.misfit = in_table(frame, frame.pixel(mark.xy) - *at);
    }
    if (fit.matrix.cols() == 4) row.ray = ray_from_centre(fit.matrix, frame.pixel(mark.xy));
    report.marks.push_back(std::move(row));
  }
}

}  // namespace

Result<ResectionReport> by_transformation(ResectionTables& tables, const ResectOneOptions& options) {
  const bool is_plane = options.method == ResectionMethod::kPlane;
  PhotoOptions photo = options.photo;
  if (!photo.principal_distance) photo.principal_distance = 1;  // the transformation needs none
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(photo, tables.unit));
  COLLINEA_TRY(check_one_image(tables));
  double robust_scale = 0;
  if (options.least_median) {
    COLLINEA_TRY(robust_scale, leave_out_by_median(tables, frame, is_plane, options.seed));
  }
  const auto fit = fitted(tables, frame, is_plane, options);
  if (!fit)
    return fail(Errc::kIllPosed,
                is_plane
                    ? "8 parameters need four points of the plane, no three of them on a line"
                    : "11 parameters need six points that do not lie on a plane; for a plane there is another method",
                {"method"_option});
  const Points points = points_of(tables, frame, is_plane);
  ResectionReport report;
  report.unit = tables.unit;
  report.variance = {fit->sigma0, fit->redundancy, tables.sigmas_are_stated, options.alpha};
  report.kind = is_plane ? ResectionReport::Kind::kPlane : ResectionReport::Kind::kDlt;
  report.iterations = fit->iterations;
  const double factor = report.variance.factor();
  ResectionReport::Image image{tables.images[0], points.points.size()};
  image.robust_scale = robust_scale;
  add_matrix(in_axes(*fit, frame), factor, image);
  if (is_plane)
    add_plane(*fit, factor, options, frame, image);
  else
    add_space(*fit, factor, frame, tables.unit, image);
  report.images.push_back(std::move(image));
  add_marks(tables, frame, *fit, points, report);
  return report;
}

}  // namespace collinea
