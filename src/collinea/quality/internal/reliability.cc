// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/reliability.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/base/parallel.h"
#include "collinea/math/quantiles.h"
#include "collinea/math/robust_squares.h"
#include "collinea/quality/internal/covariance.h"
#include "collinea/quality/internal/point_cofactor.h"
#include "collinea/quality/internal/point_rays.h"

namespace collinea {
namespace {

constexpr double kLeastRedundancy = 3;  // of a group: its factor is then known by 40 %

}  // namespace

double detectable_shift(const TestOptions& options) {
  const double quantile = options.power > 0.5 ? normal_limit(2 * (1 - options.power)) : 0;
  return normal_limit(options.false_alarm) + quantile;
}

// Sigmas given far too small make redundancy numbers small, and the residuals still say so.
double GroupSums::sigma_factor() const {
  const double factor = std::sqrt(std::max(squares, 0.0) / redundancy);
  return is_determined() || (redundancy >= kLeastRedundancy && factor > 1) ? factor : 1;
}

double GroupSums::relative_sigma() const { return 1 / std::sqrt(2 * squared_redundancy); }

bool GroupSums::is_determined() const { return squared_redundancy >= kLeastRedundancy; }

namespace bundle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoRedundancy = 1e-6;  // rounding of the selected inverse: nothing checks such an observation
constexpr std::size_t kMostSuspects = 1000;

int ray_count(const Problem& problem, std::size_t point) {
  return static_cast<int>(problem.end_ray(point) - problem.point(point).first_ray);
}

// sigma0 as it is estimated however small it is, not sigma_scale(), which is 1 where observations agree to rounding:
// tau compares residuals with each other, and one that stands out of rounding is a gross error all the same.
double sigma0_of_tests(const Adjusted& adjusted, bool sigma0_known) {
  return sigma0_known || adjusted.redundancy < 1 ? 1 : std::max(adjusted.sigma0, 1e-12);
}

// The standard deviation of what a measurement misses the others' prediction by, see Examiner::test().
double spread_of(double sigma, double own_sigma0, double sigma0, double leverage, double weight, double r) {
  return sigma * std::sqrt(own_sigma0 * own_sigma0 + sigma0 * sigma0 * leverage / (weight * r));
}

// What w of tie points is distributed like, over both coordinates. Those of a point with two rays say the same.
TieErrors shown_tie_errors(const Problem& problem, const State& state, const std::vector<Eigen::Matrix2d>& leverages,
                           double sigma0) {
  std::vector<RayError> errors;
  ImagePoint::for_each(problem, [&](const ImagePoint::Item& item) {
    const int rays = ray_count(problem, item.point);
    if (!ImagePoint::is_tie(problem, item) || (rays == 2 && item.ray != problem.point(item.point).first_ray)) return;
    const auto px = ImagePoint::residual(problem, state, item);
    if (!px) return;
    const Ray& ray = problem.rays[item.ray];
    const Eigen::Vector2d residual = ImagePoint::whitened(ray, *px, sigma0);
    const double weight = ImagePoint::loss(problem, item).weight(ImagePoint::squared(problem, item, *px));
    errors.push_back({checked_error(residual, Eigen::Matrix2d::Identity() - leverages[item.ray], weight), rays});
  });
  return fit_tie_errors(errors);
}

// The limit of |w|, and the shift of w that is found with the wanted power.
struct TestLimits {
  double limit = 0, delta0 = 0;
};

// Those of a class of tie points; as those of all else where its errors are normal.
TestLimits limits_of(const ErrorDistribution& w, const Reliability& tests) {
  if (w.is_normal() && w.scale == 1) return {tests.limit, tests.delta0};
  const double limit = w.limit(tests.false_alarm);
  return {limit, limit + (tests.power > 0.5 ? w.limit(2 * (1 - tests.power)) : 0)};
}

const PixelShape& shape_of(const TestedObservation& one, const Block& block) {
  return one.group == ObservationGroup::kTieImages ? block.observations[one.source].shape
                                                   : block.control_observations[one.source].shape;
}

// The two coordinates of an image point that are correlated, as they are tested: as those of correlated control, see
// Examiner::take_control(). With W of the whitening, P = W' W / s^2 and the hat matrix H of the whitened residuals W v
// / s the weight is p_ii, the residual (P v)_i / p_ii and the leverage (W' H W)_ii / (s^2 p_ii).
struct ShapedPoint {
  Eigen::Vector2d sigma, residual, leverage;
  Eigen::Vector2d redundancy;  // of each coordinate alone: the part of its variance that its residual has
  double squares = 0;

