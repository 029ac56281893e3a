// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/camera/internal/film_parameters.h"
#include "collinea/math/fisher.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

using namespace film;

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr std::array<FilmModel, 5> kModels = {FilmModel::kRigid, FilmModel::kSimilarity, FilmModel::kTwoScales,
                                              FilmModel::kAffine, FilmModel::kProjective};

constexpr double kLeastLever = 1e-3;

using Used = std::vector<char>;
using Whitener = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 2, 2>;  // a row for each coordinate of a mark

// Equations of marks that are used.
Eigen::Index rows_of(std::span<const FilmMark> marks, const Used& used) {
  Eigen::Index rows = 0;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (used[i]) rows += count_of(marks[i].coordinates);
  return rows;
}

// The film coordinates of a mark; one that the calibration does not define is that of its pixel.
Vector2d film_at(const FilmTransformation& t, const FilmMark& mark) {
  Vector2d film = mark.film_mm;
  if (mark.coordinates == MarkCoordinates::kBoth) return film;
  const int undefined = mark.coordinates == MarkCoordinates::kX ? 1 : 0;
  if (const auto measured = t.film_of(mark.pixel)) film[undefined] = (*measured)[undefined];
  return film;
}

// Across the line of the film on which a mark of one coordinate lies.
Vector2d across_of(const FilmTransformation& t, const FilmMark& mark) {
  const Vector2d along = t.by_film(film_at(t, mark)).col(mark.coordinates == MarkCoordinates::kX ? 1 : 0).normalized();
  return {-along.y(), along.x()};
}

// The similarity of marks of equal weight, in closed form, and the sum of its squared residuals.
std::optional<std::pair<FilmTransformation, double>> similarity_of(std::span<const FilmMark> marks, const Used& used,
                                                                   bool is_mirrored) {
  FilmTransformation t;
  t.is_mirrored = is_mirrored;
  Vector2d film_mean = Vector2d::Zero(), pixel_mean = Vector2d::Zero();
  double count = 0;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (used[i]) {
      film_mean += turned(marks[i].film_mm, t.is_mirrored);
      pixel_mean += marks[i].pixel;
      ++count;
    }
  if (count < 2) return std::nullopt;
  film_mean /= count;
  pixel_mean /= count;
  double along = 0, across = 0, spread = 0, pixel_spread = 0;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (used[i]) {
      const Vector2d q = turned(marks[i].film_mm, t.is_mirrored) - film_mean, p = marks[i].pixel - pixel_mean;
      along += q.dot(p);
      across += q.x() * p.y() - q.y() * p.x();
      spread += q.squaredNorm();
      pixel_spread += p.squaredNorm();
    }
  if (!(spread > 0 && pixel_spread > 0) || !std::isfinite(pixel_spread)) return std::nullopt;
  const double rotation = std::atan2(across, along), scale = std::hypot(along, across) / spread;
  const Vector2d centre = pixel_mean - scale * turned_by(rotation) * film_mean;
  t.parameters = Eigen::Vector4d(centre.x(), centre.y(), rotation, scale);
  return std::pair(t, pixel_spread - scale * scale * spread);
}

// The model's parameters at a similarity.
FilmTransformation started(const FilmTransformation& similarity, FilmModel model, const FilmFitOptions& options) {
  FilmTransformation t = similarity;
  t.model = model;
  const int count = parameter_count(model);
  t.parameters = VectorXd::Zero(count);
  t.parameters.head(std::min(count, 4)) = similarity.parameters.head(std::min(count, 4));
  if (count > kScaleY) t.parameters[kScaleY] = t.parameters[kScaleX];
  if (options.pixel_mm) t.scale_px_per_mm = 1 / *options.pixel_mm;
  return t;
}

// Equations of the used marks, in units of their sigmas.
struct Equations {
  MatrixXd design;
  VectorXd residual;  // measured minus transformed
  VectorXd reach;     // norms of the columns, did all marks have both coordinates
};

