// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "collinea/block/image_masks.h"
#include "collinea/dense/depth_map.h"

namespace collinea {

/// The same image as seen without distortion, and its halvings: levels[l] is 1/2^l of the size (rounded down).
/// Grey value 0 means that the image has nothing there; real pixels have 1 to 255.
struct WorkingImage {
  Camera camera;  ///< of levels[0]; without distortion
  std::vector<GreyImage> levels;
};

/// The pinhole camera of level `level` of an image whose level 0 has the camera `camera`.
[[nodiscard]] Camera camera_of_level(const Camera& camera, int level);

/// The camera of an image reduced by a whole number, as PixelSource reduces: sizes are rounded up.
[[nodiscard]] Camera shrunk(const Camera& camera, int shrink);

/// The camera without distortion that shares focal length, principal point and size with `camera`.
[[nodiscard]] Camera without_distortion(const Camera& camera);

/// An image resampled (bicubically) into without_distortion(camera), as it would be without the bend of its rays;
/// `camera` fits the image.
[[nodiscard]] GreyImage undistorted(const GreyImage& image, const Camera& camera, const RayBend& bend = {});

/// Half the size, by the mean of 2 x 2 pixels; 0 where one of them is 0.
[[nodiscard]] GreyImage halved(const GreyImage& image);

/// The images for matching, made on demand and kept until half of `memory_mb` is full (least recently used go first;
/// the other half is for matching costs). What masks hide is nothing in them. Thread-safe. The block must outlive it.
class WorkingImages {
 public:
  WorkingImages(const Block& block, PixelSource pixels, const DenseOptions& options, ImageMasks masks = {});

  /// Errors: whatever the source says; an image whose size does not fit its camera.
  [[nodiscard]] Result<std::shared_ptr<const WorkingImage>> image_of(ImageId image);

  /// Forgets all images: they will not be asked for again soon.
  void clear();

  /// The camera its working image has, without making it.
  [[nodiscard]] Result<Camera> camera(ImageId image) const;

 private:
  struct Entry {
    std::mutex making;
    std::shared_ptr<const WorkingImage> image;
    std::size_t bytes = 0;
    std::list<ImageId>::iterator use;
  };
  Result<WorkingImage> make(ImageId image) const;
  void keep(ImageId image, const std::shared_ptr<Entry>& entry);

  const Block& block_;
  PixelSource pixels_;
  DenseOptions options_;
  ImageMasks masks_;
  std::mutex mutex_;
  std::map<ImageId, std::shared_ptr<Entry>> entries_;
  std::list<ImageId> by_use_;  ///< latest first
  std::size_t bytes_ = 0;
};

}  // namespace collinea
