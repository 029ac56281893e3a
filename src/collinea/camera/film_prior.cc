// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kGrid = 14;            // positions along each side: twice and more what the functions resolve
constexpr double kRemainder = 1e-4;  // of the variance, white: what the functions leave keeps matrices regular

MatrixXd covariance_of(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b, double correlation_px) {
  MatrixXd c(Index(a.size()), Index(b.size()));
  for (Index k = 0; k < c.cols(); ++k)
    for (Index i = 0; i < c.rows(); ++i)
      c(i, k) =
          std::exp(-0.5 * (a[std::size_t(i)] - b[std::size_t(k)]).squaredNorm() / (correlation_px * correlation_px));
  return c;
}

// 1, x, y of each position.
MatrixXd affinities(const std::vector<Vector2d>& at, ImageExtent size) {
  MatrixXd rows(Index(at.size()), 3);
  for (std::size_t i = 0; i < at.size(); ++i)
    rows.row(Index(i)) << 1, at[i].x() / size.width_px - 0.5, at[i].y() / size.height_px - 0.5;
  return rows;
}

std::vector<Vector2d> grid_over(ImageExtent size) {
  std::vector<Vector2d> grid;
  for (int i = 0; i < kGrid; ++i)
    for (int k = 0; k < kGrid; ++k)
      grid.emplace_back(size.width_px * (i + 0.5) / kGrid, size.height_px * (k + 0.5) / kGrid);
  return grid;
}

// Functions from what they are on the grid, by least squares.
MatrixXd fit_on(const std::vector<Vector2d>& grid, ImageExtent size, int functions) {
  MatrixXd values(Index(grid.size()), functions);
  for (std::size_t i = 0; i < grid.size(); ++i)
    values.row(Index(i)) = film_functions(size, grid[i]).head(functions).transpose();
  return values.completeOrthogonalDecomposition().pseudoInverse();
}

std::vector<Vector2d> positions_of(const FilmPrior& prior) {
  std::vector<Vector2d> at;
  for (const FilmMarkOffset& mark : prior.marks) at.push_back(mark.pixel);
  return at;
}

// The residuals of the marks, column and row.
MatrixXd residuals_of(const FilmPrior& prior) {
  MatrixXd offsets(Index(prior.marks.size()), 2);
  for (std::size_t i = 0; i < prior.marks.size(); ++i) offsets.row(Index(i)) = prior.marks[i].offset_px.transpose();
  return offsets;
}

// Contrasts of the marks, which no affinity changes: orthonormal rows by the residuals; none of three marks and fewer.
MatrixXd contrasts_of(const std::vector<Vector2d>& marks, ImageExtent size) {
  const auto count = Index(marks.size());
  if (count <= 3) return MatrixXd::Zero(0, count);
  const MatrixXd basis = affinities(marks, size).householderQr().householderQ() * MatrixXd::Identity(count, count);
  return basis.rightCols(count - 3).transpose();
}

// The joint covariance of functions and contrasts.
MatrixXd joint(const FilmShape& shape, double variance, double mark_variance) {
  const Index n = shape.functions.rows(), m = shape.contrasts.rows();
  MatrixXd all(n + m, n + m);
  all.topLeftCorner(n, n) = variance * shape.functions + mark_variance * shape.by_marks;
  all.topRightCorner(n, m) = variance * shape.with_marks;
  all.bottomLeftCorner(m, n) = variance * shape.with_marks.transpose();
  all.bottomRightCorner(m, m) = variance * shape.contrasts + mark_variance * MatrixXd::Identity(m, m);
  return all;
}

// Scans with marks at the same positions, and the mean of the squares of their functions and contrasts.
struct Group {
  const FilmPrior* prior;
  MatrixXd squares;
  double count = 0;
};

bool have_same_marks(const FilmPrior& a, const FilmPrior& b) {
  return a.functions == b.functions && positions_of(a) == positions_of(b) && a.mark_sigma_px == b.mark_sigma_px;
}

std::vector<Group> groups_of(std::span<const FilmMoments> scans, ImageExtent size) {
  std::vector<Group> groups;
  for (const FilmMoments& scan : scans) {
    const Index n = scan.prior.functions;
    const MatrixXd contrasts = contrasts_of(positions_of(scan.prior), size) * residuals_of(scan.prior);
    const Index all = n + contrasts.rows();
    Group* its = nullptr;
    for (Group& group : groups)
      if (have_same_marks(*group.prior, scan.prior)) its = &group;
    if (!its) its = &groups.emplace_back(Group{&scan.prior, MatrixXd::Zero(all, all)});
    for (Index axis = 0; axis < 2; ++axis) {
      VectorXd values(all);
      for (Index k = 0; k < n; ++k) values[k] = scan.values[2 * k + axis];
      values.tail(contrasts.rows()) = contrasts.col(axis);
      its->squares += values * values.transpose();
      for (Index k = 0; k < n; ++k)
        for (Index i = 0; i < n; ++i) its->squares(i, k) += scan.covariance(2 * i + axis, 2 * k + axis);
      its->count += 1;
    }
  }
  return groups;
}

// Minus twice the logarithm of the likelihood, but for a constant.
double unlikelihood(const Group& group, const FilmShape& shape, double sigma_px) {
  const double mark = group.prior->mark_sigma_px;
  const Eigen::LLT<MatrixXd> factor(joint(shape, sigma_px * sigma_px, mark * mark));
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const MatrixXd lower = factor.matrixL();
  return 2 * group.count * lower.diagonal().array().log().sum() + factor.solve(group.squares).trace();
}

