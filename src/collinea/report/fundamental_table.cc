// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/fundamental_table.h"

#include "collinea/io/text.h"

namespace collinea {

TextTable fundamental_table(const Eigen::Matrix3d& fundamental) {
  TextTable table;
  table.remarks = {"fundamental matrix F, x_right' F x_left = 0 of pixels (x, y, 1)"};
  table.columns = {{"by_x_left", ""}, {"by_y_left", ""}, {"constant", ""}};
  for (const auto& row : fundamental.rowwise()) table.rows.push_back({exact(row[0]), exact(row[1]), exact(row[2])});
  return table;
}

}  // namespace collinea
