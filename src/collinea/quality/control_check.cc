// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/control_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/block/image_axes.h"
#include "collinea/geometry/robust_similarity.h"
#include "collinea/math/median.h"
#include "collinea/quality/internal/control_measurements.h"

namespace collinea {
namespace {

using bundle::PositionPair;

struct LocatedPoint {
  ControlId id;
  PositionPair pair;  // block frame and world frame
  Eigen::Vector3d in_map;
  double sigma_in_block = 0;  // of its intersection, by its marks
};

std::vector<PositionPair> pairs_of(const std::vector<LocatedPoint>& located_points) {
  std::vector<PositionPair> pairs;
  for (const LocatedPoint& located : located_points) pairs.push_back(located.pair);
  return pairs;
}

std::vector<PositionPair> position_pairs(const Block& block) {
  std::vector<PositionPair> pairs;
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& position = block.images.at(id).position; position && position->sigma_m.allFinite())
      pairs.push_back({centre_of(pose), position->position_in_world, std::sqrt(position->sigma_m.squaredNorm() / 3)});
  return pairs;
}

// Root mean square distance of the pairs that count.
double scatter_m(const std::vector<PositionPair>& pairs, const Similarity3& world_from_block) {
  double squared = 0;
  for (const double distance : bundle::distances(pairs, world_from_block)) squared += distance * distance;
  return std::sqrt(squared / double(pairs.size()));
}

double size_m(const std::vector<PositionPair>& pairs) {
  Eigen::Vector3d low = pairs.front().in_world, high = low;
  for (const PositionPair& pair : pairs) {
    low = low.cwiseMin(pair.in_world);
    high = high.cwiseMax(pair.in_world);
  }
  return (high - low).norm();
}

std::optional<Similarity3> fit(const std::vector<PositionPair>& pairs) {
  std::vector<Eigen::Vector3d> a, b;
  for (const PositionPair& pair : pairs) {
    a.push_back(pair.in_block);
    b.push_back(pair.in_world);
  }
  return align(a, b);
}

// --- exchanged axes

// How well a similarity fits the control to the map (centred, so that kilometres do not cost digits), and whether the
// cameras then stand the right way up: the lower edge of an image as it is looked at or its optical axis points down,
// as images are taken.
struct MapFit {
  double scatter_m;
  double upright;  // mean of -(down + forward) over the images, positive when upright
};

std::optional<MapFit> fit_to_map(const Block& block, const std::vector<LocatedPoint>& located_points, bool swapped,
                                 std::uint64_t seed) {
  std::vector<PositionPair> pairs = pairs_of(located_points);
  for (std::size_t i = 0; i < located_points.size(); ++i) {
    const Eigen::Vector3d from_first = located_points[i].in_map - located_points.front().in_map;
    pairs[i].in_world = swapped ? Eigen::Vector3d(from_first.y(), from_first.x(), from_first.z()) : from_first;
  }
  const auto found = bundle::robust_similarity(pairs, seed);
  if (!found) return std::nullopt;
  const auto& similarity = found->world_from_block;
  MapFit result{median(std::vector(found->distances_m)), 0};
  for (const auto& [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d down_and_forward =
        pose.rotation.conjugate() * (down_in_cam(block.images.at(id).orientation) + Eigen::Vector3d::UnitZ());
    result.upright -= (similarity.rotation * down_and_forward).z() / double(count_oriented(block));
  }
  return result;
}

bool axes_are_swapped(const Block& block, const std::vector<LocatedPoint>& located_points, std::uint64_t seed) {
  if (located_points.size() < 3) return false;
  const auto as_given = fit_to_map(block, located_points, false, seed),
             exchanged = fit_to_map(block, located_points, true, seed);
  if (!as_given || !exchanged) return false;
  const double noise = 1e-6 + located_points.front().pair.sigma_m;
  const bool fits_better = 5 * (exchanged->scatter_m + noise) < as_given->scatter_m && exchanged->upright > 0;
  // On flat ground both fit, but one of them from below.
  const bool stands_better =
      exchanged->scatter_m < 2 * as_given->scatter_m + noise && exchanged->upright > 0.5 && as_given->upright < -0.5;
  return fits_better || stands_better;
}

// --- coordinates of points

Finding wrong_point(FindingCode code, ControlId id, const Eigen::Vector3d& off) {
  return finding_of(code, {id},
                    {{FigureName::kOffset, off.norm()},
                     {FigureName::kOffsetPlan, std::hypot(off.x(), off.y())},
                     {FigureName::kOffsetHeight, off.z()}});
}

void exclude(std::vector<LocatedPoint>& located_points, std::size_t i, const Eigen::Vector3d& off, FindingCode code,
             ControlDiagnosis& diagnosis) {
  const ControlId id = located_points[i].id;
  diagnosis.findings.push_back(wrong_point(code, id, off));
  diagnosis.excluded_points.insert(id);
  located_points.erase(located_points.begin() + static_cast<std::ptrdiff_t>(i));
}

// Leave-one-out: the point without which the others fit best goes when it is far off that fit.
void check_points_among_each_other(std::vector<LocatedPoint>& located_points, ControlDiagnosis& diagnosis) {
  while (located_points.size() >= 4) {
    double least = std::numeric_limits<double>::infinity(), scale = 1;
    std::size_t worst = located_points.size();
    Eigen::Vector3d off = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < located_points.size(); ++i) {
      std::vector<PositionPair> others = pairs_of(located_points);
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const auto similarity = fit(others);
      if (!similarity) continue;
      const double scatter = scatter_m(others, *similarity);
      if (scatter >= least) continue;
      least = scatter;
      worst = i;
      scale = similarity->scale;
      off = located_points[i].pair.in_world - *similarity * located_points[i].pair.in_block;
    }
    if (worst == located_points.size()) return;
    // Seven coordinates of the others are used up by the fit; what the few that are left say of the scatter is
    // uncertain, and the factor grows as Student's quantiles do (four points: two left, five: five, six: eight).
    const double times = located_points.size() == 4   ? 20
                         : located_points.size() == 5 ? 12
                         : located_points.size() == 6 ? 8
                                                      : 6;
    const double bending = 2e-3 * size_m(pairs_of(located_points));
    const double sigma_m = std::hypot(located_points[worst].pair.sigma_m, scale * located_points[worst].sigma_in_block);
    if (off.norm() < std::max({times * least, 10 * sigma_m, bending})) return;
    exclude(located_points, worst, off, FindingCode::kControlPoint, diagnosis);
  }
}

// Check points that contradict the control: for the user to know, nothing is excluded.
void name_wrong_check_points(const std::vector<LocatedPoint>& located_points, const std::vector<LocatedPoint>& checks,
                             ControlDiagnosis& diagnosis) {
  const std::vector<PositionPair> pairs = pairs_of(located_points);
  const auto similarity = bundle::span_a_plane(pairs) ? fit(pairs) : std::nullopt;
  if (!similarity) return;
  const double limit_m = std::max(20 * scatter_m(pairs, *similarity), 0.02 * size_m(pairs));
  for (const LocatedPoint& located : checks) {
    const Eigen::Vector3d off = located.pair.in_world - *similarity * located.pair.in_block;
    if (off.norm() < std::max(limit_m, 10 * located.pair.sigma_m)) continue;
    diagnosis.findings.push_back(
        finding_of(FindingCode::kCheckPoint, {located.id}, {{FigureName::kOffset, off.norm()}}));
  }
}

// Few points: the camera positions judge, as far as they can, after a shift common to all points.
void check_points_by_positions(const Block& block, std::vector<LocatedPoint>& located_points,
                               ControlDiagnosis& diagnosis, std::uint64_t seed) {
  const std::vector<PositionPair> positions = position_pairs(block);
  if (located_points.size() >= 4 || located_points.size() < 2 || !bundle::span_a_plane(positions)) return;
  const auto found = bundle::robust_similarity(positions, seed);
  if (!found) return;
  const double spread = median(std::vector(found->distances_m));
  const double limit = std::max(20 * spread, 0.02 * size_m(positions));
  std::vector<Eigen::Vector3d> off;
  for (const LocatedPoint& located : located_points)
    off.push_back(located.pair.in_world - found->world_from_block * located.pair.in_block);
  if (located_points.size() == 2) {
    const double apart = (off[0] - off[1]).norm();
    if (apart < limit) return;
    diagnosis.findings.push_back(finding_of(FindingCode::kControlInconsistent,
                                            {located_points[0].id, located_points[1].id},
                                            {{FigureName::kOffset, apart}}));
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d &one = off[(i + 1) % 3], &other = off[(i + 2) % 3], shift = (one + other) / 2;
    if ((one - other).norm() < limit / 2 && (off[i] - shift).norm() > limit) {
      exclude(located_points, i, off[i] - shift, FindingCode::kControlPointByPositions, diagnosis);
      return;
    }
  }
}

// --- positions against control

Eigen::Vector3d median_difference(const std::vector<Eigen::Vector3d>& differences, Eigen::Vector3d& scatter) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  scatter.setZero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values, apart;
    for (const auto& difference : differences)
      if (std::isfinite(difference[axis])) values.push_back(difference[axis]);
    if (values.empty()) continue;
    middle[axis] = median(values);
    for (const double value : values) apart.push_back(std::abs(value - middle[axis]));
    scatter[axis] = 1.4826 * median(apart);
  }
  return middle;
}

