// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/mark_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "collinea/adjust/kind_image_point.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostRounds = 20;
constexpr double kSettled = 1e-8;           // of a step of all unknowns, in their standard deviations, squared
constexpr double kLeastEigenvalue = 1e-12;  // of the largest, of normals scaled to one: rounding leaves no more

// Where the unknowns of the images and cameras that have rays stand among those that are solved for.
class Involved {
 public:
  Involved(const Problem& problem, std::span<const MarkPoint> points) : problem_(problem) {
    for (const MarkPoint& point : points)
      for (const Ray& ray : point.rays) {
        if (static_cast<int>(ray.image) < problem.poses) take(poses_, ray.image, 6 * static_cast<int>(ray.image), 6);
        const int camera = problem.images[ray.image].camera;
        const ProblemCamera& its = problem.cameras[static_cast<std::size_t>(camera)];
        take(cameras_, camera, 6 * problem.poses + its.first_global, static_cast<int>(its.free.size()));
      }
  }
  [[nodiscard]] const std::vector<int>& rows() const { return rows_; }
  /// -1: the image is fixed.
  [[nodiscard]] Index of_pose(std::uint32_t image) const {
    const auto found = poses_.find(image);
    return found == poses_.end() ? -1 : found->second;
  }
  [[nodiscard]] Index of_camera(int camera) const { return cameras_.at(camera); }
  [[nodiscard]] const std::map<int, Index>& cameras() const { return cameras_; }

 private:
  template <class Key>
  void take(std::map<Key, Index>& table, Key key, int first_row, int count) {
    if (!table.try_emplace(key, static_cast<Index>(rows_.size())).second) return;
    for (int k = 0; k < count; ++k) rows_.push_back(first_row + k);
  }

  const Problem& problem_;
  std::vector<int> rows_;
  std::map<std::uint32_t, Index> poses_;
  std::map<int, Index> cameras_;
};

// Where images and cameras are that moved from where the block has them, and with them the block as a whole.
class MovedImages {
 public:
  MovedImages(const Problem& problem, const State& state, const Involved& involved,
              const std::optional<BlockMotion>& motion)
      : problem_(problem), state_(state), involved_(involved), motion_(motion) {
    images = expected = VectorXd::Zero(static_cast<Index>(involved.rows().size()));
  }

  VectorXd images;                  // by how much
  VectorXd expected;                // without the marks
  Vector7 whole = Vector7::Zero();  // and the block
  [[nodiscard]] Index motions() const { return motion_ ? 7 : 0; }

  // Computes frames and lenses for the equations of rays.
  void settle() {
    moved_ = motion_ ? motion_->after(whole) : BlockMotion{};
    frames_.clear();
    lenses_.clear();
    for (const auto& [camera, first] : involved_.cameras()) {
      const auto c = static_cast<std::size_t>(camera);
      auto params = state_.cameras[c];
      const std::vector<int>& free = problem_.cameras[c].free;
      for (std::size_t k = 0; k < free.size(); ++k)
        params[static_cast<std::size_t>(free[k])] += images[first + static_cast<Index>(k)];
      lenses_.emplace(camera, lens_with(state_.lenses[c], params.data()));
    }
  }

  // The frame of an image, after settle().
  const Frame& frame(std::uint32_t image) {
    auto [its, is_new] = frames_.try_emplace(image);
    if (!is_new) return its->second;
    const Frame& before = state_.frames[image];
    const auto rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(before.data());
    Eigen::Quaterniond rotation(Matrix3d{rows});
    Vector3d centre(before[9], before[10], before[11]);
    if (const Index first = involved_.of_pose(image); first >= 0) {
      rotation = rotation_by(images.segment<3>(first)) * rotation;
      centre += images.segment<3>(first + 3);
    }
    if (motion_) {
      rotation = rotation * moved_.moved.rotation.conjugate();
      centre = moved_.moved * centre;
    }
    return its->second = frame_of(rotation.normalized(), centre.data());
  }

