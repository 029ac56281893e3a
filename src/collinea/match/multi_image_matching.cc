// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/multi_image_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/match/internal/window_equations.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix28 = Eigen::Matrix<double, 2, kWindowUnknowns>;

constexpr int kMostIterations = 30, kFixedMaps = 2;  // the first ones move the point alone
constexpr double kSettled_px = 0.003;
constexpr double kLeastRay_px = 1e-3;  // the reference is on its ray
constexpr double kSearchStep_px = 0.7;
constexpr double kSmallestScale = 0.5, kLargestScale = 2;
constexpr double kLargestMapChange = 0.5, kBeyondSearch_px = 4;
constexpr double kMapSigma = 0.05;         // of the map against that of a surface that faces the cameras
constexpr double kLargestSigma_px = 0.5;   // along the ray: more is no measurement
constexpr double kRaysApart = 10;          // so much more where rays miss, in their variance
constexpr double kFixed = 1e12;            // weight of a map that is not free
constexpr double kLeastSlowNoise = 1;      // it is an estimate itself
constexpr double kSlowPart = 0.6;          // of what the unknowns of a window take up
constexpr double kLeastAngle_rad = 1e-4;   // as intersect()
constexpr double kLessToStart = 0.2;       // a view may correlate by so much less before it is adjusted
constexpr double kLeastNoise_grey = 0.29;  // of whole grey values

struct Seen {
  Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;
};
std::optional<Seen> seen_in(const OrientedView& view, const Vector3d& point) {
  Matrix23 by_cam;
  const auto pixel = project(*view.camera, view.cam_from_world * point, &by_cam, nullptr);
  if (!pixel) return std::nullopt;
  return Seen{*pixel, by_cam * view.cam_from_world.rotation.toRotationMatrix()};
}

struct ReferenceRay {
  Vector3d centre, direction;  // unit
};
ReferenceRay ray_of(const OrientedView& view, const Vector2d& pixel) {
  const Eigen::Quaterniond world_from_cam = view.cam_from_world.rotation.conjugate();
  return {centre_of(view.cam_from_world), world_from_cam * ray_in_cam(*view.camera, pixel)};
}

// One point being matched.
class Matcher {
 public:
  Matcher(std::span<const OrientedView> views, std::size_t reference, const Vector2d& reference_px,
          const MultiImageOptions& options)
      : views_(views), reference_(reference), reference_px_(reference_px), options_(options) {
    result_.views.resize(views.size());
  }

  MultiImagePoint run(const Vector3d& start) {
    const auto window = ReferenceTemplate::of(*views_[reference_].image, reference_px_, options_.window_px | 1);
    const ReferenceRay ray = ray_of(views_[reference_], reference_px_);
    const double depth = ray.direction.dot(start - ray.centre);
    if (!window || !(depth > 0)) return failed(MultiImageOutcome::kOutside);
    template_ = *window;
    if (const auto outcome = search(ray, depth)) return failed(*outcome);
    const Vector3d from = point_;
    for (;;) {
      point_ = from;
      if (const auto outcome = adjust(starts_)) return failed(*outcome);
      bend_windows();
      if (const auto outcome = adjust(states_)) return failed(*outcome);
      WindowInView* worst = nullptr;
      for (const std::size_t i : used_)
        if (!worst || result_.views[i].correlation < worst->correlation) worst = &result_.views[i];
      if (worst->correlation >= options_.least_correlation) break;
      std::erase(used_, std::size_t(worst - result_.views.data()));
      if (used_.empty()) return failed(MultiImageOutcome::kFewViews);
      states_ = starts_;
    }
    finish();
    return result_;
  }

 private:
  MultiImagePoint failed(MultiImageOutcome outcome) {
    result_.outcome = outcome;
    return result_;
  }

  // Where a plane through the point shows what the reference has at an offset.
  std::optional<Vector2d> on_plane(std::size_t i, const Vector3d& point, const Vector3d& normal,
                                   const Vector2d& offset) const {
    const ReferenceRay ray = ray_of(views_[reference_], reference_px_ + offset);
    const double along = normal.dot(ray.direction);
    if (!(std::abs(along) > 1e-9)) return std::nullopt;
    const Vector3d at = ray.centre + ray.direction * (normal.dot(point - ray.centre) / along);
    return project(*views_[i].camera, views_[i].cam_from_world * at);
  }

