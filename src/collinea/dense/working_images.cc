// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/working_images.h"

#include <algorithm>

#include "collinea/dense/epipolar_pair.h"

namespace collinea {
namespace {

constexpr double kDefaultPixels = 3.2e6;
constexpr int kSmallestSide = 40;  // of the coarsest level kept

bool is_ideal(const Camera& camera) {
  return !is_fisheye(camera.model) &&
         std::all_of(camera.params.begin() + Camera::kK1, camera.params.end(), [](double p) { return p == 0; });
}

// What masks hide of an image, in the working image: `taken` is the camera of the image reduced by `shrink`.
void hide(const MaskRings& masks, const Camera& taken, const RayBend& bend, int shrink, const Camera& ideal,
          GreyImage& image) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto pixel = project(taken, bend.bent(ray_in_cam(ideal, {x + 0.5, y + 0.5})));
      if (pixel && masks.hides(*pixel * shrink)) image.at(x, y) = 0;
    }
}

}  // namespace

DenseOptions options_of_matching(DenseOptions options) {
  const DenseOptions unset;
  options.min_images = unset.min_images;
  options.max_reprojection_px = unset.max_reprojection_px;
  options.max_sigmas = unset.max_sigmas;
  options.memory_mb = unset.memory_mb;
  options.cloud = unset.cloud;
  options.ply = unset.ply;
  return options;
}

Result<int> working_shrink(const Camera& camera, const DenseOptions& options) {
  if (options.resolution) return static_cast<int>(*options.resolution);
  int shrink = 1;
  while (shrink < 8 && double(camera.width_px) * camera.height_px / (shrink * shrink) > kDefaultPixels) shrink *= 2;
  return shrink;
}

Camera shrunk(const Camera& camera, int shrink) {
  Camera result = camera;
  for (int k = 0; k < Camera::kAllParams; ++k)
    if (param_unit(k) == "px") result.params[std::size_t(k)] /= shrink;
  result.width_px = (camera.width_px + shrink - 1) / shrink;
  result.height_px = (camera.height_px + shrink - 1) / shrink;
  return result;
}

Camera without_distortion(const Camera& camera) {
  Camera result = camera;
  result.model = Brown{};
  result.additional = AdditionalSet::kNone;
  std::fill(result.params.begin() + Camera::kK1, result.params.end(), 0.0);
  return result;
}

Camera camera_of_level(const Camera& camera, int level) {
  Camera result = camera;
  const double scale = std::ldexp(1.0, -level);
  for (const auto i : {Camera::kF, Camera::kCx, Camera::kCy}) result.params[std::size_t(i)] *= scale;
  result.width_px = camera.width_px >> level;
  result.height_px = camera.height_px >> level;
  return result;
}

GreyImage undistorted(const GreyImage& image, const Camera& camera, const RayBend& bend) {
  if (!is_ideal(camera) || bend.per_tangent_rad != 0)
    return resampled(image, camera, Eigen::Quaterniond::Identity(), without_distortion(camera), Run{}, bend);
  GreyImage result(image.width, image.height);
  std::transform(image.data.begin(), image.data.end(), result.data.begin(),
                 [](std::uint8_t v) { return std::max<std::uint8_t>(v, 1); });
  return result;
}

GreyImage halved(const GreyImage& image) {
  GreyImage half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    const std::uint8_t* a = image.row(2 * y);
    const std::uint8_t* b = image.row(2 * y + 1);
    std::uint8_t* out = half.row(y);
    for (int x = 0; x < half.width; ++x) {
      const int p = a[2 * x], q = a[2 * x + 1], r = b[2 * x], s = b[2 * x + 1];
      out[x] = p && q && r && s ? std::uint8_t((p + q + r + s + 2) / 4) : std::uint8_t(0);
    }
  }
  return half;
}

WorkingImages::WorkingImages(const Block& block, PixelSource pixels, const DenseOptions& options, ImageMasks masks)
    : block_(block), pixels_(std::move(pixels)), options_(options), masks_(std::move(masks)) {}

Result<Camera> WorkingImages::camera(ImageId image) const {
  const Camera& original = block_.camera_of(image);
  COLLINEA_TRY(const int shrink, working_shrink(original, options_));
  return without_distortion(shrunk(original, shrink));
}

Result<WorkingImage> WorkingImages::make(ImageId image) const {
  const Camera& original = block_.camera_of(image);
  COLLINEA_TRY(const int shrink, working_shrink(original, options_));
  COLLINEA_TRY(const GreyImage file, pixels_(image, shrink));
  const Camera camera = shrunk(original, shrink);
  if (file.width != camera.width_px || file.height != camera.height_px)
    return fail(Errc::kBadInput, block_.images.at(image).file + ": the image has " + std::to_string(file.width) +
                                     " x " + std::to_string(file.height) + " pixels, its camera " +
                                     std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px));
  WorkingImage result{without_distortion(camera), {}};
  const RayBend& bend = block_.images.at(image).bend;
  result.levels.push_back(undistorted(file, camera, bend));
  if (const MaskRings* masks = masks_.of(image)) hide(*masks, camera, bend, shrink, result.camera, result.levels[0]);
  while (std::min(result.levels.back().width, result.levels.back().height) >= 2 * kSmallestSide)
    result.levels.push_back(halved(result.levels.back()));
  return result;
}

Result<std::shared_ptr<const WorkingImage>> WorkingImages::image_of(ImageId image) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    auto& slot = entries_[image];
    if (!slot) {
      slot = std::make_shared<Entry>();
      by_use_.push_front(image);
      slot->use = by_use_.begin();
    } else {
      by_use_.splice(by_use_.begin(), by_use_, slot->use);
    }
    entry = slot;
  }
  const std::lock_guard making(entry->making);
  if (!entry->image) {
    COLLINEA_TRY(WorkingImage made, make(image));
    entry->image = std::make_shared<const WorkingImage>(std::move(made));
    keep(image, entry);
  }
  return entry->image;
}

void WorkingImages::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  by_use_.clear();
  bytes_ = 0;
}

void WorkingImages::keep(ImageId image, const std::shared_ptr<Entry>& entry) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(image);
  if (found == entries_.end() || found->second != entry) return;  // pushed out while it was being made
  for (const GreyImage& level : entry->image->levels) entry->bytes += level.data.size();
  bytes_ += entry->bytes;
  const auto limit = std::size_t(options_.memory_mb * 1e6 / 2);
  while (bytes_ > limit && by_use_.back() != image) {
    const auto oldest = entries_.find(by_use_.back());
    bytes_ -= oldest->second->bytes;
    entries_.erase(oldest);
    by_use_.pop_back();
  }
}

}  // namespace collinea
