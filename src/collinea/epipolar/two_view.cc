// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/two_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/epipolar/robust.h"
#include "collinea/epipolar/two_view_criteria.h"
#include "collinea/epipolar/two_view_problems.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kReferenceSize_px = 3000;  // pictures up to this size share one threshold
constexpr double kAssumedFocal = 0.1;       // sigma_f / f beyond which a focal length is a guess
constexpr double kPlaneThreshold = 1.25;    // two degrees of freedom instead of one at the same 95 %
constexpr double kMotionShare = 0.7;        // of the fundamental matrix's inliers that an essential matrix must keep
constexpr double kLensDoubt = 3;            // thresholds that an uncalibrated lens may feign as parallax

// Matches in random order.
struct Prepared {
  PointPairs pairs;
  std::vector<Match> matches;
  std::vector<Eigen::Vector2d> first_px, second_px;
  std::vector<int> preferred;  // those that turn and scale as most do
};

// What was found for one pair: the relation, who obeys it, and the motion with the coordinates it belongs to.
struct Finding {
  PairGeometry geometry = PairGeometry::kNone;
  std::vector<int> inliers;  // ascending
  Rigid3 second_from_first;  // translation 0: not known
  double median_parallax_rad = 0;
};

int longest_side_px(const Camera& first, const Camera& second) {
  return std::max({first.width_px, first.height_px, second.width_px, second.height_px});
}

double relative_sigma_f(const Camera& camera) { return camera.prior.sigma_f_px / camera.focal_px(); }

class Verification {
 public:
  Verification(const Camera& first, const Camera& second, const VerifyOptions& options, Random& random)
      : first_(first), second_(second), options_(options), random_(random) {
    threshold_px_ = largest_error_px(first, second, options);
  }

  [[nodiscard]] Finding find(const Prepared& prepared) {
    if (prepared.pairs.size() < options_.min_inliers) return {};
    preferred_ = prepared.preferred;
    const bool assumed = relative_sigma_f(first_) > kAssumedFocal || relative_sigma_f(second_) > kAssumedFocal;
    Relation epipolar = assumed ? by_fundamental(prepared.pairs) : by_essential(prepared.pairs);
    const std::optional<Plane> plane = by_plane(prepared.pairs, epipolar.inliers.size());
    if (plane && 4 * epipolar.inliers.size() < 3 * plane->inliers.size()) {
      // A wrong focal length can break the essential matrix but not the plane.
      epipolar.inliers = plane->inliers;
      epipolar.motion.reset();
    }
    if (!acceptable(prepared, epipolar.inliers)) return {};
    Finding finding = judged(epipolar, plane, prepared.pairs);
    if (!acceptable(prepared, finding.inliers)) return {};
    return finding;
  }

 private:
  struct Relation {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  // essential or fundamental, of `pairs`
    PointPairs pairs;                                  // with the focal length the matrix belongs to
    std::vector<int> inliers;
    int parameters = 5;
    std::optional<Rigid3> motion;
  };
  struct Plane {
    Eigen::Matrix3d matrix;  // of the nominal coordinates
    std::vector<int> inliers;
    std::vector<double> errors;
  };
  struct Turn {
    Eigen::Quaterniond rotation;
    std::vector<double> errors;
    int parameters;
  };

  [[nodiscard]] RobustOptions search_options(double threshold_px, int size) const {
    RobustOptions search;
    search.max_error_px = threshold_px;
    search.confidence = options_.confidence;
    search.max_trials = options_.max_trials;
    search.min_inlier_ratio = static_cast<double>(options_.min_inliers) / size;
    search.preferred = preferred_;
    return search;
  }

  // Rays nearer to parallel than this say nothing about before and behind.
  [[nodiscard]] double blind_angle_rad(const PointPairs& pairs) const {
    return 2 * threshold_px_ / std::min(pairs.focal_first_px, pairs.focal_second_px);
  }

  Relation by_essential(const PointPairs& pairs) {
    Relation relation;
    const auto fit =
        robust_fit(EssentialProblem{pairs, threshold_px_}, search_options(threshold_px_, pairs.size()), random_);
    if (!fit) return relation;
    relation.matrix = fit->model;
    relation.pairs = pairs;
    relation.inliers = fit->inliers;
    relation.motion = in_front(motions(fit->model), pairs, fit->inliers, blind_angle_rad(pairs));
    if (first_.prior.sigma_f_px > 0 || second_.prior.sigma_f_px > 0) adapt_focal(relation);
    return relation;
  }

