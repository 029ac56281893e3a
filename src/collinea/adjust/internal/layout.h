// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/internal/participants.h"

namespace collinea::bundle {

/// Where candidate images stand in Problem::images: free ones first, in the order of their elimination, then fixed
/// ones.
struct ImageOrder {
  std::vector<std::uint32_t> index;  ///< of each candidate; CandidateImages::kNone: it takes no part
  int free = 0, all = 0;             ///< how many
};

/// An order in which the factor of the normal equations stays sparse (elimination_order()); where two tiles of them
/// hold all images, as they come.
[[nodiscard]] ImageOrder order_images(const Block& block, const Participants& participants);

/// The tables of an adjustment and its start: images, points and cameras in the order of their unknowns, then the
/// observations of instruments and geodetic ones with the unknowns that they bring along. Points are ordered by their
/// first free image, so that neighbours are near in memory. Errors: as adjust() says.
[[nodiscard]] Result<ProblemAndStart> lay_out(const Block& block, const AdjustScope& scope,
                                              const AdjustOptions& options, Participants participants,
                                              const ImageOrder& order);

}  // namespace collinea::bundle
