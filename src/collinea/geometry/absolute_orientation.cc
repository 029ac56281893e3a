// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/absolute_orientation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/geometry/robust_similarity.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/rotation_angles.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix7 = AbsoluteOrientation::Matrix7;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Design = Eigen::Matrix<double, Eigen::Dynamic, 7>;

constexpr double kLeastEigenvalue = 1e-11;  // of the normal matrix with unit diagonal
constexpr int kMostIterations = 60;

// Both sides reduced to a point among the control, so that large coordinates cost no digits.
struct Reduced {
  Vector3d model = Vector3d::Zero(), ground = Vector3d::Zero();
};

// The known components of all points: rows of the equations.
struct Row {
  std::size_t pair;
  int axis;
};

std::vector<Row> rows_of(std::span<const AbsoluteControl> pairs) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (axis < 2 ? pairs[i].has_plan : pairs[i].has_height) rows.push_back({i, axis});
  return rows;
}

Reduced centroids(std::span<const AbsoluteControl> pairs) {
  Reduced mean;
  double plan = 0, height = 0;
  for (const AbsoluteControl& pair : pairs) {
    mean.model += pair.in_model / double(pairs.size());
    if (pair.has_plan) {
      mean.ground.head<2>() += pair.in_ground.head<2>();
      plan += 1;
    }
    if (pair.has_height) {
      mean.ground.z() += pair.in_ground.z();
      height += 1;
    }
  }
  if (plan > 0) mean.ground.head<2>() /= plan;
  if (height > 0) mean.ground.z() /= height;
  return mean;
}

// The covariance of the equations, point by point or of all at once, and what is done with it.
class Weights {
 public:
  Weights(std::span<const AbsoluteControl> pairs, const std::vector<Row>& rows, const MatrixXd* full)
      : pairs_(pairs), rows_(rows), full_(full) {}

