// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_prior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr ImageExtent kSize{1000, 1000};

VectorXd normals(Index count, Random& random) {
  VectorXd values(count);
  for (double& value : values) value = random.normal();
  return values;
}

// A process of standard deviation 0.1 px on positions over the image and at eight marks, which are measured to 0.02 px.
class Film : public ::testing::Test {
 protected:
  static constexpr double kSigma_px = 0.1, kCorrelation_px = 200, kMark_px = 0.02;
  static constexpr int kGrid = 14;

  Film() {
    for (const double x : {-30.0, 500.0, 1030.0})
      for (const double y : {-30.0, 500.0, 1030.0})
        if (x != 500 || y != 500) marks_.push_back({x, y});
    for (int i = 0; i < kGrid; ++i)
      for (int k = 0; k < kGrid; ++k) positions_.push_back({1000 * (i + 0.5) / kGrid, 1000 * (k + 0.5) / kGrid});
    const auto grid = Index(positions_.size());
    positions_.insert(positions_.end(), marks_.begin(), marks_.end());
    const auto all = Index(positions_.size());
    MatrixXd c(all, all);
    for (Index i = 0; i < all; ++i)
      for (Index k = 0; k < all; ++k)
        c(i, k) = kSigma_px * kSigma_px *
                  std::exp(-0.5 * (positions_[std::size_t(i)] - positions_[std::size_t(k)]).squaredNorm() /
                           (kCorrelation_px * kCorrelation_px));
    c.diagonal().array() += 1e-12;  // of the last digits
    root_ = c.llt().matrixL();
    MatrixXd functions(grid, Index(kFilmFunctions));
    affinity_.resize(all, 3);
    for (Index i = 0; i < all; ++i) {
      affinity_.row(i) << 1, positions_[std::size_t(i)].x() / 1000, positions_[std::size_t(i)].y() / 1000;
      if (i < grid) functions.row(i) = film_functions(kSize, positions_[std::size_t(i)]).transpose();
    }
    fit_ = functions.completeOrthogonalDecomposition().pseudoInverse();
    by_marks_ = affinity_.bottomRows(8).completeOrthogonalDecomposition().pseudoInverse();
  }

  // A scan with the functions that it truly has: of the process, less the affinity that its marks were given.
  FilmMoments scan(Random& random) const {
    FilmMoments made{.values = VectorXd(2 * kFilmFunctions),
                     .covariance = MatrixXd::Zero(2 * kFilmFunctions, 2 * kFilmFunctions)};
    made.prior = {.sigma_px = kSigma_px, .correlation_px = kCorrelation_px, .mark_sigma_px = kMark_px};
    for (const Vector2d& mark : marks_) made.prior.marks.push_back({mark, Vector2d::Zero()});
    const Index grid = Index(positions_.size()) - 8;
    for (Index axis = 0; axis < 2; ++axis) {
      const VectorXd z = root_ * normals(root_.rows(), random), measured = z.tail(8) + kMark_px * normals(8, random);
      const VectorXd affine = by_marks_ * measured;
      const VectorXd values = fit_ * (z.head(grid) - affinity_.topRows(grid) * affine);
      for (Index k = 0; k < values.size(); ++k) made.values[2 * k + axis] = values[k];
      const VectorXd residuals = measured - affinity_.bottomRows(8) * affine;
      for (Index i = 0; i < 8; ++i) made.prior.marks[std::size_t(i)].offset_px[axis] = residuals[i];
    }
    return made;
  }

  std::vector<Vector2d> marks_, positions_;
  MatrixXd root_, fit_, affinity_, by_marks_;
};

TEST(FilmFunctions, AreThoseOfTheSetInItsOrder) {
  const Vector2d pixel(312, 777);
  AdditionalEffect effect;
  additional_effect(AdditionalSet::kFilm, kSize, pixel, effect);
  const auto functions = film_functions(kSize, pixel);
  for (std::size_t k = 0; k < kFilmFunctions; ++k) {
    EXPECT_EQ(effect.column[2 * k], functions[Index(k)]);
    EXPECT_EQ(effect.row[2 * k + 1], functions[Index(k)]);
    EXPECT_EQ(effect.column[2 * k + 1], 0);
    EXPECT_EQ(effect.row[2 * k], 0);
  }
}

