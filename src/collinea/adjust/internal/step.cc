// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/step.h"

#include <algorithm>
#include <cmath>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/adjust/point_normals.h"
#include "collinea/base/parallel.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kPointsInItem = 512;
constexpr double kSurprise = 0.02;  // cost of one point, in squared sigmas, that is worth a look

struct Sums {
  double cost = 0, promised = 0;
};

State with_reduced_moved(const Problem& problem, const State& state, Step& step) {
  State next = state;
  step.largest_rotation_rad = step.largest_move_m = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(problem.poses); ++i) {
    const double* d = &step.reduced[6 * i];
    const Eigen::Vector3d rotation(d[0], d[1], d[2]), shift(d[3], d[4], d[5]);
    const Eigen::Vector3d centre = Eigen::Vector3d(state.frames[i].data() + 9) + shift;
    next.rotations[i] = (rotation_by(rotation) * state.rotations[i]).normalized();
    next.frames[i] = frame_of(next.rotations[i], centre.data());
    step.largest_rotation_rad = std::max(step.largest_rotation_rad, rotation.norm());
    step.largest_move_m = std::max(step.largest_move_m, shift.norm());
  }
  const double* by_camera = step.reduced.data() + 6 * problem.poses;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    const ProblemCamera& camera = problem.cameras[i];
    for (std::size_t k = 0; k < camera.free.size(); ++k)
      next.cameras[i][camera.free[k]] += by_camera[camera.first_global + static_cast<int>(k)];
    if (!camera.free.empty()) next.lenses[i] = lens_with(state.lenses[i], next.cameras[i].data());
  }
  for (std::size_t i = 0; i < problem.auxiliaries.size(); ++i)
    next.auxiliaries[i] += by_camera[problem.first_auxiliary + static_cast<int>(i)];
  for (const std::uint32_t p : problem.retained_points)
    for (int c = 0; c < 3; ++c)
      next.points[3ul * p + static_cast<std::size_t>(c)] += by_camera[problem.point(p).first_retained + c];
  return next;
}

double squared(const double* residual) { return residual[0] * residual[0] + residual[1] * residual[1]; }

// r := r - J d - B dc: the residual after the step of image and camera, by the linear model.
void take_step_of_image(const Problem& problem, const State& state, const Step& step, const Ray& ray,
                        LinearRay& linear) {
  if (static_cast<int>(ray.image) < problem.poses) {
    const double* d = &step.reduced[6ul * ray.image];
    for (int row = 0; row < 2; ++row) {
      const double *rotation = linear.by_rotation + 3 * row, *shift = linear.by_point + 3 * row;
      linear.residual[row] -= rotation[0] * d[0] + rotation[1] * d[1] + rotation[2] * d[2];
      linear.residual[row] += shift[0] * d[3] + shift[1] * d[4] + shift[2] * d[5];
    }
  }
  const int camera = problem.images[ray.image].camera;
  const ProblemCamera& unknowns = problem.cameras[camera];
  if (unknowns.free.empty()) return;
  double b[2 * Camera::kAllParams];
  linearise_camera(linear, state.lenses[camera], unknowns.free, b);
  const double* d = step.reduced.data() + 6 * problem.poses + unknowns.first_global;
  const std::size_t count = unknowns.free.size();
  for (std::size_t k = 0; k < count; ++k) {
    linear.residual[0] -= b[k] * d[k];
    linear.residual[1] -= b[count + k] * d[k];
  }
}

double cost_of_point(const Problem& problem, const State& state, std::size_t p, const double* position) {
  const ProblemPoint& point = problem.point(p);
  const Loss loss = problem.loss_of(point);
  CostSum cost(loss);
  for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
    const Ray& ray = problem.rays[r];
    cost.add(square_of(ray, state.frames[ray.image], state.lenses[problem.images[ray.image].camera], position));
  }
  return cost.value() + (point.control >= 0 ? PointNormals().add(problem.control[point.control], position) : 0);
}

// Improves one point while images and cameras stay, by steps that lower its cost; answers the cost.
double settle_point(const Problem& problem, const State& state, std::size_t p, double* position, double cost) {
  constexpr int kMostSteps = 4;
  const ProblemPoint& point = problem.point(p);
  Loss loss = problem.loss_of(point);
  for (int step = 0; step < kMostSteps; ++step) {
    PointNormals normals;
    for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
      const Ray& ray = problem.rays[r];
      LinearRay linear;
      linearise(problem, state, ray, position, loss, &linear);
      normals.add(linear);
    }
    if (point.control >= 0) normals.add(problem.control[point.control], position);
    normals.factor(0);
    double d[3] = {normals.right[0], normals.right[1], normals.right[2]};
    normals.forward(d);
    normals.backward(d);
    const double next[3] = {position[0] + d[0], position[1] + d[1], position[2] + d[2]};
    const double there = cost_of_point(problem, state, p, next);
    if (there < cost) {
      std::copy(next, next + 3, position);
      if (cost - there < 1e-3 * cost) return there;
      cost = there;
    } else if (loss.least_curvature < 1) {
      loss.least_curvature = 1;  // too bold: plain reweighting
    } else {
      return cost;
    }
  }
  return cost;
}