  // A focal length from the EXIF data may be some per cent wrong, which costs matches that are right: lets it vary
  // within its uncertainty, as long as that brings the pairs clearly closer to the relation.
  void adapt_focal(Relation& relation) const {
    FocalDoubt doubt{first_.prior.sigma_f_px > 0, second_.prior.sigma_f_px > 0,
                     std::max(relative_sigma_f(first_), relative_sigma_f(second_))};
    const PointPairs nominal = relation.pairs;
    std::vector<double> errors = errors_of(relation.matrix, nominal, false);
    double cost = truncated_cost(errors, threshold_px_);
    for (int round = 0; round < 5 && relation.motion; ++round) {
      // Wide at first: the wrong focal length has pushed right matches across the threshold.
      const double reach_px = round < 2 ? 3 * threshold_px_ : threshold_px_;
      const auto fit = refine_relative_and_focal(*relation.motion, nominal, below(errors, reach_px), reach_px, doubt);
      if (!fit) return;
      PointPairs pairs =
          with_focal_factor(nominal, doubt.first ? fit->focal_factor : 1, doubt.second ? fit->focal_factor : 1);
      const Eigen::Matrix3d matrix = essential_matrix(fit->second_from_first);
      errors = errors_of(matrix, pairs, false);
      const double better = truncated_cost(errors, threshold_px_);
      if (!(better < 0.99 * cost)) {
        if (round < 2) continue;
        return;
      }
      cost = better;
      relation.inliers = below(errors, threshold_px_);
      relation.motion = in_front(motions(matrix), pairs, relation.inliers, blind_angle_rad(pairs));
      relation.matrix = matrix;
      relation.pairs = std::move(pairs);
      relation.parameters = 6;
    }
  }

  Relation by_fundamental(const PointPairs& pairs) {
    Relation relation;
    const auto fit =
        robust_fit(FundamentalProblem{pairs, threshold_px_}, search_options(threshold_px_, pairs.size()), random_);
    if (!fit) return relation;
    relation.matrix = fit->model;
    relation.pairs = pairs;
    relation.inliers = fit->inliers;
    relation.parameters = 7;
    calibrate(relation);
    return relation;
  }

  // The factor of the assumed focal length under which the fundamental matrix comes nearest to an essential one, and
  // its motion.
  void calibrate(Relation& relation) const {
    const PointPairs nominal = relation.pairs;
    const Eigen::Matrix3d fundamental = relation.matrix;
    std::size_t most = 0;
    for (const double factor : {1.0, 0.85, 1.18, 0.71, 1.4, 0.6, 1.67, 0.5, 2.0}) {
      const double k1 = relative_sigma_f(first_) > kAssumedFocal ? factor : 1;
      const double k2 = relative_sigma_f(second_) > kAssumedFocal ? factor : 1;
      const PointPairs pairs = with_focal_factor(nominal, k1, k2);
      const Eigen::Matrix3d nearly_essential =
          Eigen::DiagonalMatrix<double, 3>(k2, k2, 1) * fundamental * Eigen::DiagonalMatrix<double, 3>(k1, k1, 1);
      const auto motion = in_front(motions(nearly_essential), pairs, relation.inliers, blind_angle_rad(pairs));
      if (!motion) continue;
      const auto fit = refine_relative(*motion, pairs, relation.inliers, threshold_px_);
      if (!fit) continue;
      const auto kept = below(errors_of(essential_matrix(fit->second_from_first), pairs, false), threshold_px_);
      if (kept.size() <= most ||
          static_cast<double>(kept.size()) < kMotionShare * static_cast<double>(relation.inliers.size()))
        continue;
      most = kept.size();
      relation.motion = fit->second_from_first;
      relation.pairs = pairs;
    }
    // The criterion and the inliers stay with the fundamental matrix, in whichever coordinates.
    const double k1 = relation.pairs.focal_first_px / nominal.focal_first_px;
    const double k2 = relation.pairs.focal_second_px / nominal.focal_second_px;
    relation.matrix =
        Eigen::DiagonalMatrix<double, 3>(k2, k2, 1) * fundamental * Eigen::DiagonalMatrix<double, 3>(k1, k1, 1);
  }