// Orthogonal over the image, with a mean square of 1 / ((2 i + 1) (2 j + 1)): by sums over positions of Gauss's rule,
// which are exact to the degree 13.
TEST(FilmFunctions, AreOrthogonalOverTheImage) {
  constexpr double kAt[7] = {0,
                             0.4058451513773972,
                             0.7415311855993945,
                             0.9491079123427585,
                             -0.4058451513773972,
                             -0.7415311855993945,
                             -0.9491079123427585};
  constexpr double kWeight[7] = {0.4179591836734694, 0.3818300505051189, 0.2797053914892766, 0.1294849661688697,
                                 0.3818300505051189, 0.2797053914892766, 0.1294849661688697};
  MatrixXd products = MatrixXd::Zero(kFilmFunctions, kFilmFunctions);
  for (int i = 0; i < 7; ++i)
    for (int k = 0; k < 7; ++k) {
      const auto f = film_functions(kSize, {500 + 500 * kAt[i], 500 + 500 * kAt[k]});
      products += 0.25 * kWeight[i] * kWeight[k] * f * f.transpose();
    }
  Index number = 0;
  for (int degree = 0; degree <= 6; ++degree)
    for (int i = 0; i <= degree; ++i, ++number)
      EXPECT_NEAR(products(number, number), 1.0 / ((2 * i + 1) * (2 * (degree - i) + 1)), 1e-12);
  products.diagonal().setZero();
  EXPECT_LT(products.cwiseAbs().maxCoeff(), 1e-12);
}

// Mean and covariance given the marks tell the truth: (a - m)' C^-1 (a - m) is chi-squared with 28 degrees of freedom
// for each coordinate, its mean over n has the standard deviation sqrt(56 / n). What marks know is worth something:
// without their residuals the squares would be larger than they are by the variance that these explain.
TEST_F(Film, FieldGivenTheMarksMatchesTheRealDeformation) {
  Random random(3);
  constexpr int kScans = 200;
  double squares = 0, around_zero = 0, around_mean = 0;
  for (int i = 0; i < kScans; ++i) {
    const FilmMoments made = scan(random);
    const FilmField field = film_field(made.prior, film_shape(made.prior, kSize, kCorrelation_px));
    const Eigen::LLT<MatrixXd> factor(field.covariance);
    ASSERT_EQ(factor.info(), Eigen::Success);
    for (Index axis = 0; axis < 2; ++axis) {
      VectorXd error(kFilmFunctions);
      for (Index k = 0; k < error.size(); ++k) error[k] = made.values[2 * k + axis];
      around_zero += error.squaredNorm();
      error -= axis == 0 ? field.column : field.row;
      around_mean += error.squaredNorm();
      squares += factor.matrixL().solve(error).squaredNorm();
    }
  }
  EXPECT_NEAR(squares / (2 * kScans), 28, 4 * std::sqrt(56.0 / (2 * kScans)));
  EXPECT_LT(around_mean, 0.9 * around_zero);
}

// A variance from r residuals is known to sqrt(2 / r) of itself: 2 x 5 of each scan, correlated a little.
TEST_F(Film, MarksAloneFindTheStandardDeviation) {
  Random random(5);
  std::vector<FilmPrior> scans;
  for (int i = 0; i < 400; ++i) scans.push_back(scan(random).prior);
  const auto sigma_px = sigma_by_marks(scans, kSize, kCorrelation_px);
  ASSERT_TRUE(sigma_px);
  EXPECT_NEAR(*sigma_px, kSigma_px, 4 * kSigma_px * std::sqrt(0.5 / (10 * 400)) * 1.2);
  for (FilmPrior& one : scans)
    for (FilmMarkOffset& mark : one.marks) mark.offset_px *= 0.1;  // less than errors of measurement
  EXPECT_FALSE(sigma_by_marks(scans, kSize, kCorrelation_px));
}

// Functions that are known exactly and marks: of 2 x 33 normal values of each scan the standard deviation is known to
// sqrt(1 / (2 x 66 n)) of itself at best and the length is known with it; three times that leaves it room.
TEST_F(Film, TheLikeliestProcessIsTheTrueOne) {
  Random random(9);
  std::vector<FilmMoments> scans;
  for (int i = 0; i < 40; ++i) {
    scans.push_back(scan(random));
    scans.back().prior.sigma_px = 0.05;  // where it begins
    scans.back().prior.correlation_px = 80;
  }
  const FilmProcess found = likeliest_process(scans, kSize);
  EXPECT_NEAR(found.sigma_px / kSigma_px, 1, 0.1);
  EXPECT_NEAR(found.correlation_px / kCorrelation_px, 1, 0.05);
  for (FilmMoments& one : scans) one.prior.sigma_is_given = one.prior.correlation_is_given = true;
  const FilmProcess given = likeliest_process(scans, kSize);
  EXPECT_EQ(given.sigma_px, 0.05);
  EXPECT_EQ(given.correlation_px, 80);
}

TEST_F(Film, WithoutMarksTheWholeProcessIsInTheImage) {
  FilmPrior prior{.sigma_px = kSigma_px, .correlation_px = 1e7};  // a shift of the whole image
  const FilmField field = film_field(prior, film_shape(prior, kSize, prior.correlation_px));
  EXPECT_NEAR(field.covariance(0, 0), kSigma_px * kSigma_px, 1e-5);
  EXPECT_LT(field.covariance(1, 1), 1e-5);
  EXPECT_EQ(field.column.norm(), 0);
}

}  // namespace
}  // namespace collinea
