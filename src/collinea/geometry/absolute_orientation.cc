// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/absolute_orientation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "collinea/geometry/internal/absolute_starts.h"
#include "collinea/geometry/internal/control_weights.h"
#include "collinea/geometry/robust_similarity.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/rotation_angles.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix7 = AbsoluteOrientation::Matrix7;
using Vector7 = Eigen::Matrix<double, 7, 1>;

constexpr double kLeastEigenvalue = 1e-11;  // of the normal matrix with unit diagonal
constexpr int kMostIterations = 60;

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
  Fit(std::span<const AbsoluteControl> pairs, const ReducedControl& reduced, const MatrixXd* model_covariance)
      : pairs_(pairs), reduced_(reduced), weights_(pairs, model_covariance) {
    for (const AbsoluteControl& pair : pairs) {
      models_.push_back(pair.in_model - reduced.model);
      adjusted_.push_back(models_.back());
      components_ += 2 * pair.has_plan + pair.has_height;
    }
  }

  // False: the points leave something open, weights are not positive definite, or it does not converge.
  [[nodiscard]] bool run(const Similarity3& ground_from_model) {
    scale_ = ground_from_model.scale;
    rotation_ = ground_from_model.rotation;
    position_ = ground_from_model * reduced_.model - reduced_.ground;
    has_misfits_ = false;
    bool is_near = false;
    double before = std::numeric_limits<double>::infinity();  // the last step, in standard deviations
    for (iterations_ = 1; iterations_ <= kMostIterations; ++iterations_) {
      if (!solve()) return false;
      Vector7 step = covariance_ * right_;
      const double turn = step.segment<3>(3).norm();
      if (turn > 0.6) step *= 0.6 / turn;
      if (std::abs(step[6]) > 1) step *= 1 / std::abs(step[6]);
      move(step);
      const double length = std::sqrt(step.cwiseAbs2().dot(covariance_.diagonal().cwiseInverse()));
      is_near |= turn < 1e-2 && std::abs(step[6]) < 1e-2;
      if (is_near && !correct_model()) return false;
      const bool is_rounding = length < 1e-3 && length > before / 2;
      if (is_near && (length < 1e-9 || is_rounding)) return solve() && scale_ > 0;
      before = length;
    }
    return false;
  }

  [[nodiscard]] double cost() const { return cost_; }
  [[nodiscard]] Vector3d up() const { return rotation_ * Vector3d::UnitZ(); }
  [[nodiscard]] const Eigen::Quaterniond& rotation() const { return rotation_; }

  // To be asked once.
  [[nodiscard]] AbsoluteOrientation result() {
    AbsoluteOrientation out;
    out.ground_from_model = {scale_, rotation_, Vector3d::Zero()};
    out.ground_from_model.translation = position_ + reduced_.ground - out.ground_from_model * reduced_.model;
    out.centroid_in_model = reduced_.model;
    out.covariance = covariance_;
    out.redundancy = components_ - 7;
    if (out.redundancy > 0) out.sigma0 = std::sqrt(cost() / out.redundancy);
    out.iterations = iterations_;
    out.residuals = residuals();
    return out;
  }

 private:
  using Rows = ControlWeights::Rows;
  using Matrix8 = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;

  [[nodiscard]] Matrix3d turned() const { return scale_ * rotation_.toRotationMatrix(); }

  // The equations of a point at its adjusted model coordinates, before they are weighted.
  [[nodiscard]] Rows rows_of(std::size_t i, const Matrix3d& by) const {
    const Vector3d arm = by * adjusted_[i];
    Rows rows;
    rows << 1, 0, 0, 0, arm.z(), -arm.y(), arm.x(), misfit_[i].x(),  //
        0, 1, 0, -arm.z(), 0, arm.x(), arm.y(), misfit_[i].y(),      //
        0, 0, 1, arm.y(), -arm.x(), 0, arm.z(), misfit_[i].z();
    if (!pairs_[i].has_plan) rows.topRows<2>().setZero();
    if (!pairs_[i].has_height) rows.row(2).setZero();
    return rows;
  }
  // Adds rows' rows to the upper triangle, row by row from an even column on.
  template <int... kRow>
  static void add_squares(const Rows& rows, Matrix8& normal, std::integer_sequence<int, kRow...>) {
    for (int k = 0; k < 3; ++k)
      ((normal.row(kRow).template tail<8 - kRow / 2 * 2>() +=
        rows(k, kRow) * rows.row(k).template tail<8 - kRow / 2 * 2>()),
       ...);
  }
  // Weighted equations at the present parameters and adjusted model coordinates, and the normal equations of them.
  [[nodiscard]] bool solve() {
    if (!set_misfits()) return false;
    const Matrix3d by = turned();
    design_.resize(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) design_[i] = rows_of(i, by);
    weights_.whiten(design_);
    Matrix8 normal = Matrix8::Zero();  // its upper triangle, with the right side
    for (const Rows& rows : design_) add_squares(rows, normal, std::make_integer_sequence<int, 7>{});
    const auto covariance = covariance_of(normal.topLeftCorner<7, 7>().selfadjointView<Eigen::Upper>());
    if (!covariance) return false;
    covariance_ = *covariance;
    right_ = normal.col(7).head<7>();
    return true;
  }
  // Weights and misfits, which the adjusted model coordinates do not change.
  [[nodiscard]] bool set_misfits() {
    if (has_misfits_) return true;
    const Matrix3d by = turned();
    if (!weights_.set(by)) return false;
    misfit_.resize(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      misfit_[i] = pairs_[i].in_ground - reduced_.ground - position_ - by * models_[i];
      clear_unknown(pairs_[i], misfit_[i]);
    }
    weighted_misfit_ = misfit_;
    weights_.whiten(weighted_misfit_);
    cost_ = 0;
    for (const Vector3d& misfit : weighted_misfit_) cost_ += misfit.squaredNorm();
    has_misfits_ = std::isfinite(cost_);
    return has_misfits_;
  }
  void move(const Vector7& step) {
    has_misfits_ = false;
    position_ += step.head<3>();
    rotation_ = (rotation_by(step.segment<3>(3)) * rotation_).normalized();
    scale_ *= std::exp(step[6]);
  }
  // Adjusted model coordinates, at which the next equations are linearised.
  [[nodiscard]] bool correct_model() {
    if (!set_misfits()) return false;
    const std::vector<Vector3d> corrections = weights_.model_corrections(multipliers());
    for (std::size_t i = 0; i < pairs_.size(); ++i) adjusted_[i] = models_[i] + corrections[i];
    return true;
  }
  [[nodiscard]] std::vector<Vector3d> multipliers() const {  // W^-1 e
    std::vector<Vector3d> out = weighted_misfit_;
    weights_.whiten_transposed(out);
    return out;
  }

  // Misfit e, its covariance W - A C A', redundancy (W - A C A') W^-1 and w by W^-1 e (Baarda 1968, correlated).
  [[nodiscard]] std::vector<ControlResidual> residuals() {
    const std::vector<Vector3d> by_weight = multipliers(), model = weights_.model_corrections(by_weight);
    weights_.whiten_transposed(design_);  // W^-1 A
    const ControlWeights::Diagonals diagonals = weights_.diagonals();
    Matrix8 covariance = Matrix8::Zero();
    covariance.topLeftCorner<7, 7>() = covariance_;
    std::vector<ControlResidual> out(pairs_.size());
    const Matrix3d by = turned();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      ControlResidual& residual = out[i];
      const Rows plain = rows_of(i, by), plain_by = plain.lazyProduct(covariance),
                 weighted_by = design_[i].lazyProduct(covariance);
      residual.misfit = misfit_[i];
      residual.model_correction = model[i];
      residual.ground_correction = by * model[i] - misfit_[i];
      clear_unknown(pairs_[i], residual.ground_correction);
      for (int axis = 0; axis < 3; ++axis) {
        if (!(axis < 2 ? pairs_[i].has_plan : pairs_[i].has_height)) continue;
        const double inverse = diagonals.inverse[i][axis];
        residual.sigma[axis] =
            std::sqrt(std::max(0.0, diagonals.covariance[i][axis] - plain_by.row(axis).dot(plain.row(axis))));
        residual.redundancy[axis] = std::max(0.0, 1 - plain_by.row(axis).dot(design_[i].row(axis)));
        const double variance = inverse - weighted_by.row(axis).dot(design_[i].row(axis));
        if (variance > 1e-9 * inverse) residual.w[axis] = by_weight[i][axis] / std::sqrt(variance);
      }
    }
    return out;
  }

  std::span<const AbsoluteControl> pairs_;
  const ReducedControl& reduced_;
  ControlWeights weights_;
  std::vector<Vector3d> models_, adjusted_;  // model coordinates from the centroid: as measured, corrected
  int components_ = 0;                       // known ones of all points
  bool has_misfits_ = false;                 // at the present parameters
  double scale_ = 1;
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Vector3d position_ = Vector3d::Zero();
  std::vector<Rows> design_;
  std::vector<Vector3d> misfit_, weighted_misfit_;
  double cost_ = 0;
  Matrix7 covariance_ = Matrix7::Zero();
  Vector7 right_ = Vector7::Zero();
  int iterations_ = 0;
};

