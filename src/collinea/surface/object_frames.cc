// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/object_frames.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kVoxels = 64;           // along the extent of the points
constexpr std::size_t kLeastPoints = 5;  // of a voxel that has a normal
constexpr std::size_t kSeeds = 300;      // planes that are tried
constexpr double kSameNormal = 0.9063;   // cosine of 25 degrees
constexpr double kFrontal = 0.4226;      // of 65 degrees
constexpr double kLevel = 0.342;         // of 70 degrees: how far a wall's normal may be from level
constexpr double kNearlyUp = 0.9397;     // of 20 degrees
constexpr double kOutside = 0.005;       // of the points, on each side of an extent
constexpr double kWider = 0.01;          // than what the points extend over

// Sums of points, from which the plane through them follows without going through them again.
struct Moments {
  double count = 0;
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();

  void add(const Vector3d& p) {
    count += 1;
    sum += p;
    squares += p * p.transpose();
  }
  void add(const Moments& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
  [[nodiscard]] Vector3d middle() const { return sum / count; }
  [[nodiscard]] Matrix3d covariance() const { return squares / count - middle() * middle().transpose(); }
};

struct Plane {
  Vector3d middle = Vector3d::Zero(), normal = Vector3d::UnitZ();
  double rms_m = 0, width_m = 0;  // width: the smaller of the two extents in the plane, as a standard deviation

  explicit Plane(const Moments& moments) : middle(moments.middle()) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(moments.covariance());
    normal = axes.eigenvectors().col(0);
    rms_m = std::sqrt(std::max(0.0, axes.eigenvalues()[0]));
    width_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  }
  [[nodiscard]] double distance(const Vector3d& p) const { return std::abs(normal.dot(p - middle)); }
};

using Cell = std::array<int, 3>;

struct Voxel {
  Cell cell{};
  Moments moments;
  std::optional<Vector3d> normal;  // where its points lie in a plane
  bool taken = false;
};

// What most points extend over.
std::pair<Vector3d, Vector3d> bounds_of_most(std::span<const Vector3d> points, double outside) {
  Vector3d low, high;
  std::vector<double> along(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) along[i] = points[i][axis];
    low[axis] = quantile(along, outside);
    high[axis] = quantile(along, 1 - outside);
  }
  return {low, high};
}

class PlaneSearch {
 public:
  PlaneSearch(std::span<const Vector3d> points, const FrameSearch& search) : points_(points), search_(search) {
    const auto [low, high] = bounds_of_most(points, 0.05);
    origin_ = low;
    side_m_ = std::max((high - low).maxCoeff() / kVoxels, 2 * search.tolerance_m);
    gather();
  }

  // A plane, from the origin of the search, and the voxels that lie on it.
  struct Found {
    Plane plane;
    std::vector<std::size_t> voxels;
    double area_m2;
  };
  // The largest one; nothing when no voxel has a normal any more, or the run was stopped.
  std::optional<Found> next(const Run& run) {
    std::vector<std::size_t> seeds;
    for (std::size_t i = 0; i < voxels_.size(); ++i)
      if (!voxels_[i].taken && voxels_[i].normal) seeds.push_back(i);
    const std::size_t step = 1 + seeds.size() / kSeeds;
    std::vector<double> areas((seeds.size() + step - 1) / step);
    parallel_for(run, areas.size(), [&](std::size_t i) {
      if (const auto found = grown(seeds[i * step])) areas[i] = found->area_m2;
    });
    const auto largest = std::ranges::max_element(areas);
    if (run.stopped() || largest == areas.end() || *largest == 0) return std::nullopt;
    auto best = grown(seeds[std::size_t(largest - areas.begin()) * step]);
    for (const std::size_t voxel : best->voxels) voxels_[voxel].taken = true;
    return best;
  }

  [[nodiscard]] Vector3d middle_in_world(const Found& found) const { return found.plane.middle + origin_; }

  // The points of a plane that was found, in the world.
  [[nodiscard]] std::vector<Vector3d> points_of(const Found& found) const {
    std::vector<char> is_of(voxels_.size());
    for (const std::size_t voxel : found.voxels) is_of[voxel] = 1;
    std::vector<Vector3d> all;
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (voxel_of_[i] >= 0 && is_of[std::size_t(voxel_of_[i])] &&
          found.plane.distance(points_[i] - origin_) <= search_.tolerance_m)
        all.push_back(points_[i]);
    return all;
  }