// The square root of a mark's weight: the inverse of the Cholesky factor of its covariance; of a mark of one coordinate
// the row across its line over the sigma there. Empty when the covariance is none.
std::optional<std::vector<Whitener>> whiteners(std::span<const FilmMark> marks, const FilmTransformation& t,
                                               double px_per_mm) {
  std::vector<Whitener> out;
  for (const FilmMark& mark : marks) {
    const double calibration = px_per_mm * mark.calibration_sigma_mm;
    const Matrix2d covariance = mark.covariance + calibration * calibration * Matrix2d::Identity();
    const Eigen::LLT<Matrix2d> root(covariance);
    if (root.info() != Eigen::Success) return std::nullopt;
    if (mark.coordinates == MarkCoordinates::kBoth) {
      out.emplace_back(root.matrixL().solve(Matrix2d::Identity()));
      continue;
    }
    const Vector2d across = across_of(t, mark);
    out.emplace_back(across.transpose() / std::sqrt(across.dot(covariance * across)));
  }
  return out;
}

Equations equations(const FilmTransformation& t, std::span<const FilmMark> marks, const Used& used,
                    const std::vector<Whitener>& whitener) {
  const Eigen::Index rows = rows_of(marks, used);
  Equations e{MatrixXd(rows, t.parameters.size()), VectorXd(rows), VectorXd::Zero(t.parameters.size())};
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!used[i]) continue;
    const Vector2d film = film_at(t, marks[i]);
    const Eigen::Index count = whitener[i].rows();
    const auto by = t.by_parameters(film);
    e.design.middleRows(row, count) = whitener[i] * by;
    e.reach += whitener[i].rowwise().norm().mean() * whitener[i].rowwise().norm().mean() *
               by.colwise().squaredNorm().transpose();
    e.residual.segment(row, count) = whitener[i] * (marks[i].pixel - t.pixel_of(film));
    row += count;
  }
  e.reach = e.reach.cwiseSqrt();
  return e;
}

// The inverse of the normal matrix; nothing when the columns, scaled to length one, depend on each other.
std::optional<MatrixXd> inverse_normals(const Equations& e) {
  const MatrixXd& design = e.design;
  const VectorXd scale = design.colwise().norm();
  // A lever of less than a thousandth of the marks' distances is how they were read, nothing that determines.
  if (!((scale - kLeastLever * e.reach).minCoeff() > 0)) return std::nullopt;
  if (!scale.allFinite()) return std::nullopt;
  const MatrixXd scaled = design * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled.transpose() * scaled);
  if (!(eigen.eigenvalues()[0] > 1e-10 * eigen.eigenvalues()[scale.size() - 1])) return std::nullopt;
  const MatrixXd inverse =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
}

// The chance of the residuals of one mark, when the others are good: chi-squared of its whitened residual in the
// coordinates that others control, or F against the rest.
double misread_chance(const VectorXd& whitened, const MatrixXd& redundancy, double squares, int degrees, bool known) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(redundancy);
  double test = 0;
  int controlled = 0;
  for (Eigen::Index k = 0; k < whitened.size(); ++k) {
    if (!(eigen.eigenvalues()[k] > 1e-6)) continue;
    const double along = eigen.eigenvectors().col(k).dot(whitened);
    test += along * along / eigen.eigenvalues()[k];
    ++controlled;
  }
  if (controlled == 0 || degrees - controlled < 1) return 1;
  if (known) return fisher_tail(test / controlled, controlled, std::numeric_limits<double>::infinity());
  const double rest = std::max(squares - test, 1e-12) / (degrees - controlled);
  return fisher_tail(test / controlled / rest, controlled, degrees - controlled);
}

// Test and redundancy of a used mark, in pixels; `redundancy` is that of its whitened residuals.
void judge_used(FilmMarkResidual& mark, const Whitener& whitener, const VectorXd& whitened, const MatrixXd& redundancy,
                double scale) {
  if (whitened.size() == 1) {
    const Vector2d across = whitener.row(0).transpose().normalized();
    mark.redundancy = redundancy(0, 0) * across.cwiseAbs2();
    const int nearer = std::abs(across.x()) >= std::abs(across.y()) ? 0 : 1;
    if (redundancy(0, 0) > 1e-12 && scale > 0)
      mark.w[nearer] = std::copysign(1.0, across[nearer]) * whitened[0] / std::sqrt(redundancy(0, 0)) / scale;
    return;
  }
  // Back in pixels: P v and P Qv P of the mark.
  const Matrix2d root = whitener;
  const Vector2d weighted = root.transpose() * whitened;
  const Matrix2d of_weighted = root.transpose() * redundancy * root, weight = root.transpose() * root;
  const Matrix2d in_pixels = root.inverse() * redundancy * root;
  for (int k = 0; k < 2; ++k) {
    mark.redundancy[k] = in_pixels(k, k);
    if (of_weighted(k, k) > 1e-12 * weight(k, k) && scale > 0)
      mark.w[k] = weighted[k] / std::sqrt(of_weighted(k, k)) / scale;
  }
}

