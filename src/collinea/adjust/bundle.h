// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/solved.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"

namespace collinea {

/// Least-squares bundle adjustment (Brown 1958; Triggs et al. 2000): Levenberg-Marquardt on images, cameras and points
/// at once, points eliminated (Schur complement), robust losses by reweighting.
///
/// Observations: tie points; control points (their image measurements, never robust, and their coordinates by sigma_m,
/// infinite = not given); measurements on the ground between control points, and planes, lines and heights that these
/// are known to lie on (Block::geodetic, never robust; check points
/// among them take part with their image measurements, not with their coordinates, and with scope.use_check_rays all
/// check points do); GNSS positions, of an antenna
/// with a lever arm, a shift, a drift and a time offset if the scope says so; scope.attitudes with a boresight;
/// scope.verticals; and weak ones for the parameters of calibration so that weak geometry does not run away: f by
/// CameraPrior::sigma_f_px (0: f is fixed), principal point 3 % of the width, k1 0.2, k2 0.5, k3 0.5, p1 and p2 0.01,
/// b1 and b2 0.5 % of f, all around scope.first_cameras. Cameras with calibrate = false are fixed. scope.camera_sigmas
/// takes the place of all that for the cameras it names.
///
/// A control point with the sigmas 0 is fixed where it is given. Where only some axes have the sigma 0, these get a
/// thousandth of what one measured pixel is on the ground at the point.
///
/// Datum: a part of the block whose position, attitude or scale nothing fixes keeps them: every step is orthogonal to
/// the motions that no observation sees (inner constraints over up to eight images spread over the part). Residuals do
/// not depend on that choice.
///
/// Points with fewer than two rays (one for fixed points and for control known on three axes) and images with fewer
/// than three measured points take no part, nor do measurements on the ground to such points; but points that these
/// measurements determine need no rays (a total station that no image shows). Errors: kBadInput (options,
/// sigmas not positive, coordinates with finite sigmas that are no numbers), kIllPosed (nothing to adjust, or more
/// unknowns than observations), kUnsupported (more than 10,000 unknowns of cameras and of points that are joined by
/// measurements), kCancelled.
[[nodiscard]] Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                      const Run& run);

/// adjust() with all that covariances, reliability and weaknesses follow from.
[[nodiscard]] Result<Solved> solve_bundle(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                          const Run& run);

/// Adjusts a large block again and again: keeps the factor of the normal equations, by which the next steps of the same
/// images are solved with less work. The answers are the same within the accuracy of the options, and depend on what
/// was adjusted before in no other way.
class Adjuster {
 public:
  Adjuster();
  ~Adjuster();
  Adjuster(const Adjuster& other);  ///< a copy begins without a factor
  Adjuster& operator=(const Adjuster& other);
  Adjuster(Adjuster&&) noexcept;
  Adjuster& operator=(Adjuster&&) noexcept;

  [[nodiscard]] Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                        const Run& run);
  /// What it answers is of use until the next adjustment.
  [[nodiscard]] Result<Solved> solve(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                     const Run& run);

 private:
  std::shared_ptr<bundle::KeptFactor> kept_;
};

}  // namespace collinea
