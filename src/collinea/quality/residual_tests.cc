// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/residual_tests.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "collinea/math/normal.h"
#include "collinea/math/series_tests.h"
#include "collinea/quality/internal/image_order.h"
#include "collinea/quality/internal/tie_marginal.h"

namespace collinea {
namespace {

using Kind = ResidualTestKind;
using Series = ResidualSeries;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastRedundancy = 0.05;  // below, a residual is mostly rounding and what others say
constexpr std::size_t kLeastInImage = 30, kLeastOfStrip = 12;
constexpr long kLeastOfSeries = 8, kLeastForDistribution = 20;
constexpr double kMedianDistance = 0.8276;  // of Kolmogorov's distribution
constexpr double kAlikeEnough = 0.1;        // correlation of neighbours from which it is worth a finding,
constexpr double kFarEnough = 0.02;         // and distance from a distribution

// The ray by which a tie point takes part, NaN on axes that little checks.
struct ChosenRay {
  ImageId image;
  Eigen::Vector2d pixel, residual_px, w;
  int rays = 0;  // of its point
};

std::uint32_t scattered(std::uint32_t number) {
  number = (number ^ (number >> 16)) * 0x45d9f3bu;
  number = (number ^ (number >> 16)) * 0x45d9f3bu;
  return number ^ (number >> 16);
}

std::vector<ChosenRay> chosen_rays(const Block& block, const Examined& adjusted) {
  std::vector<ChosenRay> chosen;
  if (!adjusted.reliability) return chosen;
  const std::vector<std::uint32_t>& used = adjusted.observations;
  const double sigma0 = adjusted.reliability->sigma0_known ? 1 : sigma_scale(adjusted);
  for (std::size_t begin = 0, end = 0; begin < used.size(); begin = end) {
    const PointId point = block.observations[used[begin]].point;
    while (end < used.size() && block.observations[used[end]].point == point) ++end;
    const std::size_t at = begin + scattered(point.value) % (end - begin);
    const Observation& seen = block.observations[used[at]];
    ChosenRay ray{seen.image, seen.pixel, adjusted.residuals_px[at], {kNaN, kNaN}, static_cast<int>(end - begin)};
    for (int axis = 0; axis < 2; ++axis)
      if (const double r = adjusted.reliability->tie_redundancy[at][axis]; r > kLeastRedundancy)
        ray.w[axis] = ray.residual_px[axis] / (sigma0 * seen.sigma_px * std::sqrt(r));
    chosen.push_back(ray);
  }
  return chosen;
}

double rms_of(const std::vector<double>& values) {
  double squares = 0, count = 0;
  for (const double value : values)
    if (std::isfinite(value)) squares += value * value, count += 1;
  return count > 0 ? std::sqrt(squares / count) : 0;
}

// Gathers the tests, without those of too few residuals.
class ResidualTester {
 public:
  ResidualTester(const Block& block, const Examined& adjusted, std::span<const std::map<ImageId, double>> strips)
      : block_(block), adjusted_(adjusted), order_(order_flown(block, strips)) {
    for (const auto& strip : strips) {
      std::vector<ImageId>& images = strips_.emplace_back();
      images = images_of_strip(strip);
    }
    if (strips_.size() < 2) strips_.clear();
  }

  std::vector<ResidualTest> tests(double level) {
    test_positions();
    const std::vector<ChosenRay> rays = chosen_rays(block_, adjusted_);
    test_means(rays);
    test_images(rays);
    test_distributions(rays);
    correct_for_number(level);
    return std::move(tests_);
  }

 private:
  void add(ResidualTest test) {
    if (test.count >= kLeastOfSeries) tests_.push_back(std::move(test));
  }

