// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/robust_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "collinea/block/transform.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/geometry/robust_similarity.h"
#include "collinea/math/median.h"
#include "collinea/quality/internal/mark_network.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostRounds = 10;
constexpr double kTimesTypical = 3;                        // where the loss turns, in typical misfits
constexpr double kWithout = 30;                            // times that: without any weight
constexpr double kUncompared = 1e4;                        // times the sigma of what has not been compared yet
constexpr double kGrossOnGround = 20, kGrossInImage = 50;  // sigmas, and typical misfits

// --- kinds of measurements that are about as far off as each other

enum class Kind { kTie, kMark, kCoordinate, kMeasured };
constexpr std::size_t kKinds = 4;

Kind kind_of(ObservationGroup group) {
  switch (traits_of(group).source) {
    case ObservationSource::kTieImagePoint:
      return Kind::kTie;
    case ObservationSource::kControlImagePoint:
      return Kind::kMark;
    case ObservationSource::kControlCoordinates:
    case ObservationSource::kPosition:
      return Kind::kCoordinate;
    case ObservationSource::kGeodetic:
    case ObservationSource::kAttitude:
      return Kind::kMeasured;
  }
  bug("a measurement of no kind");
}

// What is typical of each kind: the median, 1 at least.
using Typical = std::array<double, kKinds>;

Typical typical_of(const std::vector<Misfit>& misfits) {
  std::array<std::vector<double>, kKinds> all;
  for (const Misfit& one : misfits) all[static_cast<std::size_t>(kind_of(one.index.group))].push_back(one.sigmas);
  Typical typical{};
  for (std::size_t k = 0; k < kKinds; ++k) typical[k] = all[k].empty() ? 1 : std::max(1.0, median(std::move(all[k])));
  return typical;
}

double typical_of(const Misfit& one, const Typical& typical) {
  return typical[static_cast<std::size_t>(kind_of(one.index.group))];
}

// --- onto control and positions

// A position that is known in the frame of the network and, on axes with a finite sigma, in the world.
struct KnownPosition {
  Eigen::Vector3d in_network, in_world, sigma_m;
  [[nodiscard]] bool is_full() const { return sigma_m.allFinite(); }
};

std::vector<KnownPosition> known_positions(const Measurements& given, const MarkNetwork& network) {
  std::vector<KnownPosition> positions;
  const auto add = [&](const Eigen::Vector3d& in_network, const Eigen::Vector3d& in_world,
                       const Eigen::Vector3d& sigma_m) {
    const Eigen::Vector3d there = sigma_m.array().isFinite().select(in_world, in_network);
    if (there.allFinite()) positions.push_back({in_network, there, sigma_m});
  };
  if (given.scope.use_control)
    for (const auto& [id, marked] : network.marked)
      if (const ControlPoint& control = given.block.control.at(id); control.role == ControlRole::kControl)
        add(marked, control.position_in_world, control.sigma_m);
  if (given.scope.use_positions && given.scope.position_tracks.empty())
    for (const auto& [id, pose] : oriented_images(network.block))
      if (const auto& position = given.block.images.at(id).position)
        add(centre_of(pose), position->position_in_world, position->sigma_m);
  return positions;
}

// The sum of the roots of all differences in plan and in height.
double roots_of_differences(const std::vector<KnownPosition>& positions, const Similarity3& world_from_network) {
  double sum = 0;
  for (const KnownPosition& one : positions) {
    const Eigen::Vector3d off = world_from_network * one.in_network - one.in_world;
    if (one.sigma_m.head<2>().allFinite()) sum += std::sqrt(off.head<2>().norm());
    if (std::isfinite(one.sigma_m.z())) sum += std::sqrt(std::abs(off.z()));
  }
  return sum;
}

// By the triple of positions known on all axes for which the roots are least.
std::optional<Similarity3> robust_alignment(const std::vector<KnownPosition>& positions, std::uint64_t seed) {
  constexpr std::size_t kMostTriples = 1000;
  std::vector<bundle::PositionPair> full;
  for (const KnownPosition& one : positions)
    if (one.is_full()) full.push_back({one.in_network, one.in_world});
  return bundle::best_of_triples(full, kMostTriples, seed, [&](const Similarity3& candidate) {
    return roots_of_differences(positions, candidate);
  });
}

// --- reweighting

class Reweighting {
 public:
  Reweighting(const Measurements& given, const AdjustOptions& options, const Run& run)
      : fit_{given, {}, {}}, options_(options), run_(run) {
    options_.loss = Loss::kCauchy;
    options_.position_loss = Loss::kNone;
    options_.relative_cost_change = 1e-6;
  }