  // The window on a plane; without one, on the plane that faces the cameras.
  std::optional<WindowState> facing(std::size_t i, const Vector3d& point,
                                    std::optional<Vector3d> plane = std::nullopt) const {
    Vector3d normal = plane.value_or(Vector3d::Zero());
    if (!plane)
      for (const OrientedView& view : views_) normal += (centre_of(view.cam_from_world) - point).normalized();
    const auto image_of = [&](const Vector2d& offset) { return on_plane(i, point, normal, offset); };
    constexpr double kStep_px = 2;
    const auto middle = image_of({0, 0}), left = image_of({-kStep_px, 0}), right = image_of({kStep_px, 0}),
               up = image_of({0, -kStep_px}), down = image_of({0, kStep_px});
    if (!middle || !left || !right || !up || !down) return std::nullopt;
    WindowState state{*middle, Matrix2d::Zero()};
    state.map.col(0) = (*right - *left) / (2 * kStep_px);
    state.map.col(1) = (*down - *up) / (2 * kStep_px);
    const Eigen::JacobiSVD<Matrix2d> svd(state.map);
    if (svd.singularValues()(0) > kLargestScale || svd.singularValues()(1) < kSmallestScale) return std::nullopt;
    return state;
  }

  // The plane that all maps together speak for: A_i = J_i z [r_u r_v] + (J_i r) g', g the slope of the depth z.
  std::optional<Vector3d> plane_of_maps() const {
    constexpr double kStep_px = 1;
    const ReferenceRay ray = ray_of(views_[reference_], reference_px_);
    const double depth = ray.direction.dot(point_ - ray.centre);
    Eigen::Matrix<double, 3, 2> turning;
    for (int k = 0; k < 2; ++k) {
      const Vector3d there = ray_of(views_[reference_], reference_px_ + kStep_px * Vector2d::Unit(k)).direction;
      turning.col(k) = depth * (there / there.dot(ray.direction) - ray.direction) / kStep_px;
    }
    Vector2d slope = Vector2d::Zero();
    double weights = 0;
    for (const std::size_t i : used_) {
      const auto seen = seen_in(views_[i], point_);
      if (!seen) return std::nullopt;
      const Vector2d by_depth = seen->by_point * ray.direction;
      slope += (states_[i].map - seen->by_point * turning).transpose() * by_depth;
      weights += by_depth.squaredNorm();
    }
    if (!(weights > 0)) return std::nullopt;
    const Eigen::Matrix<double, 3, 2> tangents = turning + ray.direction * (slope / weights).transpose();
    return tangents.col(0).cross(tangents.col(1)).normalized();
  }

  // What perspective within the windows adds to their maps.
  void bend_windows() {
    const auto normal = plane_of_maps();
    if (!normal) return;
    for (const std::size_t i : used_) {
      const auto plane = facing(i, point_, normal);
      if (!plane) continue;
      std::vector<Vector2d> bend;
      for (const auto& point : template_.points) {
        const auto at = on_plane(i, point_, *normal, point.offset);
        if (!at) break;
        bend.push_back(*at - plane->pixel - plane->map * point.offset);
      }
      if (bend.size() == template_.points.size()) states_[i].bend = std::move(bend);
    }
  }

