// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/mark_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "collinea/epipolar/intersect_rays.h"
#include "collinea/quality/internal/mark_factor.h"

namespace collinea {
namespace {

constexpr double kSigmas = 6, kLeast_px = 3, kOfSide = 0.002;  // tolerance of a mark
constexpr double kFits = 0.5;                                  // share of redundancy from which marks fit as given
constexpr double kExplains = 0.7;                              // and from which a system explains them
constexpr int kLeastRedundancy = 6, kLeastPoints = 3;
constexpr double kRival = 0.5;  // of the best system's share: not certain
constexpr double kLeastNoise_px = 0.05;
constexpr double kMargin = 0.02;    // of the image's side: how far outside a corrected mark may lie
constexpr double kNoFactor = 0.02;  // a factor nearer to one says nothing
constexpr double kFactorStep = 2e-3;
constexpr int kFactorSteps = 6;          // either way, around a likely factor
constexpr double kCurvatureStep = 1e-3;  // of the logarithm of a factor: no mark leaves the tolerance by it
constexpr std::size_t kMostPoints = 60;
constexpr double kDepthFactor = 2;  // by which control may stand out of the depths of tie points

using Points = std::vector<std::vector<MarkedRay>>;

struct Depths {
  double nearest = 0, farthest = 0;
};

// Depths of the tie points in each image with marks, without the twentieth part at either end.
std::map<ImageId, Depths> depths_of(const Block& block) {
  std::map<ImageId, std::vector<double>> all;
  for (const ControlObservation& seen : block.control_observations) all[seen.image];
  for (const Observation& seen : block.observations) {
    const auto its = all.find(seen.image);
    if (its == all.end()) continue;
    const auto point = block.points.find(seen.point);
    const std::optional<Rigid3> pose = find_pose(block, seen.image);
    if (point != block.points.end() && pose) its->second.push_back((*pose * point->second.position_in_world).z());
  }
  std::map<ImageId, Depths> depths;
  for (auto& [image, values] : all) {
    if (values.empty()) continue;
    std::sort(values.begin(), values.end());
    const std::size_t twentieth = values.size() / 20;
    depths[image] = {values[twentieth], values[values.size() - 1 - twentieth]};
  }
  return depths;
}

// Points that are marked in two oriented images and more; of very many an even selection.
Points marked_points(const Block& block) {
  const std::map<ImageId, Depths> depths = depths_of(block);
  std::map<ControlId, std::vector<MarkedRay>> of_point;
  for (const ControlObservation& seen : block.control_observations)
    if (const std::optional<Rigid3> pose = find_pose(block, seen.image)) {
      MarkedRay ray{&block.camera_of(seen.image), *pose, seen.pixel, seen.sigma_px};
      if (const auto its = depths.find(seen.image); its != depths.end()) {
        ray.nearest = its->second.nearest / kDepthFactor;
        ray.farthest = its->second.farthest * kDepthFactor;
      }
      of_point[seen.point].push_back(ray);
    }
  std::erase_if(of_point, [](const auto& point) { return point.second.size() < 2; });
  Points points;
  const std::size_t step = of_point.size() / kMostPoints + 1;
  std::size_t number = 0;
  for (auto& [id, rays] : of_point)
    if (number++ % step == 0) points.push_back(std::move(rays));
  return points;
}

double tolerance_px(const std::vector<MarkedRay>& rays) {
  double tolerance = kLeast_px;
  for (const MarkedRay& ray : rays)
    tolerance =
        std::max({tolerance, kSigmas * ray.sigma_px, kOfSide * std::max(ray.camera->width_px, ray.camera->height_px)});
  return tolerance;
}

bool lies_near(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double x = kMargin * camera.width_px, y = kMargin * camera.height_px;
  return pixel.x() >= -x && pixel.y() >= -y && pixel.x() <= camera.width_px + x && pixel.y() <= camera.height_px + y;
}

// At least as many images see the point at a depth of their tie points as do not.
bool lies_among_tie_points(const std::vector<MarkedRay>& rays, const RobustPoint& point) {
  int among = 0, off = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!point.inlier[i] || rays[i].farthest <= 0) continue;
    const double depth = (rays[i].cam_from_world * point.point_in_world).z();
    ++(depth >= rays[i].nearest && depth <= rays[i].farthest ? among : off);
  }
  return among >= off;
}