  // False when it is not positive definite.
  [[nodiscard]] bool set(const Matrix3d& scaled_rotation) {
    scaled_rotation_ = scaled_rotation;
    if (full_) return set_full();
    factors_.clear();
    for (std::size_t begin = 0; begin < rows_.size();) {
      const std::size_t end = group_end(begin);
      const AbsoluteControl& pair = pairs_[rows_[begin].pair];
      const Matrix3d all =
          pair.ground_covariance + scaled_rotation * pair.model_covariance * scaled_rotation.transpose();
      Small block(end - begin, end - begin);
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t j = begin; j < end; ++j) block(i - begin, j - begin) = all(rows_[i].axis, rows_[j].axis);
      Eigen::LLT<Small> factor(block);
      if (factor.info() != Eigen::Success || !(block.trace() > 0)) return false;
      factors_.push_back(std::move(factor));
      begin = end;
    }
    return true;
  }
  // L^-1 of rows that belong to the equations.
  template <class Matrix>
  void whiten(Matrix& m) const {
    if (full_) {
      m = whole_.matrixL().solve(m).eval();
      return;
    }
    std::size_t begin = 0;
    for (const auto& factor : factors_) {
      auto block = m.middleRows(begin, factor.rows());
      block = factor.matrixL().solve(block).eval();
      begin += static_cast<std::size_t>(factor.rows());
    }
  }
  template <class Matrix>
  void whiten_transposed(Matrix& m) const {  // L^-T
    if (full_) {
      m = whole_.matrixU().solve(m).eval();
      return;
    }
    std::size_t begin = 0;
    for (const auto& factor : factors_) {
      auto block = m.middleRows(begin, factor.rows());
      block = factor.matrixU().solve(block).eval();
      begin += static_cast<std::size_t>(factor.rows());
    }
  }
  // W^-1 of the equations, its diagonal, and the diagonal of W.
  void diagonals(VectorXd& inverse, VectorXd& covariance) const {
    inverse.resize(static_cast<Eigen::Index>(rows_.size()));
    covariance.resize(inverse.size());
    if (full_) {
      inverse = whole_.solve(MatrixXd::Identity(inverse.size(), inverse.size())).diagonal();
      covariance = whole_.reconstructedMatrix().diagonal();
      return;
    }
    Eigen::Index begin = 0;
    for (const auto& factor : factors_) {
      const Eigen::Index n = factor.rows();
      inverse.segment(begin, n) = factor.solve(Small::Identity(n, n)).diagonal();
      covariance.segment(begin, n) = factor.reconstructedMatrix().diagonal();
      begin += n;
    }
  }
  // Corrections of the model coordinates of all points by the multipliers W^-1 e.
  [[nodiscard]] std::vector<Vector3d> model_corrections(const VectorXd& multipliers) const {
    std::vector<Vector3d> on_ground(pairs_.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < rows_.size(); ++i)
      on_ground[rows_[i].pair][rows_[i].axis] = multipliers[static_cast<Eigen::Index>(i)];
    std::vector<Vector3d> corrections(pairs_.size());
    if (full_) {
      VectorXd stacked(3 * static_cast<Eigen::Index>(pairs_.size()));
      for (std::size_t i = 0; i < pairs_.size(); ++i)
        stacked.segment<3>(3 * static_cast<Eigen::Index>(i)) = scaled_rotation_.transpose() * on_ground[i];
      const VectorXd all = *full_ * stacked;
      for (std::size_t i = 0; i < pairs_.size(); ++i) corrections[i] = all.segment<3>(3 * static_cast<Eigen::Index>(i));
      return corrections;
    }
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      corrections[i] = pairs_[i].model_covariance * (scaled_rotation_.transpose() * on_ground[i]);
    return corrections;
  }

 private:
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;

  [[nodiscard]] std::size_t group_end(std::size_t begin) const {
    std::size_t end = begin;
    while (end < rows_.size() && rows_[end].pair == rows_[begin].pair) ++end;
    return end;
  }
  [[nodiscard]] bool set_full() {
    const auto n = static_cast<Eigen::Index>(rows_.size());
    MatrixXd jacobian = MatrixXd::Zero(n, full_->rows());
    MatrixXd sum = MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Row& row = rows_[static_cast<std::size_t>(i)];
      jacobian.block<1, 3>(i, 3 * static_cast<Eigen::Index>(row.pair)) = scaled_rotation_.row(row.axis);
      for (Eigen::Index j = 0; j < n; ++j)
        if (const Row& other = rows_[static_cast<std::size_t>(j)]; other.pair == row.pair)
          sum(i, j) = pairs_[row.pair].ground_covariance(row.axis, other.axis);
    }
    sum += jacobian * *full_ * jacobian.transpose();
    whole_.compute(sum);
    return whole_.info() == Eigen::Success;
  }

  std::span<const AbsoluteControl> pairs_;
  const std::vector<Row>& rows_;
  const MatrixXd* full_;
  Matrix3d scaled_rotation_ = Matrix3d::Identity();
  std::vector<Eigen::LLT<Small>> factors_;
  Eigen::LLT<MatrixXd> whole_;
};

// The normal matrix with unit diagonal has an inverse: its covariance; nothing when a combination is left open.
std::optional<Matrix7> covariance_of(const Matrix7& normal) {
  const Vector7 scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Matrix7 unit = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(unit);
  if (!(eigen.eigenvalues()[0] > kLeastEigenvalue)) return std::nullopt;
  const Matrix7 inverse =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return Matrix7(scale.asDiagonal() * inverse * scale.asDiagonal());
}

// One fit from a start. All in reduced coordinates: ground - reduced.ground = position + scale R (model -
// reduced.model).
class Fit {
 public:
  Fit(std::span<const AbsoluteControl> pairs, const std::vector<Row>& rows, const Reduced& reduced,
      const MatrixXd* model_covariance)
      : pairs_(pairs),
        rows_(rows),
        reduced_(reduced),
        weights_(pairs, rows, model_covariance),
        corrections_(pairs.size(), Vector3d::Zero()) {}