  // Along the ray: where the images are most alike, and which of them are.
  std::optional<MultiImageOutcome> search(const ReferenceRay& ray, double depth) {
    const Vector3d start = ray.centre + depth * ray.direction;
    double fastest = 0, widest = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (i == reference_) continue;
      const auto seen = seen_in(views_[i], start);
      if (!seen || !inside(*views_[i].camera, seen->pixel)) continue;
      fastest = std::max(fastest, (seen->by_point * ray.direction).norm());
      const Vector3d other = (start - centre_of(views_[i].cam_from_world)).normalized();
      widest = std::max(widest, std::atan2(other.cross(ray.direction).norm(), other.dot(ray.direction)));
    }
    if (fastest == 0) return MultiImageOutcome::kFewViews;
    if (widest < kLeastAngle_rad) return MultiImageOutcome::kParallel;
    const int steps = static_cast<int>(std::ceil(options_.refine_search_px / kSearchStep_px));
    double best = -1;
    for (int step = -steps; step <= steps; ++step) {
      const double there = depth + step * kSearchStep_px / fastest;
      if (!(there > 0)) continue;
      const Vector3d point = ray.centre + there * ray.direction;
      double alike = 0;
      for (std::size_t i = 0; i < views_.size(); ++i)
        if (const auto state = i == reference_ ? std::nullopt : facing(i, point))
          alike += std::max(
              0.0, window_correlation(template_, *views_[i].image, state->pixel, state->map, 2).value_or(0) - 0.3);
      if (alike > best) {
        best = alike;
        point_ = point;
      }
    }
    if (best < 0) return MultiImageOutcome::kOutside;
    return begin();
  }

  std::optional<MultiImageOutcome> begin() {
    starts_.assign(views_.size(), {});
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto state = i == reference_ ? std::nullopt : facing(i, point_);
      if (!state) continue;
      const auto alike = window_correlation(template_, *views_[i].image, state->pixel, state->map, 1);
      if (!alike || !(*alike >= options_.least_correlation - kLessToStart)) continue;
      starts_[i] = *state;
      used_.push_back(i);
    }
    states_ = starts_;
    misses_.assign(views_.size(), Vector2d::Zero());
    if (!used_.empty()) return std::nullopt;
    double square = 0;
    for (const auto& point : template_.points) square += point.weight * point.sample.grey * point.sample.grey;
    return square < template_.weights * kLeastNoise_grey * kLeastNoise_grey ? MultiImageOutcome::kNoTexture
                                                                            : MultiImageOutcome::kFewViews;
  }

  // What the windows say of the shifts alone, map and light eliminated: score = normal * shift + noise.
  struct Reduced {
    WindowEquations equations;
    Matrix28 transform;
    Matrix2d normal;
    Vector2d score;
    PixelForms<2> own, common;
    Seen seen;
    double prior_weight = 0;
  };
  std::optional<Reduced> reduced(std::size_t i, double variance, bool has_free_map) const {
    const MapPrior prior{starts_[i].map, has_free_map ? variance / (kMapSigma * kMapSigma) : kFixed};
    const auto seen = seen_in(views_[i], point_);
    auto equations = window_equations(template_, *views_[i].image, states_[i], prior);
    if (!seen || !equations) return std::nullopt;
    const WindowMatrix& m = equations->matrix;
    const Eigen::FullPivLU<Eigen::Matrix<double, 6, 6>> others(m.bottomRightCorner<6, 6>());
    if (!others.isInvertible()) return std::nullopt;
    Reduced out{std::move(*equations), {}, {}, {}, {}, {}, *seen, has_free_map ? prior.weight : 0};
    out.transform.leftCols<2>().setIdentity();
    out.transform.rightCols<6>() = -out.equations.matrix.topRightCorner<2, 6>() * others.inverse();
    out.normal = out.transform * out.equations.matrix.leftCols<2>();
    out.score = out.transform * out.equations.right;
    out.own = forms_of_image<2>(out.equations, out.transform);
    out.common = forms_of_reference<2>(template_, out.equations, states_[i].gain, out.transform);
    return out;
  }

  // The point by the scores of all windows with their full covariance, and by the reference's ray.
  struct System {
    Eigen::MatrixXd design, weight;
    Eigen::VectorXd right;
    Matrix3d covariance;
  };
  std::optional<System> system_of(const std::vector<Reduced>& all, double variance) const {
    const Eigen::Index rows = 2 * Eigen::Index(all.size()) + 2;
    System out;
    out.design.setZero(rows, 3);
    out.right.setZero(rows);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(rows, rows);
    const double ray = std::max(options_.ray_sigma_px, kLeastRay_px);
    for (std::size_t a = 0; a < all.size(); ++a) {
      const Eigen::Index row = 2 * Eigen::Index(a);
      const Reduced& one = all[a];
      out.design.middleRows<2>(row) = one.normal * one.seen.by_point;
      out.right.segment<2>(row) = one.score + one.normal * misses_[used_[a]];
      for (std::size_t b = 0; b <= a; ++b) {
        const Matrix2d block = variance * one.common.with(all[b].common);
        covariance.block<2, 2>(row, 2 * Eigen::Index(b)) = block;
        covariance.block<2, 2>(2 * Eigen::Index(b), row) = block.transpose();
      }
      const Eigen::Matrix<double, 2, 4> by_map = one.transform.middleCols<4>(2);
      covariance.block<2, 2>(row, row) +=
          variance * one.own.with(one.own) + one.prior_weight * variance * by_map * by_map.transpose() +
          options_.ray_sigma_px * options_.ray_sigma_px * one.normal * one.normal.transpose();
    }
    // Along edges scores and their noise vanish together.
    covariance.diagonal().head(rows - 2).array() += 1e-7 * covariance.diagonal().maxCoeff();
    const auto seen = seen_in(views_[reference_], point_);
    if (!seen) return std::nullopt;
    out.design.bottomRows<2>() = seen->by_point;
    out.right.tail<2>() = reference_px_ - seen->pixel;
    covariance.bottomRightCorner<2, 2>() = ray * ray * Matrix2d::Identity();
    const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
    if (factor.info() != Eigen::Success) return std::nullopt;
    out.weight = factor.solve(Eigen::MatrixXd::Identity(rows, rows));
    const Matrix3d normal = out.design.transpose() * out.weight * out.design;
    const Eigen::LDLT<Matrix3d> solver(normal);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
    out.covariance = solver.solve(Matrix3d::Identity());
    return out;
  }

  std::optional<std::vector<Reduced>> all_reduced(double variance, bool has_free_map) const {
    std::vector<Reduced> all;
    for (const std::size_t i : used_) {
      auto one = reduced(i, variance, has_free_map);
      if (!one) return std::nullopt;
      all.push_back(std::move(*one));
    }
    return all;
  }

  std::optional<MultiImageOutcome> adjust(std::vector<WindowState> from) {
    for (const std::size_t i : used_) {
      states_[i] = from[i];
      misses_[i].setZero();
    }
    double variance = kLeastNoise_grey * kLeastNoise_grey;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      const bool has_free_map = iteration >= kFixedMaps;
      const auto all = all_reduced(variance, has_free_map);
      if (!all) return MultiImageOutcome::kNotConverged;
      double squares = 0, white = 0;
      for (const Reduced& one : *all) {
        squares += one.equations.squares;
        white += one.equations.white;
      }
      variance = std::max(squares / white, kLeastNoise_grey * kLeastNoise_grey);
      const auto system = system_of(*all, variance);
      if (!system) return MultiImageOutcome::kNoTexture;
      if (has_free_map && too_uncertain(*all, system->covariance, options_.ray_sigma_px))
        return MultiImageOutcome::kNoTexture;
      const auto moved_px = step(*all, *system);
      if (!moved_px) return MultiImageOutcome::kNotConverged;
      result_.iterations = iteration + 1;
      if (has_free_map && *moved_px < kSettled_px) return settled(variance);
    }
    return MultiImageOutcome::kNotConverged;
  }

  [[nodiscard]] static bool too_uncertain(const std::vector<Reduced>& all, const Matrix3d& covariance,
                                          double ray_sigma_px) {
    double largest = 0;
    for (const Reduced& one : all)
      largest = std::max(largest, (one.seen.by_point * covariance * one.seen.by_point.transpose()).trace());
    return largest > kLargestSigma_px * kLargestSigma_px + kRaysApart * ray_sigma_px * ray_sigma_px;
  }

  // Moves point and windows; the largest change of a position, nothing where that leads away.
  std::optional<double> step(const std::vector<Reduced>& all, const System& system) {
    const Eigen::VectorXd weighted = system.weight * system.right;
    const Vector3d by = system.covariance * (system.design.transpose() * weighted);
    const Eigen::VectorXd left = system.weight * (system.right - system.design * by);
    point_ += by;
    double largest = 0;
    for (std::size_t a = 0; a < all.size(); ++a) {
      const std::size_t i = used_[a];
      WindowState& state = states_[i];
      const auto seen = seen_in(views_[i], point_);
      if (!seen) return std::nullopt;
      misses_[i] = options_.ray_sigma_px * options_.ray_sigma_px * all[a].normal.transpose() *
                   left.segment<2>(2 * Eigen::Index(a));
      const Vector2d pixel = seen->pixel + misses_[i], shift = pixel - state.pixel;
      const WindowMatrix& m = all[a].equations.matrix;
      const Eigen::Matrix<double, 6, 1> others = m.bottomRightCorner<6, 6>().fullPivLu().solve(
          all[a].equations.right.tail<6>() - m.bottomLeftCorner<6, 2>() * shift);
      state.pixel = pixel;
      state.map(0, 0) += others[0];
      state.map(0, 1) += others[1];
      state.map(1, 0) += others[2];
      state.map(1, 1) += others[3];
      state.gain += others[4];
      state.offset_grey += others[5];
      const Matrix2d change = starts_[i].map.inverse() * state.map - Matrix2d::Identity();
      if (!(change.norm() < kLargestMapChange) || !(state.gain > 0.05) ||
          !((pixel - starts_[i].pixel).norm() < options_.refine_search_px + kBeyondSearch_px))
        return std::nullopt;
      largest = std::max({largest, shift.norm(), others.head<4>().norm() * options_.window_px / 4});
    }
    return largest;
  }

  // Correlations, noise, covariance and test at the end.
  std::optional<MultiImageOutcome> settled(double variance) {
    const auto all = all_reduced(variance, true);
    if (!all) return MultiImageOutcome::kNotConverged;
    double squares = 0, expected = 0, squares_of_means = 0, expected_of_means = 0;
    for (std::size_t a = 0; a < all->size(); ++a) {
      const Reduced& one = (*all)[a];
      const double lost = fitted(one, states_[used_[a]].gain);
      squares += one.equations.squares;
      expected += one.equations.white - lost;
      const BlockMeans means = block_means(template_, one.equations, states_[used_[a]]);
      squares_of_means += means.squares;
      expected_of_means += std::max(means.white - kSlowPart * lost, means.white / 4);  // what is fitted varies slowly
      WindowInView& view = result_.views[used_[a]];
      view.correlation = one.equations.correlation;
      view.misclosure_px = one.normal.fullPivLu().solve(one.score) + misses_[used_[a]];
    }
    result_.noise_grey = std::max(std::sqrt(squares / std::max(expected, 1e-9)), kLeastNoise_grey);
    const double slow = std::sqrt(squares_of_means / std::max(expected_of_means, 1e-9)) / result_.noise_grey;
    result_.slow_noise = std::max(slow, kLeastSlowNoise);
    const double noise_grey = result_.noise_grey * result_.slow_noise;
    const auto system = system_of(*all, noise_grey * noise_grey);
    if (!system) return MultiImageOutcome::kNoTexture;
    result_.covariance = system->covariance;
    const Eigen::VectorXd& v = system->right;
    const Vector3d by = system->covariance * (system->design.transpose() * (system->weight * v));
    const Eigen::VectorXd left = v - system->design * by;
    result_.statistic = left.dot(system->weight * left);
    result_.redundancy = static_cast<int>(v.size()) - 3;
    return std::nullopt;
  }

  // By how much the eight unknowns of a window lessen r'W r, for white noise of 1.
  [[nodiscard]] double fitted(const Reduced& one, double gain) const {
    const WindowMatrix identity = WindowMatrix::Identity();
    const auto own = forms_of_image<kWindowUnknowns>(one.equations, identity);
    const auto common = forms_of_reference<kWindowUnknowns>(template_, one.equations, gain, identity);
    const WindowMatrix noise = own.with(own) + common.with(common);
    return one.equations.matrix.fullPivLu().solve(noise).trace();
  }

  void finish() {
    result_.outcome = MultiImageOutcome::kFound;
    result_.point_in_world = point_;
    for (const std::size_t i : used_) {
      WindowInView& view = result_.views[i];
      view.is_used = true;
      view.pixel = states_[i].pixel;
      view.px_from_reference = states_[i].map;
      view.gain = states_[i].gain;
      view.offset_grey = states_[i].offset_grey;
    }
    WindowInView& own = result_.views[reference_];
    own.pixel = reference_px_;
    own.px_from_reference.setIdentity();
    own.correlation = 1;
  }

  std::span<const OrientedView> views_;
  std::size_t reference_;
  Vector2d reference_px_;
  const MultiImageOptions& options_;
  ReferenceTemplate template_;
  Vector3d point_{0, 0, 0};
  std::vector<std::size_t> used_;
  std::vector<WindowState> starts_, states_;
  std::vector<Vector2d> misses_;  // of the rays, where they need not meet
  MultiImagePoint result_;
};

}  // namespace

MultiImagePoint match_in_images(std::span<const OrientedView> views, std::size_t reference,
                                const Vector2d& reference_px, const Vector3d& start_in_world,
                                const MultiImageOptions& options) {
  return Matcher(views, reference, reference_px, options).run(start_in_world);
}

}  // namespace collinea
