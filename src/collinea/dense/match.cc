// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/match.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/dense/internal/foreground_fattening.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/measured_sigma.h"
#include "collinea/dense/internal/overview.h"
#include "collinea/dense/internal/pinhole.h"
#include "collinea/dense/internal/texture_centroid.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using dense::Labels;
using dense::Level;

constexpr std::size_t kFewestTiePoints = 8;
constexpr float kParallaxOfLabelPx = 0.8f;
constexpr int kMargin = 3;               // labels searched beyond the coarse surface
constexpr double kCoarsestLabels = 100;  // the coarsest level is the first with no more than these
// Searched beyond the tie points at least, as parts of the inverse depth: trees and masts seldom have tie points.
constexpr double kLeastFarther = 0.1, kLeastNearer = 0.8;
constexpr int kSmallestCoarsePatch = 20;  // pixels of a level; what hangs together less is not believed by the next
constexpr int kOverviewPx = 512;          // width of an overview at most
constexpr int kOverviewsCompared = 12;
constexpr float kOverviewReach = 1.5f;  // steps within which overviews agree
constexpr int kMeasuredLevels = 3;      // the finest of the pyramid
constexpr double kPlanePart = 0.5;      // a plane is worth taking when it leaves less than this of the range
constexpr float kAgreeing = 1.5f;       // steps
constexpr float kOneSurface = 2;        // steps
constexpr float kUnison = 8;            // sigmas
constexpr float kMuchBetter = 0.6f;
constexpr int kSmallestPatch = 40;  // pixels

Eigen::Matrix3d calibration(const Camera& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = k(1, 1) = camera.focal_px();
  k(0, 2) = camera.params[Camera::kCx];
  k(1, 2) = camera.params[Camera::kCy];
  return k;
}

// A tie point as matching sees it: its position on the working image and its inverse depth.
struct DepthSample {
  double x, y, w;
};

Result<std::vector<DepthSample>> depth_samples(const TieView& ties, ImageId image, const Camera& camera) {
  COLLINEA_TRY(const auto seen, ties.seen_by(image));
  std::vector<DepthSample> result;
  for (const Eigen::Vector3d& point_in_cam : seen) {
    const auto pixel = project(camera, point_in_cam);
    if (pixel && inside(camera, *pixel)) result.push_back({pixel->x(), pixel->y(), 1 / point_in_cam.z()});
  }
  return result;
}

// w = a x + b y + c around which the inverse depths lie, and how far (all of them but the grossest).
struct StartSurface {
  double a = 0, b = 0, c = 0, low = 0, high = 0;
};

StartSurface spread_around(double a, double b, double c, const std::vector<DepthSample>& depth_samples) {
  std::vector<double> rest;
  for (const DepthSample& s : depth_samples) rest.push_back(s.w - a * s.x - b * s.y - c);
  return {a, b, c, quantile(rest, 0.005), quantile(rest, 0.995)};
}

StartSurface start_surface(const std::vector<DepthSample>& depth_samples, double margin) {
  const StartSurface level = spread_around(0, 0, 0, depth_samples);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const DepthSample& s : depth_samples) {
    if (s.w < level.low || s.w > level.high) continue;
    const Eigen::Vector3d row(s.x, s.y, 1);
    normal += row * row.transpose();
    right += row * s.w;
  }
  const Eigen::Vector3d plane = normal.ldlt().solve(right);
  StartSurface best = level;
  if (plane.allFinite()) {
    const StartSurface tilted = spread_around(plane.x(), plane.y(), plane.z(), depth_samples);
    if (tilted.high - tilted.low < kPlanePart * (level.high - level.low)) best = tilted;
  }
  const double reach = margin * (level.high - level.low);
  best.low -= std::max(reach, kLeastFarther * level.high);
  best.high += std::max(reach, kLeastNearer * level.high);
  return best;
}

// Pixels in the neighbour per unit of inverse depth, in the middle of the depth samples.
double sensitivity(const Eigen::Matrix3d& h, const Eigen::Vector3d& b, const std::vector<DepthSample>& depth_samples) {
  std::vector<double> all;
  for (const DepthSample& s : depth_samples) {
    const Eigen::Vector3d p = h * Eigen::Vector3d(s.x, s.y, 1) + s.w * b;
    if (!(p.z() > 0)) continue;
    const Eigen::Vector2d by_w = (b.head<2>() - p.head<2>() / p.z() * b.z()) / p.z();
    all.push_back(by_w.norm());
  }
  return all.empty() ? 0 : quantile(all, 0.5);
}

