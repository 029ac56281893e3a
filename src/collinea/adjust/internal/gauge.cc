// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/gauge.h"

#include <Eigen/Eigenvalues>
#include <utility>

#include "collinea/adjust/observation_kinds.h"

namespace collinea::bundle {
namespace {

// All that observes the block as a whole, moved by `motion`, and its derivatives by a further motion.
MotionNormals normals_at(const Problem& problem, const State& state, const BlockMotion& motion) {
  MotionNormals normals;
  for_each_kind([&]<class Kind>() {
    if constexpr (requires { Kind::add_to_gauge(problem, state, motion, normals); })
      Kind::add_to_gauge(problem, state, motion, normals);
  });
  return normals;
}

// The least motion that solves the normals; directions that nothing observes stay. Nothing: an eigenvalue of at most
// this part of the largest one, which are by the weights of the observations too, not by geometry alone as those that
// kSeenMotion is of: what is observed 30,000 times worse than the best known motion stays as it is.
Vector7 solve(const MotionNormals& normals) {
  constexpr double kSolved = 1e-9;
  const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(normals.matrix);
  Vector7 motion = Vector7::Zero();
  for (int k = 0; k < 7; ++k)
    if (eigen.eigenvalues()[k] > kSolved * eigen.eigenvalues()[6])
      motion += eigen.eigenvectors().col(k) * (eigen.eigenvectors().col(k).dot(normals.right) / eigen.eigenvalues()[k]);
  return motion;
}

void transform(const Problem& problem, State& state, const BlockMotion& motion) {
  const Similarity3& moved = motion.moved;
  for (std::size_t i = 0; i < state.auxiliaries.size(); ++i)
    state.auxiliaries[i] = motion.moved_auxiliary(problem.auxiliaries[i], state.auxiliaries[i]);
  for (std::size_t i = 0; i < state.frames.size(); ++i) {
    const Eigen::Vector3d there = moved * centre_in(state, i);
    state.rotations[i] = (state.rotations[i] * moved.rotation.conjugate()).normalized();
    state.frames[i] = frame_of(state.rotations[i], there.data());
  }
  for (std::size_t p = 0; 3 * p < state.points.size(); ++p) {
    Eigen::Map<Eigen::Vector3d> point(&state.points[3 * p]);
    point = moved * Eigen::Vector3d(point);
  }
}

// Whether anything fixes the position of the block.
bool is_placed(const Problem& problem) {
  bool placed = false;
  for_each_kind([&]<class Kind>() { placed = placed || Kind::positions_block(problem); });
  return placed;
}

// Nothing is observed of the position of the block but what normals_at() has.
bool is_gauge_complete(const Problem& problem) {
  bool complete = true;
  for_each_kind([&]<class Kind>() { complete = complete && Kind::is_gauge_complete(problem); });
  return complete;
}

// All that a motion of the whole block changes.
double cost_of_position(const Problem& problem, const State& state) {
  double cost = 0;
  for_each_kind([&]<class Kind>() {
    if constexpr (Kind::kIsOfPosition)
      Kind::for_each(problem,
                     [&](const auto& item) { cost += Kind::loss(problem).cost(Kind::squared(problem, state, item)); });
  });
  return cost;
}

}  // namespace

double settle_gauge(const Problem& problem, State& state) {
  if (!problem.moves_as_one || !is_placed(problem)) return 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < problem.poses; ++i) centre += centre_in(state, i) / double(problem.poses);
  BlockMotion motion{{}, centre, problem.extent_m};
  MotionNormals normals = normals_at(problem, state, motion);
  const double before = normals.cost;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const BlockMotion next = motion.after(solve(normals));
    const MotionNormals there = normals_at(problem, state, next);
    if (!(there.cost < normals.cost * (1 - 1e-9))) break;
    motion = next;
    normals = there;
  }
  double fallen = before - normals.cost;
  if (!(fallen > 0)) return 0;
  if (is_gauge_complete(problem)) {
    transform(problem, state, motion);
    return fallen;
  }
  State there = state;
  transform(problem, there, motion);
  fallen = cost_of_position(problem, state) - cost_of_position(problem, there);
  if (!(fallen > 0)) return 0;
  state = std::move(there);
  return fallen;
}

}  // namespace collinea::bundle
