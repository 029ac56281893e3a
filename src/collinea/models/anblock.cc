// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/anblock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "collinea/geometry/rotation.h"
#include "collinea/models/internal/pair_equations.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kHigh = 0.5;  // of the RMS distance from the centroid in plan

struct Named {
  std::string name;
  int axis = 0;
};

// Level models as they stand in the cycles, and what they say of ground coordinates.
class LevelModels {
 public:
  struct State {
    Eigen::Quaterniond levelled = Eigen::Quaterniond::Identity();  // from the model as given
    double a = 1, b = 0;
    Vector3d t = Vector3d::Zero();  // of the centroid
    [[nodiscard]] double scale() const { return std::hypot(a, b); }
  };

  LevelModels(const std::vector<StereoModel>& models, const std::vector<bool>& used,
              const std::vector<SurveyedPoint>& control)
      : given_(models) {
    for (std::size_t m = 0; m < models.size(); ++m)
      if (used[m]) {
        models_.push_back(m);
        Vector3d centre = Vector3d::Zero();
        for (const NamedPoint& point : models[m].points) centre += point.position / double(models[m].points.size());
        centres_.push_back(centre);
        for (const NamedPoint& point : models[m].points) times_[point.name] += 1;
      }
    states_.resize(models_.size());
    find_high();
    for (const SurveyedPoint& point : control)
      if (!point.is_check) surveyed_[point.name] = &point;
  }

  [[nodiscard]] int count() const { return static_cast<int>(models_.size()); }
  [[nodiscard]] Result<> check_control() const {
    int plan = 0, heights = 0;
    for (const auto& [name, point] : surveyed_) {
      if (!times_.contains(name)) continue;
      plan += point->has_plan() ? 1 : 0;
      heights += point->has(2) ? 1 : 0;
    }
    if (plan >= 2 && heights >= 3) return {};
    return fail(Errc::kIllPosed, fmt::format("the models show control with {} points in plan and {} heights; Anblock "
                                             "needs two in plan and three heights that are not on a line",
                                             plan, heights));
  }