  ShapedPoint(const PixelShape& shape, const Eigen::Vector2d& px, double s, const Eigen::Matrix2d& hat) {
    const Eigen::Matrix2d w = shape.whitening(), root = w.inverse();
    const Eigen::Vector2d independent = w * px / s, weighted = w.transpose() * independent;
    squares = independent.squaredNorm();
    const Eigen::Matrix2d left = root * (Eigen::Matrix2d::Identity() - hat) * root.transpose();
    redundancy = left.diagonal().cwiseQuotient(shape.covariance().diagonal());
    for (int axis = 0; axis < 2; ++axis) {
      const double p = w.col(axis).squaredNorm();
      sigma[axis] = s / std::sqrt(p);
      residual[axis] = weighted[axis] * s / p;
      leverage[axis] = w.col(axis).dot(hat * w.col(axis)) / p;
    }
  }
};

// The hat matrix of each ray.
std::vector<Eigen::Matrix2d> leverages_of(const Problem& problem, const State& state, TileCholesky& inverse,
                                          const Run& run) {
  std::vector<Eigen::Matrix2d> leverages(problem.rays.size());
  parallel_for(run, problem.point_count(), [&](std::size_t p) {
    const std::vector<Eigen::Matrix2d> all = PointSystem(problem, state, p).leverages(inverse);
    for (std::size_t k = 0; k < all.size(); ++k) leverages[problem.point(p).first_ray + k] = all[k];
  });
  return leverages;
}

class Examiner {
 public:
  Examiner(const Solved& solved, const Adjusted& adjusted, const TestOptions& options, TileCholesky& inverse,
           const Run& run)
      : problem_(solved.problem()),
        state_(solved.state()),
        inverse_(inverse),
        run_(run),
        adjusted_(adjusted),
        tie_(problem_.tie_loss) {
    out_.false_alarm = options.false_alarm;
    out_.power = options.power;
    out_.sigma0_known = options.sigma0_known;
    const bool known = options.sigma0_known || adjusted.redundancy < 1;
    sigma0_ = sigma0_of_tests(adjusted, options.sigma0_known);
    out_.limit = known ? normal_limit(options.false_alarm) : tau_limit(options.false_alarm, adjusted.redundancy);
    out_.delta0 = detectable_shift(options);
    fits_ties_ = !options.normal_ties && !known;
  }

  Reliability examine(const Block& block) {
    leverages_ = leverages_of(problem_, state_, inverse_, run_);
    by_source_.assign(block.observations.size(), Eigen::Vector2d::Constant(kNaN));
    if (run_.stopped()) return out_;
    if (fits_ties_) {
      out_.tie_errors = shown_tie_errors(problem_, state_, leverages_, sigma0_);
      for (const TieErrors::Class& one : out_.tie_errors.classes)
        out_.tie_limits.push_back(tie_limits_.emplace_back(limits_of(one.distribution, out_)).limit);
    }
    ImagePoint::for_each(problem_, [&](const ImagePoint::Item& item) { take_image_point(item, block); });
    out_.tie_redundancy.reserve(adjusted_.observations.size());
    for (const std::uint32_t source : adjusted_.observations) out_.tie_redundancy.push_back(by_source_[source]);
    for_each_kind<kInTests>([&]<class Kind>() { take_kind<Kind>(); });
    sums(ObservationGroup::kTieImages).squares = tie_.squares();
    trim();
    return std::move(out_);
  }

 private:
  GroupSums& sums(ObservationGroup group) { return out_.groups[static_cast<std::size_t>(group)]; }

  // `leverage` in units of the observation's weight, which is `weight` times 1 / sigma^2 (not 1 by a robust loss).
  // The observation is tested as the others predict it, by its full sigma: v / r has the variance
  // sigma^2 (1 + h / (weight r)), which is sigma^2 / r without a loss. sigma0 multiplies what the others say, and the
  // sigmas of image points; those given in metres stay as given.
  void test(TestedObservation one, double leverage, double weight) {
    test(std::move(one), leverage, weight, {out_.limit, out_.delta0});
  }

  void test(TestedObservation one, double leverage, double weight, const TestLimits& limits) {
    const double r = std::clamp(1 - leverage, 0.0, 1.0);
    GroupSums& group = sums(one.group);
    ++group.observations;
    group.redundancy += 1 - leverage;
    group.squared_redundancy += r * r;
    out_.redundancy_sum += 1 - leverage;
    one.redundancy = r;
    one.limit = limits.limit;
    one.w = one.suspicion = 0;  // of the coordinate before
    one.minimal_detectable_bias = one.effect = one.effect_in_sigmas = kInfinity;
    if (r > kNoRedundancy) {
      const double own = is_image_point(one.group) ? sigma0_ : 1;
      const double spread = spread_of(one.sigma, own, sigma0_, leverage, weight, r);
      one.gross_error = one.residual / r;
      one.w = one.gross_error / spread;
      one.suspicion = one.gross_error / (sigma0_ * one.sigma * std::sqrt(1 + leverage / (weight * r)));
      one.minimal_detectable_bias = limits.delta0 * spread;
      one.effect = one.minimal_detectable_bias * leverage;
      one.effect_in_sigmas =
          one.minimal_detectable_bias / (sigma0_ * one.sigma) * std::sqrt(weight * std::max(leverage, 0.0));
      ++out_.tested;
      if (std::abs(one.w) > limits.limit) {
        ++out_.rejected;
        out_.suspects.push_back(one);
      }
    }
    if (one.group != ObservationGroup::kTieImages) out_.others.push_back(one);
    if (out_.suspects.size() > 20 * kMostSuspects) trim();
  }

