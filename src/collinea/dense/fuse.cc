// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/fuse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/base/units.h"
#include "collinea/dense/internal/depth_cache.h"
#include "collinea/dense/internal/pinhole.h"
#include "collinea/dense/working_images.h"

namespace collinea {
namespace {

constexpr int kStripRows = 32;
constexpr std::size_t kStripsAtOnce = 4;  // for each thread: their points and marks are in memory together
constexpr std::size_t kMostNeighbours = 20;
constexpr double kFramePx = 6;            // at the border of an image little is measured
constexpr double kSharedSource = 8;       // in so many maps depths of one point have as much in common as of their own
constexpr double kSamePositionPx = 0.63;  // smaller: points are written twice; larger: gaps where one image takes over
constexpr double kRoughReach = 2;         // sigmas, where these are larger than max_reprojection_px: rough surfaces
constexpr double kSmallestCosine = 0.1;   // between ray and normal, to move a depth along the surface

using dense::Pinhole;
using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

struct Other {
  ImageId image;
  std::shared_ptr<const DepthMap> map;
  Pinhole pinhole;
  Matrix3 rotation;  // other_cam_from_reference_cam
  Vector3 translation;
};

// A pixel of the `other`-th neighbour that shows a point written for the reference.
struct Mark {
  std::uint32_t other, pixel;
};

// What the depth maps say of a point, the one it is written for included. Counts of maps, and sums of 1 / sigma^2.
struct Votes {
  int in_view = 1, looking = 1;    // that have it on their image; of these, those that are not far aside
  int agreeing = 1, measured = 1;  // the second: of these, those that know it to a part of a pixel
  int looking_through = 0;
  double agreed = 0, against = 0;  // of those that agree, and of those that look through

  // What is only known from coarse images comes from one and the same vote of overviews, whichever map tells it:
  // there every image that could have measured it counts, and a few precise depths behind it outweigh many such.
  [[nodiscard]] bool confirmed(int min_images) const {
    const bool enough =
        measured >= std::clamp(looking, 2, min_images) || agreeing >= std::clamp(in_view, 2, min_images);
    return enough && looking_through < agreeing && against <= agreed;
  }
};

// Mean of depths, weighted by 1 / sigma^2. They come from the same images: beside what each errs by itself there is
// what it shares with each other one, also when that looks too much aside to be averaged. As many count as would,
// equally sure, say as much: those of next to no weight add no certainty.
struct Mean {
  double weights = 0, squares = 0, sum = 0;

  void add(double depth, double weight) {
    weights += weight;
    squares += weight * weight;
    sum += weight * depth;
  }
  [[nodiscard]] double value() const { return sum / weights; }
  [[nodiscard]] double sigma() const {
    const double n = std::max(weights * weights / squares, 2.0), mean_variance = weights / squares;
    return std::sqrt((1 + kSharedSource / n) / n * mean_variance);
  }
};

struct Strip {
  std::vector<FusedPoint> points;
  std::vector<Mark> marks;
  std::int64_t measured = 0, confirmed = 0;
};

// The image whose points are being written, strip by strip.
struct Written {
  ImageId image;
  ColourImage colours;  // read when the first of its points is there
  std::int64_t measured = 0, confirmed = 0;
};

// The depth a map has at a continuous position: interpolated where the four pixels belong together, else the nearest.
struct Reading {
  double depth, sigma;
};

std::optional<Reading> reading_at(const DepthMap& map, double u, double v) {
  const int x = std::min(int(u), map.depth.width - 1), y = std::min(int(v), map.depth.height - 1);
  const float nearest = map.depth.at(x, y), sigma = map.sigma.at(x, y);
  if (std::isnan(nearest)) return std::nullopt;
  // in the outermost half pixel the same line goes on
  const int x0 = std::clamp(int(std::floor(u - 0.5)), 0, map.depth.width - 2);
  const int y0 = std::clamp(int(std::floor(v - 0.5)), 0, map.depth.height - 2);
  const float* upper = map.depth.row(y0) + x0;
  const float* lower = map.depth.row(y0 + 1) + x0;
  for (const float z : {upper[0], upper[1], lower[0], lower[1]})
    if (!(std::abs(z - nearest) <= 6 * sigma)) return Reading{nearest, sigma};
  const double a = u - 0.5 - x0, b = v - 0.5 - y0;
  const double depth = (1 - b) * ((1 - a) * double(upper[0]) + a * double(upper[1])) +
                       b * ((1 - a) * double(lower[0]) + a * double(lower[1]));
  return Reading{depth, sigma};
}

// The normal of the surface at a pixel, in the camera frame, towards the camera: a plane n X = 1 has the inverse depth
// n ray, so n follows from the inverse depth and its slopes (over the two neighbours on either side that are there).
std::optional<Vector3> normal_at(const DepthMap& map, const Pinhole& pinhole, int x, int y) {
  const FloatImage& depth = map.depth;
  const double middle = 1.0 / double(depth.at(x, y)), reach = 10 * double(map.sigma.at(x, y)) * middle * middle;
  const auto slope = [&](int dx, int dy) -> std::optional<double> {
    double products = 0, squares = 0;
    for (int k = -2; k <= 2; ++k) {
      const int i = x + k * dx, j = y + k * dy;
      if (k == 0 || i < 0 || j < 0 || i >= depth.width || j >= depth.height) continue;
      const double off = 1.0 / double(depth.at(i, j)) - middle;
      if (!(std::abs(off) <= reach * std::abs(k))) continue;
      products += k * off;
      squares += k * k;
    }
    return squares > 0 ? std::optional(products / squares) : std::nullopt;
  };
  const auto by_x = slope(1, 0), by_y = slope(0, 1);
  if (!by_x || !by_y) return std::nullopt;
  const Vector3 plane(pinhole.f * *by_x, pinhole.f * *by_y,
                      middle - (x + 0.5 - pinhole.cx) * *by_x - (y + 0.5 - pinhole.cy) * *by_y);
  return -plane.normalized();
}

// Where memory was shortest: of so many maps that overlap one some fitted; all, with it, take `bytes`.
struct Lacking {
  std::size_t room = 0, maps = 0, bytes = 0;
};

class Fusion {
 public:
  Fusion(const Block& block, const TieView& ties, std::span<const ImageId> images, DepthStore& store,
         const ColourSource& colours, const PointSink& sink, const DenseOptions& options, const Run& run)
      : block_(block),
        ties_(ties),
        images_(images.begin(), images.end()),
        colours_(colours),
        sink_(sink),
        options_(options),
        run_(run),
        cache_(store, std::size_t(options.memory_mb * 1e6)) {}

