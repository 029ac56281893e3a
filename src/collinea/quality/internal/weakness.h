// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/finding.h"
#include "collinea/base/run.h"

namespace collinea {

namespace bundle {

/// What is weak, from several looks at an adjustment.
class WeaknessFinder {
 public:
  /// `adjusted`: what `solved` estimated.
  WeaknessFinder(const Solved& solved, const Adjusted& adjusted)
      : block_(solved.block()), problem_(solved.problem()), state_(solved.state()), adjusted_(adjusted) {}

  /// Without any solution: motions of the whole that nothing observes, images that are left out.
  void look_at_observations();
  /// Images that look from nearly one position: whose points have distances that hardly anything tells. Needs the
  /// inverse after look_at_correlations(); without (nullptr) it trusts the positions in the images, and sees less.
  void look_at_bases(TileCholesky* inverse, const Run& run);
  /// Where the normal equations are singular beyond the datum: which images hang loose, by inverse iteration with a
  /// slightly stiffened matrix.
  void look_at_loose_images(Solved& solved, const Run& run);
  /// With the factor: motions of the ground as a whole that are far worse known than what fixes them, parameters of
  /// cameras that only their pseudo-observations determine, and motions of the images that imitate them. At most seven
  /// solutions for the block and thirteen for each of up to three cameras.
  void look_at_correlations(const TileCholesky& factor);
  /// Images known far worse than the others.
  void look_at_images(const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance);
  /// All that was found so far; none: everything is well determined.
  [[nodiscard]] std::vector<Finding> take() { return std::move(weaknesses_); }

 private:
  void add(Finding finding);
  [[nodiscard]] bool has(std::initializer_list<FindingCode> codes) const;
  struct KnownInPart {
    std::vector<ControlId> control;  // sorted by name
    bool whole = true;               // on all three axes
    bool control_alone = true;       // no positions
  };
  [[nodiscard]] KnownInPart known_in(int part) const;
  [[nodiscard]] double variance_of_distance(std::size_t point, TileCholesky* inverse) const;
  void look_at_scale(const TileCholesky& factor);
  void name_unseen(const std::vector<const DatumConstraint*>& unseen, bool whole);
  void name_articulation_images();
  void look_at_motions(const TileCholesky& factor);
  void name_weak_motion(const std::optional<Eigen::Vector3d>& axis, double variance, double size);
  /// A camera with its free parameters: their index among the reduced unknowns, and their cofactors.
  struct FreeCamera {
    const ProblemCamera& camera;
    int first;
    Eigen::MatrixXd cofactor;

    [[nodiscard]] int count() const { return static_cast<int>(camera.free.size()); }
    [[nodiscard]] Subject parameter(int k) const {
      return {camera.id, Aspect::kParameter, camera.free[static_cast<std::size_t>(k)]};
    }
  };
  void look_at_camera(const TileCholesky& factor, std::size_t camera);
  [[nodiscard]] std::vector<Eigen::VectorXd> motions_like_a_camera(std::size_t camera) const;
  bool name_imitation(const TileCholesky& factor, const FreeCamera& free, std::size_t which,
                      const Eigen::VectorXd& motion);
  void name_what_is_owed(const FreeCamera& free, bool imitated);
  [[nodiscard]] double reference_sigma(bool height) const;
  [[nodiscard]] std::vector<Subject> subjects(const std::vector<int>& images) const;
  [[nodiscard]] std::vector<double> solved(const TileCholesky& factor, std::vector<double> right) const;

  const Block& block_;
  const Problem& problem_;
  const State& state_;
  const Adjusted& adjusted_;
  std::vector<Finding> weaknesses_;
  std::vector<double> with_scale_;  // covariance of the reduced unknowns with the scale
  double scale_variance_ = 0;
};

}  // namespace bundle
}  // namespace collinea