// Positions minus where the control puts the cameras (or, with little control, minus control seen from positions); NaN
// for heights that were not given.
std::vector<Eigen::Vector3d> position_differences(const Block& block, const std::vector<LocatedPoint>& located_points,
                                                  std::uint64_t seed) {
  std::vector<Eigen::Vector3d> differences;
  const std::vector<PositionPair> control = pairs_of(located_points);
  if (bundle::span_a_plane(control)) {
    const auto found = bundle::robust_similarity(control, seed);
    if (!found) return differences;
    for (const auto& [id, pose] : oriented_images(block)) {
      const auto& position = block.images.at(id).position;
      if (!position || !position->sigma_m.head<2>().allFinite()) continue;
      differences.push_back(position->position_in_world - found->world_from_block * centre_of(pose));
      if (!std::isfinite(position->sigma_m.z())) differences.back().z() = std::nan("");
    }
  } else if (const auto positions = position_pairs(block); bundle::span_a_plane(positions)) {
    if (const auto found = bundle::robust_similarity(positions, seed))
      for (const PositionPair& point : control)
        differences.push_back(found->world_from_block * point.in_block - point.in_world);
  }
  return differences;
}

void check_positions(const Block& block, const std::vector<LocatedPoint>& located_points, ControlDiagnosis& diagnosis,
                     std::uint64_t seed) {
  if (located_points.empty()) return;
  const std::vector<Eigen::Vector3d> differences = position_differences(block, located_points, seed);
  if (differences.empty()) return;
  Eigen::Vector3d scatter;
  const Eigen::Vector3d off = median_difference(differences, scatter);
  std::vector<double> sigmas;
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& position = block.images.at(id).position; position && position->sigma_m.head<2>().allFinite())
      sigmas.push_back(std::isfinite(position->sigma_m.z()) ? std::sqrt(position->sigma_m.squaredNorm() / 3)
                                                            : std::sqrt(position->sigma_m.head<2>().squaredNorm() / 2));
  const double sigma = median(sigmas), count = double(differences.size());
  const double plan = std::hypot(off.x(), off.y());
  const auto limit = [&](double spread, double least) {
    return std::max({least, 3 * sigma, 5 * spread / std::sqrt(count)});
  };
  if (plan > limit(scatter.head<2>().norm(), 500)) {
    diagnosis.findings.push_back(finding_of(FindingCode::kPositionCrs, {}, {{FigureName::kOffset, plan}}));
    diagnosis.positions_unusable = true;
    return;
  }
  if (plan > limit(scatter.head<2>().norm(), 10)) {
    diagnosis.findings.push_back(
        finding_of(FindingCode::kPositionOffset, {},
                   {{FigureName::kOffset, plan}, {FigureName::kEast, off.x()}, {FigureName::kNorth, off.y()}}));
    diagnosis.positions_unusable = true;
  }
  if (std::abs(off.z()) > std::max({1.0, 1.5 * sigma, 5 * scatter.z() / std::sqrt(count)})) {
    diagnosis.findings.push_back(
        finding_of(FindingCode::kPositionHeights, {}, {{FigureName::kUp, off.z()}},
                   {OptionName{"gps_heights", "import"}, OptionName{"control_heights", "import"}}));
    diagnosis.position_height_shift_m = -off.z();
  }
}

}  // namespace

