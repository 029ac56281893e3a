// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/ground_table.h"
#include "collinea/jobs/internal/resection_options.h"

namespace collinea {

/// A row of the table of measurements; of a station x is the direction.
struct ResectionRow {
  std::string image, point;
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();
  double sigma = 1;
  bool is_rejected = false;
};

struct ResectionTables {
  std::vector<ResectionRow> marks;
  std::vector<std::string> images;  ///< in order of appearance
  GroundTable ground;
  std::string unit;
  bool sigmas_are_stated = false;

  [[nodiscard]] std::size_t image_of(const ResectionRow& mark) const {
    return static_cast<std::size_t>(std::find(images.begin(), images.end(), mark.image) - images.begin());
  }
  [[nodiscard]] bool is_known(const ResectionRow& mark) const {
    const GroundTablePoint* found = ground.find(mark.point);
    return found && found->sigma.allFinite();
  }
};

/// Image coordinates (or directions) and ground points as their tables have them. Errors: columns, a sigma that is not
/// above 0, a point measured twice, no measurement.
[[nodiscard]] Result<ResectionTables> read_resection_tables(const std::filesystem::path& measurements,
                                                            const std::filesystem::path& ground,
                                                            const ResectOneOptions& options);

/// That the table is of one image, as a method wants it that cannot take several at once.
[[nodiscard]] Result<> check_one_image(const ResectionTables& tables);

/// A difference in the axes of the camera, in those of the table.
[[nodiscard]] inline Eigen::Vector2d in_table(const PhotoFrame& frame, const Eigen::Vector2d& difference) {
  return frame.in_table(difference);
}

}  // namespace collinea
