// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/kind_image_point.h"

namespace collinea::bundle {

double linearise_other(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                       LinearRay* out) {
  return linearise_as<false>(ray, frame, lens, point, loss, out);
}

}  // namespace collinea::bundle