  [[nodiscard]] Vector3d turned(std::size_t k, const NamedPoint& point) const {
    return states_[k].levelled * (point.position - centres_[k]);
  }
  // Standard deviations of u and v together and of w, of the levelled model.
  [[nodiscard]] Eigen::Vector2d variances(std::size_t k, const NamedPoint& point) const {
    const Eigen::Matrix3d rotation = states_[k].levelled.toRotationMatrix();
    const Eigen::Matrix3d covariance = rotation * point.covariance * rotation.transpose();
    const double least = 1e-12 * (1 + covariance.trace());  // of a projection centre without any
    return {std::max(least, (covariance(0, 0) + covariance(1, 1)) / 2), std::max(least, covariance(2, 2))};
  }
  [[nodiscard]] Similarity3 orientation(std::size_t k) const {
    const State& state = states_[k];
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::atan2(state.b, state.a), Vector3d::UnitZ()));
    const Eigen::Quaterniond rotation = (turn * state.levelled).normalized();
    return {state.scale(), rotation, state.t - state.scale() * (rotation * centres_[k])};
  }

  // Equations of all ground coordinates that say anything of the models, in the order of their names.
  std::vector<CoordinateEquations> equations(bool plan, bool is_first) {
    std::map<std::string, std::array<CoordinateEquations, 3>> of_point;
    for (std::size_t k = 0; k < models_.size(); ++k)
      for (const NamedPoint& point : given_[models_[k]].points) {
        if (times_.at(point.name) < 2 && !surveyed_.contains(point.name)) continue;
        const Vector3d u = turned(k, point);
        const State& state = states_[k];
        const Eigen::Vector2d variance = variances(k, point) * state.scale() * state.scale();
        auto& axes = of_point[point.name];
        const int model = static_cast<int>(k);
        const double x = state.a * u.x() - state.b * u.y(), y = state.b * u.x() + state.a * u.y();
        const double z = state.scale() * u.z();
        const bool is_high = high_.contains(point.name);
        if (plan && !is_high) {
          axes[0].models.push_back({model, Vector4d(u.x(), -u.y(), 1, 0), 0, 1 / variance[0]});
          axes[1].models.push_back({model, Vector4d(u.y(), u.x(), 0, 1), 0, 1 / variance[0]});
        }
        if (plan) continue;
        axes[2].models.push_back({model, Vector4d(y, -x, 1, 0), z, 1 / variance[1]});
        if (!is_high) continue;
        axes[0].models.push_back({model, Vector4d(0, z, 0, 0), state.t.x() + x, 1 / variance[0]});
        axes[1].models.push_back({model, Vector4d(-z, 0, 0, 0), state.t.y() + y, 1 / variance[0]});
      }
    std::vector<CoordinateEquations> all;
    names_.clear();
    for (auto& [name, axes] : of_point)
      for (int axis = 0; axis < 3; ++axis) {
        CoordinateEquations& one = axes[static_cast<std::size_t>(axis)];
        if (one.models.empty()) continue;
        const auto found = surveyed_.find(name);
        if (found != surveyed_.end() && found->second->has(axis)) {
          one.surveyed = found->second->position[axis];
          // At first the scale is not known, by which models weigh against control.
          one.surveyed_sigma = plan && is_first ? 0 : found->second->sigma[axis];
        }
        all.push_back(std::move(one));
        names_.push_back({name, axis});
      }
    return all;
  }

  // Equations less unknowns: each coordinate has one of its own, unless it is fixed.
  [[nodiscard]] long redundancy(const std::vector<CoordinateEquations>& coordinates, int unknowns) const {
    long sum = -static_cast<long>(unknowns) * count();
    for (const CoordinateEquations& one : coordinates)
      sum += static_cast<long>(one.models.size()) - (one.surveyed ? 0 : 1);
    return sum;
  }

  [[nodiscard]] const StereoModel& given(std::size_t k) const { return given_[models_[k]]; }
  [[nodiscard]] std::size_t index(std::size_t k) const { return models_[k]; }
  [[nodiscard]] std::size_t size() const { return models_.size(); }
  [[nodiscard]] State& state(std::size_t k) { return states_[k]; }
  [[nodiscard]] const State& state(std::size_t k) const { return states_[k]; }
  [[nodiscard]] const Named& coordinate(std::size_t i) const { return names_[i]; }  // of the last equations
  // Null: it is not surveyed.
  [[nodiscard]] const SurveyedPoint* surveyed(const std::string& name) const {
    const auto found = surveyed_.find(name);
    return found == surveyed_.end() ? nullptr : found->second;
  }
  [[nodiscard]] bool is_shared(const std::string& name) const {
    return times_.at(name) > 1 || surveyed(name) != nullptr;
  }

 private:
  // Points far above or below the others, as projection centres are.
  void find_high() {
    for (std::size_t k = 0; k < models_.size(); ++k) {
      std::vector<double> heights;
      double squares = 0;
      for (const NamedPoint& point : given_[models_[k]].points) {
        heights.push_back(point.position.z());
        squares += (point.position - centres_[k]).head<2>().squaredNorm();
      }
      const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
      const double extent = std::sqrt(squares / double(heights.size()));
      std::nth_element(heights.begin(), middle, heights.end());
      for (const NamedPoint& point : given_[models_[k]].points)
        if (std::abs(point.position.z() - *middle) > kHigh * extent) high_.insert(point.name);
    }
  }

  const std::vector<StereoModel>& given_;
  std::vector<std::size_t> models_;
  std::vector<Vector3d> centres_;
  std::vector<State> states_;
  std::map<std::string, int> times_;
  std::map<std::string, const SurveyedPoint*> surveyed_;
  std::vector<Named> names_;
  std::set<std::string> high_;
};

class Cycles {
 public:
  Cycles(const std::vector<StereoModel>& models, const std::vector<bool>& used,
         const std::vector<SurveyedPoint>& control, const AnblockOptions& options, const Run& run)
      : options_(options), run_(run), count_given_(models.size()), block_(models, used, control) {}

  Result<Anblock> run() {
    Anblock out;
    out.models.resize(count_given_);
    COLLINEA_TRY(block_.check_control());
    PairEquations plan(4, block_.count(), block_.equations(true, is_first_)),
        height(3, block_.count(), block_.equations(false, is_first_));
    for (;; is_first_ = false) {
      if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
      AnblockCycle& cycle = out.cycles.emplace_back();
      COLLINEA_TRY(cycle.plan_sigma0, solve_plan(plan, out.plan_redundancy));
      COLLINEA_TRY(cycle.height_sigma0, solve_height(height, out.height_redundancy));
      cycle.largest_move = move_points(out);
      if (cycle.largest_move < options_.settled * median_sigma()) break;
      if (static_cast<int>(out.cycles.size()) == options_.most_cycles)
        return fail(
            Errc::kNotConverged,
            fmt::format(
                "plan and height have not settled in {} cycles: are the models level, and three heights not on a line?",
                options_.most_cycles));
    }
    state_precision(plan, true, factor(out.cycles.back().plan_sigma0), out);
    state_precision(height, false, factor(out.cycles.back().height_sigma0), out);
    for (std::size_t k = 0; k < block_.size(); ++k)
      out.models[block_.index(k)]->ground_from_model = block_.orientation(k);
    return out;
  }