  // A plane is of interest when it explains at least half as much as the epipolar geometry.
  std::optional<Plane> by_plane(const PointPairs& pairs, std::size_t epipolar_inliers) {
    const double threshold_px = kPlaneThreshold * threshold_px_;
    RobustOptions search = search_options(threshold_px, pairs.size());
    search.min_inlier_ratio =
        std::max(search.min_inlier_ratio, 0.5 * static_cast<double>(epipolar_inliers) / pairs.size());
    search.max_trials = std::min(search.max_trials, 1000);
    const auto fit = robust_fit(HomographyProblem{pairs, threshold_px}, search, random_);
    if (!fit || 2 * fit->inliers.size() < epipolar_inliers) return std::nullopt;
    return Plane{fit->model, fit->inliers, errors_of(fit->model, pairs, true)};
  }

  // The rotation that comes nearest to the homography, for the given focal length or, if it is uncertain, the best one
  // in its range.
  [[nodiscard]] std::optional<Turn> by_rotation(const Plane& plane, const PointPairs& pairs) const {
    const double sigma = std::max(relative_sigma_f(first_), relative_sigma_f(second_));
    double best_factor = 1, nearest = distance_from_rotation(plane.matrix);
    constexpr int kSteps = 40;
    for (int i = 1; sigma > 0 && i < kSteps; ++i) {
      const double factor = std::exp((i - kSteps / 2) * std::min(3 * sigma, std::log(2.0)) / (kSteps / 2));
      const double distance = distance_from_rotation(conjugated(plane.matrix, factor, factor));
      if (distance < nearest) {
        nearest = distance;
        best_factor = factor;
      }
    }
    std::optional<Turn> best = turn(plane, pairs, 1);
    if (best_factor != 1) {
      const std::optional<Turn> other = turn(plane, with_focal_factor(pairs, best_factor, best_factor), best_factor);
      const double threshold_px = kPlaneThreshold * threshold_px_;
      if (other && (!best || truncated_cost(other->errors, threshold_px) < truncated_cost(best->errors, threshold_px)))
        best = other;
    }
    return best;
  }

  // The homography of the coordinates after multiplying the focal lengths.
  static Eigen::Matrix3d conjugated(const Eigen::Matrix3d& h, double first, double second) {
    return Eigen::DiagonalMatrix<double, 3>(1 / second, 1 / second, 1) * h *
           Eigen::DiagonalMatrix<double, 3>(first, first, 1);
  }

  [[nodiscard]] std::optional<Turn> turn(const Plane& plane, const PointPairs& pairs, double factor) const {
    const auto rotation = refine_rotation(nearest_rotation(conjugated(plane.matrix, factor, factor)), pairs,
                                          plane.inliers, kPlaneThreshold * threshold_px_);
    if (!rotation) return std::nullopt;
    return Turn{*rotation, errors_of(rotation->toRotationMatrix(), pairs, true), factor == 1 ? 3 : 4};
  }

  // General, planar or rotation, by the information criterion over all pairs that obey either relation.
  [[nodiscard]] Finding judged(const Relation& epipolar, const std::optional<Plane>& plane,
                               const PointPairs& nominal) const {
    if (!plane) return general(epipolar);
    const bool has_epipolar = epipolar.pairs.size() > 0;
    std::vector<int> either;
    std::set_union(epipolar.inliers.begin(), epipolar.inliers.end(), plane->inliers.begin(), plane->inliers.end(),
                   std::back_inserter(either));
    const std::vector<double> errors =
        has_epipolar ? errors_of(epipolar.matrix, epipolar.pairs, false)
                     : std::vector<double>(plane->errors.size(), std::numeric_limits<double>::infinity());
    const double sigma_px = noise_px(has_epipolar ? errors : plane->errors, epipolar.inliers);
    const double as_general = gric(errors, either, sigma_px, 3, epipolar.parameters);
    const double as_plane = gric(plane->errors, either, sigma_px, 2, 8);
    if (const auto turned = by_rotation(*plane, nominal)) {
      const double as_rotation = gric(turned->errors, either, sigma_px, 2, turned->parameters);
      if (as_rotation < as_general && as_rotation <= as_plane)
        return rotation(*turned, nominal, below(turned->errors, kPlaneThreshold * threshold_px_));
      if (hardly_more_than(*turned, either)) return rotation(*turned, nominal, epipolar.inliers);
    }
    if (as_general <= as_plane) return general(epipolar);
    return planar(epipolar, *plane, nominal);
  }