// Everything about the pair that does not depend on the level.
struct Neighbour {
  std::shared_ptr<const WorkingImage> image;
  Rigid3 from_reference;  // neighbour_cam_from_reference_cam
  int level_offset = 0;   // so much coarser its pyramid is used, that pixels on the ground are alike

  [[nodiscard]] int level_for(int reference_level) const {
    return std::clamp(reference_level + level_offset, 0, int(image->levels.size()) - 1);
  }
};

int level_offset(const Camera& reference, const Camera& camera, const Rigid3& from_reference,
                 const std::vector<DepthSample>& depth_samples) {
  const dense::Pinhole pinhole(reference);
  std::vector<double> ratio;
  for (const DepthSample& s : depth_samples) {
    const double z = (from_reference * (pinhole.ray(s.x, s.y) / s.w)).z();
    if (z > 0) ratio.push_back(camera.focal_px() / z / (reference.focal_px() * s.w));
  }
  return ratio.empty() ? 0 : int(std::lround(std::log2(quantile(ratio, 0.5))));
}

void follow(const FloatImage& measured, FloatImage& surface) {
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    if (!std::isnan(measured.data[i])) surface.data[i] = measured.data[i];
}

// Where the surface found at a finer level is a smooth one, both agree and it is the better one.
void prefer(const FloatImage& finer, float step, FloatImage& surface, FloatImage& certainty) {
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    if (std::abs(surface.data[i] - finer.data[i]) <= kAgreeing * step)
      surface.data[i] = finer.data[i];
    else
      certainty.data[i] = step;
}

FloatImage cut(const FloatImage& raster, const GreyImage& image) {
  FloatImage result(image.width, image.height);
  for (int y = 0; y < result.height; ++y) std::copy_n(raster.row(y), result.width, result.row(y));
  return result;
}

// Empties what is measured badly. The rest is drawn towards the smooth surface as far as that is the more certain
// one; sigma is not made smaller by that, because both come from the same images.
void keep_good(const Level& level, const FloatImage& surface, const FloatImage& certainty, const DenseOptions& options,
               dense::Refined& refined) {
  const float px = level.step / level.parallax_px;
  auto& w = refined.inverse_depth.data;
  for (std::size_t i = 0; i < w.size(); ++i) {
    float& sigma = refined.sigma.data[i];
    sigma = std::hypot(dense::kSigmaScale * sigma, dense::kSigmaFloorPx * px);
    if (!(refined.correlation.data[i] >= float(options.min_correlation) && sigma <= float(options.max_sigma_px) * px &&
          w[i] > 0))
      w[i] = std::numeric_limits<float>::quiet_NaN();
    const float prior = certainty.data[i] * certainty.data[i], part = prior / (prior + sigma * sigma);
    w[i] = surface.data[i] + part * (w[i] - surface.data[i]);
  }
}

// Takes over what four pixels of a coarser measurement say in unison, where it is much better than what there is. It
// may not be far from the surface found at full resolution: wide windows reach across the edges of roofs.
void fill_from(const dense::Refined& coarse, int factor, const FloatImage& surface, float reach,
               dense::Refined& result) {
  const FloatImage& w = coarse.inverse_depth;
  for (int y = 0; y < result.inverse_depth.height; ++y)
    for (int x = 0; x < result.inverse_depth.width; ++x) {
      const bool empty = std::isnan(result.inverse_depth.at(x, y));
      const double u = (x + 0.5) / factor, v = (y + 0.5) / factor;
      const int i = int(u - 0.5), j = int(v - 0.5);
      if (u < 0.5 || v < 0.5 || i + 1 >= w.width || j + 1 >= w.height) continue;
      const auto [low, high] = std::minmax({w.at(i, j), w.at(i + 1, j), w.at(i, j + 1), w.at(i + 1, j + 1)});
      const float value = bilinear(w, u, v), sigma = bilinear(coarse.sigma, u, v);
      if (!(high - low <= kUnison * sigma) || !(empty || sigma < kMuchBetter * result.sigma.at(x, y))) continue;
      if (!(std::abs(value - surface.at(x, y)) <= reach)) continue;
      result.inverse_depth.at(x, y) = value;
      result.sigma.at(x, y) = sigma;
    }
}