  // False: the points leave something open, weights are not positive definite, or it does not converge.
  [[nodiscard]] bool run(const Similarity3& ground_from_model) {
    scale_ = ground_from_model.scale;
    rotation_ = ground_from_model.rotation;
    position_ = ground_from_model * reduced_.model - reduced_.ground;
    has_misfits_ = false;
    bool is_near = false;
    double before = std::numeric_limits<double>::infinity();  // the last step, in standard deviations
    for (iterations_ = 1; iterations_ <= kMostIterations; ++iterations_) {
      if (!set_equations()) return false;
      const Matrix7 normal = design_.transpose() * design_;
      const auto covariance = covariance_of(normal);
      if (!covariance) return false;
      covariance_ = *covariance;
      Vector7 step = covariance_ * (design_.transpose() * misfit_);
      const double turn = step.segment<3>(3).norm();
      if (turn > 0.6) step *= 0.6 / turn;
      if (std::abs(step[6]) > 1) step *= 1 / std::abs(step[6]);
      move(step);
      const double length = std::sqrt(step.cwiseAbs2().dot(covariance_.diagonal().cwiseInverse()));
      is_near |= turn < 1e-2 && std::abs(step[6]) < 1e-2;
      if (is_near) correct_model();
      const bool is_rounding = length < 1e-3 && length > before / 2;
      if (is_near && (length < 1e-9 || is_rounding)) return finish();
      before = length;
    }
    return false;
  }

  [[nodiscard]] double cost() const { return misfit_.squaredNorm(); }
  [[nodiscard]] Vector3d up() const { return rotation_ * Vector3d::UnitZ(); }
  [[nodiscard]] const Eigen::Quaterniond& rotation() const { return rotation_; }

  [[nodiscard]] AbsoluteOrientation result() const {
    AbsoluteOrientation out;
    out.ground_from_model = {scale_, rotation_, Vector3d::Zero()};
    out.ground_from_model.translation = position_ + reduced_.ground - out.ground_from_model * reduced_.model;
    out.centroid_in_model = reduced_.model;
    out.covariance = covariance_;
    out.redundancy = static_cast<int>(rows_.size()) - 7;
    if (out.redundancy > 0) out.sigma0 = std::sqrt(cost() / out.redundancy);
    out.iterations = iterations_;
    out.residuals = residuals();
    return out;
  }

 private:
  // Whitened equations at the present parameters and corrected model coordinates.
  [[nodiscard]] bool set_equations() {
    if (!set_misfits()) return false;
    const Matrix3d turned = scale_ * rotation_.toRotationMatrix();
    design_.resize(static_cast<Eigen::Index>(rows_.size()), 7);
    for (Eigen::Index k = 0; k < design_.rows(); ++k) {
      const auto [i, axis] = rows_[static_cast<std::size_t>(k)];
      const Vector3d arm = turned * (pairs_[i].in_model - reduced_.model + corrections_[i]);
      design_.row(k).head<3>() = Vector3d::Unit(axis).transpose();
      design_.row(k).segment<3>(3) = -skew(arm).row(axis);
      design_(k, 6) = arm[axis];
    }
    weights_.whiten(design_);
    return design_.allFinite();
  }
  // Weights and misfits, which model corrections do not change.
  [[nodiscard]] bool set_misfits() {
    if (has_misfits_) return true;
    const Matrix3d turned = scale_ * rotation_.toRotationMatrix();
    if (!weights_.set(turned)) return false;
    misfit_.resize(static_cast<Eigen::Index>(rows_.size()));
    for (Eigen::Index k = 0; k < misfit_.size(); ++k) {
      const auto [i, axis] = rows_[static_cast<std::size_t>(k)];
      const Vector3d measured = turned * (pairs_[i].in_model - reduced_.model);
      misfit_[k] = pairs_[i].in_ground[axis] - reduced_.ground[axis] - position_[axis] - measured[axis];
    }
    raw_ = misfit_;
    weights_.whiten(misfit_);
    has_misfits_ = misfit_.allFinite();
    return has_misfits_;
  }
  void move(const Vector7& step) {
    has_misfits_ = false;
    position_ += step.head<3>();
    rotation_ = (rotation_by(step.segment<3>(3)) * rotation_).normalized();
    scale_ *= std::exp(step[6]);
  }
  // Adjusted model coordinates, at which the next equations are linearised.
  void correct_model() {
    if (!set_misfits()) return;
    VectorXd multipliers = misfit_;
    weights_.whiten_transposed(multipliers);
    corrections_ = weights_.model_corrections(multipliers);
  }
  [[nodiscard]] bool finish() {
    if (!set_equations()) return false;
    const auto covariance = covariance_of(design_.transpose() * design_);
    if (!covariance) return false;
    covariance_ = *covariance;
    return scale_ > 0;
  }