// What a mark misses its transformed position by; one of one coordinate its line, square to it.
Vector2d misfit_of(const FilmTransformation& t, const FilmMark& mark) {
  const Vector2d misfit = mark.pixel - t.pixel_of(film_at(t, mark));
  if (mark.coordinates == MarkCoordinates::kBoth) return misfit;
  const Vector2d across = across_of(t, mark);
  return across.dot(misfit) * across;
}

// Residuals and tests of all marks; those that are not used get the residual of a check.
void judge(FilmFit& fit, std::span<const FilmMark> marks, const Used& used, const std::vector<Whitener>& whitener,
           const Equations& e, const MatrixXd& inverse, const FilmFitOptions& options) {
  const double scale = options.sigmas_are_known || fit.redundancy == 0 ? 1 : fit.sigma0;
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    FilmMarkResidual mark{.name = marks[i].name, .is_used = used[i] != 0, .coordinates = marks[i].coordinates};
    mark.residual_px = misfit_of(fit.transformation, marks[i]);
    if (mark.is_used) {
      const Eigen::Index count = whitener[i].rows();
      const auto design = e.design.middleRows(row, count);
      const MatrixXd redundancy = MatrixXd::Identity(count, count) - design * inverse * design.transpose();
      const VectorXd whitened = e.residual.segment(row, count);
      judge_used(mark, whitener[i], whitened, redundancy, scale);
      mark.misread_chance = misread_chance(whitened, redundancy, fit.squares, fit.redundancy, options.sigmas_are_known);
      row += count;
    }
    fit.marks.push_back(mark);
  }
}

std::optional<FilmFit> fit_used(std::span<const FilmMark> marks, const Used& used, FilmModel model,
                                const FilmFitOptions& options) {
  const int parameters = parameter_count(model);
  const Eigen::Index rows = rows_of(marks, used);
  if (rows < parameters || (model == FilmModel::kRigid && !options.pixel_mm)) return std::nullopt;
  const auto straight = similarity_of(marks, used, false), mirrored = similarity_of(marks, used, true);
  if (!straight || !mirrored) return std::nullopt;
  const FilmTransformation& start = (mirrored->second < straight->second ? mirrored : straight)->first;
  FilmFit fit{.transformation = started(start, model, options)};
  FilmTransformation& t = fit.transformation;
  for (int round = 0; round < 50; ++round) {
    const auto whitener = whiteners(marks, t, start.parameters[kScaleX]);
    if (!whitener) return std::nullopt;
    const Equations e = equations(t, marks, used, *whitener);
    const auto inverse = inverse_normals(e);
    if (!inverse) return std::nullopt;
    const VectorXd step = *inverse * (e.design.transpose() * e.residual);
    if (!step.allFinite()) return std::nullopt;
    t.parameters += step;
    const double moved = (e.design * step).squaredNorm();
    if (moved > 1e-16 * double(rows) && round + 1 < 50) continue;
    if (moved > 1e-6 * double(rows)) return std::nullopt;
    const Equations last = equations(t, marks, used, *whitener);
    fit.squares = last.residual.squaredNorm();
    fit.redundancy = int(rows) - parameters;
    if (fit.redundancy > 0) fit.sigma0 = std::sqrt(fit.squares / fit.redundancy);
    const double scale = options.sigmas_are_known ? 1 : fit.sigma0;
    t.covariance = scale * scale * *inverse;
    judge(fit, marks, used, *whitener, last, *inverse, options);
    return fit;
  }
  return std::nullopt;
}

// The marks that stay when misread ones are rejected, one at a time, as long as two degrees of freedom remain.
Used not_misread(std::span<const FilmMark> marks, FilmModel model, const FilmFitOptions& options) {
  Used used(marks.size(), 1);
  while (options.reject_misread) {
    const auto fit = fit_used(marks, used, model, options);
    if (!fit || fit->redundancy < 4) break;
    std::size_t worst = marks.size();
    double chance = options.level / double(std::count(used.begin(), used.end(), char{1}));
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (used[i] && fit->marks[i].misread_chance < chance) {
        chance = fit->marks[i].misread_chance;
        worst = i;
      }
    if (worst == marks.size()) break;
    used[worst] = 0;
  }
  return used;
}

