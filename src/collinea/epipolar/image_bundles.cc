// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/image_bundles.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/epipolar/relative_elements.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Rows6 = Eigen::Matrix<double, 2, 6>;
using Rows5 = Eigen::Matrix<double, 2, 5>;
using Rows3 = Eigen::Matrix<double, 2, 3>;

constexpr double kSingular = 1e-12, kSettled = 1e-14;
constexpr double kOpenCalibration = 0.3;  // of the principal distance
constexpr double kSignificant = 10.8;     // chi-squared of one degree of freedom, 0.1 %
constexpr Index kCalibration = 5;

// One measurement: what is computed, and its derivatives.
struct Linearised {
  Vector2d computed;
  Rows6 by_image;
  Rows3 by_point;
  Rows5 by_calibration;
  double depth = 0;
};

Linearised linearised(const ImageBundles& at, const BundleMark& mark) {
  const Rigid3& pose = at.cam_from_model[mark.image];
  const Vector3d off = at.points[mark.point] - centre_of(pose);
  const Matrix3d rotation = pose.rotation.toRotationMatrix(), &k = at.calibration;
  const Vector3d in_camera = rotation * off;
  const double x = in_camera.x() / in_camera.z(), y = in_camera.y() / in_camera.z();
  Linearised out;
  out.depth = in_camera.z();
  out.computed = {k(0, 0) * x + k(0, 1) * y + k(0, 2), k(1, 1) * y + k(1, 2)};
  Rows3 by_tangents;
  by_tangents << 1, 0, -x, 0, 1, -y;
  const Rows3 by_camera = k.topLeftCorner<2, 2>() * by_tangents / in_camera.z();
  out.by_point = by_camera * rotation;
  out.by_image << out.by_point * skew(off), -out.by_point;
  out.by_calibration << x, 0, y, 1, 0, 0, y, 0, 0, 1;
  return out;
}

// Columns: free parameters; rows: 6 of each image and 5 of the calibration. The datum and what is known have none.
MatrixXd free_parameters(const ImageBundles& at, CalibrationUnknowns unknowns, std::size_t unit_base) {
  const auto images = static_cast<Index>(at.cam_from_model.size()), scale = static_cast<Index>(unit_base);
  const Index of_calibration = count_of(unknowns);
  MatrixXd map = MatrixXd::Zero(6 * images + kCalibration, 6 * (images - 1) - 1 + of_calibration);
  Index column = 0;
  for (Index i = 1; i < images; ++i) {
    map.block<3, 3>(6 * i, column).setIdentity();
    column += 3;
    if (i == scale) {
      const Vector3d base = centre_of(at.cam_from_model[unit_base]) - centre_of(at.cam_from_model[0]);
      map.block<3, 2>(6 * i + 3, column) = tangents_of(base.normalized());
      column += 2;
    } else {
      map.block<3, 3>(6 * i + 3, column).setIdentity();
      column += 3;
    }
  }
  const Index first = 6 * images;
  if (of_calibration == 5) {
    map.bottomRightCorner<5, 5>().setIdentity();
  } else if (of_calibration > 0) {
    map(first, column) = 1;
    map(first + 1, column) = at.calibration(1, 1) / at.calibration(0, 0);
    map(first + 2, column) = at.calibration(0, 1) / at.calibration(0, 0);
    if (of_calibration == 3) map.bottomRightCorner<2, 2>().setIdentity();
  }
  return map;
}

// The normal equations with the points eliminated, and what brings them back.
struct Normals {
  MatrixXd reduced;
  VectorXd right;
  std::vector<Matrix3d> point_inverse;
  std::vector<Vector3d> point_right;
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>> point_rows;
  double cost = 0;
  bool is_regular = true;
};

