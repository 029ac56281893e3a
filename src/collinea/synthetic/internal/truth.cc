// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/truth.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

// All that is needed to see a point in an image, side by side for quick refusal.
struct View {
  ImageId id;
  const Camera* camera;
  Rigid3 cam_from_world;
  Eigen::Vector3d centre, axis;
  double least_cosine;  // of the angle between the axis and anything on the image
};

View view_of(const Block& block, ImageId id) {
  View view{id, &block.camera_of(id), pose_of(block, id), {}, {}, 1};
  view.centre = centre_of(view.cam_from_world);
  view.axis = view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double w = view.camera->width_px, h = view.camera->height_px;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {w, 0}, {0, h}, {w, h}})
    view.least_cosine = std::min(view.least_cosine, ray_in_cam(*view.camera, corner).z());
  return view;
}

std::optional<Eigen::Vector2d> see(const Scene& scene, const View& view, const Eigen::Vector3d& point,
                                   double margin_px) {
  const Eigen::Vector3d ray = point - view.centre;
  if (view.axis.dot(ray) < 0.98 * view.least_cosine * ray.norm()) return std::nullopt;
  const auto pixel = project(*view.camera, view.cam_from_world * point);
  if (!pixel || !(pixel->x() >= margin_px && pixel->y() >= margin_px &&
                  pixel->x() <= view.camera->width_px - margin_px && pixel->y() <= view.camera->height_px - margin_px))
    return std::nullopt;
  return scene.visible(point, view.centre) ? pixel : std::nullopt;
}

std::optional<Hit> show(const Scene& scene, const View& view, const Eigen::Vector2d& pixel) {
  return scene.cast(view.centre, view.cam_from_world.rotation.conjugate() * ray_in_cam(*view.camera, pixel));
}

// A surface point with its image points, before it has an id.
struct Candidate {
  Eigen::Vector3d point;
  Colour albedo;
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> pixels;  // index of the view, exact position
};

// A point of the surface that `from` shows; of the other images that show it, each finds it with the chance
// `found_share`.
Candidate sample(const Scene& scene, const std::vector<View>& views, std::size_t from, double found_share,
                 Random& random) {
  const View& view = views[from];
  Candidate candidate;
  const auto hit =
      show(scene, view, {random.uniform(0, view.camera->width_px), random.uniform(0, view.camera->height_px)});
  if (!hit) return candidate;
  candidate.point = hit->point;
  candidate.albedo = scene.albedo(*hit, 0.05);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (const auto pixel = see(scene, views[i], hit->point, 0))
      if (i == from || random.uniform() < found_share) candidate.pixels.emplace_back(i, *pixel);
  return candidate;
}

std::uint8_t level(float albedo) { return std::uint8_t(std::lround(255 * std::sqrt(std::clamp(albedo, 0.0f, 1.0f)))); }

void append(Block& block, const std::vector<View>& views, const Candidate& candidate, double noise_px, Random& random) {
  const PointId id{std::uint32_t(block.points.size())};
  const Colour c = candidate.albedo;
  block.points.emplace_hint(block.points.end(), id, TiePoint{candidate.point, {level(c.r), level(c.g), level(c.b)}});
  for (const auto& [index, pixel] : candidate.pixels) {
    const Eigen::Vector2d noise(random.normal(), random.normal());
    block.observations.push_back({views[index].id, id, 0, pixel + noise_px * noise, noise_px > 0 ? noise_px : 1});
  }
}

}  // namespace

std::optional<Eigen::Vector2d> seen_at(const Truth& truth, ImageId image, const Eigen::Vector3d& point_in_world,
                                       double margin_px) {
  return see(truth.scene, view_of(truth.block, image), point_in_world, margin_px);
}

std::optional<Hit> shown_at(const Truth& truth, ImageId image, const Eigen::Vector2d& pixel) {
  return show(truth.scene, view_of(truth.block, image), pixel);
}

Result<Block> observations_only(const Truth& truth, const ObservationOptions& options, const Run& run) {
  Block block = truth.block;
  block.points.clear();
  block.observations.clear();
  std::vector<View> views;
  for (const auto& [id, image] : block.images) views.push_back(view_of(block, id));
  std::vector<int> count(views.size(), 0);
  std::uint64_t item = 0;
  // In rounds: each tops up what the points of other images have left short, so that no image gets far too many.
  constexpr int kRounds = 8;
  for (int round = 1; round <= kRounds; ++round) {
    std::vector<std::size_t> sources;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const int missing = options.points_per_image * round / kRounds - count[i];
      const int draws = round < kRounds ? (missing + 3) / 4 : int(2 * missing / options.found_share);
      sources.insert(sources.end(), std::size_t(std::max(0, draws)), i);
    }
    std::vector<Candidate> candidates(sources.size());
    parallel_for(run, sources.size(), [&](std::size_t i) {
      Random random(options.seed, item + i);
      candidates[i] = sample(truth.scene, views, sources[i], options.found_share, random);
    });
    if (run.stopped()) return fail(Errc::kCancelled, "sampling tie points was stopped");
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (candidates[i].pixels.size() < 2 || count[sources[i]] >= options.points_per_image) continue;
      Random random(options.seed + 1, item + i);
      append(block, views, candidates[i], options.noise_px, random);
      for (const auto& [view, pixel] : candidates[i].pixels) ++count[view];
    }
    item += sources.size();
  }
  // The features of an image are numbered in the order of their points.
  std::map<ImageId, std::uint32_t> next;
  for (Observation& observation : block.observations) observation.feature = next[observation.image]++;
  return block;
}

}  // namespace collinea