  // Misfit e, its covariance W - A C A', redundancy (W - A C A') W^-1 and w by W^-1 e (Baarda 1968, correlated).
  [[nodiscard]] std::vector<ControlResidual> residuals() const {
    VectorXd multipliers = misfit_, inverse, covariance;
    Design weighted = design_, plain = design_;
    weights_.whiten_transposed(multipliers);  // W^-1 e
    weights_.whiten_transposed(weighted);     // W^-1 A
    weights_.diagonals(inverse, covariance);
    const std::vector<Vector3d> model = weights_.model_corrections(multipliers);
    std::vector<ControlResidual> out(pairs_.size());
    const Matrix3d turned = scale_ * rotation_.toRotationMatrix();
    for (std::size_t i = 0; i < pairs_.size(); ++i) out[i].model_correction = model[i];
    for (Eigen::Index k = 0; k < raw_.size(); ++k) {
      const auto [i, axis] = rows_[static_cast<std::size_t>(k)];
      Vector7 row = unwhitened(k);
      const Vector7 by_weight = weighted.row(k).transpose();
      ControlResidual& residual = out[i];
      residual.misfit[axis] = raw_[k];
      residual.sigma[axis] = std::sqrt(std::max(0.0, covariance[k] - row.dot(covariance_ * row)));
      residual.redundancy[axis] = std::max(0.0, 1 - row.dot(covariance_ * by_weight));
      const double variance = inverse[k] - by_weight.dot(covariance_ * by_weight);
      if (variance > 1e-9 * inverse[k]) residual.w[axis] = multipliers[k] / std::sqrt(variance);
    }
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Vector3d by_model = turned * out[i].model_correction;
      for (int axis = 0; axis < 3; ++axis)
        if (axis < 2 ? pairs_[i].has_plan : pairs_[i].has_height)
          out[i].ground_correction[axis] = by_model[axis] - out[i].misfit[axis];
    }
    return out;
  }
  // The row of the design before it was whitened.
  [[nodiscard]] Vector7 unwhitened(Eigen::Index k) const {
    const auto [i, axis] = rows_[static_cast<std::size_t>(k)];
    const Vector3d arm = scale_ * (rotation_ * (pairs_[i].in_model - reduced_.model + corrections_[i]));
    Vector7 row = Vector7::Zero();
    row[axis] = 1;
    row.segment<3>(3) = -skew(arm).row(axis).transpose();
    row[6] = arm[axis];
    return row;
  }

  std::span<const AbsoluteControl> pairs_;
  const std::vector<Row>& rows_;
  const Reduced& reduced_;
  Weights weights_;
  std::vector<Vector3d> corrections_;  // of model coordinates
  bool has_misfits_ = false;           // at the present parameters
  double scale_ = 1;
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Vector3d position_ = Vector3d::Zero();
  Design design_;
  VectorXd misfit_, raw_;
  Matrix7 covariance_ = Matrix7::Zero();
  int iterations_ = 0;
};

Similarity3 about(const Reduced& reduced, double scale, const Eigen::Quaterniond& rotation) {
  Similarity3 start{scale, rotation.normalized(), Vector3d::Zero()};
  start.translation = reduced.ground - start * reduced.model;
  return start;
}

