// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/plane_homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <optional>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Parameters = Eigen::Matrix<double, 8, 1>;
using Jacobian = Eigen::Matrix<double, 2, 8>;

constexpr int kMaxIterations = 50;
constexpr double kLeastDetermined = 1e-3;  // of singular values, in whitened coordinates: a good square has 0.3

// To coordinates with mean 0 and unit covariance; nothing when all lie on a line.
std::optional<Matrix3d> whitening(const std::vector<Vector2d>& points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / double(points.size());
  Matrix2d covariance = Matrix2d::Zero();
  for (const Vector2d& p : points) covariance += (p - mean) * (p - mean).transpose() / double(points.size());
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(covariance);
  if (!(axes.eigenvalues()[0] > 1e-12 * axes.eigenvalues()[1])) return {};
  const Matrix2d scale = axes.operatorInverseSqrt();
  Matrix3d white = Matrix3d::Identity();
  white.topLeftCorner<2, 2>() = scale;
  white.topRightCorner<2, 1>() = -(scale * mean);
  return white;
}

Vector2d mapped(const Matrix3d& homography, const Vector2d& p) { return (homography * p.homogeneous()).hnormalized(); }

// d H(p) / d p.
Matrix2d derivative(const Matrix3d& homography, const Vector2d& p) {
  const Eigen::Vector3d image = homography * p.homogeneous();
  const Vector2d at = image.hnormalized();
  return (homography.topLeftCorner<2, 2>() - at * homography.bottomLeftCorner<1, 2>()) / image.z();
}

// d H(p) / d parameters.
Jacobian by_parameters(const Matrix3d& homography, const Vector2d& p) {
  const Eigen::Vector3d image = homography * p.homogeneous();
  const Eigen::RowVector3d row = p.homogeneous().transpose() / image.z();
  const Vector2d at = image.hnormalized();
  Jacobian j = Jacobian::Zero();
  j.block<1, 3>(0, 0) = row;
  j.block<1, 3>(1, 3) = row;
  j.block<1, 2>(0, 6) = -at.x() * row.head<2>();
  j.block<1, 2>(1, 6) = -at.y() * row.head<2>();
  return j;
}

// The direct linear solution between whitened coordinates. Nothing when the points leave it open.
std::optional<Matrix3d> direct_solution(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(9, 2 * Eigen::Index(from.size())), 9);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::RowVector3d p = from[i].homogeneous().transpose();
    const auto r = 2 * Eigen::Index(i);
    rows.block<1, 3>(r, 0) = p;
    rows.block<1, 3>(r, 6) = -to[i].x() * p;
    rows.block<1, 3>(r + 1, 3) = p;
    rows.block<1, 3>(r + 1, 6) = -to[i].y() * p;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeFullV);
  if (!(svd.singularValues()[7] > kLeastDetermined * svd.singularValues()[0])) return {};
  const Eigen::VectorXd h = svd.matrixV().col(8);
  return Matrix3d(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data()));
}

// One point as the adjustment sees it: the plane whitened, the image undistorted.
struct Measured {
  Vector2d from, to;
  double sigma_to;
  Matrix2d covariance_from;

  [[nodiscard]] Matrix2d weight(const Matrix3d& homography) const {
    const Matrix2d d = derivative(homography, from);
    return (sigma_to * sigma_to * Matrix2d::Identity() + d * covariance_from * d.transpose()).inverse();
  }
};

struct Normals {
  Eigen::Matrix<double, 8, 8> matrix = Eigen::Matrix<double, 8, 8>::Zero();
  Parameters right = Parameters::Zero();
  double squares = 0;
};

Normals normals_of(const Matrix3d& homography, const std::vector<Measured>& all) {
  Normals normals;
  for (const Measured& m : all) {
    const Jacobian j = by_parameters(homography, m.from);
    const Vector2d residual = m.to - mapped(homography, m.from);
    const Matrix2d weight = m.weight(homography);
    normals.matrix += j.transpose() * weight * j;
    normals.right += j.transpose() * weight * residual;
    normals.squares += residual.dot(weight * residual);
  }
  return normals;
}

