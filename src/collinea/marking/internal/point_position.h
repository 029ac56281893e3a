// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/marking/marked_point.h"
#include "collinea/marking/marking_block.h"

namespace collinea {

/// A point and the poses of local images, adjusted together by the point's coordinates and marks.
struct PointState {
  Eigen::Vector3d position_in_world;
  Eigen::VectorXd pose_steps;  ///< what the poses gained, 6 for each image
  Eigen::MatrixXd covariance;  ///< of [position, poses], 3 + 6 n
  bool given_disagrees = false;
};

/// The marks as local images count them; each of them is among these.
[[nodiscard]] std::vector<PointMark> point_marks(const LocalPoses& local, const std::vector<ControlObservation>& marks);

/// About where a point lies: by two marks, by its coordinates, or by one mark and tie points. Nothing: not known.
[[nodiscard]] std::optional<Eigen::Vector3d> start_position(const MarkingBlock& in, const ControlPoint& given,
                                                            const std::vector<ControlObservation>& marks);

/// The state by everything that agrees. Nothing: not known.
[[nodiscard]] std::optional<PointState> state_of_point(const MarkingBlock& in, const LocalPoses& local,
                                                       const ControlPoint& given,
                                                       const std::vector<ControlObservation>& marks);

/// The state about a position by the marks alone; what they leave open has a standard deviation of ten distances.
[[nodiscard]] PointState state_of_marks(const Block& block, const LocalPoses& local,
                                        const std::vector<ControlObservation>& marks,
                                        const Eigen::Vector3d& position_in_world);

}  // namespace collinea