  Result<RobustFit> fit() {
    COLLINEA_TRY(const MarkNetwork network, mark_network_of(fit_.measurements, run_));
    begin_at(network);
    for (int round = 0; round < kMostRounds; ++round) {
      const Typical typical = typical_of(fit_.misfits);
      const double of_ties = round == 0 ? network.typical_sigmas : typical[0];
      options_.loss_scale_sigmas = std::clamp(2 * of_ties, 2.0, 1e6);
      COLLINEA_TRY(fit_.adjusted, adjust(weighted(typical).block, scope_, options_, run_));
      apply(fit_.adjusted, fit_.measurements.block);
      std::vector<Misfit> misfits = misfits_of(fit_.measurements, fit_.adjusted);
      const bool settled = round > 1 && is_settled(misfits);
      fit_.misfits = std::move(misfits);
      if (settled) break;
    }
    return std::move(fit_);
  }

 private:
  void begin_at(const MarkNetwork& network) {
    Measurements& all = fit_.measurements;
    std::optional<Similarity3> similarity;  // fixed images are where they are
    if (all.scope.fixed_images.empty()) similarity = robust_alignment(known_positions(all, network), run_.seed);
    const Similarity3 moved_by = similarity.value_or(Similarity3{});
    for (const auto& [id, pose] : oriented_images(network.block)) set_pose(all.block, id, pose);
    for (const auto& [id, position] : network.points) all.block.points.at(id).position_in_world = position;
    if (similarity) transform(all.block, moved_by);
    scope_ = all.scope;
    for (auto& [id, control] : all.block.control) soften(id, control.sigma_m);
    Adjusted at;  // as if adjusted there
    for (const auto& [id, pose] : oriented_images(all.block)) at.cam_from_world[id] = pose;
    for (const auto& [id, control] : all.block.control) {
      ControlDifference one{.point = id, .used = scope_.use_control && is_control(id)};
      const auto marked = network.marked.find(id);
      one.position_in_world =
          start_of(control, sight_lines(all.block, id),
                   marked == network.marked.end() ? std::nullopt : std::optional(moved_by * marked->second));
      if (one.position_in_world) at.control.push_back(one);
    }
    at.control_residuals_px = residuals_of_marks(at);
    fit_.misfits = misfits_of(all, at);
  }

  [[nodiscard]] bool is_control(ControlId id) const {
    return fit_.measurements.block.control.at(id).role == ControlRole::kControl;
  }

  // Where its rays meet or where it was surveyed: where the sum of the roots of all differences is least, in pixels and
  // each up to a hundred. Of a point with two marks one of which is wrong the survey says which.
  [[nodiscard]] static std::optional<Eigen::Vector3d> start_of(const ControlPoint& control,
                                                               const std::vector<SightLine>& lines,
                                                               const std::optional<Eigen::Vector3d>& marked) {
    if (!control.sigma_m.allFinite() || !control.position_in_world.allFinite()) return marked;
    if (!marked) return control.position_in_world;
    const auto root = [](double px) { return std::sqrt(std::min(100.0, px)); };
    double at_survey = 0, at_marks = 0, finest = 0;
    for (const SightLine& line : lines) {
      at_survey += root(miss_px(line, control.position_in_world));
      at_marks += root(miss_px(line, *marked));
      finest = std::max(finest, line.camera->focal_px() / (line.cam_from_world * *marked).norm());
    }
    const Eigen::Vector3d off = finest * (control.position_in_world - *marked);
    at_marks += root(off.head<2>().norm()) + root(std::abs(off.z()));
    return at_marks <= at_survey ? *marked : control.position_in_world;
  }

  // Fixed coordinates get the size of a pixel on the ground.
  void soften(ControlId id, Eigen::Vector3d& sigma_m) const {
    if ((sigma_m.array() > 0).all()) return;
    const Block& block = fit_.measurements.block;
    double finest_m = kInfinity;
    for (const SightLine& line : sight_lines(block, id)) {
      const auto met = intersect(sight_lines(block, id));
      if (!met) break;
      finest_m = std::min(finest_m,
                          line.sigma_px * (line.cam_from_world * met->point_in_world).norm() / line.camera->focal_px());
    }
    if (!std::isfinite(finest_m)) finest_m = 0.01;
    sigma_m = (sigma_m.array() > 0).select(sigma_m, finest_m);
  }