  // The two equations of a ray: what it is off by [sigmas] and its derivatives by images, the block and its point.
  struct Rows {
    Eigen::Ref<VectorXd> misclosure;
    Eigen::Ref<MatrixXd> by_images, by_whole, by_point;
  };
  void linearise_ray(const Ray& ray, const Vector3d& position, Rows rows) {
    using Rows3 = Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>;
    const int camera = problem_.images[ray.image].camera;
    const Lens& lens = lenses_.at(camera);
    LinearRay linear;
    linearise(ray, frame(ray.image), lens, position.data(), Loss{}, &linear);
    const Rows3 by_rotation(linear.by_rotation), by_point(linear.by_point);
    rows.misclosure = Eigen::Vector2d(linear.residual[0], linear.residual[1]);
    rows.by_point = by_point;
    if (motion_) rows.by_whole = -by_point * moved_.derivatives_at(position);
    if (const Index pose = involved_.of_pose(ray.image); pose >= 0) {
      // The block moves as a whole after the images have moved in it.
      const Similarity3 moved = motion_ ? moved_.moved : Similarity3{};
      rows.by_images.middleCols<3>(pose) = by_rotation;
      rows.by_images.middleCols<3>(pose + 3) = -by_point * moved.scale * moved.rotation.toRotationMatrix();
    }
    const std::vector<int>& free = problem_.cameras[static_cast<std::size_t>(camera)].free;
    if (free.empty()) return;
    std::vector<double> by_camera(2 * free.size());
    linearise_camera(linear, lens, free, by_camera.data());
    for (std::size_t k = 0; k < free.size(); ++k)
      for (int r = 0; r < 2; ++r)
        rows.by_images(r, involved_.of_camera(camera) + static_cast<Index>(k)) =
            by_camera[static_cast<std::size_t>(r) * free.size() + k];
  }

 private:
  const Problem& problem_;
  const State& state_;
  const Involved& involved_;
  const std::optional<BlockMotion>& motion_;
  BlockMotion moved_{};
  std::map<std::uint32_t, Frame> frames_;
  std::map<int, Lens> lenses_;
};

// Its equations at one place, for all rays of some points.
struct Equations {
  VectorXd misclosure;
  MatrixXd by_images, by_whole, by_points;

  Equations(Index rays, Index images, Index motions, Index points)
      : misclosure(VectorXd::Zero(2 * rays)),
        by_images(MatrixXd::Zero(2 * rays, images)),
        by_whole(MatrixXd::Zero(2 * rays, motions)),
        by_points(MatrixXd::Zero(2 * rays, 3 * points)) {}

  void add(Index ray, Index point, const Ray& measured, const Vector3d& position, MovedImages& images) {
    images.linearise_ray(measured, position,
                         {misclosure.segment<2>(2 * ray), by_images.middleRows<2>(2 * ray),
                          by_whole.middleRows<2>(2 * ray), by_points.block<2, 3>(2 * ray, 3 * point)});
  }
};