class Matching {
 public:
  Matching(const DenseOptions& options, SharedBudget& costs, const Run& run)
      : options_(options), costs_(costs), run_(run) {}

  Result<> prepare(const Block& block, ImageId image, const TieView& ties, WorkingImages& images) {
    const std::string& file = block.images.at(image).file;
    COLLINEA_TRY(reference_, images.image_of(image));
    COLLINEA_TRY(depth_samples_, depth_samples(ties, image, reference_->camera));
    if (depth_samples_.size() < kFewestTiePoints)
      return fail(Errc::kIllPosed, file + ": too few tie points to match it");
    const Rigid3& pose = pose_of(block, image);
    COLLINEA_TRY(const auto others, ties.neighbours(image, options_.neighbours));
    for (const ImageId id : others) {
      if (run_.stopped()) return fail(Errc::kCancelled, "dense matching was stopped");
      Neighbour neighbour;
      COLLINEA_TRY(neighbour.image, images.image_of(id));
      neighbour.from_reference = pose_of(block, id) * inverse(pose);
      neighbour.level_offset =
          level_offset(reference_->camera, neighbour.image->camera, neighbour.from_reference, depth_samples_);
      neighbours_.push_back(std::move(neighbour));
    }
    if (neighbours_.empty()) return fail(Errc::kIllPosed, file + ": no other image sees its tie points");
    start_ = start_surface(depth_samples_, options_.depth_margin);
    return {};
  }

  Result<DepthMap> overview() const {
    const int last = overview_level();
    FloatImage surface;
    COLLINEA_TRY(match(coarsest_level(), last, surface, nullptr));
    DepthMap map{camera_of_level(reference_->camera, last), surface, surface};
    const float step = outline_of(last).step;
    for (std::size_t i = 0; i < surface.data.size(); ++i) {
      map.depth.data[i] = 1 / surface.data[i];
      map.sigma.data[i] = step / (surface.data[i] * surface.data[i]);
    }
    return map;
  }

  // `agreed`: what the overviews say, on their level; empty when there are none, NaN where they disagree.
  Result<DepthMap> run(const FloatImage& agreed) {
    std::array<FloatImage, kMeasuredLevels> surfaces;
    FloatImage surface = agreed;
    dense::fill_holes(surface);
    int from = coarsest_level();
    if (!agreed.empty()) {
      const int level = overview_level();
      if (level < kMeasuredLevels) surfaces[std::size_t(level)] = surface;
      from = level - 1;
    }
    COLLINEA_TRY(match(from, 0, surface, &surfaces));
    return measured(surfaces, agreed);
  }

  Result<FloatImage> agreed_overview(const Block& block, ImageId image, const TieView& ties, DepthStore& store) const {
    COLLINEA_TRY(const DepthMap own, store.read(image));
    const Rigid3& pose = pose_of(block, image);
    COLLINEA_TRY(const auto overlapping, ties.overlapping(image, kOverviewsCompared));
    std::vector<dense::LocatedMap> others;
    for (const ImageId id : overlapping) {
      if (!store.has(id)) continue;
      dense::LocatedMap other;
      COLLINEA_TRY(other.map, store.read(id));
      other.reference_from_cam = pose * inverse(pose_of(block, id));
      others.push_back(std::move(other));
    }
    return dense::agreed_surface(own, others, kOverviewReach * outline_of(overview_level()).step);
  }

 private:
  // From one level to another, both included; starts with the tie points when `surface` is empty.
  Result<> match(int from, int to, FloatImage& surface, std::array<FloatImage, kMeasuredLevels>* surfaces) const {
    for (int l = from; l >= to; --l) {
      const Level level = level_at(l);
      const Labels labels = surface.empty() ? start_labels(level, l) : next_labels(surface, level);
      surface = dense::match_level(level, labels, costs_, run_);
      if (run_.stopped()) return fail(Errc::kCancelled, "dense matching was stopped");
      if (surfaces && l < kMeasuredLevels) (*surfaces)[std::size_t(l)] = surface;
    }
    return {};
  }