  Result<FuseReport> all() {
    UnitList list{.stage = "fuse"};
    for (const ImageId image : images_) list.units.push_back(Unit::of(UnitKind::kImage, image));
    COLLINEA_TRY(run_units_one_by_one(run_, list, [&](const Unit& unit) { return one(unit.image()); }));
    if (lacking_.maps > 0) state_budget();
    return std::move(report_);
  }

 private:
  Result<> one(ImageId image) {
    COLLINEA_TRY(reference_, cache_.map(image));
    COLLINEA_TRY(read_others(image));
    const std::vector<bool>& used = used_of(image, *reference_);
    const int rows = reference_->depth.height;
    const auto strips = std::size_t((rows + kStripRows - 1) / kStripRows);
    const std::size_t at_once = kStripsAtOnce * std::size_t(std::max(1, run_.threads));
    const Rigid3 world_from_cam = inverse(pose_of(block_, image));
    Written written{image, {}};
    for (std::size_t first = 0; first < strips; first += at_once) {
      std::vector<Strip> made(std::min(at_once, strips - first));
      parallel_for(run_, made.size(), [&](std::size_t i) {
        const int begin = int(first + i) * kStripRows;
        for (int y = begin; y < std::min(begin + kStripRows, rows); ++y) row(y, used, world_from_cam, made[i]);
      });
      if (run_.stopped()) return fail(Errc::kCancelled, "fusion was stopped");
      mark(made);
      COLLINEA_TRY(colour(made, written));
      COLLINEA_TRY(hand_over(made, written));
    }
    used_.erase(image);
    done_.insert(image);
    report_.confirmed[image] = written.measured ? double(written.confirmed) / double(written.measured) : 0;
    return {};
  }

  // What other images need not write again.
  void mark(std::vector<Strip>& strips) {
    for (Strip& strip : strips) {
      for (const Mark& mark : strip.marks)
        if (!done_.count(others_[mark.other].image))
          used_of(others_[mark.other].image, *others_[mark.other].map)[mark.pixel] = true;
      std::vector<Mark>().swap(strip.marks);
    }
  }

