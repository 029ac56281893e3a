// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "collinea/adjust/geodetic_positions.h"
#include "collinea/adjust/internal/gather_geodetic.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/epipolar/intersect.h"

namespace collinea::bundle {
namespace {

// The part of the finest pixel on the ground that a fixed coordinate may move beside a free one. The results then
// differ by the square of it from those of a coordinate that is really fixed, which a stiffer spring would spoil by
// rounding.
constexpr double kFixedPart = 1e-3;

// Sigma of a pixel across the sight line at that position, the least of all lines; 0 of no line.
double finest_on_ground_m(const std::vector<SightLine>& lines, const Eigen::Vector3d& position) {
  double finest = lines.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const SightLine& line : lines)
    finest = std::min(finest, line.sigma_px * (line.cam_from_world * position).norm() / line.camera->focal_px());
  return finest;
}

// Appends the ray of a measurement, if its image is oriented.
template <class Observed>
Result<> append_ray(const Block& block, const CandidateImages& images, const Observed& observed, std::size_t source,
                    std::vector<Ray>& rays) {
  const std::uint32_t image = images.index_of(observed.image);
  if (image == CandidateImages::kNone) return {};
  if (!(observed.sigma_px > 0) || !std::isfinite(observed.sigma_px) || !observed.pixel.allFinite())
    return fail(Errc::kBadInput, "an observation in " + block.images.at(observed.image).file +
                                     " has no finite coordinates with a positive standard deviation");
  if (!observed.shape.is_valid())
    return fail(Errc::kBadInput, "an observation in " + block.images.at(observed.image).file +
                                     " has a covariance that is none: standard deviations are above 0, the correlation "
                                     "is between -1 and 1");
  rays.push_back({{observed.pixel.x(), observed.pixel.y()},
                  1 / observed.sigma_px,
                  image,
                  static_cast<std::uint32_t>(source),
                  whitening_of(observed.shape)});
  return {};
}

// Appends the point whose rays from first_ray on were appended: one for each image, and none when no free image is
// among them in a local adjustment. True when the point is there.
bool close_point(const CandidateImages& images, const AdjustScope& scope, CandidatePoint point,
                 CandidatePoints& candidates) {
  std::vector<Ray>& rays = candidates.rays;
  const auto begin = rays.begin() + point.first_ray;
  const auto by_image = [](const Ray& a, const Ray& b) { return a.image < b.image; };
  if (!std::is_sorted(begin, rays.end(), by_image)) std::stable_sort(begin, rays.end(), by_image);
  rays.erase(std::unique(begin, rays.end(), [](const Ray& a, const Ray& b) { return a.image == b.image; }), rays.end());
  bool is_wanted = !scope.free_images;
  for (auto ray = begin; ray != rays.end() && !is_wanted; ++ray) is_wanted = images.images[ray->image].is_free;
  if ((begin == rays.end() && !point.is_linked) || !is_wanted) {
    rays.resize(point.first_ray);
    return false;
  }
  point.end_ray = static_cast<std::uint32_t>(rays.size());
  candidates.points.push_back(point);
  return true;
}

Result<> append_tie_points(const Block& block, const AdjustScope& scope, const CandidateImages& images,
                           CandidatePoints& candidates) {
  const auto& observations = block.observations;
  if (!scope.free_images) {
    candidates.rays.reserve(observations.size());
    candidates.points.reserve(block.points.size());
  }
  auto known = block.points.begin();
  for (std::size_t i = 0, end = 0; i < observations.size(); i = end) {
    const PointId id = observations[i].point;
    bool is_wanted = !scope.free_images;
    for (end = i; end < observations.size() && observations[end].point == id; ++end) {
      const std::uint32_t image = is_wanted ? CandidateImages::kNone : images.index_of(observations[end].image);
      is_wanted |= image != CandidateImages::kNone && images.images[image].is_free;
    }
    COLLINEA_CHECK(end == observations.size() || id < observations[end].point);
    if (!is_wanted) continue;
    if (known != block.points.end() && known->first < id) ++known;
    if (known == block.points.end() || known->first != id) known = block.points.lower_bound(id);
    if (known == block.points.end() || known->first != id) continue;
    CandidatePoint point;
    point.id = id.value;
    point.first_ray = static_cast<std::uint32_t>(candidates.rays.size());
    for (std::size_t k = i; k < end; ++k) COLLINEA_TRY(append_ray(block, images, observations[k], k, candidates.rays));
    point.is_fixed = scope.fixed_points.contains(id);
    if (point.is_fixed) point.least_rays = 1;
    Eigen::Map<Eigen::Vector3d>(point.position) = known->second.position_in_world;
    close_point(images, scope, point, candidates);
  }
  return {};
}

bool counts_as_control(const AdjustScope& scope, const ControlPoint& control) {
  return scope.use_control && control.role == ControlRole::kControl;
}

// Its measurements in images take part by themselves, whether its coordinates do or not.
bool has_own_rays(const AdjustScope& scope, const ControlPoint& control) {
  return counts_as_control(scope, control) || scope.use_check_rays;
}

// Where the images see a control point, else where it was surveyed.
std::optional<Eigen::Vector3d> start_of(const ControlPoint& control, bool is_control,
                                        const std::vector<SightLine>& lines) {
  if (!(is_control && (control.sigma_m.array() == 0).all()))
    if (const auto met = intersect(lines)) return met->point_in_world;
  const auto given = control.sigma_m.array().isFinite();
  if (given.all() || (given.any() && !lines.empty())) return control.position_in_world;
  return std::nullopt;
}

Result<> correlate(const ControlPoint& control, const Eigen::Vector3d& sigma_m, ControlCoordinates& coordinates) {
  const Eigen::Vector3d exact = (control.sigma_m.array() == 0).select(0, sigma_m);
  const auto weight = survey_weight(exact, control.correlation);
  if (!weight)
    return fail(Errc::kBadInput, "the correlations of control point " + control.name +
                                     " are not those of a covariance (it has to be positive definite)");
  for (int axis = 0; axis < 3; ++axis)
    if ((*weight)(axis, axis) > 0) coordinates.inverse_sigma[axis] = std::sqrt((*weight)(axis, axis));
  coordinates.off_diagonal_weight[0] = (*weight)(0, 1);
  coordinates.off_diagonal_weight[1] = (*weight)(0, 2);
  coordinates.off_diagonal_weight[2] = (*weight)(1, 2);
  return {};
}

// The surveyed coordinates of a control point. A fixed point has none that pull it.
Result<ControlCoordinates> surveyed_coordinates(const ControlPoint& control, const std::vector<SightLine>& lines,
                                                const Eigen::Vector3d& start) {
  const bool is_fixed = (control.sigma_m.array() == 0).all();
  ControlCoordinates coordinates{};
  Eigen::Vector3d sigmas_m;
  for (int axis = 0; axis < 3; ++axis) {
    double sigma_m = control.sigma_m[axis];
    if (!(sigma_m >= 0))
      return fail(Errc::kBadInput, "a standard deviation of control point " + control.name + " is no number from 0");
    if (!is_known(control.position_in_world[axis], sigma_m))
      return fail(Errc::kBadInput, "control point " + control.name + " has no finite coordinates");
    if (sigma_m == 0) sigma_m = kFixedPart * finest_on_ground_m(lines, start);
    sigmas_m[axis] = sigma_m;
    coordinates.inverse_sigma[axis] = is_fixed || !(sigma_m > 0) ? 0 : 1 / sigma_m;
    coordinates.given[axis] = std::isfinite(sigma_m) ? control.position_in_world[axis] : 0;
  }
  if (!is_fixed && !control.correlation.isZero(0)) COLLINEA_TRY(correlate(control, sigmas_m, coordinates));
  return coordinates;
}

/// What is known of a control point before it takes part.
struct ControlStart {
  std::vector<SightLine> lines;
  std::vector<std::size_t> sources;  ///< indices in Block::control_observations
  bool is_linked = false;
};

Result<> append_control_point(const Block& block, const AdjustScope& scope, const CandidateImages& images, ControlId id,
                              const ControlStart& known, const Eigen::Vector3d& start, CandidatePoints& candidates) {
  const ControlPoint& control = block.control.at(id);
  const bool is_control = counts_as_control(scope, control);
  CandidatePoint point;
  point.id = id.value;
  point.first_ray = static_cast<std::uint32_t>(candidates.rays.size());
  point.is_geodetic_only = !has_own_rays(scope, control);
  point.is_linked = known.is_linked;
  ControlCoordinates coordinates{};
  if (is_control) {
    COLLINEA_TRY(coordinates, surveyed_coordinates(control, known.lines, start));
    point.is_fixed = (control.sigma_m.array() == 0).all();
    point.given = static_cast<int>(control.sigma_m.array().isFinite().count());
  }
  if (point.given == 3) point.least_rays = 1;
  for (const std::size_t source : known.sources)
    COLLINEA_TRY(append_ray(block, images, block.control_observations[source], source, candidates.rays));
  point.control = static_cast<int>(candidates.control.size());
  Eigen::Map<Eigen::Vector3d>(point.position) = start;
  if (close_point(images, scope, point, candidates)) candidates.control.push_back(coordinates);
  return {};
}

Result<> append_control(const Block& block, const AdjustScope& scope, const CandidateImages& images,
                        CandidatePoints& candidates) {
  const std::set<ControlId> linked = points_of(block, candidates.geodetic);
  if (!scope.use_control && !scope.use_check_rays && linked.empty()) return {};
  std::map<ControlId, std::vector<std::size_t>> sources;
  for (std::size_t i = 0; i < block.control_observations.size(); ++i)
    sources[block.control_observations[i].point].push_back(i);
  std::map<ControlId, ControlStart> known;
  std::map<ControlId, Eigen::Vector3d> starts;
  for (const auto& [id, control] : block.control) {
    const bool is_control = counts_as_control(scope, control);
    if (!linked.contains(id) && !(has_own_rays(scope, control) && sources.contains(id))) continue;
    const ControlStart& its = known[id] = {sight_lines(block, id), sources[id], linked.contains(id)};
    if (const auto start = start_of(control, is_control, its.lines)) starts[id] = *start;
  }
  if (!candidates.geodetic.empty()) find_positions_by_geodetic(block, candidates.geodetic, starts);
  for (const auto& [id, its] : known) {
    const auto start = starts.find(id);
    if (start == starts.end() || !start->second.allFinite()) continue;  // there is no position to begin at
    COLLINEA_TRY(append_control_point(block, scope, images, id, its, start->second, candidates));
  }
  return {};
}

}  // namespace

CandidateImages candidate_images(const Block& block, const AdjustScope& scope) {
  CandidateImages candidates;
  const std::vector<OrientedImage> oriented = oriented_images(block);
  if (!oriented.empty()) candidates.index_of_id.assign(oriented.back().image.value + 1, CandidateImages::kNone);
  for (const auto& [id, pose] : oriented) {
    const bool is_free = (!scope.free_images || scope.free_images->contains(id)) && !scope.fixed_images.contains(id);
    candidates.index_of_id[id.value] = static_cast<std::uint32_t>(candidates.images.size());
    candidates.images.push_back({id, is_free});
  }
  return candidates;
}

Result<CandidatePoints> candidate_points(const Block& block, const AdjustScope& scope, const CandidateImages& images) {
  CandidatePoints candidates;
  COLLINEA_TRY(candidates.geodetic, geodetic_taking_part(block, scope));
  COLLINEA_TRY(append_tie_points(block, scope, images, candidates));
  COLLINEA_TRY(append_control(block, scope, images, candidates));
  return candidates;
}

bool is_known(double coordinate, double sigma) { return std::isfinite(coordinate) || std::isinf(sigma); }

}  // namespace collinea::bundle