  // Of one order of images; `residual` in the unit of people, for its size.
  void test_order(Series series, int axis, std::optional<int> strip, const std::vector<double>& values,
                  const std::vector<double>& residual) {
    const bool alike_only = series == Series::kImageMeans;
    ResidualTest test{.series = series, .axis = axis, .strip = strip, .rms = rms_of(residual)};
    const SignChanges signs = sign_changes(values);
    test.kind = Kind::kRuns;
    test.count = signs.pairs;
    test.value = double(signs.changes);
    test.expected = double(signs.pairs) / 2;
    test.correlation = signs.correlation();
    test.p_value = alike_only ? signs.few_p_value() : signs.p_value();
    add(test);
    const LagOne lag = lag_one(values);
    test.kind = Kind::kAutocorrelation;
    test.count = lag.pairs;
    test.value = test.correlation = lag.correlation;
    test.expected = 0;
    test.p_value = lag.p_value();
    if (alike_only) test.p_value = lag.correlation > 0 ? test.p_value / 2 : 1 - test.p_value / 2;
    add(test);
  }

  // In the whole order flown and in each strip that is long enough. value_of: of an image, with its residual.
  template <class ValueOf>
  void test_orders(Series series, int axis, ValueOf&& value_of) {
    const auto test_images_of = [&](const std::vector<ImageId>& images, std::optional<int> strip) {
      std::vector<double> values, residuals;
      for (const ImageId image : images)
        if (const auto [value, residual] = value_of(image); std::isfinite(residual)) {
          values.push_back(value);
          residuals.push_back(residual);
        }
      test_order(series, axis, strip, values, residuals);
    };
    test_images_of(order_, std::nullopt);
    for (std::size_t strip = 0; strip < strips_.size(); ++strip)
      if (strips_[strip].size() >= kLeastOfStrip) test_images_of(strips_[strip], int(strip));
  }

  void test_positions() {
    std::map<ImageId, const WhitenedPosition*> its;
    for (const WhitenedPosition& one : adjusted_.whitened_positions) its[one.image] = &one;
    if (its.empty()) return;
    for (int axis = 0; axis < 3; ++axis) {
      test_orders(Series::kPositions, axis, [&](ImageId image) {
        const auto found = its.find(image);
        return found == its.end() ? std::pair(kNaN, kNaN)
                                  : std::pair(found->second->whitened[axis], found->second->residual_m[axis]);
      });
      std::vector<double> values, residuals;
      for (const auto& [image, one] : its)
        if (std::isfinite(one->whitened[axis])) {
          values.push_back(one->whitened[axis]);
          residuals.push_back(one->residual_m[axis]);
        }
      test_normal(Series::kPositions, axis, values, residuals);
    }
  }

  void test_means(const std::vector<ChosenRay>& rays) {
    struct Sums {
      double w = 0, px = 0, n = 0;
    };
    for (int axis = 0; axis < 2; ++axis) {
      std::map<ImageId, Sums> sums;
      for (const ChosenRay& ray : rays)
        if (std::isfinite(ray.w[axis])) {
          Sums& its = sums[ray.image];
          its.w += ray.w[axis];
          its.px += ray.residual_px[axis];
          its.n += 1;
        }
      test_orders(Series::kImageMeans, axis, [&](ImageId image) {
        const auto its = sums.find(image);
        return its == sums.end() ? std::pair(kNaN, kNaN)
                                 : std::pair(its->second.w / std::sqrt(its->second.n), its->second.px / its->second.n);
      });
    }
  }

  // Rays of an image one after another: in bands as wide as rays are apart, to and fro.
  void sort_in_bands(std::vector<const ChosenRay*>& rays, const Camera& camera) const {
    const double apart = std::sqrt(double(camera.width_px) * camera.height_px / double(rays.size()));
    const auto key = [&](const ChosenRay* ray) {
      const double band = std::floor(ray->pixel.y() / apart);
      return std::tuple(band, std::fmod(band, 2) == 0 ? ray->pixel.x() : -ray->pixel.x());
    };
    std::ranges::stable_sort(rays, {}, key);
  }

