// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/concatenate.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Matrix37d = Eigen::Matrix<double, 3, 7>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A point of a model.
struct Shown {
  std::size_t model = 0, point = 0;  // indices
};

// A point that a join compares: what moves (the mean of these) with what is known: the mean of these, or control.
struct Compared {
  std::vector<Shown> moving, known;
  std::optional<std::size_t> control;  // index
};

// A join, or the absolute orientation of a part: its models get the increments that make both agree.
struct Join {
  std::vector<std::size_t> moves;
  std::vector<Compared> pairs;
  std::optional<std::size_t> reference;  // instead: they all move by what this one would
  Matrix7d inverse = Matrix7d::Zero();   // of the normal matrix
};

// One cause of error: a model's coordinates or one control point, with its covariance.
struct Source {
  std::optional<std::size_t> model, control;
  MatrixXd covariance;
};

// What the columns of a source do to the increments of each model; without rows: nothing.
using Effect = std::vector<MatrixXd>;

class Propagation {
 public:
  Propagation(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
              const ModelChain& chain)
      : models_(models), control_(control), chain_(chain) {
    for (const auto& [name, position] : chain.points) centre_ += position / double(chain.points.size());
    double squares = 0;
    for (const auto& [name, position] : chain.points)
      squares += (position - centre_).squaredNorm() / double(chain.points.size());
    extent_ = squares > 0 ? std::sqrt(squares) : 1;
    for (const ChainPart& part : chain.parts) add_part(part);
  }

  /// Adds what the source does to points, parameters and discrepancies.
  void propagate(const Source& source) {
    const Effect effect = effect_of(source);
    for (std::size_t m = 0; m < models_.size(); ++m)
      if (effect[m].size() > 0)
        parameters.try_emplace(m, Matrix7d::Zero()).first->second +=
            effect[m] * source.covariance * effect[m].transpose();
    for (const auto& [name, shown] : shown_) {
      const MatrixXd mean = moved(shown, effect, source);
      if (mean.size() > 0)
        points.try_emplace(name, Eigen::Matrix3d::Zero()).first->second += mean * source.covariance * mean.transpose();
      if (shown.size() < 2) continue;
      for (const Shown& one : shown) {
        const MatrixXd own = moved({one}, effect, source);
        if (own.size() == 0 && mean.size() == 0) continue;
        const MatrixXd apart = own.size() == 0 ? MatrixXd(-mean) : mean.size() == 0 ? own : MatrixXd(own - mean);
        expected_squares += (apart * source.covariance * apart.transpose()).trace();
      }
    }
  }

  [[nodiscard]] std::vector<Source> sources() const {
    std::vector<Source> all;
    for (std::size_t m = 0; m < models_.size(); ++m)
      if (chain_.ground_from_model[m]) all.push_back({m, {}, models_[m].full_covariance()});
    for (std::size_t k = 0; k < control_.size(); ++k) {
      if (control_[k].is_check || !shown_.contains(control_[k].name)) continue;
      Vector3d variance = Vector3d::Zero();
      for (int axis = 0; axis < 3; ++axis)
        if (control_[k].has(axis)) variance[axis] = control_[k].sigma[axis] * control_[k].sigma[axis];
      if (variance.sum() > 0) all.push_back({{}, k, variance.asDiagonal()});
    }
    return all;
  }

  [[nodiscard]] Vector3d position(const Shown& one) const {
    return *chain_.ground_from_model[one.model] * models_[one.model].points[one.point].position;
  }
  /// Of increments at a position on the ground.
  [[nodiscard]] Matrix37d derivatives(const Vector3d& at) const {
    const Vector3d reduced = (at - centre_) / extent_;
    Matrix37d a;
    a << reduced, -skew(reduced), Eigen::Matrix3d::Identity();
    return a;
  }
  [[nodiscard]] double extent() const { return extent_; }
  [[nodiscard]] const std::map<std::string, std::vector<Shown>>& shown() const { return shown_; }

  std::map<std::string, Eigen::Matrix3d> points;
  std::map<std::size_t, Matrix7d> parameters;
  double expected_squares = 0;