  Level level_at(int l) const {
    Level level = outline_of(l);
    for (std::size_t i = 0; i < neighbours_.size(); ++i)
      level.views[i].quads = dense::quads_of(neighbours_[i].image->levels[std::size_t(neighbours_[i].level_for(l))]);
    return level;
  }

  // A level whose views have no images yet: these take most of its memory.
  Level outline_of(int l) const {
    Level level;
    level.image = &reference_->levels[std::size_t(l)];
    const Eigen::Matrix3d own = calibration(camera_of_level(reference_->camera, l)), back = own.inverse();
    level.focal_px = float(own(0, 0)), level.cx = float(own(0, 2)), level.cy = float(own(1, 2));
    const double scale = std::ldexp(1.0, -l);
    std::vector<DepthSample> here = depth_samples_;
    for (DepthSample& s : here) s.x *= scale, s.y *= scale;
    std::vector<double> px_per_w;
    for (const Neighbour& n : neighbours_) {
      const Eigen::Matrix3d k = calibration(camera_of_level(n.image->camera, n.level_for(l)));
      const Eigen::Matrix3d h = k * n.from_reference.rotation.toRotationMatrix() * back;
      const Eigen::Vector3d b = k * n.from_reference.translation;
      dense::View view;
      view.centre_in_cam = centre_of(n.from_reference).cast<float>();
      for (int i = 0; i < 9; ++i) view.transfer.h[std::size_t(i)] = float(h(i / 3, i % 3));
      for (int i = 0; i < 3; ++i) view.transfer.b[std::size_t(i)] = float(b[i]);
      px_per_w.push_back(sensitivity(h, b, here));
      level.views.push_back(std::move(view));
    }
    const double strong = quantile(px_per_w, 0.75);
    level.step = strong > 0 ? float(kParallaxOfLabelPx / strong) : 0;
    level.parallax_px = kParallaxOfLabelPx;
    return level;
  }

  // The finest level that is small enough for an overview; of a long strip, the coarsest there is.
  int overview_level() const {
    const auto& levels = reference_->levels;
    int level = 0;
    while (level + 1 < int(levels.size()) && levels[std::size_t(level)].width > kOverviewPx) ++level;
    return level;
  }

  int coarsest_level() const {
    const Level finest = outline_of(0);
    double labels = (start_.high - start_.low) / std::max(1e-30, double(finest.step));
    int l = 0;
    const int last = int(reference_->levels.size()) - 1;
    while (l < last && (labels > kCoarsestLabels || reference_->levels[std::size_t(l)].width > 400)) {
      labels /= 2;
      ++l;
    }
    return std::max(l, overview_level());
  }

  Labels start_labels(const Level& level, int l) const {
    const double size = std::ldexp(1.0, l);
    const double at_corner = start_.c + (start_.a + start_.b) * 0.5 * size;  // at the centre of the first pixel
    return dense::labels_around_plane(level.image->width, level.image->height, level.step, float(at_corner),
                                      float(start_.a * size), float(start_.b * size), float(start_.low / level.step),
                                      float(start_.high / level.step));
  }

  static Labels next_labels(FloatImage coarse, const Level& level) {
    dense::remove_speckles(coarse, 3 * level.step, kSmallestCoarsePatch);  // a coarse label is two fine ones
    dense::fill_holes(coarse);
    return dense::labels_around(dense::median3(coarse), level.image->width, level.image->height, level.step, kMargin);
  }