 private:
  void gather() {
    std::map<Cell, std::size_t> number;  // sorted: the same for any order of the points
    voxel_of_.assign(points_.size(), -1);
    const auto cell_of = [&](const Vector3d& p) {
      const Vector3d at = (p - origin_) / side_m_;
      return Cell{int(std::floor(at.x())), int(std::floor(at.y())), int(std::floor(at.z()))};
    };
    const auto is_near = [&](const Vector3d& p) {
      return ((p - origin_) / side_m_).cwiseAbs().maxCoeff() < 8 * kVoxels;
    };
    for (const Vector3d& p : points_)
      if (is_near(p)) number.emplace(cell_of(p), 0);
    for (auto& [cell, index] : number) {
      index = voxels_.size();
      voxels_.push_back({.cell = cell});
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!is_near(points_[i])) continue;
      const std::size_t voxel = number.at(cell_of(points_[i]));
      voxel_of_[i] = std::int32_t(voxel);
      voxels_[voxel].moments.add(points_[i] - origin_);
    }
    for (Voxel& voxel : voxels_) {
      if (std::size_t(voxel.moments.count) < kLeastPoints) continue;
      const Plane plane(voxel.moments);
      if (plane.rms_m <= search_.tolerance_m && 2 * plane.rms_m < plane.width_m) voxel.normal = plane.normal;
    }
    find_neighbours(number);
  }

  void find_neighbours(const std::map<Cell, std::size_t>& number) {
    neighbours_.resize(voxels_.size());
    for (std::size_t i = 0; i < voxels_.size(); ++i)
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) {
            const Cell& at = voxels_[i].cell;
            const auto found = number.find({at[0] + x, at[1] + y, at[2] + z});
            if (found != number.end() && found->second != i) neighbours_[i].push_back(std::uint32_t(found->second));
          }
  }

  // From a voxel outwards: the nearer to the end, the less voxels may lie off.
  [[nodiscard]] std::optional<Found> grown(std::size_t seed) const {
    Plane plane(voxels_[seed].moments);
    std::vector<std::size_t> on_it;
    for (const double off_per_m : {0.05, 0.02, 0.0, 0.0}) {
      Moments all;
      on_it.clear();
      for (std::size_t i = 0; i < voxels_.size(); ++i) {
        const Voxel& voxel = voxels_[i];
        if (voxel.taken) continue;
        const Vector3d middle = voxel.moments.middle();
        if (plane.distance(middle) > search_.tolerance_m + off_per_m * (middle - plane.middle).norm()) continue;
        if (voxel.normal && std::abs(voxel.normal->dot(plane.normal)) < kSameNormal) continue;
        on_it.push_back(i);
        all.add(voxel.moments);
      }
      if (on_it.size() < 3) return std::nullopt;
      plane = Plane(all);
    }
    on_it = largest_piece(on_it);
    Moments all;
    for (const std::size_t i : on_it) all.add(voxels_[i].moments);
    plane = Plane(all);
    return Found{plane, on_it, double(cells_on(plane, on_it)) * side_m_ * side_m_};
  }

  [[nodiscard]] std::vector<std::size_t> largest_piece(const std::vector<std::size_t>& voxels) const {
    std::vector<int> piece(voxels_.size(), -1);
    for (const std::size_t i : voxels) piece[i] = 0;
    std::vector<std::size_t> largest;
    int pieces = 0;
    for (const std::size_t first : voxels) {
      if (piece[first] != 0) continue;
      std::vector<std::size_t> one = {first};
      piece[first] = ++pieces;
      for (std::size_t k = 0; k < one.size(); ++k)
        for (const std::uint32_t next : neighbours_[one[k]]) {
          if (piece[next] != 0) continue;
          piece[next] = pieces;
          one.push_back(next);
        }
      if (one.size() > largest.size()) largest = std::move(one);
    }
    std::ranges::sort(largest);
    return largest;
  }

  // Squares of the plane, as large as a voxel's side, in which voxels lie.
  [[nodiscard]] std::size_t cells_on(const Plane& plane, const std::vector<std::size_t>& voxels) const {
    const FramedPlane frame = framed_plane(plane.middle, plane.normal);
    std::vector<std::pair<int, int>> cells;
    for (const std::size_t i : voxels) {
      const Vector3d at = frame.in_plane(voxels_[i].moments.middle()) / side_m_;
      cells.emplace_back(int(std::floor(at.x())), int(std::floor(at.y())));
    }
    std::ranges::sort(cells);
    return std::size_t(std::ranges::unique(cells).begin() - cells.begin());
  }

  std::span<const Vector3d> points_;
  const FrameSearch& search_;
  Vector3d origin_ = Vector3d::Zero();  // of moments and planes: near the points, so that squares keep their digits
  double side_m_ = 0;
  std::vector<Voxel> voxels_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  // of each voxel: those that touch it
  std::vector<std::int32_t> voxel_of_;                  // of each point; -1: far from most
};