// The two indices that are farthest apart in the model, of those that pass.
template <class Passes>
std::array<std::size_t, 2> farthest(std::span<const AbsoluteControl> pairs, const Passes& passes) {
  std::array<std::size_t, 2> best{0, 0};
  double longest = -1;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t j = i + 1; j < pairs.size(); ++j)
      if (passes(pairs[i]) && passes(pairs[j]))
        if (const double length = (pairs[j].in_model - pairs[i].in_model).norm(); length > longest) {
          longest = length;
          best = {i, j};
        }
  return best;
}

// Where two full points are given: all rotations about their line, in steps.
std::vector<Similarity3> starts_about_line(std::span<const AbsoluteControl> pairs) {
  constexpr int kSteps = 12;
  const auto [i, j] = farthest(pairs, [](const AbsoluteControl& pair) { return pair.is_full(); });
  const Vector3d model = pairs[j].in_model - pairs[i].in_model, ground = pairs[j].in_ground - pairs[i].in_ground;
  if (!(model.norm() > 0 && ground.norm() > 0)) return {};
  const Eigen::Quaterniond onto = Eigen::Quaterniond::FromTwoVectors(model, ground);
  std::vector<Similarity3> starts;
  for (int k = 0; k < kSteps; ++k) {
    const Eigen::AngleAxisd spin(2 * std::numbers::pi * k / kSteps, ground.normalized());
    Similarity3 start{ground.norm() / model.norm(), (spin * onto).normalized(), Vector3d::Zero()};
    start.translation = pairs[i].in_ground - start * pairs[i].in_model;
    starts.push_back(start);
  }
  return starts;
}

// A model whose w axis is upright: the similarity of the plan alone.
std::vector<Similarity3> level_start(std::span<const AbsoluteControl> pairs, const Reduced& reduced) {
  const auto [i, j] = farthest(pairs, [](const AbsoluteControl& pair) { return pair.has_plan; });
  const Eigen::Vector2d model = (pairs[j].in_model - pairs[i].in_model).head<2>();
  const Eigen::Vector2d ground = (pairs[j].in_ground - pairs[i].in_ground).head<2>();
  if (!(model.norm() > 0 && ground.norm() > 0)) return {};
  const double kappa = std::atan2(ground.y(), ground.x()) - std::atan2(model.y(), model.x());
  return {
      about(reduced, ground.norm() / model.norm(), Eigen::Quaterniond(Eigen::AngleAxisd(kappa, Vector3d::UnitZ())))};
}

std::vector<Similarity3> starts_of(std::span<const AbsoluteControl> pairs, const Reduced& reduced) {
  std::vector<Vector3d> model, ground;
  for (const AbsoluteControl& pair : pairs)
    if (pair.is_full()) {
      model.push_back(pair.in_model);
      ground.push_back(pair.in_ground);
    }
  if (const auto aligned = align(model, ground); aligned && aligned->scale > 0) return {*aligned};
  if (model.size() >= 2) return starts_about_line(pairs);
  return level_start(pairs, reduced);
}

Result<> check_counts(std::span<const AbsoluteControl> pairs, const std::vector<Row>& rows) {
  long plan = 0, height = 0;
  for (const AbsoluteControl& pair : pairs) {
    plan += pair.has_plan;
    height += pair.has_height;
  }
  if (plan < 2)
    return fail(Errc::kIllPosed,
                "absolute orientation needs two points that are known in plan, there are " + std::to_string(plan));
  if (height < 3)
    return fail(Errc::kIllPosed, "absolute orientation needs three points that are known in height, there are " +
                                     std::to_string(height));
  for (const Row& row : rows)
    if (const AbsoluteControl& pair = pairs[row.pair];
        !pair.in_model.allFinite() || !std::isfinite(pair.in_ground[row.axis]))
      return fail(Errc::kBadInput, "a coordinate of a control point is not finite");
  return {};
}

}  // namespace