Result<> check_counts(std::span<const AbsoluteControl> pairs) {
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
  for (const AbsoluteControl& pair : pairs) {
    Vector3d in_ground = pair.in_ground;
    clear_unknown(pair, in_ground);
    if ((pair.has_plan || pair.has_height) && !(pair.in_model.allFinite() && in_ground.allFinite()))
      return fail(Errc::kBadInput, "a coordinate of a control point is not finite");
  }
  return {};
}

}  // namespace

Result<AbsoluteOrientation> absolute_orientation(std::span<const AbsoluteControl> pairs,
                                                 const AbsoluteOptions& options) {
  COLLINEA_TRY(check_counts(pairs));
  const Eigen::MatrixXd* full = options.model_covariance;
  COLLINEA_CHECK(!full ||
                 (full->rows() == 3 * static_cast<Eigen::Index>(pairs.size()) && full->cols() == full->rows()));
  const ReducedControl reduced = reduced_control(pairs);
  const std::vector<Similarity3> starts =
      options.start ? std::vector<Similarity3>{*options.start} : absolute_starts(pairs, reduced);

  constexpr double kAsGood = 6.63;        // chi-squared of one degree of freedom, 1 %
  constexpr double kSameRotation = 1e-3;  // rad
  std::vector<Fit> fits;
  for (const Similarity3& start : starts) {
    Fit fit(pairs, reduced, full);
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
  Fit* best = nullptr;
  int solutions = 0;
  for (Fit& fit : fits) {
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