// The adjustment of the points that take part, and of the images with them.
class MarkAdjustment {
 public:
  MarkAdjustment(std::span<const MarkPoint> points, const MatrixXd& cofactor, MovedImages& images,
                 const MarkGround& ground, const Earth& earth)
      : cofactor_(cofactor), images_(images), ground_(ground), earth_(earth) {
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (!points[p].takes_part) continue;
      points_.push_back(&points[p]);
      rays_ += static_cast<Index>(points[p].rays.size());
    }
    unknowns_.setZero(first_auxiliary() + static_cast<Index>(ground.auxiliaries.size()));
    for (std::size_t p = 0; p < points_.size(); ++p) unknowns_.segment<3>(Index(3 * p)) = points_[p]->start;
    for (std::size_t k = 0; k < ground.auxiliaries.size(); ++k)
      unknowns_[first_auxiliary() + static_cast<Index>(k)] = ground.auxiliaries[k];
  }

  // False when something is not determined.
  [[nodiscard]] bool solve() {
    for (int round = 0; round < kMostRounds && !converged_; ++round) {
      if (!reduce()) return false;
      const VectorXd step = inverse_ * right_;
      if (!step.allFinite()) return false;
      const VectorXd moved =
          images_.expected + cofactor_ * (by_images_.transpose() * weights_.solve(misclosure_ - by_unknowns_ * step));
      converged_ = step.dot(normals_ * step) < kSettled && moved_by(moved - images_.images) < kSettled;
      unknowns_ += step;
      images_.images = moved;
      images_.whole.head(images_.motions()) = unknowns_.segment(first_motion(), images_.motions());
    }
    return reduce();
  }

  [[nodiscard]] bool converged() const { return converged_; }
  [[nodiscard]] Vector3d position(std::size_t point) const { return unknowns_.segment<3>(Index(3 * point)); }
  [[nodiscard]] MatrixXd cofactor() const {
    const auto count = static_cast<Index>(3 * points_.size());
    return inverse_.topLeftCorner(count, count);
  }
  [[nodiscard]] VectorXd residuals() const { return misclosure_ - by_images_ * (images_.images - images_.expected); }
  [[nodiscard]] VectorXd redundancy() const {
    const MatrixXd weighted = weights_.solve(by_unknowns_);
    const MatrixXd weights = weights_.solve(MatrixXd::Identity(misclosure_.size(), misclosure_.size()));
    return (weights - weighted * inverse_ * weighted.transpose()).diagonal();
  }
  // Of the images and cameras, then the motion of the block, as the points leave them.
  [[nodiscard]] MatrixXd cofactor_of_images() const {
    const Index images = cofactor_.rows(), motions = images_.motions();
    MatrixXd out = MatrixXd::Zero(images + motions, images + motions);
    out.topLeftCorner(images, images) = cofactor_;
    if (rays_ == 0) return out;
    const MatrixXd gain = weights_.solve(by_images_ * cofactor_);  // S^-1 A Q
    const MatrixXd by_unknowns = gain.transpose() * by_unknowns_;
    const MatrixXd with_unknowns = -by_unknowns * inverse_;
    out.topLeftCorner(images, images) -=
        cofactor_ * by_images_.transpose() * gain + with_unknowns * by_unknowns.transpose();
    out.topRightCorner(images, motions) = with_unknowns.middleCols(first_motion(), motions);
    out.bottomLeftCorner(motions, images) = out.topRightCorner(images, motions).transpose();
    out.bottomRightCorner(motions, motions) = inverse_.block(first_motion(), first_motion(), motions, motions);
    return out;
  }

 private:
  // Unknowns are the points, the motion of the block, and those that belong to measurements on the ground.
  [[nodiscard]] Index first_motion() const { return static_cast<Index>(3 * points_.size()); }
  [[nodiscard]] Index first_auxiliary() const { return first_motion() + images_.motions(); }

  // Of a step of the images, the largest in their standard deviations, squared; what is known exactly counts nothing.
  [[nodiscard]] double moved_by(const VectorXd& step) const {
    double largest = 0;
    for (Index i = 0; i < step.size(); ++i)
      if (cofactor_(i, i) > 0) largest = std::max(largest, step[i] * step[i] / cofactor_(i, i));
    return largest;
  }

  void linearise_all() {
    const auto count = static_cast<Index>(points_.size());
    Equations now(rays_, cofactor_.rows(), images_.motions(), count);
    images_.settle();
    Index ray = 0;
    for (Index p = 0; p < count; ++p)
      for (const Ray& one : points_[std::size_t(p)]->rays) now.add(ray++, p, one, position(std::size_t(p)), images_);
    // As if the images were where they are expected: that is an observation, not a new beginning.
    misclosure_ = now.misclosure + now.by_images * (images_.images - images_.expected);
    by_images_ = std::move(now.by_images);
    by_unknowns_.setZero(2 * rays_, unknowns_.size());
    by_unknowns_.leftCols(first_auxiliary()) << now.by_points, now.by_whole;
  }

  // The normal equations of points and motion, there; false when they are singular.
  [[nodiscard]] bool reduce() {
    linearise_all();
    MatrixXd covariance = by_images_ * cofactor_ * by_images_.transpose();
    covariance.diagonal().array() += 1;
    weights_.compute(covariance);
    if (weights_.info() != Eigen::Success) return false;
    normals_ = by_unknowns_.transpose() * weights_.solve(by_unknowns_);
    right_ = by_unknowns_.transpose() * weights_.solve(misclosure_);
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const auto first = static_cast<Index>(3 * p);
      normals_.block<3, 3>(first, first) += points_[p]->weight;
      right_.segment<3>(first) += points_[p]->weight * (points_[p]->given - position(p));
    }
    for (const MarkLink& link : ground_.links) add_link(link);
    const VectorXd scale = normals_.diagonal().cwiseSqrt();
    if (!(scale.minCoeff() > 0) || !scale.allFinite()) return false;
    const VectorXd inverse_scale = scale.cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(inverse_scale.asDiagonal() * normals_ *
                                                        inverse_scale.asDiagonal());
    const VectorXd& values = eigen.eigenvalues();
    if (!(values[0] > kLeastEigenvalue * values[values.size() - 1])) return false;
    const MatrixXd& vectors = eigen.eigenvectors();
    inverse_ = inverse_scale.asDiagonal() * vectors * values.cwiseInverse().asDiagonal() * vectors.transpose() *
               inverse_scale.asDiagonal();
    return true;
  }

  // What was measured on the ground depends on neither images nor marks.
  void add_link(const MarkLink& link) {
    const Vector3d from = position(link.from), to = position(link.to);
    const Index first = first_auxiliary() + std::max(link.auxiliary, 0);
    const double* own = link.auxiliary < 0 ? nullptr : &unknowns_[first];
    const GeodeticModel model =
        link.shape >= 0
            ? shape_model(link.observation, ground_.shapes[static_cast<std::size_t>(link.shape)], own, from, earth_)
            : geodetic_model(link.observation, from, to, own ? *own : 0, earth_);
    VectorXd row = VectorXd::Zero(unknowns_.size());
    row.segment<3>(Index(3 * link.from)) += model.by_from;
    if (link.to != link.from) row.segment<3>(Index(3 * link.to)) += model.by_to;
    for (int k = 0; k < model.auxiliaries; ++k) row[first + k] += model.by_auxiliary[static_cast<std::size_t>(k)];
    const double weight = 1 / (link.observation.sigma * link.observation.sigma);
    normals_ += weight * row * row.transpose();
    right_ += weight * geodetic_residual(link.observation, model) * row;
  }

  const MatrixXd& cofactor_;  // of the images and cameras
  MovedImages& images_;
  const MarkGround& ground_;
  const Earth& earth_;
  std::vector<const MarkPoint*> points_;
  Index rays_ = 0;
  MatrixXd by_images_, by_unknowns_;  // derivatives in sigmas
  VectorXd misclosure_, unknowns_, right_;
  MatrixXd normals_, inverse_;
  Eigen::LLT<MatrixXd> weights_;  // of the covariance of the marks as the images leave it
  bool converged_ = false;
};

