// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/remeasure.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
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
constexpr double kBendReach = 5;                    // points of the window: half of its weight lies within
constexpr std::size_t kObservationsAtOnce = 65536;  // 150 MB of patches
constexpr std::size_t kChunk = 64;                  // points handed to a thread at once

// One observation and how the reference's window will look there.
struct Sight {
  Eigen::Matrix2d warp = Eigen::Matrix2d::Identity();
  WindowBend bend;
  double scale_px = 0;  // of its feature
  int level = 0;
  std::optional<Patch> patch;
};

// Observations [begin, end) of one point.
struct Group {
  std::size_t begin, end, reference = 0;
};

// Two directions in the surface through a point.
using Tangents = Eigen::Matrix<double, 3, 2>;

class Remeasurer {
 public:
  Remeasurer(const Block& block, const KeypointSource& keypoints, const ImageSource& images, const Run& run)
      : block_(block), keypoints_(keypoints), images_(images), run_(run), positions_(block.observations.size()) {}

  Result<std::vector<std::optional<Remeasured>>> all() {
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
    const Eigen::Vector3d& point = point_of(group);
    std::vector<Eigen::Vector3d> to_camera;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = group.begin; i < group.end; ++i) {
      to_camera.push_back((centre_of(pose_of(block_, seen(i).image)) - point).normalized());
      mean += to_camera.back();
    }
    group.reference = group.begin;
    for (std::size_t i = group.begin; i < group.end; ++i)
      if (to_camera[i - group.begin].dot(mean) > to_camera[group.reference - group.begin].dot(mean))
        group.reference = i;
    const Eigen::Vector3d normal = mean.normalized(), across = normal.unitOrthogonal();
    Tangents surface;
    surface << across, normal.cross(across);
    const std::vector<Eigen::Matrix2d> warps = warps_of(group, surface);
    const double spacing_px = std::exp2(level_of(kSpacing * sight(group.reference).scale_px));
    for (std::size_t i = group.begin; i < group.end; ++i) {
      sight(i).warp = warps[i - group.begin];
      sight(i).level = level_of(spacing_px * std::sqrt(std::abs(sight(i).warp.determinant())));
    }
    sight(group.reference).level = level_of(spacing_px);
    bend(group, surface);
  }

  [[nodiscard]] const Eigen::Vector3d& point_of(const Group& group) const {
    return block_.points.at(seen(group.begin).point).position_in_world;
  }

  // From the reference into each image, of a plane surface with these tangents.
  [[nodiscard]] std::vector<Eigen::Matrix2d> warps_of(const Group& group, const Tangents& surface) const {
    std::vector<Eigen::Matrix2d> warps;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      const Rigid3& pose = pose_of(block_, seen(i).image);
      Matrix23 by_point = Matrix23::Zero();
      (void)project(block_.camera_of(seen(i).image), pose * point_of(group), &by_point, nullptr);
      warps.emplace_back(by_point * pose.rotation.toRotationMatrix() * surface);
    }
    const Eigen::Matrix2d surface_from_reference = warps[group.reference - group.begin].inverse();
    for (Eigen::Matrix2d& warp : warps) warp *= surface_from_reference;
    return warps;
  }

  // What the images show of that plane besides: second differences of how pixels of the reference, brought to it, are
  // seen there.
  void bend(const Group& group, const Tangents& surface) {
    const double reach_px = kBendReach * std::ldexp(1.0, sight(group.reference).level);
    const ImageId reference = seen(group.reference).image;
    const Camera& camera = block_.camera_of(reference);
    const Rigid3 pose = pose_of(block_, reference);
    const Eigen::Vector3d centre = centre_of(pose), normal = surface.col(0).cross(surface.col(1)),
                          to_point = point_of(group) - centre;
    const auto middle = project(camera, pose * point_of(group));
    if (!middle) return;
    std::array<Eigen::Vector3d, kAround.size()> on_surface;
    for (std::size_t k = 0; k < kAround.size(); ++k) {
      const Eigen::Vector3d ray =
          pose.rotation.conjugate() *
          ray_in_cam(camera, *middle + reach_px * Eigen::Vector2d(kAround[k][0], kAround[k][1]));
      on_surface[k] = centre + ray * (normal.dot(to_point) / normal.dot(ray));
      if (!(normal.dot(to_point) / normal.dot(ray) > 0)) return;
    }
    for (std::size_t i = group.begin; i < group.end; ++i)
      if (i != group.reference) sight(i).bend = bend_in(i, point_of(group), on_surface, reach_px);
  }

  // Points about a position, in reaches: along x, along y, along both diagonals.
  static constexpr std::array<std::array<int, 2>, 8> kAround = {
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

  [[nodiscard]] WindowBend bend_in(std::size_t i, const Eigen::Vector3d& point,
                                   const std::array<Eigen::Vector3d, kAround.size()>& on_surface,
                                   double reach_px) const {
    const Camera& camera = block_.camera_of(seen(i).image);
    const Rigid3 pose = pose_of(block_, seen(i).image);
    const auto middle = project(camera, pose * point);
    std::array<Eigen::Vector2d, kAround.size()> at;
    for (std::size_t k = 0; k < kAround.size(); ++k) {
      const auto pixel = project(camera, pose * on_surface[k]);
      if (!pixel || !middle) return {};
      at[k] = *pixel - *middle;
    }
    Eigen::Matrix<double, 2, 3> second;
    second << (at[0] + at[1]) / 2, (at[4] + at[5] - at[6] - at[7]) / 4, (at[2] + at[3]) / 2;
    Eigen::Matrix2d warp;
    warp << at[0] - at[1], at[2] - at[3];
    warp /= 2 * reach_px;
    const WindowBend out{warp.inverse() * second / (reach_px * reach_px)};
    return out.by_squares.allFinite() ? out : WindowBend{};
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
    std::vector<std::optional<LeastSquaresMatch>> found(group.end - group.begin);
    for (std::size_t i = group.begin; i < group.end; ++i) {
      if (i == group.reference || !sight(i).patch || !sight(i).warp.allFinite()) continue;
      const double farthest_px = std::max(1.0, sight(i).scale_px);
      found[i - group.begin] =
          window->find(*sight(i).patch, {seen(i).pixel, sight(i).warp}, farthest_px, sight(i).bend);
    }
    Eigen::Matrix2d by_reference = Eigen::Matrix2d::Zero();
    int others = 0;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      const auto& one = found[i - group.begin];
      const auto known = one ? window->covariance(*sight(i).patch, *one, sight(i).bend) : std::nullopt;
      if (!known) continue;
      positions_[i] = {one->placement.position_px, known->of_other_px2,
                       window->reach_px() * std::sqrt(std::abs(one->placement.warp.determinant()))};
      by_reference += known->of_reference_px2;
      ++others;
    }
    if (others > 0)
      positions_[group.reference] = {seen(group.reference).pixel, by_reference / others, window->reach_px(), true};
  }

  const Block& block_;
  const KeypointSource& keypoints_;
  const ImageSource& images_;
  const Run& run_;
  std::size_t first_ = 0;  // of the lot in work
  std::vector<Sight> sights_;
  std::vector<std::optional<Remeasured>> positions_;
};

