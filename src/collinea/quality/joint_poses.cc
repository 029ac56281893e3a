// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/joint_poses.h"

#include <algorithm>
#include <map>

#include "collinea/adjust/reduced_system.h"
#include "collinea/quality/internal/covariance_of_images.h"

namespace collinea {

using Eigen::Index;
using Eigen::MatrixXd;

struct BlockPrecision::State {
  std::unique_ptr<const bundle::Problem> problem;
  std::vector<Eigen::Matrix3d> world_from_cam;  // of each pose
  bundle::CovarianceOfImages covariance;
  std::map<ImageId, std::size_t> numbers;  // of its images in the problem
};

BlockPrecision::BlockPrecision(std::unique_ptr<State> state) : state_(std::move(state)) {}
BlockPrecision::BlockPrecision(BlockPrecision&&) noexcept = default;
BlockPrecision& BlockPrecision::operator=(BlockPrecision&&) noexcept = default;
BlockPrecision::~BlockPrecision() = default;

Result<BlockPrecision> BlockPrecision::of(const Block& adjusted, const AdjustScope& scope, const AdjustOptions& options,
                                          const Run& run) {
  COLLINEA_TRY(bundle::ReducedSystem system,
               bundle::reduced_system(adjusted, with_first_cameras(scope, adjusted.cameras), options, run));
  const bundle::Problem& problem = *system.problem;
  if (problem.rank_defect > 0) return fail(Errc::kUnsupported, "nothing fixes the block");
  std::vector<Eigen::Matrix3d> world_from_cam;
  for (int i = 0; i < problem.poses; ++i)
    world_from_cam.push_back(system.state.rotations[std::size_t(i)].conjugate().toRotationMatrix());
  std::map<ImageId, std::size_t> numbers;
  for (std::size_t i = 0; i < problem.images.size(); ++i)
    if (!std::ranges::count(problem.images_left_out, problem.images[i].id)) numbers[problem.images[i].id] = i;
  const int size = 6 * problem.poses + problem.global_count;
  return BlockPrecision(
      std::make_unique<State>(State{std::move(system.problem), std::move(world_from_cam),
                                    bundle::CovarianceOfImages(size, std::move(system.factor)), std::move(numbers)}));
}

std::optional<JointPoses> BlockPrecision::joint_poses(std::span<const ImageId> images) {
  const bundle::Problem& problem = *state_->problem;
  JointPoses joint{.images = {images.begin(), images.end()}, .covariance = {}};
  std::vector<int> rows;       // of the unknowns
  std::vector<Index> columns;  // where these stand in the answer
  std::vector<int> cameras;
  Index size = 0;
  for (const ImageId image : images) {
    const auto number = state_->numbers.find(image);
    if (number == state_->numbers.end()) return std::nullopt;
    const bool is_free = static_cast<int>(number->second) < problem.poses;
    for (int k = 0; k < 6 && is_free; ++k) {
      rows.push_back(6 * static_cast<int>(number->second) + k);
      columns.push_back(size + k);
    }
    size += 6;
    if (const int camera = problem.images[number->second].camera; !std::ranges::count(cameras, camera))
      cameras.push_back(camera);
  }
  std::ranges::sort(cameras);
  for (const int camera : cameras) {
    const bundle::ProblemCamera& its = problem.cameras[std::size_t(camera)];
    if (its.free.empty()) continue;
    joint.cameras.push_back({its.id, its.free});
    for (std::size_t k = 0; k < its.free.size(); ++k) {
      rows.push_back(6 * problem.poses + its.first_global + static_cast<int>(k));
      columns.push_back(size++);
    }
  }
  joint.covariance = MatrixXd::Zero(size, size);
  const MatrixXd of_rows = state_->covariance.of(rows);
  for (std::size_t a = 0; a < rows.size(); ++a)
    for (std::size_t b = 0; b < rows.size(); ++b)
      joint.covariance(columns[a], columns[b]) = of_rows(Index(a), Index(b));
  // Turns of the camera become those of the world before it.
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::size_t number = state_->numbers.at(images[i]);
    if (static_cast<int>(number) >= problem.poses) continue;
    const Eigen::Matrix3d& rotation = state_->world_from_cam[number];
    joint.covariance.middleRows<3>(6 * Index(i)) = (rotation * joint.covariance.middleRows<3>(6 * Index(i))).eval();
    joint.covariance.middleCols<3>(6 * Index(i)) =
        (joint.covariance.middleCols<3>(6 * Index(i)) * rotation.transpose()).eval();
  }
  return joint;
}

}  // namespace collinea