// A point where its images see it: least squares of its marks alone, with the covariance of the images.
class SeenPoint {
 public:
  SeenPoint(const MarkPoint& point, MovedImages& images) : point_(point), images_(images), position_(point.start) {}

  [[nodiscard]] bool solve(const MatrixXd& cofactor_of_images) {
    const auto rays = static_cast<Index>(point_.rays.size());
    for (int round = 0; round < kMostRounds; ++round) {
      Equations now(rays, cofactor_of_images.rows() - images_.motions(), images_.motions(), 1);
      for (Index r = 0; r < rays; ++r) now.add(r, 0, point_.rays[std::size_t(r)], position_, images_);
      const Eigen::LLT<Matrix3d> normals(Matrix3d(now.by_points.transpose() * now.by_points));
      if (normals.info() != Eigen::Success || !(normals.rcond() > kLeastEigenvalue)) return false;
      const Vector3d step = normals.solve(now.by_points.transpose() * now.misclosure);
      position_ += step;
      const bool settled = (now.by_points * step).squaredNorm() < kSettled;
      if (!settled && round + 1 < kMostRounds) continue;
      finish(now, normals.solve(Matrix3d::Identity()), cofactor_of_images);
      return settled;
    }
    return false;
  }

  [[nodiscard]] const Vector3d& position() const { return position_; }
  Matrix3d cofactor;
  VectorXd residuals, redundancy, residual_sigmas;

