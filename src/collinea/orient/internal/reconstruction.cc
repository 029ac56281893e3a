// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/reconstruction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/base/parallel.h"
#include "collinea/epipolar/intersect_rays.h"
#include "collinea/match/tracks.h"
#include "collinea/orient/internal/resection.h"

namespace collinea {
namespace {

constexpr double kAcceptFactor = 1.5;  // a new ray may be that much worse than one that stays: the pose is still young
constexpr std::size_t kLocalImages = 8;
constexpr double kGuessedFocal = 0.2;  // relative sigma from which a focal length is hardly known
constexpr int kNeedCells = 8,
              kNeededPerCell = 12;  // of an image's cells: up to 768 tracks an image and what others need
constexpr double kLeastSigma = 0.01, kMostSigma = 10;  // of the errors of tie points, over what the options say
constexpr std::size_t kChunk = 256;                    // tracks handed to a thread at once

// Spread of pixels over an image: occupied cells on grids of 2, 4, 8 and 16, finer grids counting more (COLMAP's
// idea).
class Spread {
 public:
  void add(const Eigen::Vector2d& pixel, const Camera& camera) {
    for (int level = 0; level < kLevels; ++level) {
      const int cells = 2 << level;
      const int column = std::clamp(static_cast<int>(pixel.x() / camera.width_px * cells), 0, cells - 1);
      const int row = std::clamp(static_cast<int>(pixel.y() / camera.height_px * cells), 0, cells - 1);
      bool& cell = occupied_[static_cast<std::size_t>(level)][static_cast<std::size_t>(row * cells + column)];
      if (!cell) score_ += cells;
      cell = true;
    }
  }
  [[nodiscard]] double score() const { return score_; }