void add_point(const std::vector<MarkedRay>& given, const MarkHypothesis& hypothesis, MarkMeeting& meeting) {
  const double tolerance = tolerance_px(given);
  std::vector<MarkedRay> rays;
  std::vector<Rigid3> poses;
  std::vector<Eigen::Vector2d> normalized_xy;
  std::vector<double> focal_px;
  for (const MarkedRay& ray : given) {
    const Eigen::Vector2d pixel = pixel_of(hypothesis, *ray.camera, ray.given);
    if (!pixel.allFinite() || !lies_near(*ray.camera, pixel) || !in_plane(*ray.camera, pixel)) continue;
    rays.push_back(ray);
    poses.push_back(ray.cam_from_world);
    normalized_xy.push_back(normalized(*ray.camera, pixel));
    focal_px.push_back(ray.camera->focal_px());
  }
  const auto all = static_cast<int>(given.size());
  meeting.marks += all;
  meeting.redundancy += 2 * all - 3;
  const auto point = robust_intersect(poses, normalized_xy, focal_px, tolerance);
  const bool is_met = point && lies_among_tie_points(rays, *point);
  const int met = is_met ? point->inliers : 0;
  meeting.meeting += met;
  if (is_met) {
    meeting.redundancy_met += 2 * met - 3;
    meeting.cost_met += met * std::pow(point->rms_px, 2);
  }
  meeting.truncated_cost += (all - met) * tolerance * tolerance + (is_met ? met * std::pow(point->rms_px, 2) : 0);
}

MarkMeeting meeting_of(const Points& points, const MarkHypothesis& hypothesis) {
  MarkMeeting meeting;
  for (const std::vector<MarkedRay>& point : points) add_point(point, hypothesis, meeting);
  return meeting;
}

struct Explanation {
  MarkHypothesis hypothesis;
  MarkMeeting meeting;
  double relative_sigma = 0;  // of its factor
  bool is_determined = true;  // an error of the factor by its sigma moves the marks by less than their own
};

bool is_better(const MarkMeeting& one, const MarkMeeting& other) { return one.truncated_cost < other.truncated_cost; }

// Standard deviation of a coordinate of the marks that meet.
double noise_px(const MarkMeeting& meeting) {
  return std::max(kLeastNoise_px, std::sqrt(meeting.cost_met / std::max(1, meeting.redundancy_met)));
}