  void test_images(const std::vector<ChosenRay>& rays) {
    std::map<ImageId, std::vector<const ChosenRay*>> by_image;
    for (const ChosenRay& ray : rays) by_image[ray.image].push_back(&ray);
    struct Sums {
      std::array<SignChanges, 2> signs;
      std::array<std::vector<double>, 2> residuals;
    };
    std::map<CameraId, Sums> cameras;
    for (auto& [image, its] : by_image) {
      const CameraId id = block_.common_camera(block_.images.at(image).camera);
      const Camera& camera = block_.cameras.at(id);
      if (its.size() < kLeastInImage || camera.width_px <= 0 || camera.height_px <= 0) continue;
      sort_in_bands(its, camera);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        std::vector<double> values;
        for (const ChosenRay* ray : its)
          if (const double w = ray->w[Eigen::Index(axis)]; std::isfinite(w)) {
            values.push_back(w);
            cameras[id].residuals[axis].push_back(ray->residual_px[Eigen::Index(axis)]);
          }
        cameras[id].signs[axis] += sign_changes(values);
      }
    }
    for (const auto& [id, sums] : cameras)
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const SignChanges& signs = sums.signs[axis];
        add({.kind = Kind::kRuns,
             .series = Series::kInImages,
             .axis = int(axis),
             .camera = id,
             .count = signs.pairs,
             .value = double(signs.changes),
             .expected = double(signs.pairs) / 2,
             .correlation = signs.correlation(),
             .rms = rms_of(sums.residuals[axis]),
             .p_value = signs.few_p_value()});
      }
  }

  void test_distribution(Kind kind, Series series, int axis, std::vector<double> probabilities, double rms) {
    const Kolmogorov found = kolmogorov(std::move(probabilities));
    if (found.count < kLeastForDistribution) return;
    add({.kind = kind,
         .series = series,
         .axis = axis,
         .count = found.count,
         .value = found.distance,
         .expected = kMedianDistance / std::sqrt(double(found.count)),
         .rms = rms,
         .p_value = found.p_value()});
  }

  // Of their own scale.
  void test_normal(Series series, int axis, const std::vector<double>& values, const std::vector<double>& residuals) {
    const double scale = rms_of(values);
    if (!(scale > 0)) return;
    std::vector<double> probabilities;
    for (const double value : values) probabilities.push_back(normal_probability(value / scale));
    test_distribution(Kind::kNormal, series, axis, std::move(probabilities), rms_of(residuals));
  }

  void test_distributions(const std::vector<ChosenRay>& rays) {
    if (rays.empty()) return;
    const TieErrors& errors = adjusted_.reliability->tie_errors;
    std::vector<TieMarginal> marginals;
    bool any_other = false;
    for (const TieErrors::Class& one : errors.classes) {
      any_other |= !one.distribution.is_normal() || one.distribution.scale != 1;
      marginals.emplace_back(one.distribution);
    }
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> values, residuals, probabilities;
      for (const ChosenRay& ray : rays) {
        if (!std::isfinite(ray.w[axis])) continue;
        values.push_back(ray.w[axis]);
        residuals.push_back(ray.residual_px[axis]);
        if (any_other) probabilities.push_back(marginals[*errors.class_of(ray.rays)](ray.w[axis]));
      }
      test_normal(Series::kTiePoints, axis, values, residuals);
      if (any_other)
        test_distribution(Kind::kTieErrors, Series::kTiePoints, axis, std::move(probabilities), rms_of(residuals));
    }
  }

  void correct_for_number(double level) {
    std::vector<double> p_values;
    for (const ResidualTest& test : tests_) p_values.push_back(test.p_value);
    const std::vector<double> corrected = holm(p_values);
    for (std::size_t i = 0; i < tests_.size(); ++i) {
      tests_[i].p_corrected = corrected[i];
      tests_[i].significant = corrected[i] < level;
    }
  }

  const Block& block_;
  const Examined& adjusted_;
  std::vector<ImageId> order_;
  std::vector<std::vector<ImageId>> strips_;
  std::vector<ResidualTest> tests_;
};

