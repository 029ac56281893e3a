// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

// Sums of rows, element by element, with as many lanes as the processor has. Products are rounded before they are
// added: the same bits with any number of lanes, and those of a plain loop.

/// x += factor y
void add_multiple(double* x, const double* y, double factor, int count);

/// x -= z[0] y[0] + z[1] y[1] + z[2] y[2]
void subtract_multiples(double* x, const double* const* y, const double* z, int count);

}  // namespace collinea