// Pixels of an image that windows take, in squares of kCell pixels.
class TakenPixels {
 public:
  TakenPixels(int width_px, int height_px)
      : columns_(width_px / kCell + 1),
        rows_(height_px / kCell + 1),
        taken_(std::size_t(columns_) * std::size_t(rows_)) {}

  [[nodiscard]] bool is_free(const Remeasured& window) const {
    bool is_free = true;
    visit(window, [&](std::size_t cell) { is_free = is_free && !taken_[cell]; });
    return is_free;
  }
  void take(const Remeasured& window) {
    visit(window, [&](std::size_t cell) { taken_[cell] = true; });
  }

 private:
  static constexpr double kCell = 4;

  template <class Visit>
  void visit(const Remeasured& window, const Visit& visit_cell) const {
    const auto cells = [&](double middle_px, int end) {
      return std::pair(std::clamp(int((middle_px - window.reach_px) / kCell + 0.5), 0, end),
                       std::clamp(int((middle_px + window.reach_px) / kCell + 0.5), 0, end));
    };
    const auto [left, right] = cells(window.pixel.x(), columns_);
    const auto [top, bottom] = cells(window.pixel.y(), rows_);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) visit_cell(std::size_t(y) * std::size_t(columns_) + std::size_t(x));
  }

  int columns_, rows_;
  std::vector<bool> taken_;
};

}  // namespace

void keep_apart(const Block& block, std::vector<std::optional<Remeasured>>& positions) {
  struct Point {
    std::size_t begin, end;
    double largest_px = 0;
    int rays = 0;
  };
  std::vector<Point> points;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i == 0 || block.observations[i].point != block.observations[i - 1].point) points.push_back({i, i});
    points.back().end = i + 1;
    if (!positions[i]) continue;
    points.back().largest_px = std::max(points.back().largest_px, positions[i]->reach_px);
    ++points.back().rays;
  }
  // The smallest windows first, for they take the fewest pixels; of equal ones those in most images.
  const auto level = [](const Point& point) { return std::lround(std::log2(std::max(point.largest_px, 1.0))); };
  std::stable_sort(points.begin(), points.end(), [&](const Point& a, const Point& b) {
    return std::pair(level(a), -a.rays) < std::pair(level(b), -b.rays);
  });
  std::map<ImageId, TakenPixels> taken;
  for (const auto& [id, image] : block.images) {
    const Camera& camera = block.camera_of(id);
    taken.emplace(id, TakenPixels(camera.width_px, camera.height_px));
  }
  for (const Point& point : points) {
    bool is_free = true;
    for (std::size_t i = point.begin; i < point.end; ++i)
      is_free = is_free && (!positions[i] || taken.at(block.observations[i].image).is_free(*positions[i]));
    for (std::size_t i = point.begin; i < point.end; ++i)
      if (positions[i] && is_free)
        taken.at(block.observations[i].image).take(*positions[i]);
      else
        positions[i].reset();
  }
}

Result<std::vector<std::optional<Remeasured>>> remeasure(const Block& block, const KeypointSource& keypoints,
                                                         const ImageSource& images, const Run& run) {
  return Remeasurer(block, keypoints, images, run).all();
}

}  // namespace collinea
