// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "collinea/adjust/block_motion.h"
#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_cofactor.h"
#include "collinea/quality/internal/score_tests.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kSampled = 500;  // points

// Every so many points that the block determines.
std::vector<std::size_t> sampled_points(const Problem& problem) {
  std::vector<std::size_t> all;
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (!problem.point(p).is_fixed && !problem.is_unseen(p)) all.push_back(p);
  std::vector<std::size_t> some;
  const std::size_t step = std::max<std::size_t>(1, all.size() / kSampled);
  for (std::size_t k = 0; k < all.size(); k += step) some.push_back(all[k]);
  return some;
}

// Takes off what moves the block as a whole where nothing fixes it.
void in_own_datum(const Problem& problem, const State& state, const std::vector<std::size_t>& points,
                  Eigen::MatrixXd& moves) {
  if (problem.datum.empty() || points.empty()) return;
  Eigen::MatrixXd motions(3 * static_cast<Eigen::Index>(points.size()),
                          static_cast<Eigen::Index>(problem.datum.size()));
  for (std::size_t k = 0; k < points.size(); ++k)
    for (std::size_t d = 0; d < problem.datum.size(); ++d) {
      const DatumConstraint& datum = problem.datum[d];
      const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(&state.points[3 * points[k]]);
      const bool is_its = problem.part_of_point[points[k]] == datum.part;
      motions.block<3, 1>(3 * static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(d)) =
          is_its ? Eigen::Vector3d(motion_of(position, datum.centre, datum.size) * datum.motion)
                 : Eigen::Vector3d(Eigen::Vector3d::Zero());
    }
  moves -= motions * motions.colPivHouseholderQr().solve(moves);
}

// What of the displacements of a ray by tests is left when all unknowns follow them: `reduced` by these, the point by
// `move` (3 x tests).
Eigen::MatrixXd left_of(const RayDerivatives& ray, const Problem& problem, const Eigen::MatrixXd& reduced,
                        const Eigen::MatrixXd& move) {
  const Eigen::Index pose = 6 * Eigen::Index(ray.image);
  const Eigen::Index first =
      6 * Eigen::Index(problem.poses) + problem.cameras[static_cast<std::size_t>(ray.camera)].first_global;
  Eigen::MatrixXd left = ray.by_column + ray.by_point * move;
  if (ray.image < problem.poses)
    left += ray.by_rotation * reduced.middleRows<3>(pose) - ray.by_point * reduced.middleRows<3>(pose + 3);
  if (ray.by_camera.cols() > 0) left += ray.by_camera * reduced.middleRows(first, ray.by_camera.cols());
  return left;
}

}  // namespace

// The largest displacement of a position, or rotation of an attitude.
double ScoreTests::largest_at_given(const Eigen::VectorXd& by_column) const {
  double largest = 0;
  const auto take = [&](std::size_t count, auto&& parts_of) {
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int axis = 0; axis < 3; ++axis)
        for (const ColumnPart& part : parts_of(i, axis)) sum[axis] += part.derivative * by_column[part.column];
      largest = std::max(largest, sum.norm());
    }
  };
  take(columns_.problem.positions.size(), [&](std::size_t i, int axis) { return columns_.of_position(i, axis); });
  take(columns_.problem.attitudes.size(), [&](std::size_t i, int axis) { return columns_.of_attitude(i, axis); });
  return largest;
}

// If the error were estimated, images and cameras would move by -(A'PA)^-1 A'PH d, and each point after them.
void ScoreTests::measure_effects(TileCholesky& inverse, const Run& run) {
  const Problem& problem = columns_.problem;
  const std::vector<std::size_t> points = sampled_points(problem);
  const auto count = static_cast<Eigen::Index>(tests_.size());
  Eigen::MatrixXd by_column(columns_.count(), count);
  for (Eigen::Index t = 0; t < count; ++t) by_column.col(t) = fits_[static_cast<std::size_t>(t)].by_column;
  const Eigen::MatrixXd reduced = -normals_.solution() * by_column;
  Eigen::MatrixXd moves(3 * static_cast<Eigen::Index>(points.size()), count);
  Eigen::MatrixXd pixels = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(points.size()), count);
  Eigen::VectorXd sigmas_m(static_cast<Eigen::Index>(points.size()));
  // A fault of a camera is for the most part another focal length or attitude; of others the whole counts.
  std::vector<char> is_of_camera;
  for (const SystematicTest& test : tests_) is_of_camera.push_back(columns_.camera_with_deformation(test) >= 0);
  parallel_for(run, points.size(), [&](std::size_t k) {
    const auto row = static_cast<Eigen::Index>(k);
    std::vector<RayDerivatives> rays;
    const Eigen::MatrixXd own = normals_.point_columns(points[k], &rays) * by_column;
    const PointSystem system(problem, columns_.state, points[k]);
    sigmas_m[row] = sigma0_ * std::sqrt(system.covariance(inverse).trace());
    const int retained = problem.point(points[k]).first_retained;
    for (Eigen::Index t = 0; t < count; ++t)
      moves.block<3, 1>(3 * row, t) =
          retained >= 0 ? Eigen::Vector3d(reduced.block<3, 1>(6 * problem.poses + retained, t))
                        : Eigen::Vector3d(system.follow(reduced.col(t).data()) - system.solve_own(own.col(t)));
    for (RayDerivatives& ray : rays) {
      ray.by_column = (ray.by_column * by_column).eval();
      const Eigen::MatrixXd left = left_of(ray, problem, reduced, moves.middleRows<3>(3 * row));
      for (Eigen::Index t = 0; t < count; ++t)
        pixels(row, t) =
            std::max(pixels(row, t), (is_of_camera[static_cast<std::size_t>(t)] ? left : ray.by_column).col(t).norm());
    }
  });
  if (run.stopped()) return;
  in_own_datum(problem, columns_.state, points, moves);
  for (Eigen::Index t = 0; t < count; ++t) {
    SystematicTest& test = tests_[static_cast<std::size_t>(t)];
    for (Eigen::Index k = 0; k < pixels.rows(); ++k) {
      const double move = moves.block<3, 1>(3 * k, t).norm();
      test.ground_change_m = std::max(test.ground_change_m, move);
      test.ground_change_sigmas = std::max(test.ground_change_sigmas, move / sigmas_m[k]);
    }
    test.largest_effect = test.effect_unit == "px"             ? (pixels.rows() > 0 ? pixels.col(t).maxCoeff() : 0)
                          : test.kind == SystematicKind::kBowl ? std::abs(test.values[0])
                                                               : largest_at_given(by_column.col(t));
  }
}

}  // namespace collinea::bundle
