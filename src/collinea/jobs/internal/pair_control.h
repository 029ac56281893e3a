// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "collinea/geometry/absolute_orientation.h"
#include "collinea/jobs/internal/control_fit.h"
#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// Control of a pair as its table states it.
struct PairControl {
  std::filesystem::path file;
  std::vector<std::array<Eigen::Vector2d, 2>> pixels;  ///< in the images as they are worked on
  double sigma_px = 0;                                 ///< of their coordinates there
  ControlFit fit;                                      ///< ground alone

  /// Positions in the left image of what is used.
  [[nodiscard]] std::vector<Eigen::Vector2d> used_left_px() const;
  [[nodiscard]] std::vector<std::string> used_names() const;
};

/// `shrink`: of the images as they are worked on, against the files. Errors: the table; a role that is neither control
/// nor check; a point beyond the film.
[[nodiscard]] Result<PairControl> read_pair_control(const std::filesystem::path& file, const PairFiles& pair,
                                                    int shrink, double sigma_px);

/// The absolute orientation of a model by what is used of its control, intersected in it. Errors: rays that do not
/// meet; what absolute_orientation() refuses.
[[nodiscard]] Result<AbsoluteOrientation> oriented_absolutely(const PairControl& control, const ModelOfPair& model,
                                                              const Rigid3& right_from_left);

/// The same; with `reject` points are left out one by one as long as the largest test is beyond its limit.
[[nodiscard]] Result<AbsoluteOrientation> oriented_with_rejection(PairControl& control, const ModelOfPair& model,
                                                                  const Rigid3& right_from_left, bool reject,
                                                                  double alpha);

/// Parameters, tests and positions of control and check points, by that orientation of the model. The model of the
/// report has the axes of photographs: x right, y up, z backwards.
[[nodiscard]] Result<AbsoluteReport> pair_control_report(const PairControl& control, const ModelOfPair& model,
                                                         const AbsoluteOrientation& found, double alpha);

}  // namespace collinea
