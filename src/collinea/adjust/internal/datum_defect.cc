// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/datum_defect.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include <utility>

#include "collinea/adjust/internal/datum_parts.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/math/median.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kDatumImages = 8, kLeastDatumCandidates = 64;

// Fills Problem::part_of_pose and part_of_point of points that free images show; answers the parts. Fixed images belong
// to every part and join nothing.
std::vector<DatumPart> find_parts(Problem& problem) {
  std::vector<int> root(problem.poses);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for_each_kind<kEvery>([&]<class Kind>() {
    const auto tie = [&](std::uint32_t one, std::uint32_t other) {
      const int a = find(static_cast<int>(one)), b = find(static_cast<int>(other));
      root[std::max(a, b)] = std::min(a, b);
    };
    if constexpr (requires { Kind::for_each_tied_images(problem, tie); }) Kind::for_each_tied_images(problem, tie);
  });
  std::vector<DatumPart> parts;
  std::vector<int>& part = problem.part_of_pose;
  part.assign(problem.poses, -1);
  for (int i = 0; i < problem.poses; ++i) {
    part[i] = find(i) == i ? static_cast<int>(parts.size()) : part[find(i)];
    if (find(i) == i) parts.emplace_back();
    parts[part[i]].poses.push_back(i);
  }
  problem.part_of_point.assign(problem.point_count(), -1);
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (problem.point(p).first_free < problem.end_ray(p))
      problem.part_of_point[p] = part[problem.rays[problem.point(p).first_free].image];
  return parts;
}

// Centre and size of each part. The size is that of the part's bases or, when there are none to speak of, the distance
// of its points.
void measure(std::vector<DatumPart>& parts, const Problem& problem, const State& state) {
  std::vector<std::vector<double>> distances(parts.size());
  for (DatumPart& one : parts)
    for (const int pose : one.poses) one.centre += centre_in(state, pose) / double(one.poses.size());
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (const int its = problem.part_of_point[p]; its >= 0)
      distances[its].push_back((Eigen::Vector3d(&state.points[3 * p]) - parts[its].centre).norm());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double squared = 0, distance = 1;
    for (const int pose : parts[i].poses) squared += (centre_in(state, pose) - parts[i].centre).squaredNorm();
    if (!distances[i].empty()) distance = median(distances[i]);
    parts[i].size = std::sqrt(squared / double(parts[i].poses.size()));
    if (!(parts[i].size > 1e-3 * distance)) parts[i].size = distance > 0 ? distance : 1;
  }
}

// What observations without unknowns of their own see: those of images, then point by point those of points.
void observe_motions(const Problem& problem, const State& state, std::vector<DatumPart>& parts) {
  for_each_kind([&]<class Kind>() {
    if constexpr (requires { Kind::observe_motions(problem, state, parts); })
      Kind::observe_motions(problem, state, parts);
  });
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    if (problem.part_of_point[p] < 0) continue;
    for_each_kind<kOfPoints>([&]<class Kind>() { Kind::observe_motions(problem, state, p, parts); });
  }
}

// Points that no image shows belong to the part of those they are measured to.
void extend_parts(Problem& problem) {
  std::vector<int>& part_of_point = problem.part_of_point;
  for (bool found = true; found;) {
    found = false;
    const auto extend = [&](std::uint32_t from, std::uint32_t to) {
      for (const auto& [a, b] : {std::pair(from, to), std::pair(to, from)})
        if (part_of_point[a] >= 0 && part_of_point[b] < 0 && problem.is_unseen(b)) {
          part_of_point[b] = part_of_point[a];
          found = true;
        }
    };
    for_each_kind([&]<class Kind>() {
      if constexpr (requires { Kind::for_each_tied_points(problem, extend); })
        Kind::for_each_tied_points(problem, extend);
    });
  }
}

// What observations with unknowns of their own see besides.
void observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts) {
  bool is_needed = !problem.auxiliaries.empty();
  for_each_kind([&]<class Kind>() { is_needed = is_needed || Kind::needs_rows_for_datum(problem); });
  if (!is_needed) return;
  MotionsWithAuxiliaries rows(problem, parts.size());
  for_each_kind<kInDatum>([&]<class Kind>() {
    if constexpr (requires { Kind::observe_rows(problem, state, parts, rows); })
      Kind::observe_rows(problem, state, parts, rows);
  });
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].seen += rows.seen(static_cast<int>(i));
}

