// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/adjust/calibration.h"
#include "collinea/base/options.h"
#include "collinea/math/robust.h"

namespace collinea {

/// How a bundle adjustment is done. Observations are whitened by their sigmas; all costs are sums of squares in sigmas.
struct AdjustOptions {
  /// Three coordinates lie farther from the truth than two: the loss of a position sets in so many times later than
  /// that of a ray.
  static constexpr double kPositionLossScale = 1.5;

  Calibration calibration = Calibration::kFocalRadial;
  Loss::Kind loss = Loss::kHuber;
  double loss_scale_sigmas = 2;
  Loss::Kind position_loss = Loss::kHuber;
  std::optional<double> position_loss_scale_sigmas;  ///< nothing: one and a half times that of tie points
  int max_iterations = 50;
  double first_damping = 1e-4;
  double relative_cost_change = 1e-7;
  double parameter_change = 1e-9;
  double step_sigmas = 0.05;
  /// In the end every point is brought to rest beside images and cameras as they came out. The iterations end when
  /// those are at rest: a point with far to go (one ray and coarse coordinates) may still be off by some of its sigmas,
  /// which tests of single observations would take for a blunder where hardly anything checks it.
  bool settle_points = false;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AdjustOptions;
    visit(Field{"calibration", &O::calibration, "", "free camera parameters"});
    visit(Field{"loss", &O::loss, "", "robust loss of tie point observations"});
    visit(
        Field{"loss_scale_sigmas", &O::loss_scale_sigmas, "sigma", "residual from which the loss sets in", 0.01, 1e6});
    visit(Field{"position_loss", &O::position_loss, "", "robust loss of GNSS positions"});
    visit(Field{"position_loss_scale_sigmas", &O::position_loss_scale_sigmas, "sigma",
                "distance from which the loss of positions sets in", 0.01, 1e6}
              .or_auto("one and a half times loss_scale_sigmas"));
    visit(Field{"max_iterations", &O::max_iterations, "1", "upper bound of linearisations", 1, 10000});
    visit(Field{"first_damping", &O::first_damping, "1",
                "damping of the first step, over each diagonal element of the normal equations; less where the start "
                "is good",
                1e-12, 1});
    visit(Field{"relative_cost_change", &O::relative_cost_change, "1",
                "stop when a step lowers the cost by a smaller part than this", 0, 1});
    visit(Field{"parameter_change", &O::parameter_change, "1",
                "stop when no image turns by more [rad] nor moves by more of the block's size", 0, 1});
    visit(Field{"step_sigmas", &O::step_sigmas, "sigma",
                "stop when a step of images and cameras is shorter than this many of their standard deviations", 0, 1});
  }
};

}  // namespace collinea