  // Nothing predicts it, and nothing is as wrong.
  void suspect_unseen(TestedObservation one) {
    ++out_.unseen;
    one.limit = out_.limit;
    one.residual = one.gross_error = one.redundancy = one.minimal_detectable_bias = one.effect = one.effect_in_sigmas =
        kNaN;
    one.w = one.suspicion = kInfinity;
    out_.suspects.push_back(one);
    if (one.group != ObservationGroup::kTieImages) out_.others.push_back(one);
  }

  void trim() {
    std::stable_sort(out_.suspects.begin(), out_.suspects.end(),
                     [](const auto& a, const auto& b) { return std::abs(a.suspicion) > std::abs(b.suspicion); });
    if (out_.suspects.size() > kMostSuspects) out_.suspects.resize(kMostSuspects);
  }

  void take_image_point(const ImagePoint::Item& item, const Block& block) {
    const bool tie = ImagePoint::is_tie(problem_, item);
    TestedObservation one;
    one.group = ImagePoint::group(problem_, item);
    one.source = ImagePoint::source(problem_, item);
    one.sigma = tie ? block.observations[one.source].sigma_px : block.control_observations[one.source].sigma_px;
    const auto px = ImagePoint::residual(problem_, state_, item);
    if (!px) {
      suspect_unseen(one);
      return;
    }
    const double s = ImagePoint::squared(problem_, item, *px), weight = ImagePoint::loss(problem_, item).weight(s);
    const Eigen::Vector2d leverage = leverages_[item.ray].diagonal();
    const auto its_class = tie ? out_.tie_errors.class_of(ray_count(problem_, item.point)) : std::nullopt;
    const TestLimits limits = its_class ? tie_limits_[*its_class] : TestLimits{out_.limit, out_.delta0};
    if (tie) tie_.add(s, 2);
    if (const PixelShape& shape = shape_of(one, block); !shape.is_round()) {
      take_shaped_point(item, shape, *px, weight, limits, std::move(one));
      return;
    }
    if (tie) by_source_[one.source] = Eigen::Vector2d::Ones() - leverage;
    for (int axis = 0; axis < 2; ++axis) {
      one.axis = axis;
      one.residual = (*px)[axis];
      if (!tie) sums(one.group).squares += std::pow(one.residual / one.sigma, 2);
      test(one, leverage[axis], weight, limits);
    }
  }

  void take_shaped_point(const ImagePoint::Item& item, const PixelShape& shape, const Eigen::Vector2d& px,
                         double robust_weight, const TestLimits& limits, TestedObservation one) {
    const ShapedPoint point(shape, px, one.sigma, leverages_[item.ray]);
    if (ImagePoint::is_tie(problem_, item))
      by_source_[one.source] = point.redundancy;
    else
      sums(one.group).squares += point.squares;
    for (int axis = 0; axis < 2; ++axis) {
      const double beyond = point.leverage[axis] - leverages_[item.ray](axis, axis);
      one.axis = axis;
      one.sigma = point.sigma[axis];
      one.residual = point.residual[axis];
      test(one, point.leverage[axis], robust_weight, limits);
      sums(one.group).redundancy += beyond;
      out_.redundancy_sum += beyond;
    }
  }