Normals normals_of(const ImageBundles& at, std::span<const BundleMark> marks, const MatrixXd& free) {
  const std::size_t n = at.points.size();
  Normals out;
  out.reduced = MatrixXd::Zero(free.cols(), free.cols());
  out.right = VectorXd::Zero(free.cols());
  out.point_inverse.assign(n, Matrix3d::Zero());
  out.point_right.assign(n, Vector3d::Zero());
  out.point_rows.assign(n, Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, free.cols()));
  const Index first = free.rows() - kCalibration;
  for (const BundleMark& mark : marks) {
    const Linearised line = linearised(at, mark);
    out.is_regular &= line.depth > 0;
    const Vector2d misfit = mark.in_image - line.computed;
    const double weight = 1 / (mark.sigma * mark.sigma);
    const MatrixXd rows = line.by_image * free.middleRows<6>(6 * static_cast<Index>(mark.image)) +
                          line.by_calibration * free.middleRows<kCalibration>(first);
    out.cost += weight * misfit.squaredNorm();
    out.reduced += weight * rows.transpose() * rows;
    out.right += weight * rows.transpose() * misfit;
    out.point_inverse[mark.point] += weight * line.by_point.transpose() * line.by_point;
    out.point_right[mark.point] += weight * line.by_point.transpose() * misfit;
    out.point_rows[mark.point] += weight * line.by_point.transpose() * rows;
  }
  // Schur complement of the points (Triggs 2000, eq. 6.1).
  for (std::size_t p = 0; p < n; ++p) {
    const Eigen::LDLT<Matrix3d> factor(out.point_inverse[p]);
    out.is_regular &= factor.vectorD().minCoeff() > kSingular * factor.vectorD().maxCoeff();
    out.point_inverse[p] = factor.solve(Matrix3d::Identity());
    out.reduced -= out.point_rows[p].transpose() * out.point_inverse[p] * out.point_rows[p];
    out.right -= out.point_rows[p].transpose() * out.point_inverse[p] * out.point_right[p];
  }
  out.is_regular &= std::isfinite(out.cost) && out.reduced.allFinite();
  return out;
}

double cost_of(const ImageBundles& at, std::span<const BundleMark> marks) {
  double cost = 0;
  for (const BundleMark& mark : marks) {
    const Linearised line = linearised(at, mark);
    if (!(line.depth > 0)) return std::numeric_limits<double>::infinity();
    cost += (mark.in_image - line.computed).squaredNorm() / (mark.sigma * mark.sigma);
  }
  return cost;
}

ImageBundles moved(ImageBundles at, const VectorXd& change, const std::vector<Vector3d>& of_points,
                   std::size_t unit_base) {
  const Vector3d origin = centre_of(at.cam_from_model[0]);
  for (std::size_t i = 0; i < at.cam_from_model.size(); ++i) {
    Rigid3& pose = at.cam_from_model[i];
    const auto row = static_cast<Index>(6 * i);
    Vector3d centre = centre_of(pose) + change.segment<3>(row + 3);
    if (i == unit_base) centre = origin + (centre - origin).normalized();
    pose.rotation = (pose.rotation * rotation_by(-change.segment<3>(row))).normalized();
    pose.translation = -(pose.rotation * centre);
  }
  const auto calibration = change.tail<kCalibration>();
  at.calibration(0, 0) += calibration[0];
  at.calibration(1, 1) += calibration[1];
  at.calibration(0, 1) += calibration[2];
  at.calibration(0, 2) += calibration[3];
  at.calibration(1, 2) += calibration[4];
  for (std::size_t p = 0; p < at.points.size(); ++p) at.points[p] += of_points[p];
  return at;
}

struct Conditioned {
  VectorXd scale;
  double ratio = 0;
};

// Eigenvalues of the normal matrix with unit diagonal: what the units of the parameters have no part in.
Conditioned conditioning_of(const MatrixXd& normal) {
  Conditioned out;
  out.scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd unit = out.scale.asDiagonal() * normal * out.scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit, Eigen::EigenvaluesOnly);
  out.ratio = eigen.eigenvalues()[0] / eigen.eigenvalues()[unit.rows() - 1];
  return out;
}

MatrixXd inverse_of(const MatrixXd& normal, const VectorXd& scale) {
  const MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  return scale.asDiagonal() * unit.ldlt().solve(MatrixXd::Identity(unit.rows(), unit.cols())) * scale.asDiagonal();
}

