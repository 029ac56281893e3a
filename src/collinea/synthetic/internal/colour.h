// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// Linear light or reflectance, red, green, blue; 1 = all of it.
struct Colour {
  float r = 0, g = 0, b = 0;
};

inline Colour operator+(Colour a, Colour b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Colour operator*(float s, Colour c) { return {s * c.r, s * c.g, s * c.b}; }
inline Colour operator*(Colour a, Colour b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }

/// a where share = 0, b where share = 1.
inline Colour mix(Colour a, Colour b, float share) { return (1 - share) * a + share * b; }

}  // namespace collinea
