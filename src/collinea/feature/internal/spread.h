// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace collinea {

/// A position in an image with a strength.
struct Spot {
  float x = 0, y = 0;  ///< [px]
  float strength = 0;
};

/// The strength of each spot beside what its region of the image asks for; the `wanted` spots that are strongest in
/// this sense are the ones to take. A region asks for t^(1 - evenness) l^evenness: t is the strength that `wanted`
/// spots of the whole image reach, l that which the same share of them reach in the region. With evenness 0 the
/// strongest spots are taken wherever they are, with 1 as many in every region; but no region asks for less than
/// `least` t, since what is much weaker than the others is better left out. Between the middles of the regions the
/// threshold changes gradually, so that it asks the same of a spot in another image, where it lies otherwise to the
/// regions.
[[nodiscard]] std::vector<float> regional_strengths(std::span<const Spot> spots, int width, int height, int wanted,
                                                    double evenness, double least = 0.5);

}  // namespace collinea
