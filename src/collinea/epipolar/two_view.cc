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
#include "collinea/epipolar/internal/two_view_criteria.h"
#include "collinea/epipolar/internal/two_view_problems.h"
#include "collinea/epipolar/internal/two_view_relations.h"
#include "collinea/epipolar/robust.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kReferenceSize_px = 3000;  // images up to this size share one threshold
constexpr double kLensDoubt = 3;            // thresholds that an uncalibrated lens may feign as parallax

// Matches in random order.
struct Prepared {
  PointPairs pairs;
  std::vector<Match> matches;
  std::vector<Eigen::Vector2d> first_px, second_px;
  std::vector<int> preferred;  // those that turn and scale as most do
};

// What was found for one pair: the relation, who obeys it, and the motion with the coordinates it belongs to.
struct Verdict {
  PairGeometry geometry = PairGeometry::kNone;
  std::vector<int> inliers;  // ascending
  Rigid3 second_from_first;  // translation 0: not known
  double median_parallax_rad = 0;
};

int longest_side_px(const Camera& first, const Camera& second) {
  return std::max({first.width_px, first.height_px, second.width_px, second.height_px});
}

double median_parallax(const Rigid3& motion, const PointPairs& pairs, std::span<const int> inliers) {
  std::vector<double> angles;
  for (const int i : inliers) angles.push_back(meeting(motion, pairs.first(i), pairs.second(i)).angle_rad);
  return angles.empty() ? 0 : median(angles);
}

// Keeps the inliers in front of both cameras (or too far to tell) and measures their parallax.
void set_motion(const TwoViews& views, const Rigid3& motion, const PointPairs& pairs, Verdict& finding) {
  finding.second_from_first = motion;
  const double blind = blind_angle_rad(views, pairs);
  std::erase_if(finding.inliers, [&](int i) {
    const RayMeeting at = meeting(motion, pairs.first(i), pairs.second(i));
    return at.angle_rad > blind && !(at.depth_first > 0 && at.depth_second > 0);
  });
  finding.median_parallax_rad = median_parallax(motion, pairs, finding.inliers);
}

Verdict general(const TwoViews& views, const EpipolarRelation& epipolar) {
  Verdict finding{PairGeometry::kGeneral, epipolar.inliers, {}, 0};
  if (epipolar.motion) set_motion(views, *epipolar.motion, epipolar.pairs, finding);
  return finding;
}

Verdict rotation(const RotationRelation& rotated, const PointPairs& pairs, std::vector<int> inliers) {
  Verdict finding{PairGeometry::kRotation, std::move(inliers), {rotated.rotation, {0, 0, 0}}, 0};
  finding.median_parallax_rad = median_parallax(finding.second_from_first, pairs, finding.inliers);
  return finding;
}

// The motion among those of the plane and that of the essential matrix which fits all pairs best.
Verdict planar(const TwoViews& views, const EpipolarRelation& epipolar, const PlaneRelation& plane,
               const PointPairs& nominal) {
  std::vector<Rigid3> candidates;
  if (epipolar.motion && epipolar.parameters < 7) candidates.push_back(*epipolar.motion);
  const PointPairs& pairs = epipolar.pairs.size() > 0 ? epipolar.pairs : nominal;
  const double k1 = pairs.focal_first_px / nominal.focal_first_px, k2 = pairs.focal_second_px / nominal.focal_second_px;
  for (const PlanarMotion& m : planar_motions(conjugated(plane.matrix, k1, k2), pairs, plane.inliers))
    candidates.push_back(m.second_from_first);
  Verdict finding{PairGeometry::kPlanar, plane.inliers, {}, 0};
  std::optional<Rigid3> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Rigid3& start : candidates) {
    // Over all that are near, not the plane alone: what stands off the plane tells the motions apart.
    const auto near = below(errors_of(essential_matrix(start), pairs, false), 2 * views.threshold_px);
    const auto fit = refine_relative(start, pairs, near, views.threshold_px);
    if (!fit) continue;
    const auto errors = errors_of(essential_matrix(fit->second_from_first), pairs, false);
    const double cost = truncated_cost(errors, views.threshold_px);
    if (!(cost < least)) continue;
    const auto motion = in_front(motions(essential_matrix(fit->second_from_first)), pairs, plane.inliers,
                                 blind_angle_rad(views, pairs));
    if (!motion) continue;
    const auto inliers = below(errors, views.threshold_px);
    if (static_cast<double>(inliers.size()) < kMotionShare * static_cast<double>(plane.inliers.size())) continue;
    least = cost;
    best = motion;
    finding.inliers.clear();
    std::set_union(inliers.begin(), inliers.end(), plane.inliers.begin(), plane.inliers.end(),
                   std::back_inserter(finding.inliers));
  }
  if (best) set_motion(views, *best, pairs, finding);
  return finding;
}

