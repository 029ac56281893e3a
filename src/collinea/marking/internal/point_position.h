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

/// Those of the marks in oriented images that agree with each other: of three and more the most whose rays pass a point
/// within kAgree_px (and six of their sigmas); of fewer all.
[[nodiscard]] std::vector<ControlObservation> agreeing_marks(const Block& block,
                                                             const std::vector<ControlObservation>& marks);
inline constexpr double kAgree_px = 10;

/// About where a point lies: by two marks, by its coordinates, or by one mark and tie points. Nothing: not known.
[[nodiscard]] std::optional<Eigen::Vector3d> start_position(const MarkingBlock& in, const ControlPoint& given,
                                                            const std::vector<ControlObservation>& marks);

/// The state by everything that agrees: two marks and more outweigh coordinates that contradict them, and coordinates
/// count more than single marks that miss them, unless that is the only one. Nothing: not known.
[[nodiscard]] std::optional<PointState> state_of_point(const MarkingBlock& in, const LocalPoses& local,
                                                       const ControlPoint& given,
                                                       const std::vector<ControlObservation>& marks);

/// The state about a position by the marks alone; what they leave open has a standard deviation of ten distances.
[[nodiscard]] PointState state_of_marks(const Block& block, const LocalPoses& local,
                                        const std::vector<ControlObservation>& marks,
                                        const Eigen::Vector3d& position_in_world);

}  // namespace collinea
