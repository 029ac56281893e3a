// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/cloud/las_form.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How far the surface is from one camera, pixel by pixel of its working image: the image without distortion,
/// at the resolution it was matched in. Pixels without a measurement are NaN in both rasters.
struct DepthMap {
  Camera camera;     ///< pinhole without distortion; its size is that of the rasters
  FloatImage depth;  ///< z in the camera frame [m, or the unit of the gauge]
  FloatImage sigma;  ///< standard deviation of the depth [as depth]
};

/// Where depth maps are kept between matching and fusion: a folder, or memory in tests. read and write may be called
/// from several threads at once, for different images.
class DepthStore {
 public:
  virtual ~DepthStore() = default;
  virtual Result<> write(ImageId image, const DepthMap& map) = 0;
  virtual Result<DepthMap> read(ImageId image) = 0;
  [[nodiscard]] virtual bool has(ImageId image) const = 0;
};

/// The grey pixels of an image as it was taken, at 1/shrink of its size (shrink 1, 2, 4 or 8; size rounded up;
/// pixel i of the result covers [i shrink, (i + 1) shrink) of the original). May be called from several threads.
using PixelSource = std::function<Result<GreyImage>(ImageId image, int shrink)>;

/// The size at which images are matched: the whole number by which they are reduced.
enum class Resolution { kFull = 1, kHalf = 2, kQuarter = 4 };
inline constexpr Word<Resolution> kResolutionWords[] = {
    {Resolution::kFull, "full"}, {Resolution::kHalf, "half"}, {Resolution::kQuarter, "quarter"}};
[[nodiscard]] constexpr std::span<const Word<Resolution>> words(Resolution) { return kResolutionWords; }

struct DenseOptions {
  std::optional<Resolution> resolution;
  int neighbours = 6;
  double depth_margin = 0.3;
  double min_correlation = 0.5;
  double max_sigma_px = 0.5;
  int min_images = 3;
  double max_reprojection_px = 1.0;
  double max_sigmas = 4;
  double memory_mb = 800;
  LasForm cloud = LasForm::kCopc;
  bool ply = false;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = DenseOptions;
    visit(Field{"resolution", &O::resolution, "",
                "size at which the photographs are matched (nothing: the largest with at most 3.2 million pixels)"});
    visit(Field{"neighbours", &O::neighbours, "1", "images each image is matched with", 1, 8});
    visit(Field{"depth_margin", &O::depth_margin, "1",
                "how far the search reaches beyond the tie points, as a part of their range of inverse depths", 0, 10});
    visit(Field{"min_correlation", &O::min_correlation, "1", "smallest correlation of an accepted match", -1, 1});
    visit(Field{"max_sigma_px", &O::max_sigma_px, "px",
                "largest standard deviation of the parallax of an accepted match; less texture is left empty", 0.01,
                10});
    visit(Field{"min_images", &O::min_images, "1",
                "images that must agree on a point; fewer, but two, where fewer look at it", 2, 20});
    visit(Field{"max_reprojection_px", &O::max_reprojection_px, "px",
                "largest disagreement of two depth maps, as parallax", 0.01, 20});
    visit(Field{"max_sigmas", &O::max_sigmas, "1", "the same, in standard deviations of the two depths", 1, 100});
    visit(Field{
        "memory_mb", &O::memory_mb, "MB",
        "half of it for images kept at hand and half for matching costs (39 MB a thread, if that is more); then all "
        "of it for depth maps",
        10, 1e6});
    visit(Field{"cloud", &O::cloud, "", "form of the cloud in the map"});
    visit(Field{"ply", &O::ply, "", "the cloud as cloud.ply too: with normals, in the local frame"});
  }
};

/// The options that depth maps depend on; all others, which only fusion reads, as by default.
[[nodiscard]] DenseOptions options_of_matching(DenseOptions options);

/// By which whole number the images of a camera are reduced for matching.
[[nodiscard]] Result<int> working_shrink(const Camera& camera, const DenseOptions& options);

}  // namespace collinea