struct Seen {
  double front = 0, back = 0;  // how large points of the plane are in an image, from either side
  std::size_t frontal = 0;     // of those from the front, within 65 degrees of the normal
};

Seen seen_by(const Block& block, const OrientedImage& image, std::span<const Vector3d> points, const Vector3d& normal) {
  Seen seen;
  const Camera& camera = block.camera_of(image.image);
  const Vector3d centre = centre_of(image.cam_from_world);
  for (const Vector3d& p : points) {
    const auto pixel = project(camera, image.cam_from_world * p);
    if (!pixel || !inside(camera, *pixel)) continue;
    const double distance = (centre - p).norm(), cosine = normal.dot(centre - p) / distance;
    (cosine > 0 ? seen.front : seen.back) += std::abs(cosine) / (distance * distance);
    seen.frontal += cosine > kFrontal;
  }
  return seen;
}

// Windows of a wall, its cornices: planes that face as a larger one does and stand within its depth.
bool is_shown_by(const ObjectFrame& larger, std::span<const Vector3d> points, const ObjectFrame& frame) {
  constexpr double kMost = 0.8;  // of the points
  if (larger.plane.world_from_plane.col(2).dot(frame.plane.world_from_plane.col(2)) < kNearlyUp) return false;
  const auto inside =
      std::ranges::count_if(points, [&](const Vector3d& p) { return larger.holds(larger.plane.in_plane(p)); });
  return double(inside) >= kMost * double(points.size());
}

}  // namespace

double frame_tolerance_m(std::span<const Vector3d> points, std::span<const double> sigmas_m) {
  if (points.size() < 3) return 0;
  const auto [low, high] = bounds_of_most(points, 0.05);
  const double by_extent = (high - low).maxCoeff() / 200;
  return sigmas_m.empty() ? by_extent
                          : std::max(by_extent, 3 * median(std::vector<double>(sigmas_m.begin(), sigmas_m.end())));
}

Vector3d up_in_world(const Block& block) {
  if (block.georeference) return Vector3d::UnitZ();
  Vector3d up = Vector3d::Zero();
  for (const auto& [image, pose] : oriented_images(block)) up -= pose.rotation.conjugate() * Vector3d::UnitY();
  return up.norm() > 0 ? up.normalized() : Vector3d::UnitZ();
}

Vector3d up_by_walls(const Block& block, std::span<const ObjectFrame> frames) {
  const Vector3d up = up_in_world(block);
  if (block.georeference) return up;
  // The direction that is most across all walls; a weak wish to stay decides where walls do not.
  constexpr double kStay = 1e-3;
  Matrix3d moments = Matrix3d::Zero();
  double area = 0;
  for (const ObjectFrame& frame : frames) {
    const Vector3d normal = frame.plane.world_from_plane.col(2);
    if (std::abs(normal.dot(up)) > kLevel) continue;
    moments += frame.area_m2 * normal * normal.transpose();
    area += frame.area_m2;
  }
  if (area == 0) return up;
  moments += kStay * area * (Matrix3d::Identity() - up * up.transpose());
  const Vector3d found = Eigen::SelfAdjointEigenSolver<Matrix3d>(moments).eigenvectors().col(0);
  return found.dot(up) < 0 ? Vector3d(-found) : found;
}

double default_depth_m(const ObjectFrame& frame, double tolerance_m) {
  return std::max(5 * tolerance_m, 0.15 * frame.extent_m.minCoeff());
}