 private:
  static constexpr int kLevels = 4;
  std::array<std::array<bool, 256>, kLevels> occupied_{};
  double score_ = 0;
};

double angle_at(const Eigen::Vector3d& point, const Eigen::Vector3d& centre_a, const Eigen::Vector3d& centre_b) {
  const Eigen::Vector3d a = (centre_a - point).normalized(), b = (centre_b - point).normalized();
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

int count_active(const Reconstruction::TrackState& track) {
  return static_cast<int>(
      std::count_if(track.rays.begin(), track.rays.end(), [](const Reconstruction::Ray& ray) { return ray.active; }));
}

// Share of the squared errors of a point's rays that is left after its three coordinates were fitted to them.
double share_left(const Reconstruction::TrackState& track) {
  const double rays = count_active(track);
  return (2 * rays - 3) / (2 * rays);
}

}  // namespace

Result<Reconstruction> Reconstruction::create(const Block& setup, std::span<const ImagePair> pairs,
                                              const KeypointSource& keypoints, const OrientOptions& options) {
  Reconstruction result;
  result.setup_ = setup;
  result.options_ = options;
  result.noise_.sigma_px = options.sigma_px;
  result.cameras_ = setup.cameras;
  for (const Track& track : merge_tracks(pairs)) {
    TrackState state;
    const auto number = static_cast<std::uint32_t>(result.tracks_.size());
    for (const auto& [image, feature] : track.features) {
      result.rays_of_[image].push_back({number, static_cast<std::uint32_t>(state.rays.size())});
      state.rays.push_back({image, feature, Eigen::Vector2d::Zero()});
    }
    result.tracks_.push_back(std::move(state));
  }
  for (const auto& [image, rays] : result.rays_of_) {  // the keypoints of one image at a time
    COLLINEA_TRY(const std::vector<Keypoint> found, keypoints(image));
    for (const RayRef& ref : rays) {
      Ray& ray = result.tracks_[ref.track].rays[ref.ray];
      const Keypoint& keypoint = found.at(ray.feature);
      ray.pixel = {keypoint.x, keypoint.y};
      ray.sigma_factor = sigma_factor(keypoint.scale_px);
    }
  }
  for (const auto& [image, rays] : result.rays_of_) result.images_.push_back(image);
  return result;
}

const std::vector<Reconstruction::RayRef>& Reconstruction::rays_of(ImageId image) const {
  static const std::vector<RayRef> none;
  const auto found = rays_of_.find(image);
  return found == rays_of_.end() ? none : found->second;
}

std::size_t Reconstruction::point_count() const {
  return static_cast<std::size_t>(
      std::count_if(tracks_.begin(), tracks_.end(), [](const TrackState& track) { return track.point.has_value(); }));
}

Reconstruction::RayCount Reconstruction::ray_count() const {
  RayCount count;
  for (const TrackState& track : tracks_) {
    std::size_t all = 0, active = 0;
    for (const Ray& ray : track.rays) {
      all += oriented(ray.image);
      active += ray.active;
    }
    if (all < 2) continue;
    count.all += all;
    count.active += active;
  }
  return count;
}

int Reconstruction::active_rays(ImageId image) const {
  const std::vector<RayRef>& rays = rays_of(image);
  return static_cast<int>(std::count_if(rays.begin(), rays.end(),
                                        [&](const RayRef& ref) { return tracks_[ref.track].rays[ref.ray].active; }));
}

std::optional<double> Reconstruction::error_px(const Ray& ray, const Eigen::Vector3d& point_in_world) const {
  const auto pixel = project(camera_of(ray.image), poses_.at(ray.image) * point_in_world);
  if (!pixel) return std::nullopt;
  return (*pixel - ray.pixel).norm();
}

void Reconstruction::sleep_surplus() {
  std::vector<std::uint32_t> longest_first(tracks_.size());
  for (std::uint32_t i = 0; i < longest_first.size(); ++i) longest_first[i] = i;
  std::stable_sort(longest_first.begin(), longest_first.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return tracks_[a].rays.size() > tracks_[b].rays.size(); });
  std::map<ImageId, std::array<int, kNeedCells * kNeedCells>> kept;
  for (const std::uint32_t number : longest_first) {
    TrackState& track = tracks_[number];
    std::vector<int*> cells;
    for (const Ray& ray : track.rays) {
      const Camera& camera = camera_of(ray.image);
      const int column = std::clamp(static_cast<int>(ray.pixel.x() / camera.width_px * kNeedCells), 0, kNeedCells - 1);
      const int row = std::clamp(static_cast<int>(ray.pixel.y() / camera.height_px * kNeedCells), 0, kNeedCells - 1);
      cells.push_back(&kept[ray.image][static_cast<std::size_t>(row * kNeedCells + column)]);
    }
    track.asleep = std::none_of(cells.begin(), cells.end(), [](const int* count) { return *count < kNeededPerCell; });
    if (!track.asleep)
      for (int* count : cells) ++*count;
  }
}

void Reconstruction::wake_all() {
  for (TrackState& track : tracks_) track.asleep = false;
}

int Reconstruction::start(ImageId first, ImageId second, const Rigid3& second_from_first) {
  poses_[first] = Rigid3{};
  poses_[second] = second_from_first;
  return extend(first);
}

Reconstruction::Coverage Reconstruction::coverage(ImageId image) const {
  Spread spread;
  int points = 0;
  for (const RayRef& ref : rays_of(image)) {
    const TrackState& track = tracks_[ref.track];
    if (!track.point) continue;
    ++points;
    spread.add(track.rays[ref.ray].pixel, camera_of(image));
  }
  return {spread.score(), points};
}

std::set<ImageId> Reconstruction::images_around(ImageId image) const {
  std::set<ImageId> neighbours;
  for (const RayRef& ref : rays_of(image)) {
    if (tracks_[ref.track].asleep) continue;
    for (const Ray& ray : tracks_[ref.track].rays) neighbours.insert(ray.image);
  }
  return neighbours;
}

bool Reconstruction::orient_image(ImageId image, std::uint64_t seed) {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points;
  std::vector<RayRef> refs;
  for (const RayRef& ref : rays_of(image)) {
    const TrackState& track = tracks_[ref.track];
    if (!track.point) continue;
    refs.push_back(ref);
    pixels.push_back(track.rays[ref.ray].pixel);
    points.push_back(*track.point);
  }
  const ResectOptions resect_options{.max_error_px = kAcceptFactor * options_.max_error_px,
                                     .min_inliers = options_.min_points};
  const CameraId camera_id = setup_.images.at(image).camera;
  const bool guessed = camera_of(image).prior.calibrate &&
                       camera_of(image).prior.sigma_f_px > kGuessedFocal * camera_of(image).focal_px() &&
                       !camera_in_use(camera_id);
  const auto found =
      (guessed ? resect_with_focal : resect)(camera_of(image), pixels, points, resect_options, seed + image.value);
  if (!found || found->inliers < options_.min_points || found->inliers < 0.2 * static_cast<double>(points.size()))
    return false;
  poses_[image] = found->cam_from_world;
  if (guessed) cameras_[camera_id] = found->camera;
  for (std::size_t i = 0; i < refs.size(); ++i) tracks_[refs[i].track].rays[refs[i].ray].active = found->inlier[i] != 0;
  return true;
}

bool Reconstruction::camera_in_use(CameraId camera) const {
  return std::any_of(poses_.begin(), poses_.end(),
                     [&](const auto& pose) { return setup_.images.at(pose.first).camera == camera; });
}

void Reconstruction::drop_image(ImageId image) {
  poses_.erase(image);
  const CameraId camera = setup_.images.at(image).camera;
  if (!camera_in_use(camera))
    cameras_.at(camera) = setup_.cameras.at(camera);  // its pose may have determined its focal length
  for (const RayRef& ref : rays_of(image)) {
    TrackState& track = tracks_[ref.track];
    track.rays[ref.ray].active = false;
    if (std::count_if(track.rays.begin(), track.rays.end(), [](const Ray& ray) { return ray.active; }) < 2) {
      track.point.reset();
      for (Ray& ray : track.rays) ray.active = false;
    }
  }
}

bool Reconstruction::intersect(TrackState& track) const {
  std::vector<std::size_t> used;
  std::vector<Rigid3> poses;
  std::vector<Eigen::Vector2d> directions;
  std::vector<double> focal_px;
  for (std::size_t i = 0; i < track.rays.size(); ++i) {
    const auto pose = poses_.find(track.rays[i].image);
    if (pose == poses_.end()) continue;
    const Camera& camera = camera_of(track.rays[i].image);
    used.push_back(i);
    poses.push_back(pose->second);
    directions.push_back(normalized(camera, track.rays[i].pixel));
    focal_px.push_back(pixels_per_unit(camera, directions.back()));
  }
  if (used.size() < 2) return false;
  const auto found = robust_intersect(poses, directions, focal_px, kAcceptFactor * options_.max_error_px,
                                      options_.min_angle_deg * std::numbers::pi / 180);
  if (!found) return false;
  track.point = found->point_in_world;
  for (std::size_t i = 0; i < used.size(); ++i) track.rays[used[i]].active = found->inlier[i] != 0;
  return true;
}

bool Reconstruction::extend_track(TrackState& track) const {
  if (track.asleep || chosen_) return false;
  if (!track.point) return intersect(track);
  bool changed = false;
  for (Ray& ray : track.rays) {
    if (ray.active || !poses_.contains(ray.image)) continue;
    const auto error = error_px(ray, *track.point);
    if (error && *error < options_.max_error_px) ray.active = changed = true;
  }
  return changed;
}

int Reconstruction::extend(ImageId image) {
  int changed = 0;
  for (const RayRef& ref : rays_of(image)) changed += extend_track(tracks_[ref.track]);
  return changed;
}

int Reconstruction::extend_all(const Run& run) {
  const std::size_t chunks = (tracks_.size() + kChunk - 1) / kChunk;
  std::vector<int> changed(chunks, 0);
  parallel_for(run, chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(tracks_.size(), (chunk + 1) * kChunk); ++i)
      changed[chunk] += extend_track(tracks_[i]);
  });
  int total = 0;
  for (const int count : changed) total += count;
  return total;
}