// With a lens not yet calibrated, the distortion looks like a little parallax, which is a share of the image's
// size: what remains after a rotation must be clearly more.
bool hardly_more_than(const TwoViews& views, const RotationRelation& rotated, std::span<const int> items) {
  if (views.first.prior.sigma_f_px == 0 && views.second.prior.sigma_f_px == 0) return false;
  const double limit_px =
      kLensDoubt * views.options.max_error_px * longest_side_px(views.first, views.second) / kReferenceSize_px;
  const auto near = std::count_if(items.begin(), items.end(), [&](int i) {
    return rotated.errors[static_cast<std::size_t>(i)] < limit_px * limit_px;
  });
  return static_cast<double>(near) > 0.9 * static_cast<double>(items.size());
}

// From the median, which outliers just below the threshold do not move much.
double noise_px(const TwoViews& views, const std::vector<double>& squared_px2, std::span<const int> inliers) {
  constexpr double kLeastNoise_px = 0.4;  // also where a threshold was asked for that is not twice as much
  std::vector<double> some;
  for (const int i : inliers) some.push_back(squared_px2[static_cast<std::size_t>(i)]);
  return std::clamp(1.4826 * std::sqrt(some.empty() ? 0 : median(std::move(some))), kLeastNoise_px,
                    std::max(kLeastNoise_px, views.threshold_px / 2));
}

// General, planar or rotation, by the information criterion over all pairs that obey either relation.
Verdict judged(const TwoViews& views, const EpipolarRelation& epipolar, const std::optional<PlaneRelation>& plane,
               const PointPairs& nominal) {
  if (!plane) return general(views, epipolar);
  const bool has_epipolar = epipolar.pairs.size() > 0;
  std::vector<int> either;
  std::set_union(epipolar.inliers.begin(), epipolar.inliers.end(), plane->inliers.begin(), plane->inliers.end(),
                 std::back_inserter(either));
  const std::vector<double> errors =
      has_epipolar ? errors_of(epipolar.matrix, epipolar.pairs, false)
                   : std::vector<double>(plane->errors.size(), std::numeric_limits<double>::infinity());
  const double sigma_px = noise_px(views, has_epipolar ? errors : plane->errors, epipolar.inliers);
  const double as_general = gric(errors, either, sigma_px, 3, epipolar.parameters);
  const double as_plane = gric(plane->errors, either, sigma_px, 2, 8);
  if (const auto rotated = by_rotation(views, *plane, nominal)) {
    const double as_rotation = gric(rotated->errors, either, sigma_px, 2, rotated->parameters);
    if (as_rotation < as_general && as_rotation <= as_plane)
      return rotation(*rotated, nominal, below(rotated->errors, kPlaneThreshold * views.threshold_px));
    if (hardly_more_than(views, *rotated, either)) return rotation(*rotated, nominal, epipolar.inliers);
  }
  if (as_general <= as_plane) return general(views, epipolar);
  return planar(views, epipolar, *plane, nominal);
}

bool acceptable(const TwoViews& views, const Prepared& prepared, std::span<const int> inliers) {
  if (static_cast<int>(inliers.size()) < views.options.min_inliers) return false;
  const double narrow_px = 2 * views.threshold_px;
  if (breadth_px(prepared.first_px, inliers) < narrow_px || breadth_px(prepared.second_px, inliers) < narrow_px)
    return false;
  return beyond_chance(prepared.second_px, inliers.size(), views.threshold_px);
}

Verdict find(const TwoViews& views, const Prepared& prepared, Random& random) {
  if (prepared.pairs.size() < views.options.min_inliers) return {};
  const bool assumed = relative_sigma_f(views.first) > kAssumedFocal || relative_sigma_f(views.second) > kAssumedFocal;
  EpipolarRelation epipolar =
      assumed ? by_fundamental(views, prepared.pairs, random) : by_essential(views, prepared.pairs, random);
  const std::optional<PlaneRelation> plane = by_plane(views, prepared.pairs, epipolar.inliers.size(), random);
  if (plane && 4 * epipolar.inliers.size() < 3 * plane->inliers.size()) {
    // A wrong focal length can break the essential matrix but not the plane.
    epipolar.inliers = plane->inliers;
    epipolar.motion.reset();
  }
  if (!acceptable(views, prepared, epipolar.inliers)) return {};
  Verdict finding = judged(views, epipolar, plane, prepared.pairs);
  if (!acceptable(views, prepared, finding.inliers)) return {};
  return finding;
}

Prepared prepared_pairs(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                        std::span<const Keypoint> second, std::span<const Match> matches, std::span<const int> order) {
  Prepared prepared;
  prepared.pairs.focal_first_px = camera_first.focal_px();
  prepared.pairs.focal_second_px = camera_second.focal_px();
  prepared.pairs.reserve(order.size());
  std::vector<RotationAndScale> changes;
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
  const Verdict finding = find({camera_first, camera_second, options,
                                largest_error_px(camera_first, camera_second, options), prepared.preferred},
                               prepared, random);
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
