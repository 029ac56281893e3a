// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

GeodeticModel CommonHeight::model(const ShapePoint& at) {
  GeodeticModel model;
  model.computed = height_of(at.point, at.earth) - at.unknowns[0];
  model.by_from = up_at(at.point, at.earth);
  model.by_auxiliary[0] = -1;
  model.auxiliaries = 1;
  return model;
}

}  // namespace collinea::geodetic
