// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

/// Where an image shows a control point: `mark P1 DJI_1.jpg 1200.31 800.2 0.05`. Takes the place of all earlier marks
/// of the point in that image. Of scans of film: in the ideal image.
struct MarkPoint {
  static constexpr std::string_view kWord = "mark";
  static constexpr std::string_view kForm = "mark POINT IMAGE X Y [SIGMA_PX]";

  std::string point, image;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px]
  std::optional<double> sigma_px;                   ///< of each coordinate; nothing: not completed yet

  static Result<MarkPoint> parse(std::span<const std::string> words);  ///< those behind kWord
  [[nodiscard]] std::vector<std::string> words() const;                ///< the same
  /// With what was left out, and the image as the block calls it. Error: no such image.
  [[nodiscard]] Result<MarkPoint> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no point, no image, beside the image.
  Result<> apply(const EditContext& context, EditedPoint& edited) const;
};

}  // namespace collinea
