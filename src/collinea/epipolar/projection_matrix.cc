// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/projection_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation_angles.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Coordinates of mean 0 and of about unit size on both sides (Hartley 1997).
struct Normalised {
  int dimensions = 3;  // of the object
  Vector2d image_mean = Vector2d::Zero();
  VectorXd object_mean;
  double image_scale = 1, object_scale = 1;
  std::vector<Vector2d> image;
  std::vector<VectorXd> object;  // homogeneous
  std::vector<double> weight;    // of a coordinate

  // The row of elements of a matrix in normalised coordinates becomes that in given ones by this.
  [[nodiscard]] MatrixXd back() const {
    Matrix3d image_back = Matrix3d::Identity();
    image_back.topLeftCorner<2, 2>() /= image_scale;
    image_back.topRightCorner<2, 1>() = image_mean;
    MatrixXd object_to = MatrixXd::Identity(dimensions + 1, dimensions + 1);
    object_to.topLeftCorner(dimensions, dimensions) *= object_scale;
    object_to.topRightCorner(dimensions, 1) = -object_scale * object_mean;
    const int columns = dimensions + 1;
    MatrixXd map(3 * columns, 3 * columns);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        map.block(i * columns, j * columns, columns, columns) = image_back(i, j) * object_to.transpose();
    return map;
  }
};

std::optional<Normalised> normalised(std::span<const ProjectedPoint> points, int dimensions) {
  Normalised n;
  n.dimensions = dimensions;
  n.object_mean = VectorXd::Zero(dimensions);
  for (const ProjectedPoint& point : points) {
    n.image_mean += point.in_image / double(points.size());
    n.object_mean += point.in_object.head(dimensions) / double(points.size());
  }
  double image = 0, object = 0;
  for (const ProjectedPoint& point : points) {
    image += (point.in_image - n.image_mean).squaredNorm();
    object += (point.in_object.head(dimensions) - n.object_mean).squaredNorm();
  }
  if (!(image > 0 && object > 0) || !std::isfinite(image + object)) return std::nullopt;
  n.image_scale = std::sqrt(2 * double(points.size()) / image);
  n.object_scale = std::sqrt(dimensions * double(points.size()) / object);
  for (const ProjectedPoint& point : points) {
    n.image.push_back(n.image_scale * (point.in_image - n.image_mean));
    VectorXd homogeneous = VectorXd::Ones(dimensions + 1);
    homogeneous.head(dimensions) = n.object_scale * (point.in_object.head(dimensions) - n.object_mean);
    n.object.push_back(homogeneous);
    const double sigma = n.image_scale * point.sigma;
    n.weight.push_back(1 / (sigma * sigma));
  }
  return n;
}

// The linear solution: the eigenvector of the smallest eigenvalue; nothing when the next one is as small.
std::optional<VectorXd> linear_solution(const Normalised& n) {
  constexpr double kOpen = 1e-9;
  const int columns = n.dimensions + 1;
  MatrixXd normal = MatrixXd::Zero(3 * columns, 3 * columns);
  for (std::size_t i = 0; i < n.image.size(); ++i) {
    MatrixXd rows = MatrixXd::Zero(2, 3 * columns);
    for (int k = 0; k < 2; ++k) {
      rows.block(k, k * columns, 1, columns) = n.object[i].transpose();
      rows.block(k, 2 * columns, 1, columns) = -n.image[i][k] * n.object[i].transpose();
    }
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(normal);
  const VectorXd& values = eigen.eigenvalues();
  if (!(values[1] > kOpen * values[values.size() - 1])) return std::nullopt;
  return VectorXd(eigen.eigenvectors().col(0));
}

// The matrix of elements in given coordinates, with the sign by which the point is before the camera.
MatrixXd facing(const VectorXd& elements, const ProjectedPoint& point) {
  const Eigen::Index columns = elements.size() / 3;
  const MatrixXd matrix = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      elements.data(), 3, columns);
  VectorXd at = VectorXd::Ones(columns);
  at.head(columns - 1) = point.in_object.head(columns - 1);
  return matrix.row(2).dot(at) < 0 ? MatrixXd(-matrix) : matrix;
}

struct Linearised {
  MatrixXd normal;
  VectorXd right;
  double cost = 0;
  bool is_in_front = true;  // all denominators have the same sign
};

