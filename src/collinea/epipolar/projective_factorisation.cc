// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/projective_factorisation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/epipolar/projection_matrix.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

constexpr double kFlat = 1e-4;  // of the first singular value
constexpr int kAlternations = 50;

// Coordinates of an image with mean 0 and mean square 2 (Hartley 1997).
struct NormalisedImage {
  Eigen::Matrix2Xd xy;
  Matrix3d to_given = Matrix3d::Identity();
  double scale = 1;  // normalised = scale (given - mean)
};

std::optional<NormalisedImage> normalised(const Eigen::Matrix2Xd& given) {
  const Vector2d mean = given.rowwise().mean();
  const double size = std::sqrt((given.colwise() - mean).squaredNorm() / (2 * double(given.cols())));
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  NormalisedImage out;
  out.scale = 1 / size;
  out.xy = (given.colwise() - mean) / size;
  out.to_given << size, 0, mean.x(), 0, size, mean.y(), 0, 0, 1;
  return out;
}

// Projective depths by the fundamental matrix with the first image (Sturm and Triggs 1996, eq. 5):
// lambda' = (e' x u') . (F u) / |e' x u'|^2 lambda.
std::optional<Eigen::RowVectorXd> depths_by_pair(const Eigen::Matrix2Xd& first, const Eigen::Matrix2Xd& second) {
  PointPairs pairs;
  for (Index p = 0; p < first.cols(); ++p) pairs.add(first.col(p), second.col(p));
  std::vector<int> all(static_cast<std::size_t>(first.cols()));
  std::iota(all.begin(), all.end(), 0);
  const auto f = eight_point(pairs, all);
  if (!f) return std::nullopt;
  const Eigen::JacobiSVD<Matrix3d> svd(*f, Eigen::ComputeFullU);
  const Vector3d epipole = svd.matrixU().col(2);
  Eigen::RowVectorXd depths(first.cols());
  for (Index p = 0; p < first.cols(); ++p) {
    const Vector3d line = *f * Vector2d(first.col(p)).homogeneous();
    const Vector3d across = epipole.cross(Vector2d(second.col(p)).homogeneous());
    depths[p] = across.dot(line) / across.squaredNorm();
  }
  if (!depths.allFinite() || !(depths.cwiseAbs().minCoeff() > 0)) return std::nullopt;
  return Eigen::RowVectorXd(depths * std::sqrt(double(depths.size())) / depths.norm());
}

using Depths = MatrixXd;  // m x n

MatrixXd measurement_matrix(const std::vector<NormalisedImage>& images, const Depths& depths) {
  MatrixXd w(3 * depths.rows(), depths.cols());
  for (Index i = 0; i < depths.rows(); ++i)
    for (Index p = 0; p < depths.cols(); ++p)
      w.block<3, 1>(3 * i, p) = depths(i, p) * Vector2d(images[static_cast<std::size_t>(i)].xy.col(p)).homogeneous();
  return w;
}

// Points and images all weigh the same; both scales are free (Sturm and Triggs 1996, 3.2).
void balance(const std::vector<NormalisedImage>& images, Depths& depths) {
  MatrixXd lengths(depths.rows(), depths.cols());
  for (Index i = 0; i < depths.rows(); ++i)
    lengths.row(i) = (images[static_cast<std::size_t>(i)].xy.colwise().squaredNorm().array() + 1).sqrt();
  for (int sweep = 0; sweep < 3; ++sweep) {
    for (Index p = 0; p < depths.cols(); ++p) depths.col(p) /= depths.col(p).cwiseProduct(lengths.col(p)).norm();
    for (Index i = 0; i < depths.rows(); ++i)
      depths.row(i) *= std::sqrt(double(depths.cols())) / depths.row(i).cwiseProduct(lengths.row(i)).norm();
  }
}

struct Factors {
  MatrixXd matrices;        // 3m x 4
  Eigen::Matrix4Xd points;  // 4 x n
  double fourth = 0, fifth = 0;
};