bool all_before(const Matrix3d& homography, const std::vector<Measured>& all) {
  for (const Measured& m : all)
    if (!(homography.row(2).dot(m.from.homogeneous()) > 0)) return false;
  return true;
}

}  // namespace

Matrix3d PlaneHomography::as_matrix(const Parameters& h) {
  Matrix3d matrix;
  matrix << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return matrix;
}

Result<PlaneHomography> PlaneHomography::fit(const Camera& camera, std::span<const PlanePoint> points) {
  if (points.size() < 4)
    return fail(Errc::kIllPosed, std::to_string(points.size()) + " points: a plane needs four or more");
  std::vector<Vector2d> on_plane, on_image;
  for (const PlanePoint& p : points) {
    if (!p.pixel.allFinite() || !p.on_plane_m.allFinite() || !(p.sigma_px > 0) || !(p.sigma_m >= 0))
      return fail(Errc::kBadInput, "point " + p.name + ": its numbers make no sense");
    if (!in_plane(camera, p.pixel))
      return fail(Errc::kIllPosed, "point " + p.name +
                                       " lies too far off the axis of a fisheye: an image of a plane "
                                       "reaches 80 degrees");
    on_plane.push_back(p.on_plane_m);
    on_image.push_back(normalized(camera, p.pixel));
  }
  const auto open = [] {
    return fail(Errc::kIllPosed,
                "the points lie on a line, or all but one of them do: four are needed of which no three lie on a line");
  };
  const auto impossible = [] {
    return fail(Errc::kIllPosed,
                "no view of a plane shows the points so: two of them may be exchanged, or one is wrong by far");
  };
  const auto white_plane = whitening(on_plane), white_image = whitening(on_image);
  if (!white_plane || !white_image) return open();
  std::vector<Vector2d> from, to;
  for (std::size_t i = 0; i < points.size(); ++i) {
    from.push_back(mapped(*white_plane, on_plane[i]));
    to.push_back(mapped(*white_image, on_image[i]));
  }
  const auto direct = direct_solution(from, to);
  if (!direct) return open();
  Matrix3d start = white_image->inverse() * *direct;
  // The horizon of the plane runs through the middle of the points.
  if (!(std::abs(start(2, 2)) > 1e-6 * start.row(2).norm())) return impossible();
  start /= start(2, 2);

  std::vector<Measured> measured;
  const Matrix2d scale = white_plane->topLeftCorner<2, 2>();
  for (std::size_t i = 0; i < points.size(); ++i)
    measured.push_back({from[i], on_image[i], points[i].sigma_px / pixels_per_unit(camera, on_image[i]),
                        points[i].sigma_m * points[i].sigma_m * scale * scale.transpose()});
  if (!all_before(start, measured)) return impossible();

  PlaneHomography result;
  result.parameters_ << start(0, 0), start(0, 1), start(0, 2), start(1, 0), start(1, 1), start(1, 2), start(2, 0),
      start(2, 1);
  Normals normals = normals_of(start, measured);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Parameters step = normals.matrix.ldlt().solve(normals.right);
    if (!step.allFinite()) return open();
    const Parameters moved = result.parameters_ + step;
    if (!all_before(as_matrix(moved), measured)) return impossible();
    result.parameters_ = moved;
    normals = normals_of(as_matrix(moved), measured);
    if (step.norm() < 1e-13 * moved.norm()) break;
  }
  const Matrix3d from_white = as_matrix(result.parameters_);
  result.covariance_ = normals.matrix.ldlt().solve(Eigen::Matrix<double, 8, 8>::Identity());
  result.white_from_plane_ = *white_plane;
  result.matrix_ = from_white * *white_plane;
  if (!(derivative(result.matrix_, on_plane[0]).determinant() < 0))  // y is up on the plane, down in the image
    return fail(Errc::kIllPosed,
                "the points go round the other way in the photograph than on the plane, whose x is to the right and y "
                "up: some are exchanged, or the plane is given as seen from behind");
  result.redundancy_ = 2 * int(points.size()) - 8;
  if (result.redundancy_ > 0) result.sigma0_ = std::sqrt(normals.squares / result.redundancy_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d residual = measured[i].to - mapped(from_white, measured[i].from);
    Residual of_point;
    of_point.px = residual * pixels_per_unit(camera, on_image[i]);
    of_point.m = derivative(result.matrix_, on_plane[i]).inverse() * residual;
    of_point.in_sigmas = std::sqrt(residual.dot(measured[i].weight(from_white) * residual));
    result.residuals_.push_back(of_point);
  }
  return result;
}

