// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/gauge.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/adjust/linearise.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/similarity3.h"

namespace collinea::bundle {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;

struct GaugeNormals {
  Eigen::Matrix<double, 7, 7> matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  double cost = 0;
};

// The observations of place, of a block moved by `moved`, and their derivatives by a further motion.
GaugeNormals normals_at(const Problem& problem, const State& state, const Similarity3& moved,
                        const Eigen::Vector3d& centre, double size) {
  GaugeNormals normals;
  const auto add = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& given, const Eigen::Matrix3d& p,
                       const Loss& loss) {
    const Eigen::Vector3d now = moved * place, residual = given - now;
    const Matrix37 by_motion = size * motion_of(now, centre, size);
    const double s = residual.dot(p * residual), weight = loss.weight(s);
    normals.matrix += weight * by_motion.transpose() * p * by_motion;
    normals.right += weight * by_motion.transpose() * (p * residual);
    normals.cost += loss.cost(s);
  };
  for (const GivenPosition& position : problem.positions) {
    const Eigen::Vector3d place = centre_in(state, position.image);
    // What lies between centre and antenna is taken as it is.
    const Eigen::Vector3d given =
        position.plain() ? position.given : position.given - (antenna_of(state, position) - place);
    add(place, given, position.inverse_sigma.cwiseAbs2().asDiagonal(), problem.position_loss);
  }
  for (const GivenUp& given : problem.verticals) {
    const Eigen::Matrix3d cam_from_world =
        (state.rotations[given.image] * moved.rotation.conjugate()).toRotationMatrix();
    const Eigen::Vector3d residual = given.residual(cam_from_world.col(2));
    // A world turned by w sees its old z axis turned by -w.
    const Eigen::Matrix3d by_turn = given.inverse_sigma * cam_from_world * skew(Eigen::Vector3d::UnitZ());
    normals.matrix.block<3, 3>(3, 3) += by_turn.transpose() * by_turn;
    normals.right.segment<3>(3) += by_turn.transpose() * residual;
    normals.cost += residual.squaredNorm();
  }
  for (std::size_t p = problem.first_control; p < problem.point_count(); ++p) {
    if (problem.point(p).control < 0) continue;
    const ControlCoordinates& control = problem.control[problem.point(p).control];
    add(Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p]), Eigen::Map<const Eigen::Vector3d>(control.given),
        control.weight(), Loss{});
  }
  return normals;
}

// The least motion that solves the normals; directions that nothing observes stay.
Vector7 solve(const GaugeNormals& normals) {
  constexpr double kSeen = 1e-9;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 7, 7>> eigen(normals.matrix);
  Vector7 motion = Vector7::Zero();
  for (int k = 0; k < 7; ++k)
    if (eigen.eigenvalues()[k] > kSeen * eigen.eigenvalues()[6])
      motion += eigen.eigenvectors().col(k) * (eigen.eigenvectors().col(k).dot(normals.right) / eigen.eigenvalues()[k]);
  return motion;
}

Similarity3 after(const Similarity3& moved, const Vector7& motion, const Eigen::Vector3d& centre, double size) {
  const Eigen::Quaterniond turn = rotation_by(motion.segment<3>(3));
  const double scale = std::exp(motion[6]);
  const auto place = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return centre + scale * (turn * (p - centre)) + size * motion.head<3>();
  };
  return {scale * moved.scale, (turn * moved.rotation).normalized(), place(moved.translation)};
}

void transform(State& state, const Similarity3& moved) {
  for (std::size_t i = 0; i < state.frames.size(); ++i) {
    const Eigen::Vector3d centre = moved * centre_in(state, i);
    state.rotations[i] = (state.rotations[i] * moved.rotation.conjugate()).normalized();
    state.frames[i] = frame_of(state.rotations[i], centre.data());
  }
  for (std::size_t p = 0; 3 * p < state.points.size(); ++p) {
    Eigen::Map<Eigen::Vector3d> point(&state.points[3 * p]);
    point = moved * Eigen::Vector3d(point);
  }
}

// Nothing is observed of the place of the block but what normals_at() knows.
bool is_plain(const Problem& problem) {
  return problem.ground.empty() && problem.attitudes.empty() &&
         std::all_of(problem.positions.begin(), problem.positions.end(), [](const auto& one) { return one.plain(); });
}

// All that a motion of the whole block changes.
double cost_of_place(const Problem& problem, const State& state) {
  double cost = 0;
  for (const GivenPosition& position : problem.positions)
    cost += problem.position_loss.cost(
        (position.given - antenna_of(state, position)).cwiseProduct(position.inverse_sigma).squaredNorm());
  for (const GivenUp& given : problem.verticals)
    cost += given.residual(z_in_cam(state.frames[given.image])).squaredNorm();
  for (std::size_t p = problem.first_control; p < problem.point_count(); ++p)
    if (const int control = problem.point(p).control; control >= 0)
      cost += PointNormals().add(problem.control[control], &state.points[3 * p]);
  for (const GroundLink& link : problem.ground)
    cost += std::pow(ground_residual(link.observation, model_of(problem, link, state)) * link.inverse_sigma, 2);
  for (const GivenTurn& given : problem.attitudes)
    cost += residual_of(state, given).cwiseProduct(given.inverse_sigma).squaredNorm();
  return cost;
}

}  // namespace

Matrix37 motion_of(const Eigen::Vector3d& point, const Eigen::Vector3d& centre, double size) {
  const Eigen::Vector3d d = (point - centre) / size;
  Matrix37 g;
  g << 1, 0, 0, 0, d.z(), -d.y(), d.x(),  //
      0, 1, 0, -d.z(), 0, d.x(), d.y(),   //
      0, 0, 1, d.y(), -d.x(), 0, d.z();
  return g;
}

double settle_gauge(const Problem& problem, State& state) {
  if (!problem.moves_as_one || (problem.positions.empty() && problem.control.empty())) return 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < problem.poses; ++i) centre += centre_in(state, i) / double(problem.poses);
  const double size = problem.extent_m;
  Similarity3 moved;
  GaugeNormals normals = normals_at(problem, state, moved, centre, size);
  const double before = normals.cost;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const Similarity3 next = after(moved, solve(normals), centre, size);
    const GaugeNormals there = normals_at(problem, state, next, centre, size);
    if (!(there.cost < normals.cost * (1 - 1e-9))) break;
    moved = next;
    normals = there;
  }
  double fallen = before - normals.cost;
  if (!(fallen > 0)) return 0;
  if (is_plain(problem)) {
    transform(state, moved);
    return fallen;
  }
  State there = state;
  transform(there, moved);
  fallen = cost_of_place(problem, state) - cost_of_place(problem, there);
  if (!(fallen > 0)) return 0;
  state = std::move(there);
  return fallen;
}

}  // namespace collinea::bundle
