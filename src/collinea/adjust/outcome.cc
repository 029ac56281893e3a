// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/outcome.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/math/robust_squares.h"

namespace collinea::bundle {
namespace {

const Eigen::Vector2d kUnknown = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

void write_unknowns(const Block& block, const Problem& problem, const State& state, Adjusted& adjusted) {
  for (int i = 0; i < problem.poses; ++i) {
    const Eigen::Vector3d centre(state.frames[i].data() + 9);
    adjusted.cam_from_world[problem.images[i].id] = {state.rotations[i], -(state.rotations[i] * centre)};
  }
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (problem.cameras[i].free.empty()) continue;
    Camera camera = block.cameras.at(problem.cameras[i].id);
    camera.params = state.cameras[i];
    adjusted.cameras[problem.cameras[i].id] = camera;
  }
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (!problem.point(p).is_fixed && problem.point(p).control < 0)
      adjusted.points.emplace_back(PointId{problem.point(p).id}, Eigen::Vector3d(&state.points[3 * p]));
  std::sort(adjusted.points.begin(), adjusted.points.end(), [](auto& a, auto& b) { return a.first < b.first; });
}

struct RaySums {
  double squares = 0;  // of the rays of control
  long unseen = 0;     // rays, of tie points too, whose point their image does not see: they say nothing
};

// Residuals of the tie points in the order of the block, which are also added to `tie`.
RaySums write_residuals(const Problem& problem, const State& state, RobustSquares& tie, Adjusted& adjusted) {
  struct Residual {
    std::uint32_t source;
    Eigen::Vector2d px;
  };
  std::vector<Residual> residuals;
  residuals.reserve(problem.rays.size());
  RaySums rays;
  ImagePoint::for_each(problem, [&](const ImagePoint::Item& item) {
    const bool is_tie = ImagePoint::is_tie(problem, item);
    const auto px = ImagePoint::residual(problem, state, item);
    if (is_tie) residuals.push_back({ImagePoint::source(problem, item), px.value_or(kUnknown)});
    if (!px)
      ++rays.unseen;
    else if (const double s = ImagePoint::squared(problem, item, *px); is_tie)
      tie.add(s, 2);
    else
      rays.squares += s;
  });
  std::sort(residuals.begin(), residuals.end(),
            [](const Residual& a, const Residual& b) { return a.source < b.source; });
  for (const Residual& residual : residuals) {
    adjusted.observations.push_back(residual.source);
    adjusted.residuals_px.push_back(residual.px);
  }
  return rays;
}

void write_auxiliaries(const Problem& problem, const State& state, Adjusted& adjusted) {
  for (std::size_t i = 0; i < problem.auxiliaries.size(); ++i) {
    const AuxiliaryUnknown& auxiliary = problem.auxiliaries[i];
    adjusted.auxiliaries.push_back({auxiliary.kind, auxiliary.owner, auxiliary.axis, state.auxiliaries[i]});
  }
}

// The sum of squares of a kind, with a loss that which normal residuals would have.
template <class Kind>
double squares_of(const Problem& problem, const State& state, RobustSquares& robust) {
  double sum = 0;
  Kind::for_each(problem, [&](const auto& item) {
    const double s = Kind::squared(problem, state, item);
    if (!Kind::kIsRobust)
      sum += s;
    else if (const long given = Kind::count(problem, item); given > 0)
      robust.add(s, static_cast<int>(given));
  });
  return Kind::kIsRobust ? robust.squares() : sum;
}

// The sight lines of a control point in the images that take part or are fixed, with their indices in
// Block::control_observations. What the adjustment left out stands where it happened to be.
std::vector<SightLine> adjusted_sight_lines(const Block& block, const Adjusted& adjusted, ControlId point,
                                            std::vector<std::size_t>& indices) {
  std::vector<std::size_t> all_indices;
  const std::vector<SightLine> all = sight_lines(block, point, &all_indices);
  std::vector<SightLine> lines;
  indices.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ImageId image = block.control_observations[all_indices[i]].image;
    if (is_left_out(adjusted, image)) continue;
    lines.push_back(all[i]);
    indices.push_back(all_indices[i]);
    if (const auto pose = adjusted.cam_from_world.find(image); pose != adjusted.cam_from_world.end())
      lines.back().cam_from_world = pose->second;
    if (const auto camera = adjusted.cameras.find(block.images.at(image).camera); camera != adjusted.cameras.end())
      lines.back().camera = &camera->second;
  }
  return lines;
}