bool PlaneHomography::residuals_too_large() const {
  if (redundancy_ <= 0) return false;
  constexpr double kNormalQuantile = 3.09;  // one of a thousand
  const double r = redundancy_, part = 2 / (9 * r);
  return sigma0_ * sigma0_ > std::pow(1 - part + kNormalQuantile * std::sqrt(part), 3);  // Wilson and Hilferty (1931)
}

Matrix2d PlaneHomography::covariance_at(const Vector2d& on_plane_m) const {
  const Matrix3d from_white = as_matrix(parameters_);
  const Jacobian j = by_parameters(from_white, mapped(white_from_plane_, on_plane_m));
  const Matrix2d back = derivative(matrix_, on_plane_m).inverse();
  return back * j * covariance_ * j.transpose() * back.transpose();
}

std::optional<PlaneHomography::Focal> PlaneHomography::focal() const {
  // The columns a, b of the ray matrix are images of perpendicular directions of equal length: with f the factor of the
  // focal length, (a1 b1 + a2 b2) / f^2 + a3 b3 = 0 and (|a12|^2 - |b12|^2) / f^2 + a3^2 - b3^2 = 0.
  const auto inverse_square = [&](const Parameters& h) {
    const Matrix3d m = as_matrix(h) * white_from_plane_;
    const Vector2d factor((m.block<2, 1>(0, 0)).dot(m.block<2, 1>(0, 1)),
                          0.5 * (m.block<2, 1>(0, 0).squaredNorm() - m.block<2, 1>(0, 1).squaredNorm()));
    const Vector2d rest(m(2, 0) * m(2, 1), 0.5 * (m(2, 0) * m(2, 0) - m(2, 1) * m(2, 1)));
    return -factor.dot(rest) / factor.squaredNorm();
  };
  const double x = inverse_square(parameters_);
  if (!(x > 0)) return {};
  Parameters gradient;
  for (int i = 0; i < 8; ++i) {
    Parameters up = parameters_, down = parameters_;
    const double step = 1e-6 * std::max(1e-3, std::abs(parameters_[i]));
    up[i] += step;
    down[i] -= step;
    gradient[i] = (inverse_square(up) - inverse_square(down)) / (2 * step);
  }
  Focal focal;
  focal.times = 1 / std::sqrt(x);
  focal.sigma = 0.5 * focal.times / x * std::sqrt(gradient.dot(covariance_ * gradient));
  if (!(focal.sigma < 0.2 * focal.times)) return {};
  return focal;
}

Eigen::Vector3d centre_over_plane(const Matrix3d& matrix, double focal_times) {
  Matrix3d rays = matrix;
  rays.topRows<2>() /= focal_times;
  const double length = std::sqrt(rays.col(0).norm() * rays.col(1).norm());
  // The rotation nearest to the two columns as they are.
  Eigen::Matrix<double, 3, 2> axes = rays.leftCols<2>() / length;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(axes, Eigen::ComputeThinU | Eigen::ComputeThinV);
  axes = svd.matrixU() * svd.matrixV().transpose();
  Matrix3d rotation;
  rotation << axes, axes.col(0).cross(axes.col(1));
  return -(rotation.transpose() * rays.col(2)) / length;
}

}  // namespace collinea
