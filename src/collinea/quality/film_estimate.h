// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/quality/examine.h"

namespace collinea {

/// How film is deformed between its marks, as an adjustment found it, see camera/film_prior.h.
struct FilmEstimate {
  FilmProcess process;  ///< [px]
  FilmProcess before;   ///< what it began with
  double rms_px = 0;    ///< of the deformation of all scans, each coordinate, over the image
  int iterations = 0;
  bool converged = true;  ///< or given
};

/// Lets the local deformation of every scan of film take part (AdditionalSet::kFilm), with as many functions as the
/// number of scans allows: their unknowns are full rows of the normal equations. Other cameras stay as they are.
void add_film(Block& block);
[[nodiscard]] bool film_takes_part(const Block& block);

/// The process of the deformation by expectation and maximisation (likeliest_process()): adjusts, takes the likeliest
/// process, adjusts again, until standard deviation and length change by less than 2 % (at most twelve times). Priors
/// of the cameras of `block` become those; poses, cameras and points those of the last adjustment. What was given
/// stays. Errors: those of adjust(). Something undetermined: the priors stay.
[[nodiscard]] Result<FilmEstimate> estimate_film(Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                                 const Run& run);

}  // namespace collinea