ControlDiagnosis check_control(const Block& block, std::uint64_t seed) {
  ControlDiagnosis diagnosis;
  std::vector<LocatedPoint> located_points;
  for (const auto& [id, met] : bundle::intersect_control(block, diagnosis)) {
    const ControlPoint& control = block.control.at(id);
    if (!control.sigma_m.allFinite()) continue;  // partial control cannot be compared by a similarity
    located_points.push_back(
        {id,
         {met.point_in_world, control.position_in_world, std::sqrt(control.sigma_m.squaredNorm() / 3)},
         control.position_in_map,
         std::sqrt(met.covariance.trace() / 3)});
  }
  if (axes_are_swapped(block, located_points, seed)) {
    diagnosis.findings.push_back(finding_of(FindingCode::kControlAxesSwapped));
    diagnosis.axes_swapped = true;
    return diagnosis;
  }
  // From here on check points are only compared.
  const auto first_check = std::stable_partition(
      located_points.begin(), located_points.end(),
      [&](const LocatedPoint& located) { return block.control.at(located.id).role == ControlRole::kControl; });
  const std::vector<LocatedPoint> checks(first_check, located_points.end());
  located_points.erase(first_check, located_points.end());
  check_points_among_each_other(located_points, diagnosis);
  check_points_by_positions(block, located_points, diagnosis, seed);
  name_wrong_check_points(located_points, checks, diagnosis);
  check_positions(block, located_points, diagnosis, seed);
  return diagnosis;
}

void apply(const ControlDiagnosis& diagnosis, Block& block) {
  std::vector<ControlObservation> kept;
  for (std::size_t i = 0; i < block.control_observations.size(); ++i)
    if (!diagnosis.excluded_observations.contains(i) &&
        !diagnosis.excluded_points.contains(block.control_observations[i].point))
      kept.push_back(block.control_observations[i]);
  block.control_observations = std::move(kept);
  for (auto& [id, image] : block.images) {
    if (diagnosis.positions_unusable) image.position.reset();
    if (image.position) image.position->position_in_world.z() += diagnosis.position_height_shift_m;
  }
}

}  // namespace collinea
