// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/heightfield.h"
#include "collinea/synthetic/internal/solid.h"

namespace collinea {

/// A house with a gabled roof, or a hall with a flat one, of chance size; heights count from the ground.
[[nodiscard]] Solid random_building(Random& random, double x, double y, double heading);

/// Sets a building on the terrain: its walls reach into the ground, heights count from the highest ground it touches.
void found(Solid& building, const Heightfield& terrain);

/// A chimney through a gabled roof, or a plant room on a flat one.
[[nodiscard]] Solid on_roof(const Solid& house, Random& random);

}  // namespace collinea