 private:
  void add_part(const ChainPart& part) {
    std::map<std::string, std::vector<Shown>> in_part;
    for (const ChainLink& link : part) {
      Join join{{link.model}, {}, {}};
      std::map<std::string, std::vector<Shown>> known;
      if (link.partner)
        for (std::size_t i = 0; i < models_[*link.partner].points.size(); ++i)
          known[models_[*link.partner].points[i].name] = {{*link.partner, i}};
      for (std::size_t i = 0; i < models_[link.model].points.size(); ++i) {
        const std::string& name = models_[link.model].points[i].name;
        const auto& from = link.partner ? known : in_part;
        if (const auto at = from.find(name); at != from.end())
          join.pairs.push_back({{{link.model, i}}, at->second, {}});
      }
      if (&link != &part.front()) add(std::move(join));
      for (std::size_t i = 0; i < models_[link.model].points.size(); ++i)
        in_part[models_[link.model].points[i].name].push_back({link.model, i});
    }
    add_orientation(part, in_part);
    for (const auto& [name, shown] : in_part) {
      shown_[name].insert(shown_[name].end(), shown.begin(), shown.end());
      on_ground_[name] = shown;
    }
  }

  // By control and by what parts before have brought to the ground; or the frame of the reference.
  void add_orientation(const ChainPart& part, const std::map<std::string, std::vector<Shown>>& in_part) {
    Join join;
    for (const ChainLink& link : part) join.moves.push_back(link.model);
    if (!chain_.on_ground && &part == &chain_.parts.front()) {
      join.reference = chain_.reference;
      joins_.push_back(std::move(join));
      return;
    }
    std::map<std::string, std::size_t> surveyed;
    for (std::size_t k = 0; k < control_.size(); ++k)
      if (!control_[k].is_check) surveyed[control_[k].name] = k;
    for (const auto& [name, shown] : in_part)
      if (const auto before = on_ground_.find(name); before != on_ground_.end())
        join.pairs.push_back({shown, before->second, {}});
      else if (const auto given = surveyed.find(name); given != surveyed.end())
        join.pairs.push_back({shown, {}, given->second});
    add(std::move(join));
  }

  void add(Join join) {
    Matrix7d normals = Matrix7d::Zero();
    for (const Compared& pair : join.pairs) {
      const Matrix37d a = masked(pair);
      normals += a.transpose() * a;
    }
    join.inverse = normals.ldlt().solve(Matrix7d::Identity());
    joins_.push_back(std::move(join));
  }

  // Derivatives where the moving point is, zero on axes that are not given.
  [[nodiscard]] Matrix37d masked(const Compared& pair) const {
    Vector3d at = Vector3d::Zero();
    for (const Shown& one : pair.moving) at += position(one) / double(pair.moving.size());
    Matrix37d a = derivatives(at);
    for (int axis = 0; pair.control && axis < 3; ++axis)
      if (!control_[*pair.control].has(axis)) a.row(axis).setZero();
    return a;
  }

  // What the source moves the mean of these by; without rows: nothing.
  [[nodiscard]] MatrixXd moved(const std::vector<Shown>& shown, const Effect& effect, const Source& source) const {
    MatrixXd sum;
    const double share = 1 / double(shown.size());
    for (const Shown& one : shown) {
      const bool is_own = source.model == one.model;
      if (!is_own && effect[one.model].size() == 0) continue;
      if (sum.size() == 0) sum = MatrixXd::Zero(3, source.covariance.cols());
      if (effect[one.model].size() > 0) sum += share * derivatives(position(one)) * effect[one.model];
      const Similarity3& ground = *chain_.ground_from_model[one.model];
      if (is_own)
        sum.middleCols<3>(3 * static_cast<Index>(one.point)) +=
            share * ground.scale * ground.rotation.toRotationMatrix();
    }
    return sum;
  }

  [[nodiscard]] Effect effect_of(const Source& source) const {
    Effect effect(models_.size());
    const Index columns = source.covariance.cols();
    for (const Join& join : joins_) {
      MatrixXd step;
      if (join.reference) {
        step = -effect[*join.reference];
      } else {
        MatrixXd right;
        for (const Compared& pair : join.pairs) {
          MatrixXd apart = moved(pair.moving, effect, source);
          if (apart.size() > 0) apart = (-apart).eval();
          MatrixXd known;
          if (!pair.known.empty()) known = moved(pair.known, effect, source);
          if (pair.control && pair.control == source.control) known = MatrixXd::Identity(3, 3);
          if (known.size() > 0) apart = apart.size() > 0 ? MatrixXd(apart + known) : known;
          if (apart.size() == 0) continue;
          if (right.size() == 0) right = MatrixXd::Zero(7, columns);
          right += masked(pair).transpose() * apart;
        }
        if (right.size() > 0) step = join.inverse * right;
      }
      if (step.size() == 0) continue;
      for (const std::size_t m : join.moves) effect[m] = effect[m].size() > 0 ? MatrixXd(effect[m] + step) : step;
    }
    return effect;
  }

