// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// The inner loops of the interest operators, for the instruction set of the machine. Rows are rows of float pixels;
// they may be read and written up to kRowSlack floats beyond their end (sift_kernels.h).
namespace collinea {

/// Masks of the first derivative, not normalised: their values are those of the literature.
enum class GradientMask : std::uint8_t {
  kCentral,  ///< -1 0 1
  kPrewitt,  ///< three rows of it
  kSobel,    ///< the middle one counts twice
};

/// What is made of the structure tensor [a c; c b].
enum class CornerMeasure : std::uint8_t {
  kHarris,             ///< det - parameter * trace^2
  kNoble,              ///< det / trace
  kSmallerEigenvalue,  ///< (a + b - sqrt((a - b)^2 + 4 c^2)) / 2
  kRoundNoble,         ///< det / trace where 4 det / trace^2 reaches the parameter, 0 elsewhere
};

/// The products gx gx, gx gy, gy gy of the gradient of a row; x to the right, y down. Rows are readable from -1.
void gradient_products(const float* above, const float* middle, const float* below, int width, GradientMask mask,
                       float* xx, float* xy, float* yy);

/// out[x] = the measure of the tensor [a[x] c[x]; c[x] b[x]].
void corner_response(const float* a, const float* c, const float* b, int width, CornerMeasure measure, float parameter,
                     float* out);

/// out[x] = (a[x] - b[x])^2.
void squared_differences(const float* a, const float* b, int width, float* out);

/// out[x] = min(out[x], a[x]).
void lower_to(const float* a, int width, float* out);

}  // namespace collinea