  // From the median, which outliers just below the threshold do not move much.
  [[nodiscard]] double noise_px(const std::vector<double>& squared_px2, std::span<const int> inliers) const {
    constexpr double kLeastNoise_px = 0.4;  // also where a threshold was asked for that is not twice as much
    std::vector<double> some;
    for (const int i : inliers) some.push_back(squared_px2[static_cast<std::size_t>(i)]);
    return std::clamp(1.4826 * std::sqrt(some.empty() ? 0 : median(std::move(some))), kLeastNoise_px,
                      std::max(kLeastNoise_px, threshold_px_ / 2));
  }

  [[nodiscard]] Finding general(const Relation& epipolar) const {
    Finding finding{PairGeometry::kGeneral, epipolar.inliers, {}, 0};
    if (epipolar.motion) place(*epipolar.motion, epipolar.pairs, finding);
    return finding;
  }

  // With a lens not yet calibrated, the distortion looks like a little parallax, which is a share of the picture's
  // size: what remains after a rotation must be clearly more.
  [[nodiscard]] bool hardly_more_than(const Turn& turned, std::span<const int> items) const {
    if (first_.prior.sigma_f_px == 0 && second_.prior.sigma_f_px == 0) return false;
    const double limit_px = kLensDoubt * options_.max_error_px * longest_side_px(first_, second_) / kReferenceSize_px;
    const auto near = std::count_if(items.begin(), items.end(), [&](int i) {
      return turned.errors[static_cast<std::size_t>(i)] < limit_px * limit_px;
    });
    return static_cast<double>(near) > 0.9 * static_cast<double>(items.size());
  }

  [[nodiscard]] static Finding rotation(const Turn& turned, const PointPairs& pairs, std::vector<int> inliers) {
    Finding finding{PairGeometry::kRotation, std::move(inliers), {turned.rotation, {0, 0, 0}}, 0};
    finding.median_parallax_rad = median_parallax(finding.second_from_first, pairs, finding.inliers);
    return finding;
  }

  // The motion among those of the plane and that of the essential matrix which fits all pairs best.
  [[nodiscard]] Finding planar(const Relation& epipolar, const Plane& plane, const PointPairs& nominal) const {
    std::vector<Rigid3> candidates;
    if (epipolar.motion && epipolar.parameters < 7) candidates.push_back(*epipolar.motion);
    const PointPairs& pairs = epipolar.pairs.size() > 0 ? epipolar.pairs : nominal;
    const double k1 = pairs.focal_first_px / nominal.focal_first_px,
                 k2 = pairs.focal_second_px / nominal.focal_second_px;
    for (const PlanarMotion& m : planar_motions(conjugated(plane.matrix, k1, k2), pairs, plane.inliers))
      candidates.push_back(m.second_from_first);
    Finding finding{PairGeometry::kPlanar, plane.inliers, {}, 0};
    std::optional<Rigid3> best;
    double least = std::numeric_limits<double>::infinity();
    for (const Rigid3& start : candidates) {
      // Over all that are near, not the plane alone: what stands off the plane tells the motions apart.
      const auto near = below(errors_of(essential_matrix(start), pairs, false), 2 * threshold_px_);
      const auto fit = refine_relative(start, pairs, near, threshold_px_);
      if (!fit) continue;
      const auto errors = errors_of(essential_matrix(fit->second_from_first), pairs, false);
      const double cost = truncated_cost(errors, threshold_px_);
      if (!(cost < least)) continue;
      const auto motion =
          in_front(motions(essential_matrix(fit->second_from_first)), pairs, plane.inliers, blind_angle_rad(pairs));
      if (!motion) continue;
      const auto inliers = below(errors, threshold_px_);
      if (static_cast<double>(inliers.size()) < kMotionShare * static_cast<double>(plane.inliers.size())) continue;
      least = cost;
      best = motion;
      finding.inliers.clear();
      std::set_union(inliers.begin(), inliers.end(), plane.inliers.begin(), plane.inliers.end(),
                     std::back_inserter(finding.inliers));
    }
    if (best) place(*best, pairs, finding);
    return finding;
  }

