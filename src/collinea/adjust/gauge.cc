// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/gauge.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/similarity3.h"

namespace collinea::bundle {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;

// By how much a motion turns azimuths back, which are clockwise.
double heading_of(const Similarity3& moved) {
  const Eigen::Matrix3d turn = moved.rotation.toRotationMatrix();
  return std::atan2(turn(1, 0), turn(0, 0));
}

// Where a height that points have in common is at the middle of the block.
Eigen::Vector3d at_height(double height, const Eigen::Vector3d& centre) { return {centre.x(), centre.y(), height}; }

// An unknown of set-ups or shapes of a block that was moved as a whole. Planes and lines stay where they are.
double moved_extra(const AuxiliaryUnknown& extra, double value, const Similarity3& moved, const Eigen::Vector3d& centre) {
  if (extra.kind == UnknownKind::kOrientation) return value - heading_of(moved);
  if (extra.kind == UnknownKind::kHeight) return (moved * at_height(value, centre)).z();
  return value;
}

struct GaugeNormals {
  Eigen::Matrix<double, 7, 7> matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  double cost = 0;
};

// What was measured on the ground sees the scale, the level and, where only one end moves, the place.
void add_ground(const Problem& problem, const State& state, const Similarity3& moved, const Eigen::Vector3d& centre,
                double size, GaugeNormals& normals) {
  const auto motion_at = [&](const Eigen::Vector3d& place) -> Matrix37 {
    return size * motion_of(place, centre, size);
  };
  for (const GeodeticLink& link : problem.ground) {
    if (!(link.inverse_sigma > 0)) continue;
    const auto place = [&](std::uint32_t p) { return moved * Eigen::Vector3d(&state.points[3ul * p]); };
    const Eigen::Vector3d from = place(link.from), to = place(link.to);
    std::array<double, 3> extra{};
    const AuxiliaryUnknown* own = nullptr;
    for (int k = 0; k < 3 && link.extra >= 0 && static_cast<std::size_t>(link.extra + k) < state.auxiliaries.size(); ++k) {
      const auto i = static_cast<std::size_t>(link.extra + k);
      extra[static_cast<std::size_t>(k)] = moved_extra(problem.auxiliaries[i], state.auxiliaries[i], moved, centre);
      if (k == 0) own = &problem.auxiliaries[i];
    }
    const GeodeticModel model = link.shape >= 0
                                  ? shape_model(link.observation, problem.shapes[static_cast<std::size_t>(link.shape)],
                                                extra.data(), from, problem.level_at_origin)
                                  : geodetic_model(link.observation, from, to, extra[0], problem.level_at_origin);
    Eigen::Matrix<double, 1, 7> row = model.by_from.transpose() * motion_at(from);
    if (link.to != link.from) row += model.by_to.transpose() * motion_at(to);
    if (own && own->kind == UnknownKind::kOrientation) row[5] -= model.by_extra[0];
    if (own && own->kind == UnknownKind::kHeight)
      row += model.by_extra[0] *
             motion_at(moved * at_height(state.auxiliaries[static_cast<std::size_t>(link.extra)], centre)).row(2);
    row *= link.inverse_sigma;
    const double residual = geodetic_residual(link.observation, model) * link.inverse_sigma;
    normals.matrix += row.transpose() * row;
    normals.right += row.transpose() * residual;
    normals.cost += residual * residual;
  }
}

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
  add_ground(problem, state, moved, centre, size, normals);
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

void transform(const Problem& problem, State& state, const Similarity3& moved, const Eigen::Vector3d& centre) {
  for (std::size_t i = 0; i < state.auxiliaries.size(); ++i)
    state.auxiliaries[i] = moved_extra(problem.auxiliaries[i], state.auxiliaries[i], moved, centre);
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

// Nothing is observed of the place of the block but what normals_at() knows.
bool is_plain(const Problem& problem) {
  return problem.ground.empty() && problem.attitudes.empty() &&
         std::all_of(problem.positions.begin(), problem.positions.end(), [](const auto& one) { return one.plain(); });
}

// All that a motion of the whole block changes.
double cost_of_place(const Problem& problem, const State& state) {
  double cost = 0;
  for_each_kind([&]<class Kind>() {
    if constexpr (Kind::kIsOfPlace)
      Kind::for_each(problem,
                     [&](const auto& item) { cost += Kind::loss(problem).cost(Kind::squared(problem, state, item)); });
  });
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
    transform(problem, state, moved, centre);
    return fallen;
  }
  State there = state;
  transform(problem, there, moved, centre);
  fallen = cost_of_place(problem, state) - cost_of_place(problem, there);
  if (!(fallen > 0)) return 0;
  state = std::move(there);
  return fallen;
}

}  // namespace collinea::bundle
