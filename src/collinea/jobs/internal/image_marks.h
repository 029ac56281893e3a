// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/epipolar/image_bundles.h"
#include "collinea/io/photo_frame.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// What a table of measurements in several images holds: image point x y and, where known, sigma.
struct ImageMarks {
  std::vector<std::string> images, points;         ///< in order of appearance
  std::vector<BundleMark> marks;                   ///< as the frame's camera has them, in its pixels
  std::vector<std::vector<std::size_t>> marks_of;  ///< of each point, their indices
  bool sigmas_are_stated = false;

  /// The mark of a point in an image; nothing where there is none.
  [[nodiscard]] const BundleMark* find(std::size_t image, std::size_t point) const;
};

/// Errors: columns, numbers, a sigma that is not above zero, a point twice in one image. `sigma` is that of coordinates
/// whose row states none, in the unit of the column x; nothing: 0.5 px or 0.005 mm.
[[nodiscard]] Result<ImageMarks> read_image_marks(const TextTable& table, const PhotoFrame& frame,
                                                  std::optional<double> sigma);

/// The bundles in the axes of photographs (x right, y up, z backwards of the first image), multiplied by `scale`, with
/// their covariances.
[[nodiscard]] AdjustedBundles in_photo_axes(const AdjustedBundles& adjusted, double scale);

}  // namespace collinea