 private:
  [[nodiscard]] double factor(double sigma0) const { return options_.sigmas_known || !(sigma0 > 0) ? 1 : sigma0; }
  [[nodiscard]] tl::unexpected<Error> no_plan(int model) const {
    return fail(Errc::kIllPosed, fmt::format("position or scale in plan of model {} is not determined: the block needs "
                                             "two points in plan, and the model two in common with others",
                                             name_of(model)));
  }
  [[nodiscard]] tl::unexpected<Error> no_height(int model) const {
    return fail(Errc::kIllPosed,
                fmt::format("height or tilt of model {} is not determined: the block needs three heights that are not "
                            "on a line, and the model three points in common with others",
                            name_of(model)));
  }
  [[nodiscard]] const std::string& name_of(int model) const {
    return block_.given(static_cast<std::size_t>(std::min(model, block_.count() - 1))).name;
  }

  Result<double> solve_plan(PairEquations& normals, long& redundant) {
    const auto coordinates = block_.equations(true, is_first_);
    const auto solved = normals.solve(coordinates, run_);
    if (solved.undetermined >= 0) return no_plan(solved.undetermined);
    for (std::size_t k = 0; k < block_.size(); ++k) {
      const Vector4d& x = solved.of_model[k];
      block_.state(k).a = x[0];
      block_.state(k).b = x[1];
      block_.state(k).t.head<2>() = x.tail<2>();
      if (!(block_.state(k).scale() > 0)) return no_plan(int(k));
    }
    redundant = block_.redundancy(coordinates, 4);
    return redundant > 0 ? std::sqrt(solved.squares / double(redundant)) : kNaN;
  }

  Result<double> solve_height(PairEquations& normals, long& redundant) {
    const auto coordinates = block_.equations(false, is_first_);
    const auto solved = normals.solve(coordinates, run_);
    if (solved.undetermined >= 0) return no_height(solved.undetermined);
    for (std::size_t k = 0; k < block_.size(); ++k) {
      const Vector4d& x = solved.of_model[k];
      const LevelModels::State& state = block_.state(k);
      // omega and phi are about axes of the ground; of the model they are turned back by kappa.
      const Vector3d about_ground(x[0], x[1], 0);
      const Eigen::Quaterniond kappa(Eigen::AngleAxisd(std::atan2(state.b, state.a), Vector3d::UnitZ()));
      block_.state(k).levelled = (rotation_by(kappa.conjugate() * about_ground) * state.levelled).normalized();
      block_.state(k).t.z() = x[2];
    }
    redundant = block_.redundancy(coordinates, 3);
    return redundant > 0 ? std::sqrt(solved.squares / double(redundant)) : kNaN;
  }

  // Weighted means of models and control; answers the largest move.
  double move_points(Anblock& out) const {
    std::map<std::string, std::pair<Vector3d, Vector3d>> sums;
    for (std::size_t k = 0; k < block_.size(); ++k) {
      const Similarity3 ground_from_model = block_.orientation(k);
      for (const NamedPoint& point : block_.given(k).points) {
        const Eigen::Vector2d variance = block_.variances(k, point) * std::pow(block_.state(k).scale(), 2);
        const Vector3d weight(1 / variance[0], 1 / variance[0], 1 / variance[1]);
        auto& [sum, weights] = sums.try_emplace(point.name, Vector3d::Zero(), Vector3d::Zero()).first->second;
        sum += weight.cwiseProduct(ground_from_model * point.position);
        weights += weight;
      }
    }
    double largest = 0;
    for (auto& [name, both] : sums) {
      auto& [sum, weights] = both;
      Vector3d position = sum.cwiseQuotient(weights);
      const SurveyedPoint* const given = block_.surveyed(name);
      for (int axis = 0; given != nullptr && axis < 3; ++axis) {
        if (!given->has(axis)) continue;
        const double weight = given->sigma[axis] > 0 ? std::pow(given->sigma[axis], -2) : 0;
        position[axis] = given->sigma[axis] == 0
                             ? given->position[axis]
                             : (sum[axis] + weight * given->position[axis]) / (weights[axis] + weight);
      }
      const bool is_new = !out.points.contains(name);
      AnblockPoint& point = out.points[name];
      largest =
          std::max(largest, is_new ? std::numeric_limits<double>::infinity() : (position - point.position).norm());
      point.position = position;
    }
    return largest;
  }

