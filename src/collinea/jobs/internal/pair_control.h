// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "collinea/geometry/absolute_orientation.h"
#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// Control of a pair as its table states it.
struct PairControl {
  std::filesystem::path file;
  std::vector<std::string> names;
  std::vector<std::array<Eigen::Vector2d, 2>> pixels;  ///< in the images as they are worked on
  double sigma_px = 0;                                 ///< of their coordinates there
  std::vector<AbsoluteControl> points;                 ///< ground alone

  [[nodiscard]] std::vector<Eigen::Vector2d> left_px() const;
};

/// `shrink`: of the images as they are worked on, against the files. Errors: the table; a point beyond the film.
[[nodiscard]] Result<PairControl> read_pair_control(const std::filesystem::path& file, const PairFiles& pair,
                                                    int shrink, double sigma_px);

/// The absolute orientation of a model by its control, intersected in it. Errors: rays that do not meet; what
/// absolute_orientation() refuses.
[[nodiscard]] Result<AbsoluteOrientation> oriented_absolutely(const PairControl& control, const ModelOfPair& model,
                                                              const Rigid3& right_from_left);

}  // namespace collinea