void add_statistics(std::span<const BundleMark> marks, const MatrixXd& free, const Normals& normals,
                    const MatrixXd& inverse, AdjustedBundles& out) {
  out.covariance = free * inverse * free.transpose();
  for (std::size_t p = 0; p < normals.point_rows.size(); ++p) {
    const MatrixXd back = normals.point_inverse[p] * normals.point_rows[p];
    out.point_covariances.push_back(normals.point_inverse[p] + back * inverse * back.transpose());
  }
  const Index first = free.rows() - kCalibration;
  for (const BundleMark& mark : marks) {
    const Linearised line = linearised(out.bundles, mark);
    const MatrixXd rows = line.by_image * free.middleRows<6>(6 * static_cast<Index>(mark.image)) +
                          line.by_calibration * free.middleRows<kCalibration>(first);
    // The row of all unknowns across those of the images: what the point takes along.
    const MatrixXd across = rows - line.by_point * normals.point_inverse[mark.point] * normals.point_rows[mark.point];
    const Eigen::Matrix2d used = across * inverse * across.transpose() +
                                 line.by_point * normals.point_inverse[mark.point] * line.by_point.transpose();
    BundleMarkTest test;
    test.misfit = mark.in_image - line.computed;
    for (int k = 0; k < 2; ++k) {
      test.redundancy[k] = std::max(0.0, 1 - used(k, k) / (mark.sigma * mark.sigma));
      if (test.redundancy[k] > 1e-9) test.w[k] = test.misfit[k] / (mark.sigma * std::sqrt(test.redundancy[k]));
    }
    out.marks.push_back(test);
  }
}

tl::unexpected<Error> critical_motion() {
  return fail(Errc::kIllPosed,
              "the motion is critical: images without rotation, or turned about parallel axes, leave the calibration "
              "open. Take images in turned attitudes, or state more of the camera");
}

// The bundles with another principal distance, and the model stretched along the axis of the first camera by as much:
// of parallel axes all images stay as they are.
ImageBundles stretched(ImageBundles at, double factor, std::size_t unit_base) {
  at.calibration.topLeftCorner<2, 2>() *= factor;
  const Vector3d origin = centre_of(at.cam_from_model[0]),
                 axis = at.cam_from_model[0].rotation.conjugate() * Vector3d::UnitZ();
  const auto moved = [&](const Vector3d& point) {
    return Vector3d(point + (factor - 1) * (point - origin).dot(axis) * axis);
  };
  const double base = (moved(centre_of(at.cam_from_model[unit_base])) - origin).norm();
  const auto placed = [&](const Vector3d& point) { return Vector3d(origin + (moved(point) - origin) / base); };
  for (Rigid3& pose : at.cam_from_model) pose.translation = -(pose.rotation * placed(centre_of(pose)));
  for (Vector3d& point : at.points) point = placed(point);
  return at;
}

// A calibration that the steps came through, and its sum of squares.
struct Passed {
  Matrix3d calibration;
  double cost = 0;
};

// Whether the steps went along a valley: through calibrations that differ from the last one by 30 % of its principal
// distance and fit as well.
bool is_valley(const std::vector<Passed>& path, double redundancy) {
  const Passed& last = path.back();
  const double variance = std::max(1.0, last.cost / std::max(1.0, redundancy));
  return std::any_of(path.begin(), path.end(), [&](const Passed& one) {
    const double off = (one.calibration - last.calibration).cwiseAbs().maxCoeff();
    return off > kOpenCalibration * std::abs(last.calibration(0, 0)) && one.cost < last.cost + kSignificant * variance;
  });
}

// Whether a principal distance that is off by 30 % fits as well: by less than a chi-squared of 10.8 (0.1 % of one
// degree of freedom) times the variance that the fit itself has.
bool leaves_calibration_open(const ImageBundles& at, std::span<const BundleMark> marks, double cost,
                             std::size_t unit_base) {
  for (const double factor : {1 - kOpenCalibration, 1 / (1 - kOpenCalibration)}) {
    const auto fixed = adjust_bundles(stretched(at, factor, unit_base), marks, CalibrationUnknowns::kNone, unit_base);
    if (!fixed) continue;
    const double variance = std::max(1.0, fixed->sigma0 * fixed->sigma0);
    if (cost_of(fixed->bundles, marks) < cost + kSignificant * variance) return true;
  }
  return false;
}

tl::unexpected<Error> not_settled(const ImageBundles& at, std::span<const BundleMark> marks,
                                  const std::vector<Passed>& path, Index of_images, CalibrationUnknowns unknowns,
                                  std::size_t unit_base) {
  const double redundancy = 2.0 * double(marks.size()) - double(of_images) - 3.0 * double(at.points.size());
  const bool is_critical =
      unknowns != CalibrationUnknowns::kNone &&
      (is_valley(path, redundancy) || leaves_calibration_open(at, marks, path.back().cost, unit_base));
  if (is_critical) return critical_motion();
  return fail(
      Errc::kNotConverged,
      unknowns == CalibrationUnknowns::kNone
          ? "the bundles did not converge in 50 steps"
          : "the bundles did not converge in 50 steps: wrong points, or images hardly turned against each other");
}