int Reconstruction::filter(double max_error_px, const Run& run) {
  return filter([&](const Ray& /*ray*/, double /*share*/) { return max_error_px; }, run);
}

int Reconstruction::filter(const Limit& limit_px, const Run& run) {
  const double min_angle_rad = options_.min_angle_deg * std::numbers::pi / 180;
  std::map<ImageId, Eigen::Vector3d> centres;
  for (const auto& [image, pose] : poses_) centres[image] = centre_of(pose);
  const std::size_t chunks = (tracks_.size() + kChunk - 1) / kChunk;
  std::vector<int> removed(chunks, 0);
  const auto filter_track = [&](TrackState& track) {
    int inactive = 0, left = 0;
    const double share = share_left(track);
    for (Ray& ray : track.rays) {
      if (!ray.active) continue;
      const auto error = error_px(ray, *track.point);
      ray.active = error && *error <= limit_px(ray, share);
      ++(ray.active ? left : inactive);
    }
    bool wide = false;
    for (std::size_t i = 0; i < track.rays.size() && !wide; ++i)
      for (std::size_t j = 0; j < i && !wide; ++j)
        wide =
            track.rays[i].active && track.rays[j].active &&
            angle_at(*track.point, centres.at(track.rays[i].image), centres.at(track.rays[j].image)) >= min_angle_rad;
    if (wide) return inactive;
    track.point.reset();
    for (Ray& ray : track.rays) ray.active = false;
    return inactive + left;
  };
  parallel_for(run, chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(tracks_.size(), (chunk + 1) * kChunk); ++i)
      if (tracks_[i].point) removed[chunk] += filter_track(tracks_[i]);
  });
  int total = 0;
  for (const int count : removed) total += count;
  return total;
}

