// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/joint_tests.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea {
namespace bundle {
namespace {

// How a coordinate follows the unknowns: the reduced ones, and for a point that was eliminated its own.
struct Functional {
  Row reduced;
  int point = -1;  // number of its system
  Eigen::Vector3d by_point = Eigen::Vector3d::Zero();
};

class JointSystemMaker {
 public:
  JointSystemMaker(const Solved& solved, bool with_marks)
      : problem_(solved.problem()), state_(solved.state()), with_marks_(with_marks) {
    for_each_kind<kInTests>([&]<class Kind>() { take<Kind>(); });
    if (with_marks_)
      ImagePoint::for_each(problem_, [&](const ImagePoint::Item& item) {
        if (!ImagePoint::is_tie(problem_, item)) take_mark(item);
      });
  }

  [[nodiscard]] std::size_t measurements() const { return out_.measurements.size(); }

  JointSystem finish(const TileCholesky& factor, const Run& run) {
    const auto n = Eigen::Index(out_.rows.size());
    Eigen::MatrixXd cofactor(n, n);  // A Q A'
    parallel_for(run, out_.rows.size(), [&](std::size_t column) {
      const Functional& own = functionals_[column];
      Eigen::VectorXd x = Eigen::VectorXd::Zero(Eigen::Index(factor.tile_rows()) * kTile);
      for (const RowPart& part : own.reduced) x[part.row] += part.derivative;
      if (own.point >= 0) systems_[std::size_t(own.point)].add_following(own.by_point, x);
      factor.solve(x.data());
      for (std::size_t row = 0; row < out_.rows.size(); ++row)
        cofactor(Eigen::Index(row), Eigen::Index(column)) = with(functionals_[row], own, x);
    });
    const Eigen::MatrixXd joint = weights_.topLeftCorner(n, n);
    out_.gram = joint - joint * cofactor * joint;
    out_.gram = ((out_.gram + out_.gram.transpose()) / 2).eval();
    return std::move(out_);
  }

 private:
  [[nodiscard]] double with(const Functional& one, const Functional& other, const Eigen::VectorXd& x) const {
    double sum = 0;
    for (const RowPart& part : one.reduced) sum += part.derivative * x[part.row];
    if (one.point < 0) return sum;
    const PointSystem& system = systems_[std::size_t(one.point)];
    sum += one.by_point.dot(system.follow(x.data()));
    if (one.point == other.point) sum += one.by_point.dot(system.solve_own(other.by_point));
    return sum;
  }

  // Its rows follow.
  void begin(MeasurementIndex index) {
    if (!out_.measurements.empty() && out_.measurements.back().group == index.group &&
        out_.measurements.back().source == index.source)
      return;
    out_.measurements.push_back(index);
    out_.first.push_back(int(out_.rows.size()));
    out_.size.push_back(0);
  }

  void add(MeasurementIndex index, JointRow row, double score, Functional functional) {
    begin(index);
    row.measurement = out_.measurements.size() - 1;
    ++out_.size.back();
    const auto n = Eigen::Index(out_.rows.size());
    if (weights_.rows() <= n) weights_.conservativeResizeLike(Eigen::MatrixXd::Zero(2 * n + 8, 2 * n + 8));
    weights_(n, n) = row.weight;
    out_.scores.conservativeResize(n + 1);
    out_.scores[n] = score;
    out_.rows.push_back(row);
    functionals_.push_back(std::move(functional));
  }

  template <class Kind>
  void take() {
    if constexpr (std::is_same_v<Kind, ControlCoordinate>)
      Kind::for_each(problem_, [&](std::size_t p) {
        if (!problem_.point(p).is_fixed) take_control(p);
      });
    else if constexpr (Kind::kIsTested && !std::is_same_v<Kind, ImagePoint>)
      for_each_row<Kind>(problem_, state_, [&](const auto& item, int axis, const ObservationRow& row) {
        const double weight = row.weight * row.inverse_sigma * row.inverse_sigma;
        add({Kind::group(item, axis), Kind::source(problem_, item)},
            {.axis = axis, .residual = row.residual, .weight = weight, .sigma = Kind::sigma(problem_, item, axis)},
            weight * row.residual, {row.derivatives});
      });
  }