Factors factors_of(const MatrixXd& w) {
  const Eigen::JacobiSVD<MatrixXd> svd(w.cols() > w.rows() ? MatrixXd(w.transpose()) : w,
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  const bool is_turned = w.cols() > w.rows();
  const MatrixXd &left = is_turned ? svd.matrixV() : svd.matrixU(), &right = is_turned ? svd.matrixU() : svd.matrixV();
  const VectorXd& values = svd.singularValues();
  return {left.leftCols<4>() * values.head<4>().asDiagonal(), right.leftCols<4>().transpose(), values[3] / values[0],
          values.size() > 4 ? values[4] / values[0] : 0};
}

// Depths and factors in turn, until the factors explain the measurement matrix no better (Bolognesi 5.39).
Factors alternated(const std::vector<NormalisedImage>& images, Depths depths, int& alternations) {
  balance(images, depths);
  Factors factors = factors_of(measurement_matrix(images, depths));
  for (alternations = 1; alternations < kAlternations; ++alternations) {
    Depths next = depths;
    for (Index i = 0; i < depths.rows(); ++i)
      for (Index p = 0; p < depths.cols(); ++p) {
        const Vector3d ray = Vector2d(images[static_cast<std::size_t>(i)].xy.col(p)).homogeneous();
        next(i, p) = ray.dot(factors.matrices.middleRows<3>(3 * i) * factors.points.col(p)) / ray.squaredNorm();
      }
    balance(images, next);
    const Factors better = factors_of(measurement_matrix(images, next));
    if (!(better.fifth < factors.fifth * (1 - 1e-3)) || better.fifth < 1e-12) break;
    depths = next;
    factors = better;
  }
  return factors;
}

// --- least squares in the images -------------------------------------------------------------------------------------

// Three directions across a unit vector.
Eigen::Matrix<double, 4, 3> across(const Vector4d& unit) {
  Index largest = 0;
  unit.cwiseAbs().maxCoeff(&largest);
  Eigen::Matrix<double, 4, 3> out;
  for (Index k = 0, column = 0; k < 4; ++k)
    if (k != largest) {
      Vector4d axis = Vector4d::Unit(k) - unit * unit[k];
      for (Index before = 0; before < column; ++before) axis -= out.col(before) * out.col(before).dot(axis);
      out.col(column++) = axis.normalized();
    }
  return out;
}

struct Fit {
  std::vector<ProjectionMatrix> matrices;
  Eigen::Matrix4Xd points;
};

class ImageSquares {
 public:
  ImageSquares(const std::vector<NormalisedImage>& images, const ImageCoordinates& measured)
      : images_(images), measured_(measured) {}

  [[nodiscard]] double cost(const Fit& fit) const {
    double sum = 0;
    for (std::size_t i = 0; i < images_.size(); ++i)
      for (Index p = 0; p < fit.points.cols(); ++p) sum += weight(i, p) * misfit(fit, i, p).squaredNorm();
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] Vector2d misfit(const Fit& fit, std::size_t i, Index p) const {
    return images_[i].xy.col(p) - (fit.matrices[i] * fit.points.col(p)).hnormalized();
  }

  // One damped step: the points are eliminated; the collineation and the scales have no effect, the damping keeps them.
  [[nodiscard]] Fit stepped(const Fit& fit, double damping) const {
    const auto m = static_cast<Index>(images_.size()), n = fit.points.cols();
    MatrixXd reduced = MatrixXd::Zero(12 * m, 12 * m);
    VectorXd right = VectorXd::Zero(12 * m);
    std::vector<Matrix3d> inverse;
    std::vector<Vector3d> point_right;
    std::vector<MatrixXd> coupled;
    for (Index p = 0; p < n; ++p) {
      const Eigen::Matrix<double, 4, 3> tangents = across(fit.points.col(p));
      Matrix3d of_point = Matrix3d::Zero();
      Vector3d to_point = Vector3d::Zero();
      MatrixXd rows = MatrixXd::Zero(3, 12 * m);
      for (Index i = 0; i < m; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const Vector3d image = fit.matrices[k] * fit.points.col(p);
        Eigen::Matrix<double, 2, 3> by_image;
        by_image << 1, 0, -image.x() / image.z(), 0, 1, -image.y() / image.z();
        by_image /= image.z();
        const Eigen::Matrix<double, 2, 3> by_point = by_image * fit.matrices[k] * tangents;
        Eigen::Matrix<double, 2, 12> by_matrix;
        for (Index row = 0; row < 3; ++row)
          by_matrix.middleCols<4>(4 * row) = by_image.col(row) * fit.points.col(p).transpose();
        const double w = weight(k, p);
        const Vector2d off = misfit(fit, k, p);
        of_point += w * by_point.transpose() * by_point;
        to_point += w * by_point.transpose() * off;
        rows.middleCols<12>(12 * i) = w * by_point.transpose() * by_matrix;
        reduced.block<12, 12>(12 * i, 12 * i) += w * by_matrix.transpose() * by_matrix;
        right.segment<12>(12 * i) += w * by_matrix.transpose() * off;
      }
      of_point.diagonal() *= 1 + damping;
      inverse.push_back(of_point.inverse());
      point_right.push_back(to_point);
      coupled.push_back(std::move(rows));
    }
    const VectorXd diagonal = reduced.diagonal();
    for (std::size_t p = 0; p < inverse.size(); ++p) {
      reduced.noalias() -= coupled[p].transpose() * inverse[p] * coupled[p];
      right -= coupled[p].transpose() * inverse[p] * point_right[p];
    }
    reduced.diagonal() += std::max(damping, 1e-12) * diagonal;
    const VectorXd step = reduced.ldlt().solve(right);
    Fit next = fit;
    for (Index i = 0; i < m; ++i) {
      ProjectionMatrix& matrix = next.matrices[static_cast<std::size_t>(i)];
      for (Index row = 0; row < 3; ++row) matrix.row(row) += step.segment<4>(12 * i + 4 * row).transpose();
      matrix.normalize();
    }
    for (Index p = 0; p < n; ++p) {
      const auto k = static_cast<std::size_t>(p);
      next.points.col(p) += across(fit.points.col(p)) * (inverse[k] * (point_right[k] - coupled[k] * step));
      next.points.col(p).normalize();
    }
    return next;
  }

 private:
  [[nodiscard]] double weight(std::size_t i, Index p) const {
    const double sigma = images_[i].scale * measured_.sigma[i][p];
    return 1 / (sigma * sigma);
  }

  const std::vector<NormalisedImage>& images_;
  const ImageCoordinates& measured_;
};

bool refine(const ImageSquares& squares, Fit& fit, int& iterations) {
  double cost = squares.cost(fit), damping = 1e-4;
  for (iterations = 1; iterations <= 200; ++iterations) {
    const Fit next = squares.stepped(fit, damping);
    const double after = squares.cost(next);
    if (after <= cost) {
      const double gain = cost - after;
      fit = next;
      cost = after;
      if (gain < 1e-10 * std::max(1e-6, cost)) return true;
      damping = std::max(1e-10, damping / 10);
    } else {
      if (damping > 1e6 || cost < 1e-16) return std::isfinite(cost);
      damping *= 10;
    }
  }
  return false;
}

// The largest sigma0 of collineations from the first image to the others; infinite where there is none.
double sigma0_of_collineations(const ImageCoordinates& measured) {
  double largest = 0;
  for (std::size_t i = 1; i < measured.images(); ++i) {
    std::vector<ProjectedPoint> points;
    for (Index p = 0; p < measured.points(); ++p)
      points.push_back({measured.xy[i].col(p), {measured.xy[0](0, p), measured.xy[0](1, p), 0}, measured.sigma[i][p]});
    const auto fit = fit_plane_projection(points);
    largest = std::max(largest, fit ? fit->sigma0 : std::numeric_limits<double>::infinity());
  }
  return largest;
}

Result<> check(const ImageCoordinates& measured) {
  if (measured.images() < 2) return fail(Errc::kIllPosed, "a factorisation needs two images or more");
  if (measured.points() < 8)
    return fail(Errc::kIllPosed, "a factorisation needs eight points that all images show, there are " +
                                     std::to_string(measured.points()));
  return {};
}

}  // namespace