  [[nodiscard]] double median_sigma() const {
    std::vector<double> sigmas;
    for (std::size_t k = 0; k < block_.size(); ++k)
      for (const NamedPoint& point : block_.given(k).points)
        sigmas.push_back(block_.state(k).scale() * std::sqrt(block_.variances(k, point)[0]));
    std::nth_element(sigmas.begin(), sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2), sigmas.end());
    return sigmas[sigmas.size() / 2];
  }

  // Of the models' parameters and of points: variance of the mean of what models say, and of their parameters.
  void state_precision(PairEquations& normals, bool plan, double sigma0, Anblock& out) {
    const auto coordinates = block_.equations(plan, false);
    normals.invert(run_);
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const CoordinateEquations& one = coordinates[i];
      double& sigma = out.points.at(block_.coordinate(i).name).sigma[block_.coordinate(i).axis];
      if (one.surveyed && one.surveyed_sigma == 0) continue;
      double sum = one.surveyed ? std::pow(one.surveyed_sigma, -2) : 0, variance = 0;
      for (const ModelEquation& equation : one.models) sum += equation.weight;
      for (const ModelEquation& a : one.models)
        for (const ModelEquation& b : one.models)
          variance += a.weight * b.weight / (sum * sum) * a.row.dot(normals.covariance(a.model, b.model) * b.row);
      sigma = sigma0 * std::sqrt(1 / sum + variance);
    }
    for (std::size_t k = 0; k < block_.size(); ++k) {
      auto& model = out.models[block_.index(k)];
      if (!model) model.emplace();
      const Eigen::Matrix4d q = normals.covariance(int(k), int(k));
      const LevelModels::State& state = block_.state(k);
      const double scale = state.scale();
      if (plan) {
        const Vector4d by_scale(state.a / scale, state.b / scale, 0, 0);
        const Vector4d by_kappa(-state.b / (scale * scale), state.a / (scale * scale), 0, 0);
        model->sigma.head<2>() = sigma0 * q.diagonal().tail<2>().cwiseSqrt();
        model->sigma[5] = sigma0 * std::sqrt(by_kappa.dot(q * by_kappa));
        model->sigma[6] = sigma0 * std::sqrt(by_scale.dot(q * by_scale));
      } else {
        model->sigma.segment<2>(3) = sigma0 * q.diagonal().head<2>().cwiseSqrt();
        model->sigma[2] = sigma0 * std::sqrt(q(2, 2));
      }
      state_single_points(k, plan, sigma0, q, out);
    }
  }

  // Points that one model alone shows.
  void state_single_points(std::size_t k, bool plan, double sigma0, const Eigen::Matrix4d& q, Anblock& out) const {
    const LevelModels::State& state = block_.state(k);
    for (const NamedPoint& point : block_.given(k).points) {
      if (block_.is_shared(point.name)) continue;
      const Vector3d u = block_.turned(k, point);
      const Eigen::Vector2d variance = block_.variances(k, point) * state.scale() * state.scale();
      const Vector4d rows[3] = {{u.x(), -u.y(), 1, 0},
                                {u.y(), u.x(), 0, 1},
                                {state.b * u.x() + state.a * u.y(), -state.a * u.x() + state.b * u.y(), 1, 0}};
      for (int axis = plan ? 0 : 2; axis < (plan ? 2 : 3); ++axis)
        out.points.at(point.name).sigma[axis] =
            sigma0 * std::sqrt(variance[plan ? 0 : 1] + rows[axis].dot(q * rows[axis]));
    }
  }

  const AnblockOptions& options_;
  const Run& run_;
  std::size_t count_given_;
  LevelModels block_;
  bool is_first_ = true;
};

}  // namespace

Result<Anblock> anblock(const std::vector<StereoModel>& models, const std::vector<bool>& used,
                        const std::vector<SurveyedPoint>& control, const AnblockOptions& options, const Run& run) {
  if (std::none_of(used.begin(), used.end(), [](bool one) { return one; }))
    return fail(Errc::kBadInput, "there is no model");
  Vector3d origin = Vector3d::Zero(), count = Vector3d::Zero();  // near it, for digits
  for (const SurveyedPoint& point : control)
    for (int axis = 0; axis < 3; ++axis)
      if (point.has(axis)) {
        origin[axis] += point.position[axis];
        ++count[axis];
      }
  origin = origin.cwiseQuotient(count.cwiseMax(1));
  std::vector<SurveyedPoint> near = control;
  for (SurveyedPoint& point : near) point.position -= origin;
  COLLINEA_TRY(Anblock out, Cycles(models, used, near, options, run).run());
  for (auto& model : out.models)
    if (model) model->ground_from_model.translation += origin;
  for (auto& [name, point] : out.points) point.position += origin;
  return out;
}

StereoModel levelled(const StereoModel& model, const Eigen::Quaterniond& ground_from_model) {
  StereoModel turned = model;
  const Eigen::Matrix3d rotation = ground_from_model.toRotationMatrix();
  for (NamedPoint& point : turned.points) {
    point.position = rotation * point.position;
    point.covariance = (rotation * point.covariance * rotation.transpose()).eval();
  }
  for (Eigen::Index i = 0; i < turned.covariance.rows(); i += 3)
    for (Eigen::Index k = 0; k < turned.covariance.cols(); k += 3)
      turned.covariance.block<3, 3>(i, k) =
          (rotation * turned.covariance.block<3, 3>(i, k) * rotation.transpose()).eval();
  return turned;
}

}  // namespace collinea