namespace {

// The part of a plane that holds points.
ObjectFrame bounded_frame(std::span<const Vector3d> points, const Vector3d& middle, const Vector3d& normal,
                          const Vector3d& up) {
  ObjectFrame frame{.plane = framed_plane(middle, normal, up), .points = points.size()};
  if (points.empty()) return frame;
  std::vector<Vector3d> in_plane;
  double squares = 0;
  for (const Vector3d& p : points) {
    in_plane.push_back(frame.plane.in_plane(p));
    squares += std::pow(in_plane.back().z(), 2);
  }
  frame.rms_m = std::sqrt(squares / double(points.size()));
  const auto [low, high] = bounds_of_most(in_plane, kOutside);
  const Vector2d wider = kWider * (high - low).head<2>();
  frame.plane.origin_in_world += frame.plane.world_from_plane.leftCols<2>() * (low.head<2>() - wider);
  frame.extent_m = (high - low).head<2>() + 2 * wider;
  return frame;
}

// Points all over a frame.
std::vector<Vector3d> lattice_on(const ObjectFrame& frame) {
  constexpr int kAlong = 12;
  std::vector<Vector3d> points;
  for (int i = 0; i < kAlong; ++i)
    for (int k = 0; k < kAlong; ++k) {
      const Vector2d at = Vector2d(i + 0.5, k + 0.5).cwiseProduct(frame.extent_m) / kAlong;
      points.push_back(frame.plane.origin_in_world + frame.plane.world_from_plane.leftCols<2>() * at);
    }
  return points;
}

}  // namespace

ObjectFrame frame_of_plane(const Block& block, std::span<const Vector3d> points, const Vector3d& middle,
                           const Vector3d& normal_in_world, const Vector3d& up) {
  const std::vector<OrientedImage> images = oriented_images(block);
  const Vector3d normal = normal_in_world.normalized();
  ObjectFrame frame = bounded_frame(points, middle, normal, up);
  const std::vector<Vector3d> shown = lattice_on(frame);
  double from_front = 0;
  for (const OrientedImage& image : images) {
    const Seen seen = seen_by(block, image, shown, normal);
    from_front += seen.front - seen.back;
  }
  if (from_front < 0) frame = bounded_frame(points, middle, -normal, up);
  const Vector3d front = frame.plane.world_from_plane.col(2);
  for (const OrientedImage& image : images)
    if (seen_by(block, image, shown, front).frontal > 0) frame.images.push_back(image.image);
  if (frame.images.size() < 2) frame.images.clear();
  return frame;
}

Result<std::vector<ObjectFrame>> find_object_frames(const Block& block, std::span<const Vector3d> points,
                                                    const FrameSearch& search, const Run& run) {
  std::vector<ObjectFrame> frames;
  if (points.size() < 3 || !(search.tolerance_m > 0)) return frames;
  constexpr std::size_t kMostTried = 40;
  const Vector3d up = up_in_world(block);
  PlaneSearch planes(points, search);
  std::vector<PlaneSearch::Found> found;  // of the frames
  for (std::size_t tried = 0; tried < kMostTried && frames.size() < search.most; ++tried) {
    run.report("frames: planes", double(tried) / kMostTried);
    auto next = planes.next(run);
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    if (!next || (!frames.empty() && next->area_m2 < search.least_part * frames.front().area_m2)) break;
    if (std::abs(next->plane.normal.dot(up)) > kNearlyUp) continue;
    const std::vector<Vector3d> its = planes.points_of(*next);
    ObjectFrame frame = frame_of_plane(block, its, planes.middle_in_world(*next), next->plane.normal, up);
    if (frame.images.empty()) continue;
    if (std::ranges::any_of(frames, [&](const ObjectFrame& larger) { return is_shown_by(larger, its, frame); }))
      continue;
    frame.area_m2 = next->area_m2;
    frame.depth_m = default_depth_m(frame, search.tolerance_m);
    frames.push_back(std::move(frame));
    found.push_back(*std::move(next));
  }
  const Vector3d better_up = up_by_walls(block, frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double area_m2 = frames[i].area_m2;
    frames[i] = frame_of_plane(block, planes.points_of(found[i]), planes.middle_in_world(found[i]),
                               found[i].plane.normal, better_up);
    frames[i].area_m2 = area_m2;
    frames[i].name = "plane" + std::to_string(i + 1);
    frames[i].depth_m = default_depth_m(frames[i], search.tolerance_m);
  }
  return frames;
}

Block block_in_frame(const Block& block, const ObjectFrame& frame) {
  Block in_frame;
  in_frame.cameras = block.cameras;
  in_frame.images = block.images;
  const Rigid3 world_from_frame{Eigen::Quaterniond(frame.plane.world_from_plane), frame.plane.origin_in_world};
  for (const ImageId image : frame.images) set_pose(in_frame, image, pose_of(block, image) * world_from_frame);
  return in_frame;
}

std::string frame_wkt(const ObjectFrame& frame, bool is_metric) {
  return "LOCAL_CS[\"" + frame.name + "\",UNIT[\"" + (is_metric ? "metre" : "unknown") +
         R"(",1],AXIS["x",EAST],AXIS["y",NORTH]])";
}

}  // namespace collinea
