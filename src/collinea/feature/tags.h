// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/feature/tag_family.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A coded tag in an image. A model of the whole tag (a homography, its known cells, two greys, a slope of the light, a
/// blur) is fitted to the grey values by least squares.
struct Tag {
  TagFamily family = TagFamily::kApriltag36h11;
  int id = 0;
  int wrong = 0;               ///< cells that were corrected
  Eigen::Vector2d at;          ///< image of its centre: where the diagonals cross [px]
  Eigen::Matrix2d covariance;  ///< of the centre [px^2], from the residuals and what neighbours have in common
  /// Of the dark square: upper left, and on clockwise, as the tag is printed.
  std::array<Eigen::Vector2d, 4> corners;
  std::array<Eigen::Matrix2d, 4> corner_covariances;
  double blur_px = 0, contrast = 0, sigma_grey = 0;
  bool has_correlated_residuals = false;

  [[nodiscard]] double sigma_px() const;       ///< of the centre in its worst direction
  [[nodiscard]] double least_side_px() const;  ///< the shortest of the four
};

struct TagOptions {
  std::optional<TagFamily> family;
  double least_side_px = 10;
  double least_contrast = 20;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = TagOptions;
    visit(Field{"family", &O::family, "", "of coded tags; nothing: all, with 250 codes of each ArUco dictionary"});
    visit(Field{"least_side_px", &O::least_side_px, "px", "of the dark square of coded tags", 8, 1e5});
    visit(Field{"least_contrast", &O::least_contrast, "grey", "between light and dark of coded tags", 5, 255});
  }
};

/// All coded tags of an image, by family and number; tags need light ground of a cell about them. Dark quadrilaterals
/// are looked for, the greys of their cells estimated by least squares, read as a code within the distance of its
/// family, and the tag is fitted: it counts where the noise of the image explains the residuals but for a twentieth of
/// the variance of the grey values. Where the family is not given fewer cells are corrected, so that random cells are
/// no code but once in a thousand. Tags of more than 200 px are measured in a smaller image. Cost: a second for 20
/// million pixels, and some milliseconds a tag.
[[nodiscard]] std::vector<Tag> find_tags(const FloatImage& image, const TagOptions& options);

}  // namespace collinea