  // Correlation at full resolution and, for what is too rough or has too little texture for small windows, at lower
  // ones, where the same windows reach farther and the noise of the pixels averages out.
  Result<DepthMap> measured(std::array<FloatImage, kMeasuredLevels>& surfaces, const FloatImage& agreed) const {
    Level finest = level_at(0);
    dense::Refined result;
    FloatImage finer, finest_surface;
    dense::TextureCentroid finest_centroid;
    for (int l = 0; l < kMeasuredLevels && !surfaces[std::size_t(l)].empty(); ++l) {
      Level coarse = l == 0 ? Level() : level_at(l);
      Level& level = l == 0 ? finest : coarse;
      FloatImage surface = std::move(surfaces[std::size_t(l)]);
      dense::fill_holes(surface);
      surface = dense::smoothed_within(dense::median3(surface), level.step);
      FloatImage certainty(surface.width, surface.height, 1, dense::kSmoothSigmaPx / finest.parallax_px * finest.step);
      if (l > 0) prefer(cut(dense::halved(finer), *level.image), level.step, surface, certainty);
      follow(dense::refine(level, surface, false, run_).inverse_depth, surface);
      surface = dense::smoothed_within(surface, level.step);
      dense::Refined refined = dense::refine(level, surface, true, run_);
      level.views.clear();  // what follows looks at no other image
      if (run_.stopped()) return fail(Errc::kCancelled, "dense matching was stopped");
      keep_good(level, surface, certainty, options_, refined);
      dense::TextureCentroid centroid = dense::texture_centroid(*level.image);
      dense::keep_textured(centroid, kAgreeing * level.step, refined.inverse_depth);
      if (l == 0) {
        result = std::move(refined);
        finest_centroid = std::move(centroid);
      } else {
        fill_from(refined, 1 << l, finest_surface, kAgreeing * level.step, result);
      }
      finer = std::move(surface);
      if (l == 0) finest_surface = finer;
    }
    if (!agreed.empty()) dense::fill_rough(finest, finest_centroid, agreed, result);
    dense::empty_foreground_fattening(*finest.image, kOneSurface * finest.step, result.sigma, result.inverse_depth,
                                      run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "dense matching was stopped");
    return finished(finest, result);
  }

  DepthMap finished(const Level& level, dense::Refined& refined) const {
    dense::remove_speckles(refined.inverse_depth, kOneSurface * level.step, kSmallestPatch, &refined.sigma);
    DepthMap map{reference_->camera, std::move(refined.inverse_depth), std::move(refined.sigma)};
    for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
      const float z = 1 / map.depth.data[i];
      map.depth.data[i] = z;
      map.sigma.data[i] = std::isnan(z) ? z : map.sigma.data[i] * z * z;
    }
    return map;
  }

  const DenseOptions& options_;
  SharedBudget& costs_;
  const Run& run_;
  std::shared_ptr<const WorkingImage> reference_;
  std::vector<DepthSample> depth_samples_;
  std::vector<Neighbour> neighbours_;
  StartSurface start_;
};

Result<Matching> prepared(const Block& block, ImageId image, const TieView& ties, WorkingImages& images,
                          SharedBudget& costs, const DenseOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (!is_oriented(block, image)) return fail(Errc::kIllPosed, block.images.at(image).file + " is not oriented");
  Matching matching(options, costs, run);
  COLLINEA_TRY(matching.prepare(block, image, ties, images));
  return matching;
}

}  // namespace

SharedBudget budget_for_costs(const DenseOptions& options, int at_once) {
  return SharedBudget(std::max(std::size_t(options.memory_mb * 1e6 / 2),
                               std::size_t(std::max(1, at_once)) * dense::usual_bytes_to_match()));
}

Result<DepthMap> overview(const Block& block, ImageId image, const TieView& ties, WorkingImages& images,
                          SharedBudget& costs, const DenseOptions& options, const Run& run) {
  COLLINEA_TRY(const Matching matching, prepared(block, image, ties, images, costs, options, run));
  return matching.overview();
}

Result<DepthMap> depth_map(const Block& block, ImageId image, const TieView& ties, WorkingImages& images,
                           SharedBudget& costs, DepthStore* overviews, const DenseOptions& options, const Run& run) {
  COLLINEA_TRY(Matching matching, prepared(block, image, ties, images, costs, options, run));
  FloatImage agreed;
  if (overviews && overviews->has(image)) {
    COLLINEA_TRY(agreed, matching.agreed_overview(block, image, ties, *overviews));
  }
  return matching.run(agreed);
}

Result<DepthMap> depth_map(const Block& block, ImageId image, const PixelSource& pixels, const DenseOptions& options,
                           const Run& run) {
  const TieView ties(block);
  WorkingImages images(block, pixels, options);
  SharedBudget costs = budget_for_costs(options, 1);
  return depth_map(block, image, ties, images, costs, nullptr, options, run);
}

}  // namespace collinea
