// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/io/text.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string list_of(const std::vector<double>& numbers) {
  std::string text;
  for (const double n : numbers) text += (text.empty() ? "" : ",") + exact(n);
  return text;
}

std::string numbers_of(const RotationReport::Form& form) {
  std::vector<double> values;
  for (const auto& [name, value] : form.values) values.push_back(value);
  return list_of(values);
}

const ConvertRotationOptions kGiven{
    .unit = AngleUnit::kGon, .sigmas = "0.02,0.01,0.03", .correlations = "0.5,-0.2,0.3"};
constexpr const char* kAngles = "20,-30,130";
constexpr RotationForm kForms[] = {RotationForm::kCardan,   RotationForm::kEuler,     RotationForm::kTopographic,
                                   RotationForm::kGeodetic, RotationForm::kRodrigues, RotationForm::kQuaternion};

// What a form states of itself gives back what was stated of the angles.
TEST(RotationSigmas, EveryFormLeadsBackToTheOthers) {
  const auto first = convert_rotation(kAngles, kGiven);
  ASSERT_TRUE(first) << first.error().message;
  const MatrixXd& given = first->forms[0].covariance;
  ASSERT_EQ(given.rows(), 3);
  EXPECT_NEAR(std::sqrt(given(2, 2)), 0.03, 1e-12);
  EXPECT_NEAR(given(0, 1), 0.5 * 0.02 * 0.01, 1e-14);
  for (std::size_t k = 0; k < std::size(kForms); ++k) {
    const RotationReport::Form& form = first->forms[k];
    const VectorXd sigma = form.covariance.diagonal().cwiseSqrt();
    std::vector<double> correlations;
    for (Eigen::Index i = 0; i < sigma.size(); ++i)
      for (Eigen::Index j = i + 1; j < sigma.size(); ++j)
        correlations.push_back(form.covariance(i, j) / (sigma[i] * sigma[j]));
    ConvertRotationOptions options = kGiven;
    options.from = kForms[k];
    options.sigmas = list_of({sigma.data(), sigma.data() + sigma.size()});
    options.correlations = list_of(correlations);
    const auto back = convert_rotation(numbers_of(form), options);
    ASSERT_TRUE(back) << form.name << back.error().message;
    EXPECT_LT((back->forms[0].covariance - given).norm(), 1e-9 * given.norm()) << form.name;
    EXPECT_LT((*back->sigma_matrix - *first->sigma_matrix).norm(), 1e-9 * first->sigma_matrix->norm()) << form.name;
  }
}

// 400 draws of the angles: the mean of chi-squared/3 of each form of three numbers scatters by sqrt(2 / 3 / 400).
TEST(RotationSigmas, CovariancesMatchTheSpread) {
  constexpr int kDraws = 400;
  const auto first = convert_rotation(kAngles, kGiven);
  ASSERT_TRUE(first);
  const MatrixXd root = first->forms[0].covariance.llt().matrixL();
  Random random(3);
  std::vector<double> sums(5, 0);
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::Vector3d error = root * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    const auto drawn = convert_rotation(list_of({20 + error[0], -30 + error[1], 130 + error[2]}), kGiven);
    ASSERT_TRUE(drawn);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      Eigen::Vector3d off;
      for (std::size_t i = 0; i < 3; ++i)
        off[Eigen::Index(i)] = drawn->forms[k].values[i].second - first->forms[k].values[i].second;
      sums[k] += off.dot(first->forms[k].covariance.ldlt().solve(off)) / 3 / kDraws;
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k)
    EXPECT_NEAR(sums[k], 1, 4 * std::sqrt(2.0 / 3 / kDraws)) << first->forms[k].name;
}

TEST(RotationSigmas, ASingularFormHasNoneAndWhatIsNoCovarianceIsRefused) {
  ConvertRotationOptions options{.sigmas = "0.1,0.1,0.1"};
  const auto singular = convert_rotation("0,90,0", options);
  ASSERT_TRUE(singular);
  EXPECT_EQ(singular->forms[0].covariance.size(), 0);
  EXPECT_EQ(singular->forms[5].covariance.rows(), 4);
  options.correlations = "0.9,0.9,-0.9";
  EXPECT_FALSE(convert_rotation("1,2,3", options));
  options = {.sigmas = "0.1,-0.1,0.1"};
  EXPECT_FALSE(convert_rotation("1,2,3", options));
  options = {.sigmas = "0.1,0.1"};
  EXPECT_FALSE(convert_rotation("1,2,3", options));
  options = {.correlations = "0,0,0"};
  EXPECT_FALSE(convert_rotation("1,2,3", options));
}

}  // namespace
}  // namespace collinea
