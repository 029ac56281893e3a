// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/adjust/refraction.h"
#include "collinea/orient/adjustment_options.h"
#include "collinea/quality/additional_choice.h"
#include "collinea/quality/film_estimate.h"
#include "collinea/quality/mismatches.h"
#include "collinea/quality/residual_tests.h"
#include "collinea/quality/snooping.h"
#include "collinea/quality/tie_weights.h"
#include "collinea/quality/variance_components.h"

namespace collinea {

/// All that is needed to adjust a block with the full model.
struct AdjustmentTask {
  Block block;
  AdjustScope scope;
  ExamineOptions options;
  InstrumentOptions instruments;      ///< that the scope has
  bool reject_mismatches = false;     ///< of tie points
  std::optional<SnoopedKinds> snoop;  ///< what is examined for gross errors; nothing: they are only named
};

/// Check points as they would differ, did their rays take part where they do not, or not where they do.
struct OtherCheckRays {
  std::vector<ControlDifference> control;  ///< control and check points, ascending
  double sigma0 = 0;
  long redundancy = 0;
};

/// An adjusted block and all that is known of it.
struct Adjustment {
  Block block;                            ///< as adjusted, with the sigmas that were used
  Examined adjusted;                      ///< with covariances and reliability
  AdjustScope scope;                      ///< of that
  InstrumentOptions instruments;          ///< that took part, with those that were taken up
  std::vector<Finding> taken_up;          ///< systematic errors that are estimated without having been asked for
  std::optional<Refracted> refracted;     ///< when measurements were corrected for refraction
  std::optional<Mismatches> mismatches;   ///< of tie points, when they were rejected
  std::optional<TieWeights> tie_weights;  ///< when tie points weigh by their errors
  std::optional<Snooped> snooped;         ///< when gross errors were rejected; its `adjusted` may have been moved
  std::optional<FilmEstimate> film;       ///< the deformation of scans of film
  std::optional<VarianceComponents> components;    ///< when they were estimated and applied
  std::vector<AdditionalTest> additional;          ///< of cameras with additional parameters
  double additional_level = 0;                     ///< of their tests
  std::vector<ResidualTest> residual_tests;        ///< of their order and distribution
  double residual_level = 0;                       ///< of them all together
  DatumPoints datum_points;                        ///< as asked for; none: all tie points
  std::optional<OtherCheckRays> other_check_rays;  ///< when it was asked whether they take part
  std::vector<Observation> measured_ties;  ///< of tie points before any was rejected, when their residuals are wanted
};

/// Gives the cameras of the task the additional set that was asked for, free or fixed. A camera with another set begins
/// at zero. Answers the parameters that are fixed because the additional ones say the same, by name. Errors: parameters
/// to be fixed that there are not.
[[nodiscard]] Result<std::vector<std::string>> set_additional(const AdjustmentOptions& asked, AdjustmentTask& task);

/// Gives the block the deflection of the vertical that was asked for. Errors: the block has no location on Earth.
[[nodiscard]] Result<> set_deflection(const AdjustmentOptions& asked, Block& block);

/// Takes the points that were asked for as those of the datum. Errors: names that there are not, with the nearest;
/// check points whose rays take no part.
[[nodiscard]] Result<> choose_datum(const AdjustmentOptions& asked, AdjustmentTask& task);

/// Adjusts as asked for: refraction, data snooping, variance components, tests of additional parameters. Errors: those
/// of adjust(); refraction of a block without location on Earth.
[[nodiscard]] Result<Adjustment> adjust_block(AdjustmentTask task, const AdjustmentOptions& asked, const Run& run);

}  // namespace collinea