  Result<> read_others(ImageId image) {
    others_.clear();
    const std::size_t bytes = 2 * sizeof(float) * reference_->depth.data.size();
    const std::size_t room = std::max(3, int(options_.memory_mb * 1e6 / double(bytes))) - 1;
    const Rigid3 reference_from_world = pose_of(block_, image);
    COLLINEA_TRY(auto overlapping, ties_.overlapping(image, int(block_.images.size())));
    std::erase_if(overlapping, [&](ImageId other) { return !images_.count(other); });
    if (overlapping.size() > kMostNeighbours) overlapping.resize(kMostNeighbours);
    if (overlapping.size() > room) {
      const std::size_t all = (overlapping.size() + 1) * bytes;
      if (all > lacking_.bytes) lacking_ = {room, overlapping.size(), all};
      overlapping.resize(room);
    }
    for (const ImageId other : overlapping) {
      if (run_.stopped()) return fail(Errc::kCancelled, "fusion was stopped");
      COLLINEA_TRY(const auto map, cache_.map(other));
      const Rigid3 other_from_reference = pose_of(block_, other) * inverse(reference_from_world);
      others_.push_back({other, map, Pinhole(map->camera), other_from_reference.rotation.toRotationMatrix(),
                         other_from_reference.translation});
    }
    return {};
  }

  void state_budget() const {
    run_.say("fuse: memory_mb = " + std::to_string(std::lround(options_.memory_mb)) + " holds " +
             std::to_string(lacking_.room) + " of the " + std::to_string(lacking_.maps) +
             " depth maps that overlap one; all of them take " +
             std::to_string(std::lround(std::ceil(double(lacking_.bytes) / 1e6))) + " MB");
  }

  std::vector<bool>& used_of(ImageId image, const DepthMap& map) {
    auto& used = used_[image];
    if (used.empty()) used.resize(map.depth.data.size());
    return used;
  }

  void row(int y, const std::vector<bool>& used, const Rigid3& world_from_cam, Strip& strip) const {
    const Pinhole pinhole(reference_->camera);
    const float* depth = reference_->depth.row(y);
    for (int x = 0; x < reference_->depth.width; ++x) {
      if (std::isnan(depth[x])) continue;
      ++strip.measured;
      if (used[std::size_t(y) * std::size_t(reference_->depth.width) + std::size_t(x)]) {
        ++strip.confirmed;
        continue;
      }
      if (const auto point = confirmed(x, y, pinhole, world_from_cam, strip.marks)) {
        ++strip.confirmed;
        strip.points.push_back(*point);
      }
    }
  }

  std::optional<FusedPoint> confirmed(int x, int y, const Pinhole& pinhole, const Rigid3& world_from_cam,
                                      std::vector<Mark>& marks) const {
    const double z = double(reference_->depth.at(x, y)), sigma = double(reference_->sigma.at(x, y));
    const Vector3 ray = pinhole.ray(x + 0.5, y + 0.5);
    const auto normal = normal_at(*reference_, pinhole, x, y);
    Mean mean;
    mean.add(z, 1 / (sigma * sigma));
    Votes votes;
    votes.agreed = mean.weights;
    const std::size_t first_mark = marks.size();
    for (std::size_t i = 0; i < others_.size(); ++i) {
      const Other& other = others_[i];
      const Vector3 there = other.rotation * (ray * z) + other.translation;
      if (!(there.z() > 0)) continue;
      const Eigen::Vector2d at = other.pinhole.project(there);
      const double u = at.x(), v = at.y();
      if (!(u >= 0 && v >= 0 && u < other.map->depth.width && v < other.map->depth.height)) continue;
      if (u > kFramePx && v > kFramePx && u < other.map->depth.width - kFramePx &&
          v < other.map->depth.height - kFramePx) {
        ++votes.in_view;
        votes.looking += angle_between(other, ray, z) < kWidestAngle_rad;  // farther aside they may see something else
      }
      const auto reading = reading_at(*other.map, u, v);
      if (!reading) continue;
      const double off = there.z() - reading->depth, weight = 1 / (reading->sigma * reading->sigma);
      const double tolerance = options_.max_sigmas * std::hypot(sigma, reading->sigma);
      const Vector3 back = other.rotation.transpose() * (other.pinhole.ray(u, v) * reading->depth - other.translation);
      const Eigen::Vector2d shift = pinhole.f * (back.head<2>() / back.z() - ray.head<2>());
      const double in_px = shift.norm() / std::max(std::abs(off), 1e-12);
      const double sigma_px = in_px * std::max(sigma, reading->sigma);
      if (std::abs(off) > tolerance ||
          !(shift.norm() <= std::max(options_.max_reprojection_px, kRoughReach * sigma_px))) {
        votes.looking_through += off < 0;
        if (off < 0) votes.against += weight;
        continue;
      }
      ++votes.agreeing;
      votes.measured += sigma_px <= options_.max_sigma_px;
      votes.agreed += weight;
      // A view that grazes the surface, or a wrong normal, says nothing of the depth on this ray.
      if (const double moved = depth_on_ray(back, ray, normal); std::abs(moved - z) <= tolerance)
        mean.add(moved, weight);
      mark_around(i, u, v, there.z(), 2 * tolerance, marks);
    }
    if (!votes.confirmed(options_.min_images)) {
      marks.resize(first_mark);
      return std::nullopt;
    }
    FusedPoint point;
    point.position_in_world = world_from_cam * (ray * mean.value());
    point.normal_in_world = (world_from_cam.rotation * normal.value_or(-ray.normalized())).cast<float>();
    point.sigma = float((votes.measured < 2 ? sigma : mean.sigma()) * ray.norm());
    point.images = std::uint8_t(std::min(votes.agreeing, 255));
    return point;
  }

