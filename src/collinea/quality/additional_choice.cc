// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/additional_choice.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/math/fisher.h"

namespace collinea {
namespace {

constexpr double kWeak = 0.005;  // of the focal length
constexpr int kGrid = 20;

std::vector<int> spanned_by(AdditionalSet set) {
  using C = Camera;
  if (set == AdditionalSet::kNone || set == AdditionalSet::kFourier || set == AdditionalSet::kFilm) return {};
  if (set == AdditionalSet::kEbner) return {C::kB1, C::kB2, C::kP1, C::kP2};
  return {C::kB1, C::kB2, C::kP1, C::kP2, C::kK1};
}

// Estimates and cofactors of some unknowns, from which unknowns can be taken as if they were zero.
struct Estimate {
  std::vector<int> params;
  Eigen::VectorXd value;
  Eigen::MatrixXd cofactor;

  [[nodiscard]] double t(int i, double sigma0) const { return value[i] / (sigma0 * std::sqrt(cofactor(i, i))); }
  void drop(int i) {
    const auto last = Eigen::Index(params.size()) - 1;
    const Eigen::VectorXd by = cofactor.col(i) / cofactor(i, i);
    value -= by * value[i];
    cofactor -= by * cofactor.row(i).eval();
    for (Eigen::Index k = i; k < last; ++k) {
      value[k] = value[k + 1];
      cofactor.row(k) = cofactor.row(k + 1).eval();
    }
    for (Eigen::Index k = i; k < last; ++k) cofactor.col(k) = cofactor.col(k + 1).eval();
    value.conservativeResize(last);
    cofactor.conservativeResize(last, last);
    params.erase(params.begin() + i);
  }
  // F of all being zero.
  [[nodiscard]] double f(double sigma0) const {
    if (params.empty()) return 0;
    return value.dot(cofactor.ldlt().solve(value)) / (double(params.size()) * sigma0 * sigma0);
  }
};

Estimate part(const Camera& camera, const MatrixPd& covariance, const std::vector<int>& params) {
  const auto n = Eigen::Index(params.size());
  Estimate part{params, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  for (Eigen::Index a = 0; a < n; ++a) {
    part.value[a] = camera.params[std::size_t(params[std::size_t(a)])];
    for (Eigen::Index b = 0; b < n; ++b)
      part.cofactor(a, b) = covariance(params[std::size_t(a)], params[std::size_t(b)]);
  }
  return part;
}

double largest_shift_px(const Camera& camera, int param) {
  std::array<double, kMostAdditional> one{};
  one[std::size_t(param - Camera::kParams)] = camera.params[std::size_t(param)];
  double largest = 0;
  for (int i = 0; i <= kGrid; ++i)
    for (int k = 0; k <= kGrid; ++k)
      largest = std::max(
          largest, additional_shift(camera.additional, one.data(), {double(camera.width_px), double(camera.height_px)},
                                    {double(i) * camera.width_px / kGrid, double(k) * camera.height_px / kGrid})
                       .shift_px.norm());
  return largest;
}

// How the i-th of all free parameters goes with the others.
void correlate(const Estimate& all, const Eigen::MatrixXd& inverse, int i, AdditionalParameter& parameter) {
  for (int k = 0; k < int(all.params.size()); ++k) {
    if (k == i) continue;
    const double correlation = all.cofactor(i, k) / std::sqrt(all.cofactor(i, i) * all.cofactor(k, k));
    if (parameter.partner >= 0 && !(std::abs(correlation) > std::abs(parameter.correlation))) continue;
    parameter.partner = all.params[std::size_t(k)];
    parameter.correlation = correlation;
  }
  const double alone = 1 / (all.cofactor(i, i) * inverse(i, i));  // share of the variance without the others
  parameter.multiple_correlation = std::sqrt(std::clamp(1 - alone, 0.0, 1.0));
}

AdditionalTest tested(CameraId id, const Camera& camera, const MatrixPd& covariance, double sigma0, double redundancy,
                      double level) {
  AdditionalTest test{.camera = id};
  std::vector<int> free, additional;
  for (const int k : params_of(camera)) {
    if (!(covariance(k, k) > 0)) continue;
    free.push_back(k);
    if (k >= Camera::kParams) additional.push_back(k);
  }
  const Estimate all = part(camera, covariance, free);
  const Eigen::MatrixXd inverse = all.cofactor.inverse();
  Estimate left = part(camera, covariance, additional);
  test.f = left.f(sigma0);
  test.chance = additional.empty() ? 1 : fisher_tail(test.f, double(additional.size()), redundancy);
  for (int i = 0; i < int(additional.size()); ++i) {
    AdditionalParameter one{.param = additional[std::size_t(i)]};
    one.value_px = left.value[i];
    one.sigma_px = sigma0 * std::sqrt(left.cofactor(i, i));
    one.chance = student_tail(left.t(i, sigma0), redundancy);
    one.significant = one.chance < level;
    one.largest_px = largest_shift_px(camera, one.param);
    correlate(all, inverse, int(std::ranges::find(free, one.param) - free.begin()), one);
    test.parameters.push_back(one);
  }
  std::vector<int> dropped;
  while (!left.params.empty()) {
    int weakest = 0;
    for (int i = 1; i < int(left.params.size()); ++i)
      if (std::abs(left.t(i, sigma0)) < std::abs(left.t(weakest, sigma0))) weakest = i;
    if (student_tail(left.t(weakest, sigma0), redundancy) < level) break;
    dropped.push_back(left.params[std::size_t(weakest)]);
    left.drop(weakest);
  }
  test.kept = int(left.params.size());
  for (AdditionalParameter& one : test.parameters)
    one.keep = std::ranges::find(left.params, one.param) != left.params.end();
  if (!dropped.empty()) {
    test.dropped_f = part(camera, covariance, dropped).f(sigma0);
    test.dropped_chance = fisher_tail(test.dropped_f, double(dropped.size()), redundancy);
  }
  return test;
}

}  // namespace

std::optional<CameraSigmas> with_additional(CameraSigmas sigmas, const Camera& camera,
                                            const std::vector<std::string>& fixed) {
  for (const int k : spanned_by(camera.additional)) sigmas[std::size_t(k)] = 0;
  for (std::size_t k = 0; k < count_of(camera.additional); ++k) sigmas[Camera::kParams + k] = kWeak * camera.focal_px();
  for (const std::string& name : fixed) {
    const auto param = param_named(camera, name);
    if (!param || *param < Camera::kParams) return std::nullopt;
    sigmas[std::size_t(*param)] = 0;
  }
  return sigmas;
}

std::vector<AdditionalTest> test_additional(const Block& block, const Examined& adjusted, bool sigma0_known,
                                            double level) {
  std::vector<AdditionalTest> tests;
  for (const auto& [id, covariance] : adjusted.camera_covariance) {
    const auto found = adjusted.cameras.find(id);
    const Camera& camera = found == adjusted.cameras.end() ? block.cameras.at(id) : found->second;
    if (is_deformed_film(camera)) continue;  // of one scan, and expected
    if (camera.additional == AdditionalSet::kNone || covariance.rows() <= Camera::kParams) continue;
    const double redundancy =
        sigma0_known || adjusted.redundancy < 1 ? std::numeric_limits<double>::infinity() : double(adjusted.redundancy);
    AdditionalTest test = tested(id, camera, covariance, sigma0_known ? 1 : adjusted.sigma0, redundancy, level);
    if (!test.parameters.empty()) tests.push_back(std::move(test));
  }
  return tests;
}

}  // namespace collinea