// Mean squared distance of the marks from the point that the factor does not move.
double squared_radius_px2(const Points& points, const MarkHypothesis& hypothesis) {
  double sum = 0, count = 0;
  for (const std::vector<MarkedRay>& rays : points)
    for (const MarkedRay& ray : rays) {
      sum += (hypothesis.factor * ray.given).squaredNorm();
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

// The factor of least truncated cost around a likely one: steps first, then the golden section. Its sigma follows from
// how fast the cost rises: sum of squares = least + bending d^2 for the logarithm of the factor d off.
Explanation with_best_factor(const Points& points, MarkSystem system, double likely) {
  const auto at = [&](double factor) {
    const MarkHypothesis hypothesis{system, factor};
    return Explanation{hypothesis, meeting_of(points, hypothesis)};
  };
  Explanation best = at(likely);
  for (int k = -kFactorSteps; k <= kFactorSteps; ++k)
    if (Explanation next = at(likely * (1 + k * kFactorStep)); is_better(next.meeting, best.meeting)) best = next;
  double low = best.hypothesis.factor * (1 - kFactorStep), high = best.hypothesis.factor * (1 + kFactorStep);
  const double golden = (std::sqrt(5.0) - 1) / 2;
  for (int k = 0; k < 20; ++k) {
    const Explanation left = at(high - golden * (high - low)), right = at(low + golden * (high - low));
    const bool to_left = is_better(left.meeting, right.meeting);
    (to_left ? high : low) = (to_left ? right : left).hypothesis.factor;
    if (const Explanation& next = to_left ? left : right; is_better(next.meeting, best.meeting)) best = next;
  }
  const double factor = best.hypothesis.factor, cost = best.meeting.truncated_cost;
  const double bending = (at(factor * (1 + kCurvatureStep)).meeting.truncated_cost +
                          at(factor * (1 - kCurvatureStep)).meeting.truncated_cost - 2 * cost) /
                         (2 * kCurvatureStep * kCurvatureStep);
  best.relative_sigma = bending > 0 ? noise_px(best.meeting) / std::sqrt(bending) : 1;
  best.is_determined = bending > squared_radius_px2(points, best.hypothesis);
  return best;
}

// The best of a system; nothing where it has a factor and none is likely.
std::optional<Explanation> best_of(const Points& points, MarkSystem system) {
  if (!has_factor(system)) return Explanation{{system, 1}, meeting_of(points, {system, 1})};
  std::optional<Explanation> best;
  for (const double likely : likely_factors(points, system)) {
    const MarkMeeting first = meeting_of(points, {system, likely});
    if (best && first.share() < kRival * best->meeting.share()) continue;
    const Explanation next = with_best_factor(points, system, likely);
    if (std::abs(next.hypothesis.factor - 1) > kNoFactor && (!best || is_better(next.meeting, best->meeting)))
      best = next;
  }
  return best;
}

// A factor that the same system does as well without says nothing: over flat ground it goes with the depth of the
// points.
void drop_needless_factors(std::vector<Explanation>& tried) {
  constexpr double kAsWell = 0.9;
  const std::vector<Explanation> all = tried;
  std::erase_if(tried, [&](const Explanation& one) {
    const MarkSystem plain = without_factor(one.hypothesis.system);
    return plain != one.hypothesis.system && std::ranges::any_of(all, [&](const Explanation& other) {
             return other.hypothesis.system == plain && other.meeting.share() >= kAsWell * one.meeting.share();
           });
  });
}

Finding finding_of_system(FindingCode code, const Explanation& found, const MarkMeeting& as_given, double limit_px) {
  return finding_of(code, {},
                    {{FigureName::kCount, double(found.meeting.meeting)},
                     {FigureName::kOf, double(found.meeting.marks)},
                     {FigureName::kCount, double(as_given.meeting)},
                     {FigureName::kOffsetPx, limit_px},
                     {FigureName::kRatio, found.hypothesis.factor},
                     {FigureName::kSigmaScale, found.relative_sigma}},
                    {RemedyCode::kCorrectMarks}, std::string(word_of(found.hypothesis.system)));
}

}  // namespace

MarkMeeting meeting_of(const Block& block, const MarkHypothesis& hypothesis) {
  return meeting_of(marked_points(block), hypothesis);
}

MarkDiagnosis check_marks(const Block& block) {
  MarkDiagnosis diagnosis;
  const Points points = marked_points(block);
  if (points.size() < kLeastPoints) return diagnosis;
  const MarkMeeting as_given = meeting_of(points, {});
  if (as_given.redundancy < kLeastRedundancy || as_given.share() >= kFits) return diagnosis;
  std::vector<Explanation> tried;
  for (const auto& [system, word, meaning] : kMarkSystemWords)
    if (system != MarkSystem::kAsGiven)
      if (const auto found = best_of(points, system)) tried.push_back(*found);
  drop_needless_factors(tried);
  std::stable_sort(tried.begin(), tried.end(), [](const Explanation& one, const Explanation& other) {
    return one.meeting.share() > other.meeting.share();
  });
  const auto explains = [&](const Explanation& one) {
    return one.meeting.share() >= kExplains && one.meeting.redundancy_met >= kLeastRedundancy;
  };
  if (tried.empty() || !explains(tried[0])) return diagnosis;
  const Explanation& best = tried[0];
  double limit_px = 0;
  for (const auto& point : points) limit_px = std::max(limit_px, tolerance_px(point));
  for (const Explanation& one : tried)
    if (explains(one))
      diagnosis.findings.push_back(finding_of_system(FindingCode::kMarksCountedOtherwise, one, as_given, limit_px));
  const double rival = std::max(as_given.share(), tried.size() > 1 ? tried[1].meeting.share() : 0);
  if (!best.is_determined || rival >= kRival * best.meeting.share()) return diagnosis;
  diagnosis.correction = best.hypothesis;
  diagnosis.findings.push_back(finding_of_system(FindingCode::kMarksCorrected, best, as_given, limit_px));
  diagnosis.findings.back().remedies.clear();
  return diagnosis;
}

void correct_marks(std::span<const Finding> findings, Block& block) {
  for (const Finding& finding : findings) {
    if (finding.code != FindingCode::kMarksCorrected) continue;
    const auto system = from_word<MarkSystem>(finding.detail);
    if (!system) continue;
    const MarkHypothesis hypothesis{*system, finding.figure(FigureName::kRatio).value_or(1)};
    const bool is_resampled = *system == MarkSystem::kResampled || *system == MarkSystem::kResampledRowsUp;
    for (ControlObservation& seen : block.control_observations) {
      seen.pixel = pixel_of(hypothesis, block.camera_of(seen.image), seen.pixel);
      if (is_resampled) seen.sigma_px *= hypothesis.factor;
    }
    return;
  }
}

void remove_marks_outside(Block& block) {
  std::erase_if(block.control_observations,
                [&](const ControlObservation& seen) { return !inside(block.camera_of(seen.image), seen.pixel); });
}

}  // namespace collinea