Result<> check(const ImageBundles& start, std::span<const BundleMark> marks, CalibrationUnknowns unknowns,
               std::size_t unit_base) {
  if (start.cam_from_model.size() < 2 || unit_base == 0 || unit_base >= start.cam_from_model.size())
    return fail(Errc::kIllPosed, "bundles need two images or more");
  std::vector<int> seen(start.points.size(), 0);
  for (const BundleMark& mark : marks) ++seen[mark.point];
  for (const int count : seen)
    if (count < 2) return fail(Errc::kIllPosed, "a point is measured in fewer than two images");
  const auto free = free_parameters(start, unknowns, unit_base).cols() + static_cast<Index>(3 * start.points.size());
  if (static_cast<Index>(2 * marks.size()) < free)
    return fail(Errc::kIllPosed, std::to_string(2 * marks.size()) + " coordinates do not determine " +
                                     std::to_string(free) + " unknowns");
  return {};
}

}  // namespace

int count_of(CalibrationUnknowns unknowns) {
  switch (unknowns) {
    case CalibrationUnknowns::kNone:
      return 0;
    case CalibrationUnknowns::kFocal:
      return 1;
    case CalibrationUnknowns::kFocalPoint:
      return 3;
    case CalibrationUnknowns::kAll:
      break;
  }
  return 5;
}

Result<AdjustedBundles> adjust_bundles(const ImageBundles& start, std::span<const BundleMark> marks,
                                       CalibrationUnknowns unknowns, std::size_t unit_base) {
  COLLINEA_TRY(check(start, marks, unknowns, unit_base));
  AdjustedBundles out;
  out.bundles = start;
  const std::vector<Vector3d> still(start.points.size(), Vector3d::Zero());
  MatrixXd free = free_parameters(out.bundles, unknowns, unit_base);
  Normals normals = normals_of(out.bundles, marks, free);
  double damping = 0;
  bool is_converged = false;
  std::vector<Passed> path{{out.bundles.calibration, normals.cost}};
  for (out.iterations = 1; out.iterations <= 50 && !is_converged; ++out.iterations) {
    if (!normals.is_regular)
      return fail(Errc::kIllPosed, "a point lies behind a camera, or its rays are parallel: wrong approximate values");
    const Conditioned conditioned = conditioning_of(normals.reduced);
    if (!(conditioned.ratio > kSingular))
      return unknowns == CalibrationUnknowns::kNone
                 ? fail(Errc::kIllPosed, "the points leave the orientation of the images undetermined")
                 : critical_motion();
    MatrixXd damped = normals.reduced;
    damped.diagonal() *= 1 + damping;
    const VectorXd step = inverse_of(damped, conditioned.scale) * normals.right;
    std::vector<Vector3d> of_points = still;
    for (std::size_t p = 0; p < still.size(); ++p)
      of_points[p] = normals.point_inverse[p] * (normals.point_right[p] - normals.point_rows[p] * step);
    const ImageBundles next = moved(out.bundles, free * step, of_points, unit_base);
    // The decrement of Newton's method: what the step would take off the sum of squares.
    is_converged = damping < 1e-2 && step.dot(normals.right) < kSettled * std::max(1.0, normals.cost);
    const double cost = cost_of(next, marks);
    if (is_converged && !(cost < normals.cost)) break;
    if (!(cost <= normals.cost * (1 + 1e-12) + 1e-20)) {
      if (damping > 1e8) break;
      damping = damping > 0 ? 10 * damping : 1e-4;
      continue;
    }
    damping = damping > 1e-6 ? damping / 10 : 0;
    out.bundles = next;
    free = free_parameters(out.bundles, unknowns, unit_base);
    normals = normals_of(out.bundles, marks, free);
    path.push_back({out.bundles.calibration, normals.cost});
  }
  if (!is_converged) return not_settled(out.bundles, marks, path, free.cols(), unknowns, unit_base);
  const Conditioned conditioned = conditioning_of(normals.reduced);
  out.conditioning = conditioned.ratio;
  out.redundancy =
      static_cast<int>(2 * marks.size()) - static_cast<int>(free.cols()) - static_cast<int>(3 * start.points.size());
  if (out.redundancy > 0) out.sigma0 = std::sqrt(normals.cost / out.redundancy);
  add_statistics(marks, free, normals, inverse_of(normals.reduced, conditioned.scale), out);
  return out;
}

}  // namespace collinea