  const std::vector<StereoModel>& models_;
  const std::vector<SurveyedPoint>& control_;
  const ModelChain& chain_;
  Vector3d centre_ = Vector3d::Zero();
  double extent_ = 1;
  std::vector<Join> joins_;
  std::map<std::string, std::vector<Shown>> shown_, on_ground_;  // on the ground: by the part that came last
};

JoinedModel model_of(const Similarity3& ground, const Propagation& all, const Matrix7d& increments) {
  JoinedModel out;
  out.ground_from_model = ground;
  out.redundancy = kNaN;
  const OmegaPhiKappa angles = omega_phi_kappa((ground.rotation * Eigen::Quaterniond(0, 1, 0, 0)).conjugate());
  constexpr double kRadian = std::numbers::pi / 180;
  out.omega_rad = angles.omega_deg * kRadian;
  out.phi_rad = angles.phi_deg * kRadian;
  out.kappa_rad = angles.kappa_deg * kRadian;
  Matrix7d by = Matrix7d::Zero();
  by.topRows<3>() = all.derivatives(ground.translation);
  by.block<3, 3>(3, 1) = angles_by_rotation_of_camera(angles) / all.extent();
  by(6, 0) = ground.scale / all.extent();
  out.covariance = by * increments * by.transpose();
  return out;
}

void add_models(const std::vector<StereoModel>& models, const Propagation& all, double factor, JoinedBlock& block) {
  block.models.resize(models.size());
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!block.chain.ground_from_model[m]) continue;
    const Similarity3& ground = *block.chain.ground_from_model[m];
    const auto known = all.parameters.find(m);
    block.models[m] = model_of(
        ground, all, known == all.parameters.end() ? Matrix7d(Matrix7d::Zero()) : Matrix7d(factor * known->second));
    for (const NamedPoint& point : models[m].points) {
      const Vector3d residual = point.position - inverse(ground) * block.chain.points.at(point.name);
      auto& tests = block.models[m]->tests.emplace_back();
      for (std::size_t axis = 0; axis < 3; ++axis) tests[axis] = {residual[static_cast<Index>(axis)], kNaN, kNaN};
    }
  }
}

void add_control(const std::vector<SurveyedPoint>& control, JoinedBlock& block) {
  std::map<std::string, const JoinedPoint*> found;
  for (const JoinedPoint& point : block.points) found[point.name] = &point;
  for (std::size_t k = 0; k < control.size(); ++k) {
    JoinedControl& out = block.control.emplace_back();
    out.index = k;
    out.difference.setConstant(kNaN);
    out.sigma.setConstant(kNaN);
    for (CoordinateTest& test : out.tests) test = {0, kNaN, kNaN};
    const auto at = found.find(control[k].name);
    out.seen = at != found.end();
    for (int axis = 0; out.seen && axis < 3; ++axis) {
      if (!control[k].has(axis)) continue;
      const double sigma = control[k].sigma[axis];
      out.difference[axis] = control[k].position[axis] - at->second->position[axis];
      if (control[k].is_check) out.sigma[axis] = std::sqrt(sigma * sigma + at->second->covariance(axis, axis));
    }
  }
}

}  // namespace

Result<JoinedBlock> concatenate_models(const std::vector<StereoModel>& models,
                                       const std::vector<SurveyedPoint>& control, bool sigmas_known) {
  JoinedBlock block;
  COLLINEA_TRY(block.chain, chain_models(models, control));
  Propagation all(models, control, block.chain);
  for (const Source& source : all.sources()) all.propagate(source);
  for (const auto& [name, shown] : all.shown())
    for (const Shown& one : shown)
      if (shown.size() > 1) block.squares += (all.position(one) - block.chain.points.at(name)).squaredNorm();
  block.sigma0 = all.expected_squares > 0 ? std::sqrt(block.squares / all.expected_squares) : kNaN;
  block.variance_factor = !sigmas_known && block.sigma0 > 0 ? block.sigma0 * block.sigma0 : 1;
  block.limit = std::numeric_limits<double>::infinity();
  add_models(models, all, block.variance_factor, block);
  for (const auto& [name, shown] : all.shown()) {
    JoinedPoint& point = block.points.emplace_back();
    point.name = name;
    point.position = block.chain.points.at(name);
    point.models = static_cast<int>(shown.size());
    if (const auto known = all.points.find(name); known != all.points.end())
      point.covariance = block.variance_factor * known->second;
  }
  add_control(control, block);
  return block;
}

}  // namespace collinea