  [[nodiscard]] std::vector<Eigen::Vector2d> residuals_of_marks(const Adjusted& at) const {
    const Block& block = fit_.measurements.block;
    std::map<ControlId, Eigen::Vector3d> positions;
    for (const ControlDifference& one : at.control) positions.emplace(one.point, *one.position_in_world);
    std::vector<Eigen::Vector2d> residuals;
    for (const ControlObservation& seen : block.control_observations) {
      residuals.emplace_back(Eigen::Vector2d::Constant(std::nan("")));
      const auto position = positions.find(seen.point);
      if (position == positions.end() || !is_oriented(block, seen.image)) continue;
      if (const auto px = project(block.camera_of(seen.image), pose_of(block, seen.image) * position->second))
        residuals.back() = seen.pixel - *px;
    }
    return residuals;
  }

  // The measurements with sigmas that their misfits have enlarged; what is beyond hope has no part. Tie points have
  // the loss of the adjustment.
  [[nodiscard]] Measurements weighted(const Typical& typical) {
    Measurements all = fit_.measurements;
    std::vector<MeasurementIndex> rejected;
    for (const Misfit& one : fit_.misfits) {
      if (kind_of(one.index.group) == Kind::kTie) continue;
      const double k = kTimesTypical * typical_of(one, typical);
      if (one.sigmas > kWithout * k && can_go(one.index.group))
        rejected.push_back(one.index);
      else
        enlarge(one.index, typical_of(one, typical) * (1 + std::min(one.sigmas * one.sigmas, 1e12) / (k * k)), all);
    }
    if (fit_.adjusted.iterations == 0)  // nothing has been compared with measurements on the ground yet
      for (GeodeticObservation& one : all.block.geodetic) one.sigma *= kUncompared;
    all = without(std::move(all), rejected);
    scope_.attitudes = all.scope.attitudes;
    return all;
  }

  // Without a part it can be compared all the same.
  [[nodiscard]] bool can_go(ObservationGroup group) const {
    const ObservationSource source = traits_of(group).source;
    return source == ObservationSource::kControlCoordinates || source == ObservationSource::kGeodetic ||
           (source == ObservationSource::kPosition && scope_.position_tracks.empty() && scope_.lever_arms.empty() &&
            scope_.time_offset_sigma_s.empty());
  }

  // Multiplies the sigma of a measurement.
  static void enlarge(MeasurementIndex index, double factor, Measurements& all) {
    Block& block = all.block;
    const ImageId image{index.source};
    switch (traits_of(index.group).source) {
      case ObservationSource::kTieImagePoint:
        block.observations[index.source].sigma_px *= factor;
        return;
      case ObservationSource::kControlImagePoint:
        block.control_observations[index.source].sigma_px *= factor;
        return;
      case ObservationSource::kControlCoordinates:
        axes_of(index.group, block.control.at(ControlId{index.source}).sigma_m) *= factor;
        return;
      case ObservationSource::kPosition:
        axes_of(index.group, block.images.at(image).position->sigma_m) *= factor;
        return;
      case ObservationSource::kGeodetic:
        block.geodetic[index.source].sigma *= factor;
        return;
      case ObservationSource::kAttitude:
        axes_of(index.group, all.scope.attitudes.at(image).sigma_rad) *= factor;
        return;
    }
  }

  // No misfit has changed by a tenth of a sigma, and of large ones by a hundredth.
  [[nodiscard]] bool is_settled(const std::vector<Misfit>& misfits) const {
    if (misfits.size() != fit_.misfits.size()) return false;
    for (std::size_t i = 0; i < misfits.size(); ++i) {
      const double before = fit_.misfits[i].sigmas, now = misfits[i].sigmas;
      if (!(std::abs(now - before) <= 0.1 + 0.01 * before) && now != before) return false;
    }
    return true;
  }

  RobustFit fit_;
  AdjustScope scope_;
  AdjustOptions options_;
  const Run& run_;
};

}  // namespace

Result<RobustFit> robust_fit(const Measurements& given, const AdjustOptions& options, const Run& run) {
  return Reweighting(given, options, run).fit();
}

bool contradict_each_other(const RobustFit& fit) {
  return typical_of(fit.misfits)[static_cast<std::size_t>(Kind::kCoordinate)] > kGrossOnGround;
}

std::vector<Misfit> gross_misfits(const RobustFit& fit) {
  const bool contradiction = contradict_each_other(fit);
  const Typical typical = typical_of(fit.misfits);
  std::vector<Misfit> gross;
  for (const Misfit& one : fit.misfits) {
    const double limit = is_image_point(one.index.group) ? kGrossInImage : kGrossOnGround;
    const bool is_of_contradiction = contradiction && kind_of(one.index.group) == Kind::kCoordinate;
    if (one.sigmas > limit * (is_of_contradiction ? 1 : typical_of(one, typical))) gross.push_back(one);
  }
  std::stable_sort(gross.begin(), gross.end(), [](const Misfit& a, const Misfit& b) { return a.sigmas > b.sigmas; });
  return gross;
}

}  // namespace collinea