// The least value of a function of the logarithm of its argument, by golden sections, with where it is.
template <class Function>
std::pair<double, double> least_of(double low, double high, int steps, Function&& function) {
  constexpr double kGolden = 0.6180339887498949;
  double a = std::log(low), b = std::log(high);
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a);
  double at_c = function(std::exp(c)), at_d = function(std::exp(d));
  for (int i = 0; i < steps; ++i) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      c = b - kGolden * (b - a), at_c = function(std::exp(c));
    } else {
      a = c, c = d, at_c = at_d;
      d = a + kGolden * (b - a), at_d = function(std::exp(d));
    }
  }
  return at_c < at_d ? std::pair{at_c, std::exp(c)} : std::pair{at_d, std::exp(d)};
}

}  // namespace

FilmShape film_shape(const FilmPrior& prior, ImageExtent size, double correlation_px) {
  const std::vector<Vector2d> grid = grid_over(size), marks = positions_of(prior);
  const MatrixXd fit = fit_on(grid, size, prior.functions);
  const auto count = Index(marks.size());
  FilmShape shape{.of_residuals = contrasts_of(marks, size)};
  MatrixXd covariance = covariance_of(grid, grid, correlation_px);
  if (count > 3) {
    const MatrixXd at_marks = affinities(marks, size), of_marks = covariance_of(marks, marks, correlation_px);
    // By how much the grid moves with the marks: its affinities times the inverse of those of the marks.
    const MatrixXd taken = affinities(grid, size) * at_marks.completeOrthogonalDecomposition().pseudoInverse();
    const MatrixXd cross = covariance_of(grid, marks, correlation_px);
    covariance += taken * of_marks * taken.transpose() - taken * cross.transpose() - cross * taken.transpose();
    shape.with_marks = fit * (cross - taken * of_marks) * shape.of_residuals.transpose();
    shape.contrasts = shape.of_residuals * of_marks * shape.of_residuals.transpose();
    const MatrixXd by_marks = fit * taken;
    shape.by_marks = by_marks * by_marks.transpose();
  } else {
    shape.with_marks = MatrixXd::Zero(prior.functions, 0);
    shape.contrasts = MatrixXd::Zero(0, 0);
    shape.by_marks = MatrixXd::Zero(prior.functions, prior.functions);
  }
  shape.functions = fit * covariance * fit.transpose();
  shape.functions.diagonal().array() += kRemainder / prior.functions;
  return shape;
}

FilmField film_field(const FilmPrior& prior, const FilmShape& shape) {
  const double variance = prior.sigma_px * prior.sigma_px, mark_variance = prior.mark_sigma_px * prior.mark_sigma_px;
  const Index n = shape.functions.rows(), m = shape.contrasts.rows();
  const MatrixXd all = joint(shape, variance, mark_variance);
  FilmField field{VectorXd::Zero(n), VectorXd::Zero(n), all.topLeftCorner(n, n)};
  if (m == 0) return field;
  const MatrixXd gain = all.bottomRightCorner(m, m).ldlt().solve(all.bottomLeftCorner(m, n)).transpose();
  const MatrixXd means = gain * shape.of_residuals * residuals_of(prior);
  field.column = means.col(0);
  field.row = means.col(1);
  field.covariance -= gain * all.bottomLeftCorner(m, n);
  field.covariance = (0.5 * (field.covariance + field.covariance.transpose())).eval();
  return field;
}

FilmProcess likeliest_process(std::span<const FilmMoments> scans, ImageExtent size) {
  const FilmPrior& first = scans.front().prior;
  const std::vector<Group> groups = groups_of(scans, size);
  double best_sigma = first.sigma_px;
  const auto at_length = [&](double correlation_px) {
    std::vector<FilmShape> shapes;
    for (const Group& group : groups) shapes.push_back(film_shape(*group.prior, size, correlation_px));
    const auto at_sigma = [&](double sigma_px) {
      double sum = 0;
      for (std::size_t g = 0; g < groups.size(); ++g) sum += unlikelihood(groups[g], shapes[g], sigma_px);
      return sum;
    };
    if (first.sigma_is_given) return std::pair{at_sigma(first.sigma_px), first.sigma_px};
    return least_of(first.sigma_px / 5, 5 * first.sigma_px, 20, at_sigma);
  };
  if (first.correlation_is_given) return {at_length(first.correlation_px).second, first.correlation_px};
  const auto found = least_of(size.width_px / 25, size.width_px / 2, 14,
                              [&](double correlation_px) { return at_length(correlation_px).first; });
  best_sigma = at_length(found.second).second;
  return {best_sigma, found.second};
}

std::optional<double> sigma_by_marks(std::span<const FilmPrior> scans, ImageExtent size, double correlation_px) {
  double squares = 0, of_process = 0;
  for (const FilmPrior& scan : scans) {
    const std::vector<Vector2d> marks = positions_of(scan);
    const MatrixXd contrasts = contrasts_of(marks, size);
    squares += (contrasts * residuals_of(scan)).squaredNorm() -
               2 * double(contrasts.rows()) * scan.mark_sigma_px * scan.mark_sigma_px;
    of_process += 2 * (contrasts * covariance_of(marks, marks, correlation_px) * contrasts.transpose()).trace();
  }
  if (!(of_process > 0) || !(squares > 0)) return std::nullopt;
  return std::sqrt(squares / of_process);
}

}  // namespace collinea
