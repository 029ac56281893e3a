// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/remeasure.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "collinea/base/parallel.h"
#include "collinea/match/least_squares_matching.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

constexpr double kSpacing = 0.5;         // between the points of a window, of the feature's scale
constexpr double kLevelRounding = 0.25;  // points are 0.84 to 1.68 pixels of the level apart: neither alias nor blur
constexpr int kLevels = 6;
constexpr std::size_t kObservationsAtOnce = 65536;  // 150 MB of patches
constexpr std::size_t kChunk = 64;                  // points handed to a thread at once

// One observation and how the reference's window will look there.
struct Sight {
  Eigen::Matrix2d warp = Eigen::Matrix2d::Identity();
  double scale_px = 0;  // of its feature
  int level = 0;
  std::optional<Patch> patch;
};

// Observations [begin, end) of one point.
struct Group {
  std::size_t begin, end, reference = 0;
};

class Remeasurer {
 public:
  Remeasurer(const Block& block, const KeypointSource& keypoints, const ImageSource& images, const Run& run)
      : block_(block), keypoints_(keypoints), images_(images), run_(run), positions_(block.observations.size()) {}

  Result<std::vector<std::optional<Eigen::Vector2d>>> all() {
    const std::size_t count = block_.observations.size();
    for (std::size_t begin = 0; begin < count;) {
      std::size_t end = std::min(count, begin + kObservationsAtOnce);
      while (end < count && block_.observations[end].point == block_.observations[end - 1].point) ++end;
      COLLINEA_TRY(lot(begin, end));
      begin = end;
    }
    return std::move(positions_);
  }

 private:
  using ByImage = std::vector<std::pair<ImageId, std::vector<std::size_t>>>;

  [[nodiscard]] const Observation& seen(std::size_t i) const { return block_.observations[i]; }

  Result<> lot(std::size_t begin, std::size_t end) {
    sights_.assign(end - begin, {});
    first_ = begin;
    std::map<ImageId, std::vector<std::size_t>> images;
    for (std::size_t i = begin; i < end; ++i) images[seen(i).image].push_back(i);
    const ByImage by_image(images.begin(), images.end());
    for (const auto& [image, observations] : by_image) {
      COLLINEA_TRY(const std::vector<Keypoint> found, keypoints_(image));
      for (const std::size_t i : observations) sight(i).scale_px = found.at(seen(i).feature).scale_px;
    }
    std::vector<Group> groups;
    for (std::size_t i = begin; i < end; ++i) {
      if (groups.empty() || seen(groups.back().begin).point != seen(i).point) groups.push_back({i, i});
      groups.back().end = i + 1;
    }
    in_chunks(groups, [&](Group& group) { predict(group); });
    parallel_for(run_, by_image.size(), [&](std::size_t k) { cut(by_image[k].first, by_image[k].second); });
    in_chunks(groups, [&](Group& group) { match(group); });
    return run_.stopped() ? fail(Errc::kCancelled, "stopped") : Result<>{};
  }

  template <class Work>
  void in_chunks(std::vector<Group>& groups, const Work& work) {
    parallel_for(run_, (groups.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
      for (std::size_t g = chunk * kChunk; g < std::min(groups.size(), (chunk + 1) * kChunk); ++g) work(groups[g]);
    });
  }

  Sight& sight(std::size_t i) { return sights_[i - first_]; }

  // The surface through the point is taken to be square to the mean of its directions.
  void predict(Group& group) {
    const Eigen::Vector3d& point = block_.points.at(seen(group.begin).point).position_in_world;
    std::vector<Eigen::Vector3d> to_camera;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = group.begin; i < group.end; ++i) {
      to_camera.push_back((centre_of(pose_of(block_, seen(i).image)) - point).normalized());
      mean += to_camera.back();
    }
    const Eigen::Vector3d normal = mean.normalized(), across = normal.unitOrthogonal();
    Eigen::Matrix<double, 3, 2> surface;
    surface << across, normal.cross(across);
    group.reference = group.begin;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      if (to_camera[i - group.begin].dot(mean) > to_camera[group.reference - group.begin].dot(mean))
        group.reference = i;
      const Rigid3& pose = pose_of(block_, seen(i).image);
      Matrix23 by_point = Matrix23::Zero();
      (void)project(block_.camera_of(seen(i).image), pose * point, &by_point, nullptr);
      sight(i).warp = by_point * pose.rotation.toRotationMatrix() * surface;
    }
    const Eigen::Matrix2d surface_from_reference = sight(group.reference).warp.inverse();
    const double spacing_px = std::exp2(level_of(kSpacing * sight(group.reference).scale_px));
    for (std::size_t i = group.begin; i < group.end; ++i) {
      sight(i).warp *= surface_from_reference;
      sight(i).level = level_of(spacing_px * std::sqrt(std::abs(sight(i).warp.determinant())));
    }
    sight(group.reference).level = level_of(spacing_px);
  }

  // The level of the pyramid on which points so far apart are about a pixel apart.
  static int level_of(double spacing_px) {
    if (!(spacing_px > 1)) return 0;
    return static_cast<int>(std::min(std::floor(std::log2(spacing_px) + kLevelRounding), kLevels - 1.0));
  }

  // An image that cannot be read leaves its observations as they are.
  void cut(ImageId image, const std::vector<std::size_t>& observations) {
    const auto raster = images_(image);
    if (!raster) return;
    GreyImage level = *raster;
    for (int number = 0; number < kLevels; ++number) {
      if (number > 0) level = half(level);
      for (const std::size_t i : observations)
        if (sight(i).level == number) sight(i).patch = cut_patch(level, std::ldexp(1.0, number), seen(i).pixel);
    }
  }

  void match(const Group& group) {
    const Sight& of_reference = sight(group.reference);
    if (!of_reference.patch) return;
    const auto window = ReferenceWindow::of(*of_reference.patch, seen(group.reference).pixel);
    if (!window) return;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      if (i == group.reference || !sight(i).patch || !sight(i).warp.allFinite()) continue;
      const double farthest_px = std::max(1.0, sight(i).scale_px);
      const auto found = window->find(*sight(i).patch, {seen(i).pixel, sight(i).warp}, farthest_px);
      if (!found) continue;
      positions_[i] = found->placement.position_px;
      positions_[group.reference] = seen(group.reference).pixel;
    }
  }

  const Block& block_;
  const KeypointSource& keypoints_;
  const ImageSource& images_;
  const Run& run_;
  std::size_t first_ = 0;  // of the lot in work
  std::vector<Sight> sights_;
  std::vector<std::optional<Eigen::Vector2d>> positions_;
};

}  // namespace

Result<std::vector<std::optional<Eigen::Vector2d>>> remeasure(const Block& block, const KeypointSource& keypoints,
                                                              const ImageSource& images, const Run& run) {
  return Remeasurer(block, keypoints, images, run).all();
}

}  // namespace collinea