  // Between the two rays to the point at depth z.
  static double angle_between(const Other& other, const Vector3& ray, double z) {
    const Vector3 from_other = ray * z + other.rotation.transpose() * other.translation;
    return std::atan2(ray.cross(from_other).norm(), ray.dot(from_other));
  }

  // Where the surface through `point` meets the ray.
  static double depth_on_ray(const Vector3& point, const Vector3& ray, const std::optional<Vector3>& normal) {
    if (!normal) return point.z();
    const double along = normal->dot(ray);
    return along < -kSmallestCosine * ray.norm() ? normal->dot(point) / along : point.z();
  }

  void mark_around(std::size_t other, double u, double v, double depth, double tolerance,
                   std::vector<Mark>& marks) const {
    const DepthMap& map = *others_[other].map;
    const int x0 = int(std::floor(u - 0.5)), y0 = int(std::floor(v - 0.5));
    for (int j = std::max(y0, 0); j <= std::min(y0 + 1, map.depth.height - 1); ++j)
      for (int i = std::max(x0, 0); i <= std::min(x0 + 1, map.depth.width - 1); ++i)
        if (std::hypot(i + 0.5 - u, j + 0.5 - v) <= kSamePositionPx &&
            std::abs(double(map.depth.at(i, j)) - depth) <= tolerance)
          marks.push_back({std::uint32_t(other), std::uint32_t(j * map.depth.width + i)});
  }

  Result<> colour(std::vector<Strip>& strips, Written& written) const {
    if (!colours_) return {};
    const bool any = std::any_of(strips.begin(), strips.end(), [](const Strip& s) { return !s.points.empty(); });
    if (!any) return {};
    const Camera& original = block_.camera_of(written.image);
    COLLINEA_TRY(const int shrink, working_shrink(original, options_));
    const Camera camera = shrunk(original, shrink);
    ColourImage& colours = written.colours;
    if (colours.empty()) {
      COLLINEA_TRY(colours, colours_(written.image, shrink));
    }
    if (colours.channels < 3 || colours.width != camera.width_px || colours.height != camera.height_px)
      return fail(Errc::kBadInput, block_.images.at(written.image).file + ": the colour image does not fit its camera");
    const Rigid3& cam_from_world = pose_of(block_, written.image);
    const RayBend& bend = block_.images.at(written.image).bend;
    parallel_for(run_, strips.size(), [&](std::size_t i) {
      for (FusedPoint& point : strips[i].points) {
        const auto pixel = project(camera, bend.bent(cam_from_world * point.position_in_world));
        if (!pixel) continue;
        for (int c = 0; c < 3; ++c)
          point.colour[std::size_t(c)] = std::uint8_t(bilinear(colours, pixel->x(), pixel->y(), c) + 0.5f);
      }
    });
    return {};
  }

  Result<> hand_over(const std::vector<Strip>& strips, Written& written) {
    for (const Strip& strip : strips) {
      written.measured += strip.measured;
      written.confirmed += strip.confirmed;
      report_.points += std::int64_t(strip.points.size());
      if (strip.points.empty()) continue;
      COLLINEA_TRY(sink_(strip.points));
    }
    return {};
  }

  const Block& block_;
  const TieView& ties_;
  std::set<ImageId> images_;
  const ColourSource& colours_;
  const PointSink& sink_;
  const DenseOptions& options_;
  const Run& run_;
  DepthCache cache_;
  std::map<ImageId, std::vector<bool>> used_;  // of images still to come
  std::set<ImageId> done_;
  std::shared_ptr<const DepthMap> reference_;
  std::vector<Other> others_;
  FuseReport report_;
  Lacking lacking_{};
};

}  // namespace

Result<FuseReport> fuse(const Block& block, const TieView& ties, std::span<const ImageId> images, DepthStore& store,
                        const ColourSource& colours, const PointSink& sink, const DenseOptions& options,
                        const Run& run) {
  COLLINEA_TRY(validate(options));
  for (const ImageId image : images)
    if (!is_oriented(block, image))
      return fail(Errc::kIllPosed, "image " + std::to_string(image.value) + " has a depth map but no orientation");
  return Fusion(block, ties, images, store, colours, sink, options, run).all();
}

}  // namespace collinea
