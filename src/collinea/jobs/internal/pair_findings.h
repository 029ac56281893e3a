// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// What the left image has in common with the right one, where the object is as far as the points: a rectangle of left
/// pixels, cut into parts.
class PairOverlap {
 public:
  /// Nothing when no point is in front of both cameras.
  [[nodiscard]] static std::optional<PairOverlap> of(const ModelOfPair& model);

  /// Parts, of those of which the overlap is at least half, without any of the positions.
  struct Empty {
    int empty = 0, parts = 0;
  };
  /// The six zones of von Gruber: two along the base, three across.
  [[nodiscard]] Empty zones_without(std::span<const Eigen::Vector2d> left_px) const;
  [[nodiscard]] Empty quarters_without(std::span<const Eigen::Vector2d> left_px) const;

 private:
  [[nodiscard]] Empty without(std::span<const Eigen::Vector2d> left_px, int columns, int rows) const;

  std::vector<Eigen::Vector2d> inside_;  // samples of the left image that the right one shows
  Eigen::Vector2d least_ = {0, 0}, most_ = {0, 0}, step_ = {0, 0};
  bool base_along_rows_ = true;
};

/// What a user should know of the pair: few points or parts of the overlap without any, y-parallaxes beyond what
/// matching leaves, a weak geometry, a base too short for the heights that are wanted, parts without control, control
/// that contradicts, levels that were dropped, few measured cells. `report` is complete but for its findings,
/// `control_px` are positions of control in the left image.
[[nodiscard]] std::vector<Finding> pair_findings(const ModelOfPair& model, const PairReport& report,
                                                 std::span<const Eigen::Vector2d> control_px,
                                                 std::optional<double> wanted_sigma_z_m);

}  // namespace collinea
