// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/line_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

constexpr std::size_t kLeastRays = 3;      // of a point: two leave the turn of one image in the point
constexpr std::size_t kLeastInImage = 50;  // measurements
constexpr double kCore_sigmas = 2;         // beyond it an error counts less (Cauchy)
constexpr int kPose = 6, kRotation = 3, kAll = kPose + 2 * kRotation;

using VectorAll = Eigen::Matrix<double, kAll, 1>;
using MatrixAll = Eigen::Matrix<double, kAll, kAll>;

// Normal equations of one image: pose, turn by row, turn by column.
struct Normals {
  MatrixAll normal = MatrixAll::Zero();
  VectorAll right = VectorAll::Zero();
  double squares = 0;
  std::size_t measurements = 0;
};

std::map<ImageId, Normals> normals_of(const Block& block) {
  std::map<ImageId, Normals> result;
  const auto& seen = block.observations;  // sorted by point and image
  for (std::size_t begin = 0, end = 0; begin < seen.size(); begin = end) {
    while (end < seen.size() && seen[end].point == seen[begin].point) ++end;
    if (end - begin < kLeastRays) continue;
    const Eigen::Vector3d& point = block.points.at(seen[begin].point).position_in_world;
    for (std::size_t i = begin; i < end; ++i) {
      const Camera& camera = block.camera_of(seen[i].image);
      const Eigen::Vector3d in_cam = pose_of(block, seen[i].image) * point;
      Matrix23 by_point;
      const auto pixel = project(camera, in_cam, &by_point, nullptr);
      if (!pixel) continue;
      const Eigen::Vector2d error = seen[i].pixel - *pixel;
      const double sigmas2 = error.squaredNorm() / (seen[i].sigma_px * seen[i].sigma_px);
      const double weight = 1 / (1 + sigmas2 / (kCore_sigmas * kCore_sigmas)) / (seen[i].sigma_px * seen[i].sigma_px);
      const Matrix23 by_rotation = -by_point * skew(in_cam);
      Eigen::Matrix<double, 2, kAll> by_all;
      by_all << by_rotation, by_point, by_rotation * (seen[i].pixel.y() / camera.height_px - 0.5),
          by_rotation * (seen[i].pixel.x() / camera.width_px - 0.5);
      Normals& sum = result[seen[i].image];
      sum.normal += weight * by_all.transpose() * by_all;
      sum.right += weight * by_all.transpose() * error;
      sum.squares += weight * error.squaredNorm();
      ++sum.measurements;
    }
  }
  return result;
}

struct Fit {
  double pose = 0, rotation = 0;  // residual variance after six and after nine unknowns
};

// `first`: of the turn's unknowns.
std::optional<Fit> fit(const Normals& sum, int first) {
  constexpr int kBoth = kPose + kRotation;
  Eigen::Matrix<double, kBoth, kBoth> normal;
  Eigen::Matrix<double, kBoth, 1> right;
  normal << sum.normal.topLeftCorner<kPose, kPose>(), sum.normal.block<kPose, kRotation>(0, first),
      sum.normal.block<kRotation, kPose>(first, 0), sum.normal.block<kRotation, kRotation>(first, first);
  right << sum.right.head<kPose>(), sum.right.segment<kRotation>(first);
  // Lengths in the world may be any: unknowns are brought to one size.
  const Eigen::Matrix<double, kBoth, 1> scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  normal = (scale.asDiagonal() * normal * scale.asDiagonal()).eval();
  right = right.cwiseProduct(scale);
  const Eigen::LLT<Eigen::Matrix<double, kPose, kPose>> by_pose(normal.topLeftCorner<kPose, kPose>());
  const Eigen::LLT<Eigen::Matrix<double, kBoth, kBoth>> by_both(normal);
  if (by_pose.info() != Eigen::Success || by_both.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, kBoth, 1> solved = by_both.solve(right);
  const auto redundancy = 2 * static_cast<double>(sum.measurements) - kPose;
  const Eigen::Matrix<double, kPose, 1> pose = right.head<kPose>();
  return Fit{(sum.squares - pose.dot(by_pose.solve(pose))) / redundancy,
             (sum.squares - right.dot(solved)) / (redundancy - kRotation)};
}

LineMotion motion_along(const std::map<ImageId, Normals>& sums, int first) {
  LineMotion motion;
  double pose = 0, rotation = 0;
  for (const auto& [image, sum] : sums) {
    if (sum.measurements < kLeastInImage) continue;
    const auto found = fit(sum, first);
    if (!found || !(found->pose > 0)) continue;
    motion.images.push_back({image, 1 - found->rotation / found->pose});
    pose += static_cast<double>(sum.measurements) * found->pose;
    rotation += static_cast<double>(sum.measurements) * found->rotation;
  }
  if (pose > 0) motion.explained = 1 - rotation / pose;
  std::stable_sort(motion.images.begin(), motion.images.end(),
                   [](const ImageMotion& a, const ImageMotion& b) { return a.explained > b.explained; });
  return motion;
}

}  // namespace

LineMotion line_motion(const Block& oriented) {
  const auto sums = normals_of(oriented);
  LineMotion by_row = motion_along(sums, kPose), by_column = motion_along(sums, kPose + kRotation);
  return by_row.explained >= by_column.explained ? by_row : by_column;
}

}  // namespace collinea
