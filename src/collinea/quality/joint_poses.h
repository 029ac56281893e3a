// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/adjust_scope.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"

namespace collinea {

/// Poses of some images and the cameras that took them, with the covariance of all of them together.
struct JointPoses {
  struct FreeCamera {
    CameraId camera;
    std::vector<int> params;  ///< of Camera::params, those that were not held
  };
  std::vector<ImageId> images;
  std::vector<FreeCamera> cameras = {};
  /// Of [rotation (rad, in world), centre (m)] of each image, true rotation = rotation * rotation_by(e), then of the
  /// parameters of each camera.
  Eigen::MatrixXd covariance;
};

/// What an adjusted block knows of any of its images together: columns of the inverse of its normal equations, solved
/// for with their factor as they are asked for. Exact, also between images that see nothing in common; equal to what
/// examine() says of each image. By the given sigmas (sigma0 taken as 1).
///
/// Cost: one linearisation and its factor at the beginning, then six solutions for each image that was not asked for
/// before. Not for several threads at once.
class BlockPrecision {
 public:
  /// Where the block stands: it is not adjusted anew. Errors: those of adjust(); kIllPosed when images are not
  /// determined; kUnsupported, a block that nothing fixes, whose datum is a choice.
  static Result<BlockPrecision> of(const Block& adjusted, const AdjustScope& scope, const AdjustOptions& options,
                                   const Run& run);
  BlockPrecision(BlockPrecision&&) noexcept;
  BlockPrecision& operator=(BlockPrecision&&) noexcept;
  ~BlockPrecision();

  /// Images without doubles. Nothing: one of them takes no part.
  [[nodiscard]] std::optional<JointPoses> joint_poses(std::span<const ImageId> images);

 private:
  struct State;
  explicit BlockPrecision(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collinea