  // Plan and height are correlated only where their weights say so.
  void take_control(std::size_t p) {
    const ProblemPoint& point = problem_.point(p);
    const ControlCoordinates& given = problem_.control[point.control];
    const Eigen::Matrix3d weight = given.weight();
    const Eigen::Vector3d residual =
        Eigen::Map<const Eigen::Vector3d>(given.given) - Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * p]);
    const Eigen::Vector3d score = weight * residual;
    const auto first = Eigen::Index(out_.rows.size());
    std::vector<int> axes;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(weight(axis, axis) > 0)) continue;
      axes.push_back(axis);
      add({group_of(ObservationSource::kControlCoordinates, axis), point.id},
          {.axis = axis,
           .residual = score[axis] / weight(axis, axis),
           .weight = weight(axis, axis),
           .sigma = 1 / given.inverse_sigma[axis]},
          score[axis], of_point(p, Eigen::Vector3d::Unit(axis)));
    }
    for (std::size_t a = 0; a < axes.size(); ++a)
      for (std::size_t b = 0; b < axes.size(); ++b)
        weights_(first + Eigen::Index(a), first + Eigen::Index(b)) = weight(axes[a], axes[b]);
  }

  // In units of its sigma, as rays are linearised.
  void take_mark(const ImagePoint::Item& item) {
    const Ray& ray = problem_.rays[item.ray];
    LinearRay linear;
    linearise(problem_, state_, ray, &state_.points[3 * item.point], problem_.loss_of(problem_.point(item.point)),
              &linear);
    if (!(linear.root_weight > 0)) return;
    const ProblemCamera& camera = problem_.cameras[std::size_t(problem_.images[ray.image].camera)];
    const std::size_t free = camera.free.size();
    double by_camera[2 * Camera::kAllParams];
    if (free > 0) linearise_camera(linear, state_.lenses[problem_.images[ray.image].camera], camera.free, by_camera);
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d by_point =
          Eigen::Map<const Eigen::Vector3d>(linear.by_point + 3 * axis) / linear.root_weight;
      Functional functional = problem_.point(item.point).is_fixed ? Functional() : of_point(item.point, by_point);
      if (int(ray.image) < problem_.poses)
        for (int c = 0; c < 3; ++c) {
          functional.reduced.push_back({6 * int(ray.image) + c, linear.by_rotation[3 * axis + c] / linear.root_weight});
          functional.reduced.push_back({6 * int(ray.image) + 3 + c, -by_point[c]});
        }
      for (std::size_t k = 0; k < free; ++k)
        functional.reduced.push_back({6 * problem_.poses + camera.first_global + int(k),
                                      by_camera[std::size_t(axis) * free + k] / linear.root_weight});
      const double weight = linear.root_weight * linear.root_weight,
                   residual = linear.residual[axis] / linear.root_weight;
      add({ImagePoint::group(problem_, item), ImagePoint::source(problem_, item)},
          {.axis = axis, .residual = residual, .weight = weight, .sigma = 1 / ray.inverse_sigma, .in_image = true},
          weight * residual, std::move(functional));
    }
  }

  // A direction of a point: of its own unknowns, or of those that it keeps among the global parameters.
  Functional of_point(std::size_t p, const Eigen::Vector3d& direction) {
    Functional functional;
    if (const int first = problem_.point(p).first_retained; first >= 0) {
      for (int c = 0; c < 3; ++c) functional.reduced.push_back({6 * problem_.poses + first + c, direction[c]});
      return functional;
    }
    const auto known = std::ranges::find(points_, p);
    functional.point = int(known - points_.begin());
    functional.by_point = direction;
    if (known == points_.end()) {
      points_.push_back(p);
      systems_.emplace_back(problem_, state_, p);
    }
    return functional;
  }

  const Problem& problem_;
  const State& state_;
  const bool with_marks_;
  std::vector<Functional> functionals_;  // of each row
  std::vector<std::size_t> points_;      // with a system
  std::vector<PointSystem> systems_;
  Eigen::MatrixXd weights_;
  JointSystem out_;
};

}  // namespace
}  // namespace bundle

