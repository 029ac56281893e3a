// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/photo_frame.h"

#include <fmt/format.h>

#include "collinea/io/number_rows.h"
#include "collinea/io/text_table.h"

namespace collinea {

Result<PhotoFrame> photo_frame(const PhotoOptions& options, std::string_view unit) {
  const bool in_pixels = unit.empty() || unit == "px";
  if (!in_pixels && !unit_factor(unit, "mm"))
    return fail(Errc::kBadFormat, fmt::format("image coordinates are in {}; wanted are px, mm or um", unit));
  if (!options.principal_distance)
    return fail(Errc::kBadInput, "nothing says the principal distance of the photographs",
                {"principal_distance"_option});
  const auto point = parse_numbers(options.principal_point);
  if (!point || point->size() != 2)
    return fail(Errc::kBadInput, "the principal point is not two numbers with a comma between",
                {"principal_point"_option});
  PhotoFrame frame{ideal_camera(*options.principal_distance, 0, 0), !in_pixels};
  const Eigen::Vector2d middle = frame.pixel({(*point)[0], (*point)[1]});
  frame.camera.params[Camera::kCx] = middle.x();
  frame.camera.params[Camera::kCy] = middle.y();
  return frame;
}

}  // namespace collinea
