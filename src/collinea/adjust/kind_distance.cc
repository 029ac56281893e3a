// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/geodetic_kinds.h"

namespace collinea::geodetic {

// d|l| = (l / |l|) dl
GroundModel Distance::model(const Sight& sight) {
  GroundModel model;
  model.computed = sight.line.norm();
  if (model.computed > 0) derive_by_line(model, sight.line / model.computed);
  return model;
}

}  // namespace collinea::geodetic