  // Keeps the inliers in front of both cameras (or too far to tell) and measures their parallax.
  void place(const Rigid3& motion, const PointPairs& pairs, Finding& finding) const {
    finding.second_from_first = motion;
    const double blind = blind_angle_rad(pairs);
    std::erase_if(finding.inliers, [&](int i) {
      const RayMeeting at = meeting(motion, pairs.first(i), pairs.second(i));
      return at.angle_rad > blind && !(at.depth_first > 0 && at.depth_second > 0);
    });
    finding.median_parallax_rad = median_parallax(motion, pairs, finding.inliers);
  }

  static double median_parallax(const Rigid3& motion, const PointPairs& pairs, std::span<const int> inliers) {
    std::vector<double> angles;
    for (const int i : inliers) angles.push_back(meeting(motion, pairs.first(i), pairs.second(i)).angle_rad);
    return angles.empty() ? 0 : median(angles);
  }

  [[nodiscard]] bool acceptable(const Prepared& prepared, std::span<const int> inliers) const {
    if (static_cast<int>(inliers.size()) < options_.min_inliers) return false;
    const double narrow_px = 2 * threshold_px_;
    if (breadth_px(prepared.first_px, inliers) < narrow_px || breadth_px(prepared.second_px, inliers) < narrow_px)
      return false;
    return beyond_chance(prepared.second_px, inliers.size(), threshold_px_);
  }

  const Camera& first_;
  const Camera& second_;
  const VerifyOptions& options_;
  Random& random_;
  double threshold_px_;
  std::span<const int> preferred_;
};

Prepared prepared_pairs(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                        std::span<const Keypoint> second, std::span<const Match> matches, std::span<const int> order) {
  Prepared prepared;
  prepared.pairs.focal_first_px = camera_first.focal_px();
  prepared.pairs.focal_second_px = camera_second.focal_px();
  prepared.pairs.reserve(order.size());
  std::vector<TurnAndScale> changes;
  for (const int i : order) {
    const Match& match = matches[static_cast<std::size_t>(i)];
    const Keypoint &a = first[match.first], &b = second[match.second];
    if (!in_plane(camera_first, {a.x, a.y}) || !in_plane(camera_second, {b.x, b.y})) continue;
    prepared.matches.push_back(match);
    prepared.first_px.emplace_back(a.x, a.y);
    prepared.second_px.emplace_back(b.x, b.y);
    prepared.pairs.add(camera_first, prepared.first_px.back(), camera_second, prepared.second_px.back());
    changes.push_back(
        {b.angle_rad - a.angle_rad, a.scale_px > 0 && b.scale_px > 0 ? std::log2(b.scale_px / a.scale_px) : 0});
  }
  prepared.preferred = most_alike(changes);
  return prepared;
}

}  // namespace

double largest_error_px(const Camera& first, const Camera& second, const VerifyOptions& options) {
  return options.max_error_px * std::max(1.0, longest_side_px(first, second) / kReferenceSize_px);
}

ImagePair verify(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                 std::span<const Keypoint> second, std::span<const Match> putative, const VerifyOptions& options,
                 std::uint64_t seed) {
  ImagePair pair;
  pair.putative = static_cast<int>(putative.size());
  if (pair.putative < options.min_inliers) return pair;
  for (const Match& match : putative) COLLINEA_CHECK(match.first < first.size() && match.second < second.size());
  const std::vector<Match> moving = without_marks(first, second, putative);

  Random random(seed);
  const std::vector<int> order = shuffled(static_cast<int>(moving.size()), random);
  const Prepared prepared = prepared_pairs(camera_first, first, camera_second, second, moving, order);
  const Finding finding = Verification(camera_first, camera_second, options, random).find(prepared);
  if (finding.geometry == PairGeometry::kNone) return pair;
  for (const int i : finding.inliers) pair.matches.push_back(prepared.matches[static_cast<std::size_t>(i)]);
  if (nearly_all_still(first, second, pair.matches)) {
    pair.matches.clear();
    return pair;
  }
  pair.geometry = finding.geometry;
  pair.second_from_first = finding.second_from_first;
  pair.median_parallax_rad = finding.median_parallax_rad;
  std::sort(pair.matches.begin(), pair.matches.end());
  return pair;
}

}  // namespace collinea
