// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/marking/marked_point.h"
#include "collinea/marking/marking_block.h"

namespace collinea {

/// Where an image shows a point.
struct PredictedMark {
  ImageId image;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< of the true position about it [px^2]
  bool marked = false;
  bool hidden = false;  ///< by the surface: what is marked there is likely something else
  /// Largest standard deviation of the point from its marks and one in this image; nothing where they do not fix it.
  std::optional<double> sigma_after_m;
};

struct PredictedMarks {
  std::vector<PredictedMark> predicted;
  bool given_disagrees = false;        ///< the given coordinates contradict the marks, and were not used
  std::optional<MarkedPoint> marked;   ///< from the marks in oriented images alone, where there are two
  std::vector<ImageId> marked_images;  ///< parallel to MarkedPoint::tests
  std::vector<ImageId> contradicting;  ///< marks that most others of the point contradict, and that were not used
};

/// Where oriented images show a control point: by least squares from its given coordinates, its marks so far and the
/// poses with their joint covariance (local_poses()). The given coordinates are used as long as they agree with the
/// marks (at a level of 0.1 %): a block without a datum, or with a wrong one, is predicted from the second mark on;
/// from the first alone by the depth of the tie points around it.
///
/// Of three marks and more those that the most others contradict by 10 px and six sigmas are not used.
///
/// Predicted: inside the image, in front of the camera; at most kMostPredicted. Order: the mark that makes the point
/// best comes first, then the one that does so beside it, and so on, of marks equal within 2 % the one nearest to the
/// middle of its image; then in the same order those that the surface hides (is_hidden()); those that are marked come
/// last. Images that have the point marked are listed wherever the point lies. Empty: neither coordinates nor marks
/// tell where it is.
///
/// `given`: coordinates with infinite sigmas are not given; a missing height is that of the tie points.
[[nodiscard]] PredictedMarks predicted_marks(const MarkingBlock& block, const ControlPoint& given,
                                             const std::vector<ControlObservation>& marks);
inline constexpr std::size_t kMostPredicted = 40;

}  // namespace collinea