namespace {

constexpr int kMostOfSet = 3;
constexpr std::size_t kMostLookedAt = 300;  // sets of one size
constexpr double kNoRedundancy = 1e-6;      // rounding: nothing checks such a set

std::vector<Eigen::Index> rows_of(const JointSystem& system, std::span<const std::size_t> set) {
  std::vector<Eigen::Index> rows;
  for (const std::size_t one : set)
    for (int k = 0; k < system.size[one]; ++k) rows.push_back(system.first[one] + k);
  return rows;
}

// The part of the redundancy matrix of some rows, symmetric.
Eigen::MatrixXd relative(const JointSystem& system, const std::vector<Eigen::Index>& rows) {
  Eigen::VectorXd scale(Eigen::Index(rows.size()));
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    scale[i] = 1 / std::sqrt(system.rows[std::size_t(rows[std::size_t(i)])].weight);
  return scale.asDiagonal() * system.gram(rows, rows) * scale.asDiagonal();
}

double least_eigenvalue(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// Nothing when what is left does not check the set.
std::optional<Eigen::LLT<Eigen::MatrixXd>> factored(const JointSystem& system, const std::vector<Eigen::Index>& rows) {
  if (!(least_eigenvalue(relative(system, rows)) > kNoRedundancy)) return std::nullopt;
  return Eigen::LLT<Eigen::MatrixXd>(system.gram(rows, rows));
}

JointOutcome::Test test_of(const JointSystem& system, std::size_t row, double score, double gram, double sigma0) {
  const JointRow& one = system.rows[row];
  JointOutcome::Test test{.redundancy = std::clamp(gram / one.weight, 0.0, 1.0)};
  if (!(test.redundancy > kNoRedundancy)) return test;
  const double root = one.sigma * std::sqrt(one.weight);  // of the weight by the loss
  const double own = one.in_image ? sigma0 : 1;
  test.gross_error = score / one.weight / test.redundancy;
  test.w =
      test.gross_error /
      (one.sigma * std::sqrt(own * own + sigma0 * sigma0 * (1 - test.redundancy) / (root * root * test.redundancy)));
  return test;
}

bool is_suspect(const JointSystem& system, const JointOutcome& outcome, std::size_t measurement, double limit) {
  for (int k = 0; k < system.size[measurement]; ++k)
    if (std::abs(outcome.tests[std::size_t(system.first[measurement] + k)].w) > limit) return true;
  return false;
}

// Visits every set of a size.
template <class Visit>
void for_each_set(std::size_t count, int size, Visit&& visit) {
  std::vector<std::size_t> set(static_cast<std::size_t>(size));
  const auto extend = [&](auto&& self, std::size_t depth, std::size_t from) -> void {
    if (depth == set.size()) return visit(set);
    for (std::size_t i = from; i < count; ++i) {
      set[depth] = i;
      self(self, depth + 1, i + 1);
    }
  };
  extend(extend, 0, 0);
}

}  // namespace

double JointSystem::sigma0(double squares_less, int rows_less) const {
  if (sigma0_known || redundancy <= rows_less) return 1;
  return std::max(std::sqrt(std::max(squares - squares_less, 0.0) / double(redundancy - rows_less)), 1e-12);
}

JointSystem joint_system(const Solved& solved, const bundle::TileCholesky& factor, std::size_t most, bool sigma0_known,
                         const Run& run) {
  for (const bool with_marks : {true, false}) {
    bundle::JointSystemMaker maker(solved, with_marks);
    if (maker.measurements() > most) continue;
    JointSystem system = maker.finish(factor, run);
    system.redundancy = solved.estimate().redundancy;
    system.squares = std::pow(solved.estimate().sigma0, 2) * double(std::max(system.redundancy, 0L));
    system.sigma0_known = sigma0_known;
    return system;
  }
  return {};
}

double joint_statistic(const JointSystem& system, std::span<const std::size_t> set) {
  const std::vector<Eigen::Index> rows = rows_of(system, set);
  const Eigen::VectorXd scores = system.scores(rows);
  const auto own = factored(system, rows);
  return own ? scores.dot(own->solve(scores)) : 0;
}

JointOutcome without_set(const JointSystem& system, std::span<const std::size_t> set) {
  JointOutcome outcome;
  const std::vector<Eigen::Index> rows = rows_of(system, set);
  Eigen::VectorXd scores = system.scores;
  Eigen::VectorXd gram = system.gram.diagonal();
  if (!rows.empty()) {
    const auto own = factored(system, rows);
    if (!own) return outcome;
    const Eigen::MatrixXd across = system.gram(Eigen::all, rows), gain = own->solve(across.transpose());
    const Eigen::VectorXd of_set = system.scores(rows);
    outcome.statistic = of_set.dot(own->solve(of_set));
    scores -= gain.transpose() * of_set;
    gram -= across.cwiseProduct(gain.transpose()).rowwise().sum();
  }
  outcome.is_determined = true;
  outcome.sigma0 = system.sigma0(outcome.statistic, int(rows.size()));
  for (std::size_t row = 0; row < system.rows.size(); ++row)
    outcome.tests.push_back(test_of(system, row, scores[Eigen::Index(row)], gram[Eigen::Index(row)], outcome.sigma0));
  // Of the set itself, each measurement beside which the others have been rejected.
  for (std::size_t i = 0; i < set.size(); ++i) {
    std::vector<std::size_t> others(set.begin(), set.end());
    others.erase(others.begin() + std::ptrdiff_t(i));
    const std::vector<Eigen::Index> their = rows_of(system, others);
    for (int k = 0; k < system.size[set[i]]; ++k) {
      const Eigen::Index row = system.first[set[i]] + k;
      double score = system.scores[row], own_gram = system.gram(row, row);
      if (!their.empty()) {
        const Eigen::LLT<Eigen::MatrixXd> own(system.gram(their, their));
        const Eigen::VectorXd gain = own.solve(Eigen::VectorXd(system.gram(their, row)));
        score -= gain.dot(Eigen::VectorXd(system.scores(their)));
        own_gram -= gain.dot(Eigen::VectorXd(system.gram(their, row)));
      }
      outcome.tests[std::size_t(row)] = test_of(system, std::size_t(row), score, own_gram, outcome.sigma0);
    }
  }
  return outcome;
}

double redundancy_of(const JointSystem& system, std::span<const std::size_t> set) {
  return least_eigenvalue(relative(system, rows_of(system, set)));
}

JointSystem with_errors(JointSystem system, std::span<const std::size_t> rows, std::span<const double> errors) {
  const std::vector<Eigen::Index> of(rows.begin(), rows.end());
  if (of.empty()) return system;
  const Eigen::Map<const Eigen::VectorXd> error(errors.data(), Eigen::Index(errors.size()));
  const Eigen::VectorXd change = system.gram(Eigen::all, of) * error;
  system.squares += error.dot(Eigen::VectorXd(2 * system.scores(of)) + Eigen::VectorXd(change(of)));
  system.scores += change;
  return system;
}

double joint_correlation(const JointSystem& system, std::span<const std::size_t> a, std::span<const std::size_t> b) {
  std::vector<std::size_t> common, only_a, only_b;
  std::ranges::set_intersection(a, b, std::back_inserter(common));
  std::ranges::set_difference(a, b, std::back_inserter(only_a));
  std::ranges::set_difference(b, a, std::back_inserter(only_b));
  const std::vector<Eigen::Index> of_a = rows_of(system, only_a), of_b = rows_of(system, only_b),
                                  of_common = rows_of(system, common);
  if (of_a.empty() || of_b.empty()) return 0;
  const auto left = [&](const std::vector<Eigen::Index>& r, const std::vector<Eigen::Index>& c) {
    Eigen::MatrixXd block = system.gram(r, c);
    if (of_common.empty()) return block;
    const Eigen::LLT<Eigen::MatrixXd> own(system.gram(of_common, of_common));
    block -= Eigen::MatrixXd(system.gram(r, of_common)) * own.solve(Eigen::MatrixXd(system.gram(of_common, c)));
    return block;
  };
  const Eigen::LLT<Eigen::MatrixXd> root_a(left(of_a, of_a)), root_b(left(of_b, of_b));
  if (root_a.info() != Eigen::Success || root_b.info() != Eigen::Success) return 0;
  Eigen::MatrixXd between = root_a.matrixL().solve(left(of_a, of_b));
  between = root_b.matrixL().solve(between.transpose()).eval();
  return between.jacobiSvd().singularValues().minCoeff();
}

bool explains(const JointSystem& system, std::span<const std::size_t> set, double limit) {
  const JointOutcome outcome = without_set(system, set);
  if (!outcome.is_determined) return false;
  for (std::size_t one = 0; one < system.measurements.size(); ++one)
    if (is_suspect(system, outcome, one, limit) != (std::ranges::find(set, one) != set.end())) return false;
  return true;
}

std::vector<Explanation> explanations(const JointSystem& system, double limit) {
  std::vector<Explanation> found;
  if (system.measurements.empty() || explains(system, {}, limit)) return found;
  for (int size = 1; size <= kMostOfSet && found.empty(); ++size) {
    std::vector<Explanation> sets;
    for_each_set(system.measurements.size(), size, [&](const std::vector<std::size_t>& set) {
      sets.push_back({set, joint_statistic(system, set)});
    });
    const auto looked_at = sets.begin() + std::ptrdiff_t(std::min(sets.size(), kMostLookedAt));
    std::ranges::partial_sort(sets, looked_at, std::greater{}, &Explanation::statistic);
    for (auto set = sets.begin(); set != looked_at; ++set)
      if (explains(system, set->set, limit)) found.push_back(std::move(*set));
  }
  return found;
}

}  // namespace collinea
