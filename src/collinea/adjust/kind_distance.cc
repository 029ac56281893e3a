// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// d|l| = (l / |l|) dl
GeodeticModel Distance::model(const Sight& sight) {
  GeodeticModel model;
  model.computed = sight.line.norm();
  if (model.computed > 0) derive_by_line(model, sight.line / model.computed);
  return model;
}

}  // namespace collinea::geodetic
