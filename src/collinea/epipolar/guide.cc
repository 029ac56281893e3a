// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/guide.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/epipolar/internal/two_view_problems.h"
#include "collinea/epipolar/robust.h"

namespace collinea {
namespace {

constexpr double kBand = 2;  // largest errors on either side of a line, or round a position
constexpr std::size_t kMatchesPerUnknown = 5;
constexpr double kStrip_px = 128, kCell_px = 8;
constexpr double kOnPlane = 0.95;  // of the matches: where more is off the plane, there is more to be found there

// Points by strips across one axis and, within a strip, by cells along the other: the points of neighbouring cells lie
// one after the other.
class Strips {
 public:
  Strips(std::span<const double> across, std::span<const double> along) {
    if (across.empty()) return;
    const auto [across_low, across_high] = std::ranges::minmax(across);
    const auto [along_low, along_high] = std::ranges::minmax(along);
    across_low_ = across_low;
    along_low_ = along_low;
    strips_ = static_cast<std::size_t>((across_high - across_low) / kStrip_px) + 1;
    cells_ = static_cast<std::size_t>((along_high - along_low) / kCell_px) + 1;
    begin_.assign(strips_ * cells_ + 1, 0);
    std::vector<std::size_t> cell(across.size());
    for (std::size_t i = 0; i < across.size(); ++i) {
      cell[i] = static_cast<std::size_t>((across[i] - across_low) / kStrip_px) * cells_ +
                static_cast<std::size_t>((along[i] - along_low) / kCell_px);
      ++begin_[cell[i] + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    across_.resize(across.size());
    along_.resize(across.size());
    index_.resize(across.size());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < across.size(); ++i) {
      const std::size_t to = next[cell[i]]++;
      across_[to] = across[i];
      along_[to] = along[i];
      index_[to] = static_cast<std::uint32_t>(i);
    }
  }

  // Appends the points within `band_px` of across_part * across + along_part * along + constant = 0, |along_part| >=
  // 0.7. `room` holds one more than there are points.
  void add_near(double across_part, double along_part, double constant, double band_px,
                std::vector<std::uint32_t>& room, std::vector<std::uint32_t>& found) const {
    const double slope = -across_part / along_part, offset = -constant / along_part - along_low_;
    const double reach = (band_px / std::abs(along_part) + 0.5 * kStrip_px * std::abs(slope)) / kCell_px;
    const auto cells = static_cast<double>(cells_);
    std::size_t count = 0;
    for (std::size_t s = 0; s < strips_; ++s) {
      const double middle = across_low_ + (static_cast<double>(s) + 0.5) * kStrip_px;
      const double at = (slope * middle + offset) / kCell_px;
      if (!(at + reach >= 0) || !(at - reach < cells)) continue;
      const std::size_t first = s * cells_ + static_cast<std::size_t>(std::max(0.0, at - reach));
      const std::size_t last = s * cells_ + static_cast<std::size_t>(std::min(cells - 1, at + reach));
      for (std::size_t k = begin_[first]; k < begin_[last + 1]; ++k) {  // each is written, and stays if it is near
        room[count] = index_[k];
        count += std::abs(across_part * across_[k] + along_part * along_[k] + constant) < band_px;
      }
    }
    found.insert(found.end(), room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count));
  }

  // Appends the points less than `radius_px` from a position.
  void add_round(double across, double along, double radius_px, std::vector<std::uint32_t>& found) const {
    if (strips_ == 0) return;
    const auto part = [](double from_low, double size_px, std::size_t parts) {
      return static_cast<std::size_t>(std::clamp(from_low / size_px, 0.0, static_cast<double>(parts - 1)));
    };
    const std::size_t first_cell = part(along - radius_px - along_low_, kCell_px, cells_);
    const std::size_t last_cell = part(along + radius_px - along_low_, kCell_px, cells_);
    const std::size_t last_strip = part(across + radius_px - across_low_, kStrip_px, strips_);
    for (std::size_t s = part(across - radius_px - across_low_, kStrip_px, strips_); s <= last_strip; ++s)
      for (std::size_t k = begin_[s * cells_ + first_cell]; k < begin_[s * cells_ + last_cell + 1]; ++k)
        if (std::hypot(across_[k] - across, along_[k] - along) < radius_px) found.push_back(index_[k]);
  }

