// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/adjust/control_check.h"
#include "collinea/adjust/datum.h"
#include "collinea/adjust/intersect.h"
#include "collinea/orient/global.h"
#include "collinea/orient/incremental.h"
#include "collinea/orient/strip_datum.h"
#include "collinea/orient/weak_cases.h"

namespace collinea {
namespace {

constexpr double kLeastSigma0 = 1e-3;   // of exact data
constexpr double kControlMisfit = 2.5;  // of control's own sigma0: what no chance explains
constexpr int kControlRounds = 3;
constexpr double kWeakTurn_rad = 0.03;    // of a block about the line of its positions: attitudes are better
constexpr double kNoTurn_rad = 0.2;       // not known
constexpr std::size_t kSmallestPart = 3;  // images of a part that is named as one

struct Parts {
  Reconstruction largest;
  bool in_world = false;  // it was placed by the positions of its images
  std::vector<std::vector<ImageId>> others;
  std::vector<ImageId> alone;
};

std::vector<ImageId> images_of(const Reconstruction& part) {
  std::vector<ImageId> images;
  for (const auto& [image, pose] : part.poses()) images.push_back(image);
  return images;
}

bool begins_globally(const Block& setup, const OrientOptions& options) {
  return options.mode == "global" || (options.mode == "auto" && options.use_positions && worth_global(setup));
}

// Grows parts until no new one with three images comes up; the largest is kept.
Result<Parts> grow_parts(const Block& setup, Reconstruction empty, std::span<const ImagePair> pairs,
                         const OrientOptions& options, const Run& run) {
  std::vector<Reconstruction> parts;
  std::set<ImageId> taken;
  bool placed = false;  // the first part
  for (;;) {
    Reconstruction part = empty;
    if (parts.empty() && begins_globally(setup, options)) {
      COLLINEA_TRY(placed, place_globally(part, setup, pairs, options, run));
      if (!placed && options.mode == "global")
        return fail(Errc::kIllPosed,
                    "the positions of the images do not fix the block (too few, all on one line, or they contradict "
                    "the pairs): orient with --mode incremental");
    }
    if (auto grown = grow(part, pairs, taken, options, run); !grown) return tl::unexpected(grown.error());
    if (part.poses().size() < (parts.empty() ? 2 : kSmallestPart)) break;
    for (const auto& [image, pose] : part.poses()) taken.insert(image);
    parts.push_back(std::move(part));
    if (empty.images_with_tracks().size() < taken.size() + kSmallestPart) break;
  }
  if (parts.empty()) return fail(Errc::kIllPosed, why_nothing(pairs));
  const auto largest = std::max_element(
      parts.begin(), parts.end(),
      [](const Reconstruction& a, const Reconstruction& b) { return a.poses().size() < b.poses().size(); });
  Parts result{std::move(*largest), placed && largest == parts.begin(), {}, {}};
  for (const Reconstruction& part : parts)
    if (&part != &*largest) result.others.push_back(images_of(part));
  for (const auto& [image, data] : setup.images)
    if (!taken.contains(image)) result.alone.push_back(image);
  return result;
}

// Without control or positions the gauge is made readable: origin in the middle of the cameras, z opposite to the mean
// downward direction of the pictures, the unit such that the first base had length one.
Similarity3 readable_gauge(const Reconstruction& part) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  for (const auto& [image, pose] : part.poses()) {
    up -= pose.rotation.conjugate() * Eigen::Vector3d::UnitY();
    middle += centre_of(pose) / static_cast<double>(part.poses().size());
  }
  Similarity3 gauge;
  if (up.norm() > 1e-6) gauge.rotation = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  gauge.translation = -(gauge.rotation * middle);
  return gauge;
}

double median_pixel_m(const Block& block) {
  std::vector<double> sizes;
  for (const Observation& seen : block.observations) {
    const double depth_m = (block.cam_from_world.at(seen.image) * block.points.at(seen.point).position_in_world).z();
    sizes.push_back(depth_m / block.camera_of(seen.image).focal_px());
  }
  if (sizes.empty()) return 0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

std::size_t count_positions(const Block& block) {
  return static_cast<std::size_t>(
      std::count_if(block.cam_from_world.begin(), block.cam_from_world.end(),
                    [&](const auto& pose) { return block.images.at(pose.first).position.has_value(); }));
}

class Orienter {
 public:
  Orienter(const Block& setup, const OrientOptions& options, const Run& run)
      : setup_(setup), options_(options), run_(run) {}

  Result<Orientation> orient(std::span<const ImagePair> pairs, const KeypointSource& keypoints) {
    COLLINEA_TRY(Reconstruction empty, Reconstruction::create(setup_, pairs, keypoints, options_));
    empty.sleep_surplus();
    COLLINEA_TRY(Parts parts, grow_parts(setup_, std::move(empty), pairs, options_, run_));
    result_.other_parts = std::move(parts.others);
    result_.alone = std::move(parts.alone);
    Reconstruction& part = parts.largest;
    part.wake_all();
    part.extend_all(run_);
    // A part that lies in the world by its positions keeps them: without them a large block only sways.
    const AdjustScope by_itself{.use_positions = parts.in_world && options_.use_positions, .use_control = false};
    COLLINEA_TRY(const Adjusted settled, settle(part, by_itself, options_, true, run_));
    take_sigma(part, settled.sigma0);
    const AdjustScope scope = place(part);
    if (result_.georeferenced)
      if (auto tied = tie_to_ground(part, scope); !tied) return tl::unexpected(tied.error());
    AdjustOptions final_options = settled_options(part, options_);
    final_options.first_damping = kSettledDamping;
    final_options.covariances = true;
    COLLINEA_TRY(result_.adjusted, part.adjust_all(final_options, scope, run_));
    finish(part);
    for (std::string& finding : weak_cases(result_.block, setup_, pairs, result_.adjusted))
      result_.findings.push_back(std::move(finding));
    return std::move(result_);
  }

 private:
  // Hardly anything but tie points took part: their sigma is what they show among each other. The loss sets in where it did.
  static void take_sigma(Reconstruction& part, double sigma0) {
    TieNoise noise = part.noise();
    noise.sigma_px *= sigma0;
    noise.loss_scale_sigmas /= std::max(sigma0, kLeastSigma0);
    part.set_noise(noise);
  }

  // What is wrong with control or positions is named and left out, for good.
  void examine(const Block& block) {
    const ControlDiagnosis diagnosis = check_control(block, run_.seed);
    for (const Finding& finding : diagnosis.findings) result_.findings.push_back(finding.message);
    result_.excluded_control = diagnosis.excluded_points;
    apply(diagnosis, setup_);
    if (diagnosis.axes_swapped) setup_.control_observations.clear();
  }

  // Rays to one control point that miss each other by many times their sigma were not measured as well as stated.
  void weigh_measurements(const Block& block) {
    double squares = 0, redundancy = 0, sigma_px = 0;
    for (const auto& [id, point] : block.control) {
      const std::vector<SightLine> lines = sight_lines(block, id);
      const auto met = intersect(lines);
      if (lines.size() < 2 || !met) continue;
      const double left = 2 * static_cast<double>(lines.size()) - 3;
      squares += met->sigma0 * met->sigma0 * left;
      redundancy += left;
    }
    const double factor = redundancy < 3 ? 0 : std::sqrt(squares / redundancy);
    if (factor < kControlMisfit) return;
    for (ControlObservation& seen : setup_.control_observations) sigma_px = std::max(sigma_px, seen.sigma_px *= factor);
    result_.findings.push_back(
        fmt::format("image measurements of control points miss each other by {:.1f} times their sigma; it is taken as "
                    "{:.2g} px. Look for marks that do not show the same place in all images",
                    factor, sigma_px));
  }

  // Adjusts with positions and control. Control that contradicts the block, and itself, by many times its sigma cannot
  // be as good as stated: it is given the sigma it shows, and that is said.
  Result<> tie_to_ground(Reconstruction& part, const AdjustScope& scope) {
    if (scope.use_control) weigh_measurements(part.block());
    double taken = 1, sigma_m = 0;
    for (int round = 0;; ++round) {
      COLLINEA_TRY(const Adjusted tied, settle(part, scope, options_, false, run_));
      const double factor = control_misfit(tied);
      if (factor < kControlMisfit || round == kControlRounds) break;
      taken *= factor;
      for (auto& [id, point] : setup_.control) {
        if (point.role == ControlRole::kCheck) continue;
        point.sigma_m *= factor;
        if (point.sigma_m.allFinite()) sigma_m = std::max(sigma_m, point.sigma_m.maxCoeff());
      }
    }
    if (taken > 1)
      result_.findings.push_back(
          fmt::format("control points contradict the images by {:.1f} times their sigma; it is taken as {:.2g} m. "
                      "Look for wrong points, or state the sigma they really have",
                      taken, sigma_m));
    return {};
  }

  // The standard deviation of unit weight of control alone: its coordinates and image measurements in sigmas, over what
  // is left of them after each point's three unknowns. 0 with fewer than three points.
  [[nodiscard]] double control_misfit(const Adjusted& adjusted) const {
    double sum = 0;
    int measured = 0;
    std::set<ControlId> used;
    for (const ControlDifference& difference : adjusted.control) {
      if (!difference.used) continue;
      used.insert(difference.point);
      const Eigen::Vector3d& sigma_m = setup_.control.at(difference.point).sigma_m;
      for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(sigma_m[axis])) {
          sum += std::pow(difference.difference_m[axis] / sigma_m[axis], 2);
          ++measured;
        }
    }
    for (std::size_t i = 0; i < setup_.control_observations.size(); ++i) {
      const ControlObservation& seen = setup_.control_observations[i];
      if (!used.contains(seen.point) || !adjusted.control_residuals_px[i].allFinite()) continue;
      sum += adjusted.control_residuals_px[i].squaredNorm() / (seen.sigma_px * seen.sigma_px);
      measured += 2;
    }
    const int redundancy = measured - 3 * static_cast<int>(used.size());
    return used.size() < 3 || redundancy < 3 ? 0 : std::sqrt(sum / redundancy);
  }

  // Brings the part into the frame of control or positions, where there are enough of them.
  AdjustScope place(Reconstruction& part) {
    AdjustScope scope{.use_positions = options_.use_positions, .use_control = options_.use_control};
    if (setup_.georeference && scope.use_control) examine(part.block());
    auto found =
        setup_.georeference ? datum(part.block(), scope.use_positions, scope.use_control, run_.seed) : std::nullopt;
    if (setup_.georeference && scope.use_positions && (!found || found->control.empty())) {
      const double turn_rad = found ? turn_sigma_rad(part.block(), found->world_from_block.scale) : kNoTurn_rad;
      if (turn_rad > kWeakTurn_rad && place_strip(part)) return {.use_positions = false, .use_control = false};
      if (turn_rad >= kNoTurn_rad) found.reset();
    }
    if (!found) {
      scope.use_positions = scope.use_control = false;
      part.move_world(readable_gauge(part));
      result_.gauge =
          "local gauge without scale, place or north: the unit is the first base, z is up as the pictures stand";
      if (setup_.georeference)
        result_.findings.push_back(
            "positions and control do not fix the place of the block (fewer than three, or all on one line): local "
            "gauge");
      return scope;
    }
    part.move_world(found->world_from_block);
    result_.georeferenced = true;
    const std::size_t positions = scope.use_positions ? count_positions(part.block()) : 0;
    std::string by = found->by_control ? "control points" : "";
    if (positions) by += (by.empty() ? "" : " and ") + fmt::format("{} image positions", positions);
    result_.gauge = fmt::format("map {}, fixed by {}", setup_.georeference->crs, by);
    return scope;
  }

  // Positions on one line take no part in the adjustment: their errors would turn the block about that line.
  bool place_strip(Reconstruction& part) {
    const auto found = strip_datum(part.block());
    if (!found) return false;
    part.move_world(*found);
    result_.georeferenced = true;
    result_.gauge = fmt::format("map {}, fixed by {} image positions on one line and the attitudes of the camera",
                                setup_.georeference->crs, count_positions(part.block()));
    result_.findings.push_back(
        "image positions lie on one line: the tilt across it is that of the attitudes the camera wrote, good to about "
        "a "
        "degree. A second strip or three control points would fix it");
    return true;
  }

  void finish(Reconstruction& part) {
    result_.block = part.block();
    result_.gsd_m = median_pixel_m(result_.block);
    for (const auto& other : result_.other_parts)
      result_.findings.push_back(fmt::format("{} images hang together but not with the block: {} ... {}", other.size(),
                                             setup_.images.at(other.front()).file,
                                             setup_.images.at(other.back()).file));
    if (!result_.alone.empty())
      result_.findings.push_back(fmt::format("{} image{} could not be oriented, the first: {}", result_.alone.size(),
                                             result_.alone.size() == 1 ? "" : "s",
                                             setup_.images.at(result_.alone.front()).file));
  }

  Block setup_;  ///< ours: the examination of control may take observations out
  const OrientOptions& options_;
  const Run& run_;
  Orientation result_;
};

}  // namespace

Result<Orientation> orient(const Block& setup, std::span<const ImagePair> pairs, const KeypointSource& keypoints,
                           const OrientOptions& options, const Run& run) {
  return Orienter(setup, options, run).orient(pairs, keypoints);
}

}  // namespace collinea
