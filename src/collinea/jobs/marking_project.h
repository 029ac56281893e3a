// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/marking/marking_block.h"
#include "collinea/project/project.h"

namespace collinea {

/// What the square roots of the covariances of a project are multiplied by to be standard deviations, as
/// sigma_scale(Adjusted); 1 of a block that was not adjusted.
[[nodiscard]] double sigma_scale(const std::optional<AdjustmentRecord>& adjustment);

/// An oriented project, with all that is asked of it where points are marked or plotted.
struct MarkingProject {
  Block block;
  BlockCovariances covariances;
  std::map<ImageId, std::vector<std::size_t>> observations;  ///< observations_by_image()
  std::optional<LocalFrame> frame;                           ///< nothing: no location on Earth
  double sigma_scale = 1;
  std::shared_ptr<BlockPrecision> precision;  ///< null: not known, local_poses() stands for it

  /// Refers to this.
  [[nodiscard]] MarkingBlock marking() const;
  [[nodiscard]] const LocalFrame* frame_or_null() const { return frame ? &*frame : nullptr; }
  /// Errors: kIllPosed, the block is not oriented yet; the project cannot be read.
  static Result<MarkingProject> read(const Project& project);
  /// The same with `precision`, where precision_of() has one.
  static Result<MarkingProject> read_with_precision(const Project& project);
};

}  // namespace collinea