Result<ProjectiveModel> factorised(const ImageCoordinates& measured) {
  COLLINEA_TRY(check(measured));
  const auto flat = [] {
    return fail(Errc::kIllPosed,
                "the measurements have no rank 4: the points lie on a plane, or the images are taken from one centre");
  };
  std::vector<NormalisedImage> images;
  Depths depths = Depths::Ones(static_cast<Index>(measured.images()), measured.points());
  for (std::size_t i = 0; i < measured.images(); ++i) {
    const auto image = normalised(measured.xy[i]);
    if (!image) return flat();
    images.push_back(*image);
    if (i == 0) continue;
    const auto by_pair = depths_by_pair(images[0].xy, image->xy);
    if (!by_pair) return flat();
    depths.row(static_cast<Index>(i)) = *by_pair;
  }
  constexpr double kPlane = 3, kPlaneOfModel = 2;  // of sigma; of sigma0
  const double of_plane = sigma0_of_collineations(measured);
  if (of_plane < kPlane) return flat();
  ProjectiveModel model;
  const Factors factors = alternated(images, depths, model.alternations);
  model.fourth = factors.fourth;
  model.fifth = factors.fifth;
  if (!(factors.fourth > kFlat && factors.fourth > factors.fifth)) return flat();
  Fit fit;
  for (std::size_t i = 0; i < images.size(); ++i)
    fit.matrices.push_back(factors.matrices.middleRows<3>(3 * static_cast<Index>(i)).normalized());
  fit.points = factors.points.colwise().normalized();
  const ImageSquares squares(images, measured);
  if (!refine(squares, fit, model.iterations))
    return fail(Errc::kNotConverged, "the projective cameras did not converge in 200 steps");
  const auto m = static_cast<int>(images.size()), n = static_cast<int>(measured.points());
  model.redundancy = 2 * m * n - 11 * m - 3 * n + 15;
  if (model.redundancy > 0) model.sigma0 = std::sqrt(squares.cost(fit) / model.redundancy);
  if (model.redundancy > 0 && of_plane < kPlaneOfModel * model.sigma0) return flat();
  for (std::size_t i = 0; i < images.size(); ++i) {
    Eigen::Matrix2Xd misfits(2, n);
    for (Index p = 0; p < n; ++p) misfits.col(p) = squares.misfit(fit, i, p) / images[i].scale;
    model.misfits.push_back(misfits);
    model.matrices.push_back((images[i].to_given * fit.matrices[i]).normalized());
  }
  model.points = fit.points;
  return model;
}

Matrix3d fundamental_of(const ProjectionMatrix& first, const ProjectionMatrix& second) {
  // F(j, i) = +-det of the rows of the first camera without i and of the second without j (Hartley and Zisserman 17.3).
  Matrix3d f;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Eigen::Matrix4d rows;
      rows << first.row((i + 1) % 3), first.row((i + 2) % 3), second.row((j + 1) % 3), second.row((j + 2) % 3);
      f(j, i) = rows.determinant();
    }
  return f.normalized();
}

}  // namespace collinea