  void take_control(std::size_t p) {
    const ProblemPoint& point = problem_.point(p);
    const ControlCoordinates& given = problem_.control[point.control];
    const Eigen::Matrix3d q = PointSystem(problem_, state_, p).covariance(inverse_);
    const Eigen::Matrix3d weight = given.weight(), leverage = weight * q * weight;
    const Eigen::Vector3d difference =
        Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * p]) - Eigen::Map<const Eigen::Vector3d>(given.given);
    const Eigen::Vector3d weighted = weight * difference;
    // A blunder in a coordinate shows in all that are correlated with it: its test is that of the coordinate as the
    // others predict it too, of weight p_ii and with the residual (P v)_i / p_ii (Baarda 1968).
    for (int axis = 0; axis < 3; ++axis) {
      const double w = given.inverse_sigma[axis];
      if (!(w > 0)) continue;
      TestedObservation one;
      one.group = group_of(ObservationSource::kControlCoordinates, axis);
      one.source = point.id;
      one.axis = axis;
      one.residual = -weighted[axis] / (w * w);
      one.sigma = 1 / w;
      sums(one.group).squares += difference[axis] * weighted[axis];
      const double of_test = leverage(axis, axis) / (w * w), of_group = q.row(axis).dot(weight.col(axis));
      test(one, of_test, 1);
      sums(one.group).redundancy += of_test - of_group;
      out_.redundancy_sum += of_test - of_group;
    }
    for (const LeftOutPoint& one :
         without_coordinates({ControlId{point.id}}, q, difference, given.weight(), inverse_weight(given).diagonal(),
                             std::pow(sigma_scale(adjusted_), 2)))
      out_.left_out.push_back(one);
  }

  template <class Kind>
  void take_kind() {
    if constexpr (std::is_same_v<Kind, ControlCoordinate>)
      for_each<Kind>([&](std::size_t p) {
        if (!problem_.point(p).is_fixed) take_control(p);
      });
    else if constexpr (std::is_same_v<Kind, Vertical>)
      for_each<Kind>([&](const GivenUp& given) { take_vertical(given); });
    else if constexpr (Kind::kIsTested)
      test_kind<Kind>();
    else
      for_each_row<Kind>(problem_, state_, [&](const auto&, int, const ObservationRow& row) {
        out_.redundancy_sum += 1 - row.inverse_sigma * row.inverse_sigma * variance_of(row.derivatives, inverse_);
      });
  }

  template <class Kind, class Visit>
  void for_each(Visit&& visit) {
    Kind::for_each(problem_, visit);
  }

  template <class Kind>
  void test_kind() {
    const Loss loss = Kind::loss(problem_);
    for_each_row<Kind>(problem_, state_, [&](const auto& item, int axis, const ObservationRow& row) {
      TestedObservation one;
      one.group = Kind::group(item, axis);
      one.source = Kind::source(problem_, item);
      one.axis = axis;
      one.residual = row.residual;
      one.sigma = Kind::sigma(problem_, item, axis);
      sums(one.group).squares += row.weight / loss.information * std::pow(row.residual * row.inverse_sigma, 2);
      test(one, Kind::leverage(row.weight, row.inverse_sigma, variance_of(row.derivatives, inverse_)), row.weight);
    });
    if constexpr (Kind::kIsRobust) scale_squares<Kind>(loss);
  }

  // The groups of a kind share its loss, which is of the whole length, and so what it makes of their squares.
  template <class Kind>
  void scale_squares(const Loss& loss) {
    RobustSquares all(loss);
    for_each<Kind>([&](const auto& item) {
      if (const long given = Kind::count(problem_, item); given > 0)
        all.add(Kind::squared(problem_, state_, item), static_cast<int>(given));
    });
    if (!(all.weighted() > 0)) return;
    for (const ObservationGroup group : groups_of(Kind::kGivenBy))
      sums(group).squares *= all.squares() / all.weighted();
  }

  void take_vertical(const GivenUp& given) {
    const int row = 6 * static_cast<int>(given.image);
    Eigen::Matrix3d cofactor;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) cofactor(r, c) = inverse_.at(row + std::max(r, c), row + std::min(r, c));
    out_.redundancy_sum += Vertical::redundancy(state_, given, cofactor);
  }

  const Problem& problem_;
  const State& state_;
  TileCholesky& inverse_;
  const Run& run_;
  const Adjusted& adjusted_;
  RobustSquares tie_;
  double sigma0_ = 1;
  bool fits_ties_ = false;
  std::vector<Eigen::Matrix2d> leverages_;  // of each ray
  std::vector<TestLimits> tie_limits_;      // for each class of tie errors
  std::vector<Eigen::Vector2d> by_source_;  // redundancy of each of Block::observations
  Reliability out_;
};

}  // namespace
}  // namespace bundle

TieTest tie_test(const Adjusted& adjusted, const Reliability& tests, const Eigen::Vector2d& residual_px,
                 double sigma_px, int axis, double redundancy) {
  const double r = std::clamp(redundancy, 0.0, 1.0), sigma0 = bundle::sigma0_of_tests(adjusted, tests.sigma0_known);
  TieTest test{bundle::kNaN, adjusted.tie_loss.weight(residual_px.squaredNorm() / (sigma_px * sigma_px))};
  if (r > bundle::kNoRedundancy)
    test.w = residual_px[axis] / r / bundle::spread_of(sigma_px, sigma0, sigma0, 1 - redundancy, test.weight, r);
  return test;
}

Reliability reliability_of(const Solved& solved, const Adjusted& adjusted, const TestOptions& options,
                           bundle::TileCholesky& inverse, const Run& run) {
  return bundle::Examiner(solved, adjusted, options, inverse, run).examine(solved.block());
}

}  // namespace collinea
