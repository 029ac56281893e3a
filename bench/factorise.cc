// SPDX-License-Identifier: Apache-2.0
// Self-calibration from measurements alone over many random surveys: how often it is found, whether its covariance is
// true, and what each part takes.
// usage: collinea_bench_factorise
#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "collinea/epipolar/self_calibration.h"
#include "collinea/epipolar/survey_for_tests.h"

namespace collinea {
namespace {

constexpr int kSurveys = 200;
constexpr double kWithin = 11.0705;  // 95 % of chi-squared with 5 degrees of freedom

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void judge(std::size_t images, double sigma) {
  int found = 0, within = 0;
  double chi = 0, milliseconds = 0;
  std::vector<double> off_pairs, off_upgrade, off_bundles, stated;
  for (int seed = 1; seed <= kSurveys; ++seed) {
    const SelfCalibrationTruth truth = self_calibration_truth(
        {.images = images, .points = 40, .sigma = sigma, .seed = static_cast<std::uint64_t>(seed)});
    const Eigen::Vector2d middle(1500, 1000);
    const auto begin = std::chrono::steady_clock::now();
    const auto model = factorised(truth.measured);
    if (!model) continue;
    const auto upgrades = euclidean_upgrades(*model, middle, 1500, CalibrationUnknowns::kAll);
    const auto bundles = self_calibrated(*model, truth.measured, upgrades, CalibrationUnknowns::kAll, 1);
    milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    if (!bundles) continue;
    ++found;
    Eigen::Matrix3d start = Eigen::Matrix3d::Identity();
    start(0, 0) = start(1, 1) = 2600;
    start.topRightCorner<2, 1>() = middle;
    const auto by_pairs =
        calibration_from_fundamentals(fundamentals_of_pairs(truth.measured, middle), start, CalibrationUnknowns::kAll);
    if (by_pairs) off_pairs.push_back(std::abs((*by_pairs)(0, 0) - 3000));
    off_upgrade.push_back(std::abs(upgrades[0].bundles.calibration(0, 0) - 3000));
    const Eigen::Matrix3d off = bundles->bundles.calibration - truth.bundles.calibration;
    off_bundles.push_back(std::abs(off(0, 0)));
    const Eigen::Matrix<double, 5, 5> covariance = bundles->covariance.bottomRightCorner<5, 5>();
    stated.push_back(std::sqrt(covariance(0, 0)));
    Eigen::Matrix<double, 5, 1> error;
    error << off(0, 0), off(1, 1), off(0, 1), off(0, 2), off(1, 2);
    const double one = error.dot(covariance.ldlt().solve(error));
    chi += one;
    within += one < kWithin;
  }
  std::printf("| %zu | %.1f | %d of %d | %.2f | %.1f %% | %.1f | %.1f | %.1f | %.1f | %.1f |\n", images, sigma, found,
              kSurveys, chi / (5 * std::max(1, found)), 100.0 * within / std::max(1, found), median_of(off_pairs),
              median_of(off_upgrade), median_of(off_bundles), median_of(stated), milliseconds / kSurveys);
}

}  // namespace
}  // namespace collinea

int main() {
  std::printf(
      "| images | sigma [px] | found | chi2 / 5 | within 95 %% | c_x off by pairs [px] | by the upgrade | by the "
      "bundles | their sigma | ms |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t images : {3, 5, 8})
    for (const double sigma : {0.1, 0.3, 1.0}) collinea::judge(images, sigma);
}