Result<AbsoluteOrientation> absolute_orientation(std::span<const AbsoluteControl> pairs,
                                                 const AbsoluteOptions& options) {
  const std::vector<Row> rows = rows_of(pairs);
  COLLINEA_TRY(check_counts(pairs, rows));
  const Eigen::MatrixXd* full = options.model_covariance;
  COLLINEA_CHECK(!full ||
                 (full->rows() == 3 * static_cast<Eigen::Index>(pairs.size()) && full->cols() == full->rows()));
  const Reduced reduced = centroids(pairs);
  const std::vector<Similarity3> starts =
      options.start ? std::vector<Similarity3>{*options.start} : starts_of(pairs, reduced);

  constexpr double kAsGood = 6.63;        // chi-squared of one degree of freedom, 1 %
  constexpr double kSameRotation = 1e-3;  // rad
  std::vector<Fit> fits;
  for (const Similarity3& start : starts) {
    Fit fit(pairs, rows, reduced, full);
    if (!fit.run(start)) continue;
    const auto same = [&](const Fit& other) { return angle_between(fit.rotation(), other.rotation()) < kSameRotation; };
    if (std::none_of(fits.begin(), fits.end(), same)) fits.push_back(std::move(fit));
  }
  if (fits.empty())
    return fail(
        Errc::kIllPosed,
        "the control points do not determine the seven parameters: they lie on or near a line, or the heights do");
  double least = std::numeric_limits<double>::infinity();
  for (const Fit& fit : fits) least = std::min(least, fit.cost());
  const Fit* best = nullptr;
  int solutions = 0;
  for (const Fit& fit : fits) {
    if (fit.cost() > least + kAsGood) continue;
    ++solutions;
    if (!best || fit.up().z() > best->up().z()) best = &fit;
  }
  AbsoluteOrientation result = best->result();
  result.solutions = solutions;
  return result;
}

GroundPoint on_ground(const AbsoluteOrientation& orientation, const Vector3d& in_model,
                      const Matrix3d& model_covariance) {
  const Similarity3& similarity = orientation.ground_from_model;
  const Matrix3d turned = similarity.scale * similarity.rotation.toRotationMatrix();
  const Vector3d arm = turned * (in_model - orientation.centroid_in_model);
  Eigen::Matrix<double, 3, 7> by;
  by << Matrix3d::Identity(), -skew(arm), arm;
  return {similarity * in_model,
          by * orientation.covariance * by.transpose() + turned * model_covariance * turned.transpose()};
}

AbsoluteParameters parameters_of(const AbsoluteOrientation& orientation) {
  const Similarity3& similarity = orientation.ground_from_model;
  const CardanAngles angles = cardan_angles(similarity.rotation.conjugate().toRotationMatrix());
  const OmegaPhiKappa degrees{angles.omega_rad * 180 / std::numbers::pi, angles.phi_rad * 180 / std::numbers::pi,
                              angles.kappa_rad * 180 / std::numbers::pi};
  const Vector3d arm = -similarity.scale * (similarity.rotation * orientation.centroid_in_model);
  Matrix7 by = Matrix7::Zero();  // T, angles, scale by centroid, rotation, ln scale
  by.topRows<3>() << Matrix3d::Identity(), -skew(arm), arm;
  by.block<3, 3>(3, 3) = angles_by_rotation_of_camera(degrees);
  by(6, 6) = similarity.scale;
  return {similarity.translation, angles.omega_rad, angles.phi_rad,
          angles.kappa_rad,       similarity.scale, by * orientation.covariance * by.transpose()};
}

std::optional<std::vector<std::size_t>> contradicting_control(std::span<const AbsoluteControl> pairs,
                                                              std::uint64_t seed) {
  std::vector<bundle::PositionPair> full;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i].is_full()) continue;
    full.push_back({pairs[i].in_model, pairs[i].in_ground, std::sqrt(pairs[i].ground_covariance.trace() / 3)});
    indices.push_back(i);
  }
  if (full.size() < 4) return std::nullopt;
  const auto fit = bundle::robust_similarity(full, seed);
  if (!fit) return std::nullopt;
  std::vector<std::size_t> wrong;
  for (std::size_t k = 0; k < full.size(); ++k)
    if (fit->weights[k] == 0) wrong.push_back(indices[k]);
  return wrong;
}

}  // namespace collinea
