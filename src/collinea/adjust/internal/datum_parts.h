// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/datum_sources.h"

namespace collinea::bundle {

/// What of a block points connect: its free images, and which motions of it as a whole its observations see.
struct DatumPart {
  std::vector<int> poses;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of its projection centres
  double size = 1;
  Matrix7 seen = Matrix7::Zero();  ///< sum of g' g of the derivatives g of what is observed, by motion_of()
  DatumSources sources;            ///< what observes it (DatumSources::parts apart)

  /// An observed position, on the axes that are 1.
  void add(const Eigen::Vector3d& position, const Eigen::Vector3d& axes = Eigen::Vector3d::Ones()) {
    const Matrix37 g = axes.asDiagonal() * motion_of(position, centre, size);
    seen += g.transpose() * g;
  }
};

/// Observations by unknowns of their own see what these leave: their rows by the motions of a part and by auxiliary
/// unknowns and points that no image shows.
class MotionsWithAuxiliaries {
 public:
  MotionsWithAuxiliaries(const Problem& problem, std::size_t parts);
  /// `row` may hold other unknowns too, which are those that the motions stand for.
  void add(int part, const Row7& motions, const Row& row);
  /// What the motions keep when the auxiliary unknowns may be anything that their own observations allow (DatumPart's
  /// sum, reduced by them). What is left of a motion by rounding alone is nothing.
  [[nodiscard]] Matrix7 seen(int part) const;

 private:
  [[nodiscard]] int count() const { return static_cast<int>(observed_.size()); }
  void add_column(int among_globals, bool observed);

  const Problem& problem_;
  std::map<int, int> column_;  // by the index among the global parameters
  std::vector<bool> observed_;
  std::vector<Eigen::MatrixXd> normals_;
};

}  // namespace collinea::bundle