MatrixXd rows_at(const Normalised& n, const VectorXd& elements, std::size_t i, Vector2d& misfit, double& denominator) {
  const int columns = n.dimensions + 1;
  const VectorXd& object = n.object[i];
  denominator = elements.segment(2 * columns, columns).dot(object);
  MatrixXd rows = MatrixXd::Zero(2, 3 * columns);
  for (int k = 0; k < 2; ++k) {
    const double computed = elements.segment(k * columns, columns).dot(object) / denominator;
    misfit[k] = n.image[i][k] - computed;
    rows.block(k, k * columns, 1, columns) = object.transpose() / denominator;
    rows.block(k, 2 * columns, 1, columns) = -computed * object.transpose() / denominator;
  }
  return rows;
}

Linearised linearised(const Normalised& n, const VectorXd& elements) {
  Linearised sum{MatrixXd::Zero(elements.size(), elements.size()), VectorXd::Zero(elements.size())};
  double sign = 0;
  for (std::size_t i = 0; i < n.image.size(); ++i) {
    Vector2d misfit;
    double denominator = 0;
    const MatrixXd rows = rows_at(n, elements, i, misfit, denominator);
    sum.is_in_front &= sign == 0 || sign * denominator > 0;
    sign = denominator;
    sum.normal += n.weight[i] * rows.transpose() * rows;
    sum.right += n.weight[i] * rows.transpose() * misfit;
    sum.cost += n.weight[i] * misfit.squaredNorm();
  }
  return sum;
}

// The inverse of the normal matrix across the elements' own direction, which only scales them.
std::optional<MatrixXd> inverse_across(const MatrixXd& normal, const VectorXd& elements) {
  const double size = normal.trace();
  const Eigen::LDLT<MatrixXd> factor(normal + size * elements * elements.transpose());
  if (!(factor.vectorD().minCoeff() > 1e-15 * size)) return std::nullopt;
  const MatrixXd inverse = factor.solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  return MatrixXd(inverse - elements * elements.transpose() / size);
}

void add_residuals(const Normalised& n, const VectorXd& elements, const MatrixXd& inverse, ProjectionFit& fit) {
  for (std::size_t i = 0; i < n.image.size(); ++i) {
    Vector2d misfit;
    double denominator = 0;
    const MatrixXd rows = rows_at(n, elements, i, misfit, denominator);
    Vector2d redundancy = Vector2d::Zero(), w = Vector2d::Zero();
    for (int k = 0; k < 2; ++k) {
      const double used = n.weight[i] * (rows.row(k) * inverse * rows.row(k).transpose())(0, 0);
      redundancy[k] = std::max(0.0, 1 - used);
      if (redundancy[k] > 1e-9) w[k] = misfit[k] * std::sqrt(n.weight[i] / redundancy[k]);
    }
    fit.misfits.push_back(misfit / n.image_scale);
    fit.redundancies.push_back(redundancy);
    fit.w.push_back(w);
  }
}

std::optional<ProjectionFit> fitted(std::span<const ProjectedPoint> points, int dimensions) {
  const int elements_count = 3 * (dimensions + 1);
  if (static_cast<int>(2 * points.size()) < elements_count - 1) return std::nullopt;
  const auto n = normalised(points, dimensions);
  if (!n) return std::nullopt;
  const auto start = linear_solution(*n);
  if (!start) return std::nullopt;
  VectorXd elements = start->normalized();
  Linearised at = linearised(*n, elements);
  ProjectionFit fit;
  std::optional<MatrixXd> inverse;
  for (fit.iterations = 1; fit.iterations < 50; ++fit.iterations) {
    inverse = inverse_across(at.normal, elements);
    if (!inverse) return std::nullopt;
    VectorXd step = *inverse * at.right;
    Linearised next;
    for (int halving = 0; halving < 10; ++halving, step /= 2) {
      next = linearised(*n, (elements + step).normalized());
      if (next.cost <= at.cost * (1 + 1e-12)) break;
    }
    elements = (elements + step).normalized();
    const bool is_settled = step.norm() < 1e-13 || at.cost - next.cost < 1e-13 * at.cost;
    at = next;
    if (is_settled) break;
  }
  if (!at.is_in_front || !std::isfinite(at.cost)) return std::nullopt;
  inverse = inverse_across(at.normal, elements);
  if (!inverse) return std::nullopt;
  add_residuals(*n, elements, *inverse, fit);
  fit.redundancy = static_cast<int>(2 * points.size()) - (elements_count - 1);
  if (fit.redundancy > 0) fit.sigma0 = std::sqrt(at.cost / fit.redundancy);
  const MatrixXd back = n->back();
  VectorXd given = back * elements;
  const double length = given.norm();
  given /= length;
  const MatrixXd across = MatrixXd::Identity(given.size(), given.size()) - given * given.transpose();
  const MatrixXd map = across * back / length;
  fit.covariance = map * *inverse * map.transpose();
  fit.matrix = facing(given, points[0]);
  return fit;
}

}  // namespace