void Reconstruction::set_noise(const TieNoise& noise) {
  noise_ = noise;
  noise_.sigma_px = std::clamp(noise.sigma_px, kLeastSigma * options_.sigma_px, kMostSigma * options_.sigma_px);
  noise_.gross_sigmas *= noise.sigma_px / noise_.sigma_px;  // the same error in pixels
}

std::optional<TieNoise> Reconstruction::shown_noise() const {
  std::vector<double> squared_px2, squared_anew;
  for (const TrackState& track : tracks_) {
    if (!track.point || count_active(track) < 3) continue;
    for (const Ray& ray : track.rays)
      if (const auto error = ray.active ? error_px(ray, *track.point) : std::nullopt) {
        const bool is_anew = ray.anew_sigma_px > 0;
        (is_anew ? squared_anew : squared_px2)
            .push_back(std::pow(*error / (is_anew ? ray.anew_sigma_px : ray.sigma_factor), 2) / share_left(track));
      }
  }
  auto shown = fit_noise(squared_px2);
  const auto anew = fit_noise(squared_anew);
  if (!anew) return shown;
  // Both have one loss in the adjustment: that of most rays.
  if (!shown || squared_anew.size() > squared_px2.size()) {
    TieNoise both = *anew;
    both.sigma_px = shown ? shown->sigma_px : noise_.sigma_px;
    both.gross_sigmas = shown ? shown->gross_sigmas : noise_.gross_sigmas;
    shown = both;
  }
  shown->anew_factor = anew->sigma_px;
  shown->anew_gross_sigmas = anew->gross_sigmas;
  return shown;
}

std::optional<int> Reconstruction::leave_out_gross(const Run& run) {
  if (std::isinf(noise_.gross_sigmas) && std::isinf(noise_.anew_gross_sigmas)) return std::nullopt;
  chosen_ = true;
  noise_.loss = Loss::kNone;
  return filter(
      [&](const Ray& ray, double share) {
        const double gross_sigmas = ray.anew_sigma_px > 0 ? noise_.anew_gross_sigmas : noise_.gross_sigmas;
        return gross_sigmas * sigma_px(ray) * std::sqrt(share);
      },
      run);
}

std::vector<ImageId> Reconstruction::neighbours_of(ImageId image, std::size_t count) const {
  std::map<ImageId, int> shared;
  for (const RayRef& ref : rays_of(image)) {
    const TrackState& track = tracks_[ref.track];
    if (!track.point || !track.rays[ref.ray].active) continue;
    for (const Ray& ray : track.rays)
      if (ray.active && ray.image != image) ++shared[ray.image];
  }
  std::vector<std::pair<int, ImageId>> sorted;
  for (const auto& [other, points] : shared) sorted.push_back({points, other});
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<ImageId> closest;
  for (std::size_t i = 0; i < std::min(count, sorted.size()); ++i) closest.push_back(sorted[i].second);
  return closest;
}

// The points of these tracks with all their active rays, no images.
Block Reconstruction::block_of(const std::vector<std::uint32_t>& numbers) const {
  Block block;
  block.georeference = setup_.georeference;
  block.cameras = cameras_;
  for (const std::uint32_t number : numbers) {
    const TrackState& track = tracks_[number];
    const PointId point{number};
    block.points.emplace_hint(block.points.end(), point, TiePoint{*track.point, {}});
    for (const Ray& ray : track.rays)
      if (ray.active) block.observations.push_back({ray.image, point, ray.feature, ray.pixel, sigma_px(ray)});
  }
  return block;
}

// The points seen by `images`, and the images that see them.
Block Reconstruction::block_around(const std::set<ImageId>& images) const {
  std::vector<std::uint32_t> numbers;
  for (const ImageId image : images)
    for (const RayRef& ref : rays_of(image))
      if (tracks_[ref.track].point && tracks_[ref.track].rays[ref.ray].active) numbers.push_back(ref.track);
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  Block block = block_of(numbers);
  std::vector<ImageId> seen;
  for (const Observation& observation : block.observations) seen.push_back(observation.image);
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const ImageId image : seen) {
    block.images[image] = setup_.images.at(image);
    set_pose(block, image, poses_.at(image));
  }
  return block;
}