// The larger models' verdict on the smaller ones: pairs that redundancy, or known sigmas, can test.
std::vector<FilmModelTest> model_tests(std::span<const std::optional<FilmFit>> fits, bool known) {
  std::vector<FilmModelTest> tests;
  for (std::size_t i = 0; i < fits.size(); ++i)
    for (std::size_t j = i + 1; j < fits.size(); ++j) {
      if (!fits[i] || !fits[j] || (fits[j]->redundancy == 0 && !known)) continue;
      const int more = fits[i]->redundancy - fits[j]->redundancy;
      const double explained = std::max(0.0, fits[i]->squares - fits[j]->squares) / more;
      const double noise = known ? 1 : std::max(fits[j]->squares, 1e-12) / fits[j]->redundancy;
      const double degrees = known ? std::numeric_limits<double>::infinity() : fits[j]->redundancy;
      tests.push_back({kModels[i], kModels[j], explained / noise, fisher_tail(explained / noise, more, degrees)});
    }
  return tests;
}

}  // namespace

std::optional<FilmFit> fit_film(std::span<const FilmMark> marks, FilmModel model, const FilmFitOptions& options) {
  return fit_used(marks, not_misread(marks, model, options), model, options);
}

std::optional<FilmChoice> choose_film_model(std::span<const FilmMark> marks, const FilmFitOptions& options,
                                            double level) {
  const Used all(marks.size(), 1);
  const bool has_affine = fit_used(marks, all, FilmModel::kAffine, options).has_value();
  const Used used = not_misread(marks, has_affine ? FilmModel::kAffine : FilmModel::kSimilarity, options);
  std::array<std::optional<FilmFit>, kModels.size()> fits;
  for (std::size_t i = 0; i < kModels.size(); ++i) fits[i] = fit_used(marks, used, kModels[i], options);
  std::vector<FilmModelTest> tests = model_tests(fits, options.sigmas_are_known);
  for (std::size_t i = 0; i < kModels.size(); ++i) {
    if (!fits[i]) continue;
    int count = 0;
    double least = 1;
    for (const FilmModelTest& test : tests)
      if (test.smaller == kModels[i]) {
        least = std::min(least, test.chance);
        ++count;
      }
    if (count > 0 && least < level / count) continue;
    return FilmChoice{*std::move(fits[i]), std::move(tests)};
  }
  return std::nullopt;
}

std::optional<FilmDeformation> film_deformation(std::span<const FilmMark> marks, const FilmFitOptions& options) {
  const auto fit = fit_film(marks, FilmModel::kAffine, options);
  if (!fit || (fit->redundancy == 0 && !options.sigmas_are_known)) return std::nullopt;
  const VectorXd& p = fit->transformation.parameters;
  const MatrixXd& covariance = fit->transformation.covariance;
  const auto with_sigma = [&](double value, double factor, const VectorXd& by) {
    return WithSigma{factor * value, std::abs(factor) * std::sqrt(by.dot(covariance * by))};
  };
  const auto unit = [](int parameter) -> VectorXd { return VectorXd::Unit(6, parameter); };
  const double mx = p[kScaleX], my = p[kScaleY];
  FilmDeformation d;
  d.pixel_x_um = with_sigma(1 / mx, 1e3, unit(kScaleX) / (mx * mx));
  d.pixel_y_um = with_sigma(1 / my, 1e3, unit(kScaleY) / (my * my));
  d.difference_ppm = with_sigma(mx / my - 1, 1e6, unit(kScaleX) / my - unit(kScaleY) * mx / (my * my));
  d.shear_ppm = with_sigma(p[kShear], 1e6, unit(kShear));
  d.rotation_rad = with_sigma(p[kRotation], 1, unit(kRotation));
  if (options.pixel_mm) {
    d.x_ppm = with_sigma(mx * *options.pixel_mm - 1, 1e6, unit(kScaleX) * *options.pixel_mm);
    d.y_ppm = with_sigma(my * *options.pixel_mm - 1, 1e6, unit(kScaleY) * *options.pixel_mm);
  }
  const double limit = options.sigmas_are_known ? normal_limit(0.05) : student_limit(0.05, fit->redundancy);
  d.differs = std::abs(d.difference_ppm.value) > limit * d.difference_ppm.sigma;
  d.is_sheared = std::abs(d.shear_ppm.value) > limit * d.shear_ppm.sigma;
  return d;
}

}  // namespace collinea