std::optional<ProjectionFit> fit_projection(std::span<const ProjectedPoint> points) { return fitted(points, 3); }

std::optional<ProjectionFit> fit_plane_projection(std::span<const ProjectedPoint> points) { return fitted(points, 2); }

std::optional<Eigen::Matrix<double, 3, Eigen::Dynamic>> linear_projection(std::span<const ProjectedPoint> points,
                                                                          bool is_plane) {
  const int dimensions = is_plane ? 2 : 3;
  if (points.size() < (is_plane ? 4u : 6u)) return std::nullopt;
  const auto n = normalised(points, dimensions);
  if (!n) return std::nullopt;
  const auto elements = linear_solution(*n);
  if (!elements) return std::nullopt;
  return facing((n->back() * *elements).normalized(), points[0]);
}

std::optional<Decomposition> decomposed(const Eigen::Matrix<double, 3, 4>& projection) {
  const Matrix3d q = projection.leftCols<3>();
  const double determinant = q.determinant(), size = q.norm();
  if (!(std::abs(determinant) > 1e-14 * size * size * size)) return std::nullopt;
  const Matrix3d inverse = q.inverse();  // = R' K^-1: orthogonal times upper triangular
  const Eigen::HouseholderQR<Matrix3d> qr(inverse);
  Matrix3d upper = qr.matrixQR().triangularView<Eigen::Upper>();
  Matrix3d orthogonal = qr.householderQ();
  for (int k = 0; k < 3; ++k)
    if (upper(k, k) < 0) {
      upper.row(k) = -upper.row(k);
      orthogonal.col(k) = -orthogonal.col(k);
    }
  Matrix3d calibration = upper.inverse();
  Eigen::Vector3d translation = upper * projection.col(3);
  Matrix3d rotation = orthogonal.transpose();
  if (rotation.determinant() < 0) {  // the matrix with the other sign
    rotation = -rotation;
    translation = -translation;
  }
  calibration /= calibration(2, 2);
  return Decomposition{calibration, {Eigen::Quaterniond(rotation).normalized(), translation}};
}

std::optional<Vector3d> projection_centre(const Eigen::Matrix<double, 3, 4>& projection) {
  const Eigen::FullPivLU<Matrix3d> lu(projection.leftCols<3>());
  if (!lu.isInvertible()) return std::nullopt;
  return Vector3d(-lu.solve(projection.col(3)));
}

std::optional<Vector3d> ray_of(const Eigen::Matrix<double, 3, 4>& projection, const Vector2d& in_image) {
  const Eigen::FullPivLU<Matrix3d> lu(projection.leftCols<3>());
  if (!lu.isInvertible()) return std::nullopt;
  return Vector3d(lu.solve(in_image.homogeneous()).normalized());
}

std::optional<Rigid3> pose_of_plane(const Matrix3d& plane_projection, const Matrix3d& calibration) {
  const Matrix3d columns = calibration.inverse() * plane_projection;
  const double scale = (columns.col(0).norm() + columns.col(1).norm()) / 2;
  if (!(scale > 0) || !columns.allFinite()) return std::nullopt;
  Matrix3d axes;
  axes << columns.col(0) / scale, columns.col(1) / scale, Vector3d::Zero();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const auto rotation = rotation_nearest_to(axes);
  if (!rotation) return std::nullopt;
  const Vector3d translation = columns.col(2) / scale;
  return Rigid3{Eigen::Quaterniond(*rotation).normalized(), translation};
}

}  // namespace collinea