 private:
  double across_low_ = 0, along_low_ = 0;
  std::size_t strips_ = 0, cells_ = 0;
  std::vector<std::size_t> begin_;
  std::vector<double> across_, along_;
  std::vector<std::uint32_t> index_;
};

bool is_known(const Camera& camera) { return camera.prior.sigma_f_px == 0; }

PointPairs matched_pairs(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                         std::span<const Keypoint> second, const ImagePair& verified) {
  PointPairs pairs;
  pairs.focal_first_px = camera_first.focal_px();
  pairs.focal_second_px = camera_second.focal_px();
  for (const auto& [i, j] : verified.matches)
    pairs.add(camera_first, {first[i].x, first[i].y}, camera_second, {second[j].x, second[j].y});
  return pairs;
}

// The matrix of the pair's own coordinates: its essential matrix where the focal lengths are beyond doubt, else what
// the matches say by themselves.
std::optional<Eigen::Matrix3d> relation(const Camera& camera_first, std::span<const Keypoint> first,
                                        const Camera& camera_second, std::span<const Keypoint> second,
                                        const ImagePair& verified, double loss_px) {
  if (is_known(camera_first) && is_known(camera_second) && verified.second_from_first.translation.norm() > 0.5) {
    if (verified.matches.size() < 5 * kMatchesPerUnknown) return std::nullopt;
    return essential_matrix(verified.second_from_first);
  }
  if (verified.matches.size() < 7 * kMatchesPerUnknown) return std::nullopt;
  const PointPairs pairs = matched_pairs(camera_first, first, camera_second, second, verified);
  std::vector<int> all(verified.matches.size());
  std::iota(all.begin(), all.end(), 0);
  const auto start = eight_point(pairs, all);
  if (!start) return std::nullopt;
  return refine_fundamental(*start, pairs, all, loss_px);
}

// The homography that nearly all of the matches obey.
std::optional<Eigen::Matrix3d> mapping(const Camera& camera_first, std::span<const Keypoint> first,
                                       const Camera& camera_second, std::span<const Keypoint> second,
                                       const ImagePair& verified, double threshold_px) {
  if (verified.matches.size() < 8 * kMatchesPerUnknown) return std::nullopt;
  const PointPairs pairs = matched_pairs(camera_first, first, camera_second, second, verified);
  RobustOptions search;
  search.max_error_px = threshold_px;
  search.min_inlier_ratio = kOnPlane;
  Random random(1);
  const auto fit = robust_fit(HomographyProblem{pairs, threshold_px}, search, random);
  if (!fit || static_cast<double>(fit->inliers.size()) < kOnPlane * pairs.size()) return std::nullopt;
  return fit->model;
}

// Keypoints of the second image in pixels freed from distortion.
struct Undistorted {
  std::vector<double> u, v;

  Undistorted(const Camera& camera, std::span<const Keypoint> keypoints) : u(keypoints.size()), v(keypoints.size()) {
    for (std::size_t j = 0; j < keypoints.size(); ++j) {
      const Eigen::Vector2d at = camera.focal_px() * normalized(camera, {keypoints[j].x, keypoints[j].y});
      u[j] = at.x();
      v[j] = at.y();
    }
  }
};

// The candidates of every keypoint of the first image as add(its normalised coordinates, candidates) gives them.
template <class Add>
Guide guide_of(const Camera& camera, std::span<const Keypoint> keypoints, const Add& add) {
  Guide found;
  found.begin.reserve(keypoints.size() + 1);
  found.begin.push_back(0);
  for (const Keypoint& k : keypoints) {
    add(normalized(camera, {k.x, k.y}), found.candidates);
    found.begin.push_back(static_cast<std::uint32_t>(found.candidates.size()));
  }
  return found;
}

}  // namespace

std::optional<Guide> guide(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                           std::span<const Keypoint> second, const ImagePair& verified, const VerifyOptions& options) {
  const double threshold_px = largest_error_px(camera_first, camera_second, options);
  const double focal_px = camera_second.focal_px(), reach_px = kBand * threshold_px;
  if (verified.geometry == PairGeometry::kPlanar) {
    const auto matrix = mapping(camera_first, first, camera_second, second, verified, threshold_px);
    if (!matrix) return std::nullopt;
    const Undistorted undistorted(camera_second, second);
    const Strips upright(undistorted.u, undistorted.v);
    return guide_of(camera_first, first, [&](const Eigen::Vector2d& p, std::vector<std::uint32_t>& candidates) {
      const Eigen::Vector2d at = focal_px * (*matrix * p.homogeneous()).hnormalized();
      if (at.allFinite()) upright.add_round(at.x(), at.y(), reach_px, candidates);
    });
  }
  if (verified.geometry != PairGeometry::kGeneral) return std::nullopt;
  const auto matrix = relation(camera_first, first, camera_second, second, verified, threshold_px);
  if (!matrix) return std::nullopt;
  const Undistorted undistorted(camera_second, second);
  const Strips upright(undistorted.u, undistorted.v), level(undistorted.v, undistorted.u);
  std::vector<std::uint32_t> room(second.size() + 1);
  return guide_of(camera_first, first, [&](const Eigen::Vector2d& p, std::vector<std::uint32_t>& candidates) {
    const Eigen::Vector3d line = *matrix * p.homogeneous();
    const double norm = line.head<2>().norm();
    if (!(norm > 0)) return;
    const double a = line.x() / norm, b = line.y() / norm, c = focal_px * line.z() / norm;
    if (std::abs(b) >= std::abs(a))
      upright.add_near(a, b, c, reach_px, room, candidates);
    else
      level.add_near(b, a, c, reach_px, room, candidates);
  });
}

}  // namespace collinea
