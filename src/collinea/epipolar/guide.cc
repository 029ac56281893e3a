// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/guide.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "collinea/epipolar/essential.h"
#include "collinea/epipolar/fundamental.h"
#include "collinea/epipolar/point_pairs.h"
#include "collinea/epipolar/relative.h"

namespace collinea {
namespace {

constexpr double kBand = 2;  // largest errors on either side of a line
constexpr std::size_t kMatchesPerUnknown = 5;
constexpr double kStrip_px = 128, kCell_px = 8;

// a u + b v + c = 0 with a^2 + b^2 = 1.
struct Line {
  double a, b, c;
};

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

 private:
  double across_low_ = 0, along_low_ = 0;
  std::size_t strips_ = 0, cells_ = 0;
  std::vector<std::size_t> begin_;
  std::vector<double> across_, along_;
  std::vector<std::uint32_t> index_;
};

bool is_known(const Camera& camera) { return camera.sigma_f_px == 0; }

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
  PointPairs pairs;
  pairs.focal_first_px = camera_first.focal_px();
  pairs.focal_second_px = camera_second.focal_px();
  for (const auto& [i, j] : verified.matches)
    pairs.add(normalized(camera_first, {first[i].x, first[i].y}),
              normalized(camera_second, {second[j].x, second[j].y}));
  std::vector<int> all(verified.matches.size());
  std::iota(all.begin(), all.end(), 0);
  const auto start = eight_point(pairs, all);
  if (!start) return std::nullopt;
  return refine_fundamental(*start, pairs, all, loss_px);
}

}  // namespace

std::optional<Guide> guide(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                           std::span<const Keypoint> second, const ImagePair& verified, const VerifyOptions& options) {
  if (verified.geometry != PairGeometry::kGeneral) return std::nullopt;
  const double threshold_px = largest_error_px(camera_first, camera_second, options);
  const auto matrix = relation(camera_first, first, camera_second, second, verified, threshold_px);
  if (!matrix) return std::nullopt;

  const double focal_px = camera_second.focal_px();
  std::vector<double> u(second.size()), v(second.size());
  for (std::size_t j = 0; j < second.size(); ++j) {
    const Eigen::Vector2d at = focal_px * normalized(camera_second, {second[j].x, second[j].y});
    u[j] = at.x();
    v[j] = at.y();
  }
  const Strips upright(u, v), level(v, u);
  std::vector<std::uint32_t> room(second.size() + 1);
  Guide found;
  found.begin.reserve(first.size() + 1);
  found.begin.push_back(0);
  for (const Keypoint& k : first) {
    const Eigen::Vector3d line = *matrix * normalized(camera_first, {k.x, k.y}).homogeneous();
    const double norm = line.head<2>().norm();
    if (norm > 0) {
      const double a = line.x() / norm, b = line.y() / norm, c = focal_px * line.z() / norm;
      if (std::abs(b) >= std::abs(a))
        upright.add_near(a, b, c, kBand * threshold_px, room, found.candidates);
      else
        level.add_near(b, a, c, kBand * threshold_px, room, found.candidates);
    }
    found.begin.push_back(static_cast<std::uint32_t>(found.candidates.size()));
  }
  return found;
}

}  // namespace collinea