// A point that keeps its unknowns has moved already.
Sums of_retained(const Problem& problem, const State& state, const Step& step, std::size_t p, const State& next) {
  const ProblemPoint& point = problem.point(p);
  const Loss loss = problem.loss_of(point);
  const double *position = &state.points[3 * p], *there = &next.points[3 * p];
  const double* d = step.reduced.data() + 6 * problem.poses + point.first_retained;
  Sums sums;
  for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
    const Ray& ray = problem.rays[r];
    LinearRay linear;
    linearise(problem, state, ray, position, loss, &linear);
    sums.promised += squared(linear.residual);
    take_step_of_image(problem, state, step, ray, linear);
    for (int row = 0; row < 2; ++row)
      for (int c = 0; c < 3; ++c) linear.residual[row] -= linear.by_point[3 * row + c] * d[c];
    sums.promised -= squared(linear.residual);
  }
  sums.promised += PointNormals().add(problem.control[point.control], position);
  sums.promised -= PointNormals().add(problem.control[point.control], there);
  sums.cost = cost_of_point(problem, next, p, there);
  return sums;
}

// V d = A^T (r - J d - B dc) for the point; the promise is |r|^2 - |r - J d - B dc - A dp|^2.
Sums move_point(const Problem& problem, const State& state, double lambda, const Step& step, std::size_t p,
                State& next) {
  const ProblemPoint& point = problem.point(p);
  if (point.first_retained >= 0) return of_retained(problem, state, step, p, next);
  const Loss loss = problem.loss_of(point);
  const double* position = &state.points[3 * p];
  double* target = &next.points[3 * p];
  Sums sums;
  PointNormals normals;
  CostSum cost(loss);
  for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
    const Ray& ray = problem.rays[r];
    LinearRay linear;
    cost.add(linearise(problem, state, ray, position, loss, &linear));
    sums.promised += squared(linear.residual);
    take_step_of_image(problem, state, step, ray, linear);
    sums.promised -= squared(linear.residual);
    if (!point.is_fixed) normals.add(linear);
  }
  double before = cost.value();
  if (!point.is_fixed) {
    if (point.control >= 0) before += normals.add(problem.control[point.control], position);
    normals.factor(lambda);
    const double *v = normals.v, *b = normals.right;
    double d[3] = {b[0], b[1], b[2]};
    normals.forward(d);
    normals.backward(d);
    const double quadratic = v[0] * d[0] * d[0] + v[3] * d[1] * d[1] + v[5] * d[2] * d[2] +
                             2 * (v[1] * d[0] * d[1] + v[2] * d[0] * d[2] + v[4] * d[1] * d[2]);
    sums.promised += 2 * (b[0] * d[0] + b[1] * d[1] + b[2] * d[2]) - quadratic;
    for (int c = 0; c < 3; ++c) target[c] = position[c] + d[c];
  }
  sums.cost = cost_of_point(problem, next, p, target);
  // Where the linear model was wrong (outliers, a step too far) a few steps of the point alone are cheaper than another
  // of all.
  const double surprise = std::abs(before - sums.cost - sums.promised);
  if (!point.is_fixed && surprise > std::max(kSurprise, 0.3 * std::abs(sums.promised))) {
    const double stayed = cost_of_point(problem, next, p, position);
    if (stayed < sums.cost) {
      std::copy(position, position + 3, target);
      sums.cost = stayed;
    }
    sums.cost = settle_point(problem, next, p, target, sums.cost);
  }
  return sums;
}

// Observations that are no image points: what they cost after the step, and what the linear model predicts to be
// gained.
template <class Kind>
Sums of_kind(const Problem& problem, const State& state, const State& next, const Step& step) {
  Sums sums;
  const Loss loss = Kind::loss(problem);
  Kind::for_each(problem, [&](const auto& item) {
    const double s = Kind::whitened(problem, state, item).squaredNorm();
    const double left = Kind::predicted(problem, state, next, step.reduced, item).squaredNorm();
    sums.cost += loss.cost(Kind::whitened(problem, next, item).squaredNorm());
    sums.promised += loss.weight(s) * (s - left);
  });
  return sums;
}

}  // namespace

State moved(const Problem& problem, const State& state, double lambda, Step& step, const Run& run) {
  State next = with_reduced_moved(problem, state, step);
  const std::size_t points = problem.point_count(), items = (points + kPointsInItem - 1) / kPointsInItem;
  std::vector<Sums> sums(items);
  Run serial;
  parallel_for(problem.rays.size() >= kRaysWorthThreads ? run : serial, items, [&](std::size_t item) {
    for (std::size_t p = item * kPointsInItem; p < std::min(points, (item + 1) * kPointsInItem); ++p) {
      const Sums one = move_point(problem, state, lambda, step, p, next);
      sums[item].cost += one.cost;
      sums[item].promised += one.promised;
    }
  });
  for_each_kind([&]<class Kind>() {  // coordinates of control were counted with their points
    if constexpr (!Kind::kIsOfPoint) sums.push_back(of_kind<Kind>(problem, state, next, step));
  });
  step.cost = step.promised = 0;
  for (const Sums& one : sums) {
    step.cost += one.cost;
    step.promised += one.promised;
  }
  return next;
}

}  // namespace collinea::bundle
