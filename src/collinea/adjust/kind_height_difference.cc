// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

GeodeticModel HeightDifference::model(const Sight& sight) {
  GeodeticModel model;
  model.computed = height_of(sight.to, sight.earth) - height_of(sight.from, sight.earth);
  model.by_to = sight.up_there;
  model.by_from = -sight.up;
  return model;
}

}  // namespace collinea::geodetic