Result<> Reconstruction::adjust_around(ImageId centre, const AdjustOptions& options, const Run& run) {
  std::set<ImageId> moving{centre};
  for (const ImageId neighbour : neighbours_of(centre, kLocalImages)) moving.insert(neighbour);
  if (moving.size() >= poses_.size()) moving = {centre};  // a young block: something must hold the gauge
  const Block local = block_around(moving);
  AdjustScope scope;
  scope.use_positions = scope.use_control = scope.use_geodetic = false;
  scope.free_images = moving;
  COLLINEA_TRY(const Adjusted adjusted, adjust(local, scope, options, run));
  for (const ImageId image : moving)
    if (adjusted.cam_from_world.contains(image)) poses_[image] = adjusted.cam_from_world.at(image);
  for (const auto& [point, position] : adjusted.points) tracks_[point.value].point = position;
  return {};
}

Result<Adjusted> Reconstruction::adjust_all(const AdjustOptions& options, const AdjustScope& scope, const Run& run) {
  AdjustScope with_origin = scope;
  with_origin.first_cameras = setup_.cameras;
  COLLINEA_TRY(Adjusted adjusted, adjuster_.adjust(block(), with_origin, options, run));
  take(adjusted);
  return adjusted;
}

Result<Adjusted> Reconstruction::examine_all(const AdjustOptions& options, const AdjustScope& scope, const Run& run) {
  const AdjustScope with_origin = with_first_cameras(scope, setup_.cameras);
  COLLINEA_TRY(Adjusted adjusted, adjust_with_control_precision(adjuster_, block(), with_origin, options, run));
  take(adjusted);
  return adjusted;
}

Block Reconstruction::block() const {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < tracks_.size(); ++i)
    if (tracks_[i].point) numbers.push_back(i);
  Block block = block_of(numbers);
  block.images = setup_.images;
  set_poses(block, poses_);
  block.control = setup_.control;
  block.control_observations = setup_.control_observations;
  block.geodetic = setup_.geodetic;
  block.georeference = setup_.georeference;
  return block;
}

void Reconstruction::set_additional(AdditionalSet set) {
  for (auto& [id, camera] : cameras_)
    if (camera.prior.calibrate) camera.additional = set;
}

void Reconstruction::take(const Adjusted& adjusted) {
  for (const auto& [id, camera] : adjusted.cameras) cameras_[id] = camera;
  for (const auto& [image, pose] : adjusted.cam_from_world) poses_[image] = pose;
  for (const auto& [point, position] : adjusted.points) tracks_[point.value].point = position;
}

void Reconstruction::move_world(const Similarity3& new_from_old) {
  for (auto& [image, pose] : poses_) pose = moved(pose, new_from_old);
  for (TrackState& track : tracks_)
    if (track.point) track.point = new_from_old * *track.point;
}

void Reconstruction::move_rays(const Block& block, std::span<const std::optional<MovedRay>> moved) {
  const auto ray_of = [&](const Observation& seen) -> Ray& {
    std::vector<Ray>& rays = tracks_[seen.point.value].rays;
    return *std::lower_bound(rays.begin(), rays.end(), seen.image,
                             [](const Ray& one, ImageId image) { return one.image < image; });
  };
  for (std::size_t begin = 0; begin < block.observations.size();) {
    std::size_t end = begin, count = 0;
    while (end < block.observations.size() && block.observations[end].point == block.observations[begin].point)
      count += moved[end++].has_value();
    for (std::size_t i = begin; count > 0 && i < end; ++i) {
      Ray& ray = ray_of(block.observations[i]);
      if (moved[i]) {
        ray.pixel = moved[i]->pixel;
        ray.anew_sigma_px = moved[i]->sigma_px;
      } else {
        ray.sigma_factor *= std::numbers::sqrt2;
      }
    }
    begin = end;
  }
}

void Reconstruction::start_from_poses(const std::map<ImageId, Rigid3>& poses) {
  for (const auto& [image, pose] : poses) poses_[image] = pose;
}

void Reconstruction::drop_loose(int least_rays) {
  std::vector<ImageId> loose;
  do {
    loose.clear();
    for (const auto& [image, pose] : poses_)
      if (active_rays(image) < least_rays) loose.push_back(image);
    for (const ImageId image : loose) drop_image(image);
  } while (!loose.empty());
}

void Reconstruction::forget() {
  poses_.clear();
  cameras_ = setup_.cameras;
  for (TrackState& track : tracks_) {
    track.point.reset();
    for (Ray& ray : track.rays) ray.active = false;
  }
}

}  // namespace collinea
