// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/adjust/datum_sources.h"
#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/block/gauge.h"
#include "collinea/quality/conditioning.h"
#include "collinea/quality/snooping.h"

namespace collinea {

// Words for the things that findings and reports speak of.

/// "the lever arm to the right of FC6310", "k1 of camera FC6310", "the attitudes of the images", "IMG_3.jpg".
[[nodiscard]] std::string words_of(const Subject& subject, const Block& block);

/// The subjects one after the other: "A.jpg, B.jpg and C.jpg"; of many the first six and how many more there are.
[[nodiscard]] std::string words_of(const std::vector<Subject>& subjects, const Block& block);

/// What fixes position, attitude and scale: "control points, positions of images", "free network (7 degrees of
/// freedom kept by inner constraints)".
[[nodiscard]] std::string words_of(const DatumSources& datum, int rank_defect);

/// "the horizontal edges of the images".
[[nodiscard]] std::string words_of(LevelSource level);

/// "in EPSG:25832, fixed by control points and the positions of 24 images", "local gauge, as given by model/".
[[nodiscard]] std::string words_of(const Gauge& gauge);

/// "others are suspect to the same degree".
[[nodiscard]] std::string words_of(StayReason reason);

/// What the worst combination of unknowns consists of: "k1 of camera X (64 %), the attitudes of the images (21 %)".
[[nodiscard]] std::string words_of(const Conditioning& conditioning, const Block& block);

}  // namespace collinea