// Control and check points.
void write_control(const Block& block, const AdjustScope& scope, const Problem& problem, const State& state,
                   Adjusted& adjusted) {
  std::map<ControlId, Eigen::Vector3d> estimated;
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    const ProblemPoint& point = problem.point(p);
    if (point.control < 0) continue;
    estimated[ControlId{point.id}] = Eigen::Vector3d(&state.points[3 * p]);
  }
  adjusted.control_residuals_px.assign(block.control_observations.size(), kUnknown);
  for (const auto& [id, control] : block.control) {
    const auto used = estimated.find(id);
    if (used == estimated.end() && scope.free_images) continue;  // a local adjustment judges only what it uses
    std::vector<std::size_t> indices;
    const std::vector<SightLine> lines = adjusted_sight_lines(block, adjusted, id, indices);
    const bool takes_part = used != estimated.end();
    if (lines.empty() && !takes_part) continue;
    ControlDifference difference;
    difference.point = id;
    difference.used = takes_part && scope.use_control && control.role == ControlRole::kControl;
    difference.rays = static_cast<int>(lines.size());
    if (takes_part) {
      difference.position_in_world = used->second;
    } else if (const auto met = intersect(lines)) {
      difference.position_in_world = met->point_in_world;
    }
    if (difference.position_in_world) {
      for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(control.sigma_m[axis]))
          difference.difference_m[axis] = (*difference.position_in_world)[axis] - control.position_in_world[axis];
      for (std::size_t i = 0; i < lines.size(); ++i)
        if (const auto pixel =
                collinea::project(*lines[i].camera, lines[i].cam_from_world * *difference.position_in_world))
          adjusted.control_residuals_px[indices[i]] = lines[i].pixel - *pixel;
    }
    adjusted.control.push_back(difference);
  }
}

}  // namespace

bool is_left_out(const Adjusted& adjusted, ImageId image) {
  return std::find(adjusted.images_left_out.begin(), adjusted.images_left_out.end(), image) !=
         adjusted.images_left_out.end();
}

void describe_outcome(const Block& block, const AdjustScope& scope, Problem& problem, const State& state,
                      Adjusted& adjusted) {
  RobustSquares tie(problem.tie_loss), positions(problem.position_loss);
  adjusted.images_left_out = problem.images_left_out;
  write_unknowns(block, problem, state, adjusted);
  const RaySums rays = write_residuals(problem, state, tie, adjusted);
  problem.observation_count -= 2 * rays.unseen;
  for_each_kind([&]<class Kind>() {
    if constexpr (requires { Kind::tabulate(problem, state, adjusted); }) Kind::tabulate(problem, state, adjusted);
  });
  write_control(block, scope, problem, state, adjusted);
  write_auxiliaries(problem, state, adjusted);
  double squares = rays.squares + tie.squares();
  for_each_kind<kInSquares>([&]<class Kind>() { squares += squares_of<Kind>(problem, state, positions); });
  adjusted.redundancy = problem.redundancy();
  adjusted.sigma0 = adjusted.redundancy > 0 ? std::sqrt(squares / static_cast<double>(adjusted.redundancy)) : 0;
  adjusted.observation_count = problem.observation_count;
  adjusted.unknown_count = problem.unknown_count;
  adjusted.rank_defect = problem.rank_defect;
  adjusted.datum = problem.datum_sources;
  const double left = static_cast<double>(problem.redundancy()) / static_cast<double>(problem.observation_count);
  problem.tie_loss.information = tie.information(1 - left);
  problem.position_loss.information = positions.information(1 - left);
  adjusted.tie_loss = problem.tie_loss;
}

}  // namespace collinea::bundle