// Up to kDatumImages poses of the part, each as far as possible from those before; of a large part among those that are
// eliminated last, where the ties between them cost nothing.
std::vector<int> spread_poses(const DatumPart& part, const State& state) {
  const auto last = static_cast<std::size_t>(4 * std::sqrt(static_cast<double>(part.poses.size())));
  const std::size_t candidates = std::min(part.poses.size(), std::max(kLeastDatumCandidates, last));
  const std::vector<int> poses(part.poses.end() - static_cast<std::ptrdiff_t>(candidates), part.poses.end());
  std::vector<double> distance(poses.size());
  for (std::size_t i = 0; i < distance.size(); ++i) distance[i] = (centre_in(state, poses[i]) - part.centre).norm();
  std::vector<int> chosen;
  while (chosen.size() < std::min(kDatumImages, poses.size())) {
    const auto far = std::max_element(distance.begin(), distance.end()) - distance.begin();
    chosen.push_back(poses[far]);
    for (std::size_t i = 0; i < distance.size(); ++i)
      distance[i] = std::min(distance[i], (centre_in(state, poses[i]) - centre_in(state, poses[far])).norm());
    distance[far] = -1;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// The motion `unseen` of the whole part as a motion of single poses; inner product in units of angle and size.
DatumConstraint constraint(const DatumPart& part, const State& state, const std::vector<int>& poses,
                           const Vector7& unseen) {
  DatumConstraint result{poses, {}, {}, part.centre, part.size, 0};
  double squared = 0;
  for (const int pose : poses) {
    // A world turned by w turns cam_from_world by -R w in the camera frame.
    const Eigen::Vector3d rotation = -(state.rotations[pose] * unseen.segment<3>(3));
    const Eigen::Vector3d shift = motion_of(centre_in(state, pose), part.centre, part.size) * unseen / part.size;
    result.direction.push_back({rotation.x(), rotation.y(), rotation.z(), shift.x(), shift.y(), shift.z()});
    squared += rotation.squaredNorm() + shift.squaredNorm() * part.size * part.size;
  }
  for (auto& direction : result.direction)
    for (double& value : direction) value /= std::sqrt(squared);
  return result;
}

// Constraints on the motions of a part that nothing sees.
void constrain(Problem& problem, const DatumPart& part, int index, const State& start) {
  problem.extent_m = std::max(problem.extent_m, part.size);
  const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(part.seen);
  const double largest = std::max(eigen.eigenvalues()[6], 1e-300);
  const std::vector<int> poses = spread_poses(part, start);
  for (int k = 0; k < 7 && eigen.eigenvalues()[k] <= kSeenMotion * largest; ++k) {
    problem.datum.push_back(constraint(part, start, poses, eigen.eigenvectors().col(k)));
    problem.datum.back().motion = eigen.eigenvectors().col(k);
    problem.datum.back().part = index;
    ++problem.rank_defect;
  }
}

DatumSources sources_of(const std::vector<DatumPart>& parts) {
  DatumSources sources;
  for (const DatumPart& part : parts) {
    sources.geodetic |= part.sources.geodetic;
    sources.fixed |= part.sources.fixed;
    sources.positions |= part.sources.positions;
    sources.control |= part.sources.control;
    sources.attitudes |= part.sources.attitudes;
  }
  sources.parts = static_cast<int>(parts.size());
  return sources;
}

}  // namespace

void find_datum(Problem& problem, const State& start) {
  std::vector<DatumPart> parts = find_parts(problem);
  measure(parts, problem, start);
  observe_motions(problem, start, parts);
  extend_parts(problem);
  observe_rows(problem, start, parts);
  for (std::size_t i = 0; i < parts.size(); ++i) constrain(problem, parts[i], static_cast<int>(i), start);
  // Nothing of it is fixed, also no station on the ground that no image shows.
  bool is_fixed = false;
  for (std::size_t p = 0; p < problem.point_count(); ++p) is_fixed = is_fixed || problem.point(p).is_fixed;
  problem.moves_as_one = parts.size() == 1 && !is_fixed && problem.images.size() == parts.front().poses.size();
  problem.datum_sources = sources_of(parts);
}

}  // namespace collinea::bundle