// Whether a significant test is also of a size that matters. That ties are not normal is taken care of where they are
// tested by the distribution that they have.
bool is_worth_a_finding(const ResidualTest& test, bool ties_modelled) {
  if (!test.significant) return false;
  switch (test.kind) {
    case Kind::kRuns:
    case Kind::kAutocorrelation:
      return std::abs(test.correlation) > kAlikeEnough;
    case Kind::kNormal:
      return test.value > kFarEnough && !(ties_modelled && test.series == Series::kTiePoints);
    case Kind::kTieErrors:
      return test.value > kFarEnough;
  }
  return false;
}

FindingCode code_of(const ResidualTest& test) {
  if (test.kind == Kind::kNormal || test.kind == Kind::kTieErrors) return FindingCode::kResidualDistribution;
  return test.series == Series::kPositions ? FindingCode::kPositionsInOrder : FindingCode::kImageResidualsAlike;
}

Finding finding_of_test(const ResidualTest& test) {
  const Aspect aspect = test.series == Series::kPositions ? Aspect::kPosition : Aspect::kWhole;
  Subject subject(SubjectKind::kBlock, Subject::kAll, aspect, test.axis);
  if (test.strip) subject = Subject(SubjectKind::kStrip, static_cast<std::uint32_t>(*test.strip), aspect, test.axis);
  if (test.camera) subject = Subject(*test.camera, aspect, test.axis);
  Finding finding = finding_of(code_of(test), {subject});
  finding.figures.push_back({FigureName::kCount, double(test.count)});
  if (finding.code == FindingCode::kResidualDistribution)
    finding.figures.push_back({FigureName::kShare, test.value});
  else
    finding.figures.push_back({FigureName::kCorrelation, test.correlation});
  finding.figures.push_back({FigureName::kChance, test.p_corrected});
  finding.figures.push_back({test.series == Series::kPositions ? FigureName::kSigma : FigureName::kSigmaPx, test.rms});
  if (finding.code == FindingCode::kPositionsInOrder)
    finding.remedies = {OptionName{"time_offset", ""}, OptionName{"position_shift", "", "strips"},
                        OptionName{"position_drift", ""}};
  else if (finding.code == FindingCode::kImageResidualsAlike)
    finding.remedies = {RemedyCode::kSeeAdjustment, RemedyCode::kHoldStill};
  else if (test.series == Series::kPositions)
    finding.remedies = {OptionName{"loss", "", "huber"}, RemedyCode::kSeeAdjustment};
  else
    finding.remedies = {OptionName{"reject_mismatches", ""}, OptionName{"loss", "", "huber"}};
  return finding;
}

}  // namespace

std::vector<ResidualTest> residual_tests(const Block& block, const Examined& adjusted,
                                         std::span<const std::map<ImageId, double>> strips, double level) {
  return ResidualTester(block, adjusted, strips).tests(level);
}

std::vector<Finding> residual_findings(const std::vector<ResidualTest>& tests) {
  const bool ties_modelled =
      std::ranges::any_of(tests, [](const ResidualTest& test) { return test.kind == Kind::kTieErrors; });
  std::map<std::tuple<FindingCode, Series, std::optional<CameraId>>, const ResidualTest*> worst;
  for (const ResidualTest& test : tests) {
    if (!is_worth_a_finding(test, ties_modelled)) continue;
    const ResidualTest*& so_far = worst[{code_of(test), test.series, test.camera}];
    if (!so_far || test.p_value < so_far->p_value) so_far = &test;
  }
  std::vector<Finding> findings;
  for (const auto& [key, test] : worst) findings.push_back(finding_of_test(*test));
  return findings;
}

}  // namespace collinea
