// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/row_kernels.h"

#include <gtest/gtest.h>

#include <vector>

#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(RowKernels, HaveTheBitsOfPlainLoops) {
  Random random(1, 2);
  for (int count = 0; count < 40; ++count) {
    std::vector<std::vector<double>> rows(4, std::vector<double>(static_cast<std::size_t>(count)));
    for (auto& row : rows)
      for (double& value : row) value = random.normal();
    const double z[3] = {random.normal(), random.normal(), random.normal()};
    std::vector<double> added = rows[0], subtracted = rows[0];
    for (std::size_t k = 0; k < rows[0].size(); ++k) {
      added[k] += z[0] * rows[1][k];
      subtracted[k] -= z[0] * rows[1][k] + z[1] * rows[2][k] + z[2] * rows[3][k];
    }
    std::vector<double> x = rows[0];
    add_multiple(x.data(), rows[1].data(), z[0], count);
    EXPECT_EQ(x, added) << count;
    x = rows[0];
    const double* const y[3] = {rows[1].data(), rows[2].data(), rows[3].data()};
    subtract_multiples(x.data(), y, z, count);
    EXPECT_EQ(x, subtracted) << count;
  }
}

}  // namespace
}  // namespace collinea
