// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/dense/internal/local_kernels.h"
#include "collinea/match/area_matching.h"

namespace collinea::dense {

/// An image as bytes of a similarity, its border repeated so that windows round all pixels are whole.
class LocalPlanes {
 public:
  /// The grey values; of rank one byte a pixel, of census as many as its bits take. half_px: half of the window.
  LocalPlanes(const GreyImage& image, Similarity similarity, int half_px, int neighbourhood_px, const Run& run);

  [[nodiscard]] std::size_t count() const { return planes_.size(); }
  /// Element x + half is that of column x; rows beyond the border are the nearest in the image.
  [[nodiscard]] const std::uint8_t* row(std::size_t plane, int y) const;

 private:
  std::vector<GreyImage> planes_;
  int half_;
};

/// Sums of the grey values of the windows round all pixels, and 1 / root of their sums of squared deviations (0:
/// constant); not about the mean: sums of 0, and 1 / root of the sums of squares, where they are not constant. Rows are
/// kLocalSlack longer than those of the image.
struct LocalMoments {
  Raster<std::int32_t> sum;
  FloatImage scale;
};
[[nodiscard]] LocalMoments local_moments(const LocalPlanes& grey, int width, int height, int half_px,
                                         bool is_about_mean);

/// Both images made ready for one similarity. The images must outlive it.
struct LocalPair {
  LocalPair(const GreyImage& left, const GreyImage& right, Similarity similarity, int half_px, int neighbourhood_px,
            const Run& run);

  const GreyImage &left, &right;
  int half;
  LocalPlanes left_planes, right_planes;
  LocalMoments left_moments, right_moments;  ///< the latter of ncc and cosine alone
};

}  // namespace collinea::dense