 private:
  void finish(const Equations& now, const Matrix3d& inverse, const MatrixXd& of_images) {
    MatrixXd by_images(now.by_images.rows(), of_images.rows());
    by_images << now.by_images, now.by_whole;
    MatrixXd covariance = by_images * of_images * by_images.transpose();
    covariance.diagonal().array() += 1;
    const MatrixXd to_point = inverse * now.by_points.transpose();
    const MatrixXd to_residuals =
        MatrixXd::Identity(now.misclosure.size(), now.misclosure.size()) - now.by_points * to_point;
    cofactor = to_point * covariance * to_point.transpose();
    residuals = to_residuals * now.misclosure;
    redundancy = to_residuals.diagonal();
    residual_sigmas = (to_residuals * covariance * to_residuals.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  }

  const MarkPoint& point_;
  MovedImages& images_;
  Vector3d position_;
};

}  // namespace

std::optional<MarkSolution> solve_marks(const Problem& problem, const State& state, std::span<const MarkPoint> points,
                                        CovarianceOfImages& covariance, std::span<const double> step,
                                        const std::optional<BlockMotion>& motion, const MarkGround& ground) {
  const Involved involved(problem, points);
  const MatrixXd cofactor = covariance.of(involved.rows());
  MovedImages images(problem, state, involved, motion);
  for (std::size_t i = 0; i < involved.rows().size(); ++i)
    images.expected[Index(i)] = step[std::size_t(involved.rows()[i])];
  images.images = images.expected;
  MarkAdjustment together(points, cofactor, images, ground, problem.earth);
  const bool has_some = std::ranges::any_of(points, &MarkPoint::takes_part);
  if (has_some ? !together.solve() : motion.has_value()) return std::nullopt;
  images.settle();
  MarkSolution out;
  out.converged = !has_some || together.converged();
  if (has_some) out.cofactor = together.cofactor();
  const VectorXd residuals = has_some ? together.residuals() : VectorXd(),
                 redundancy = has_some ? together.redundancy() : VectorXd();
  const MatrixXd of_images = together.cofactor_of_images();
  const auto count = std::accumulate(points.begin(), points.end(), Index(0), [](Index sum, const MarkPoint& point) {
    return sum + 2 * static_cast<Index>(point.rays.size());
  });
  out.residuals.resize(count);
  out.redundancy.resize(count);
  out.residual_sigmas.resize(count);
  Index row = 0, row_together = 0;
  std::size_t number = 0;
  for (const MarkPoint& point : points) {
    const auto rows = 2 * static_cast<Index>(point.rays.size());
    if (point.takes_part) {
      out.positions.push_back(together.position(number));
      out.cofactors.emplace_back(out.cofactor.block<3, 3>(Index(3 * number), Index(3 * number)));
      out.residuals.segment(row, rows) = residuals.segment(row_together, rows);
      out.redundancy.segment(row, rows) = redundancy.segment(row_together, rows);
      out.residual_sigmas.segment(row, rows) = redundancy.segment(row_together, rows).cwiseMax(0).cwiseSqrt();
      row_together += rows;
      ++number;
    } else {
      SeenPoint seen(point, images);
      if (!seen.solve(of_images)) return std::nullopt;
      out.positions.push_back(seen.position());
      out.cofactors.push_back(seen.cofactor);
      out.residuals.segment(row, rows) = seen.residuals;
      out.redundancy.segment(row, rows) = seen.redundancy;
      out.residual_sigmas.segment(row, rows) = seen.residual_sigmas;
    }
    row += rows;
  }
  return out;
}

}  // namespace collinea::bundle
