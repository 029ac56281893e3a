// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/covariance_of_images.h"

#include <algorithm>

namespace collinea::bundle {

Eigen::MatrixXd CovarianceOfImages::of(std::span<const int> rows) {
  if ((columns_.size() + rows.size()) * static_cast<std::size_t>(size_) > kMostKept) columns_.clear();
  std::vector<double> x(static_cast<std::size_t>(factor_.tile_rows()) * kTile);
  for (const int row : rows) {
    auto [column, is_new] = columns_.try_emplace(row);
    if (!is_new) continue;
    std::fill(x.begin(), x.end(), 0.0);
    x[static_cast<std::size_t>(row)] = 1;
    factor_.solve(x.data());
    column->second = Eigen::Map<const Eigen::VectorXd>(x.data(), size_);
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd out(count, count);
  for (Eigen::Index c = 0; c < count; ++c) {
    const Eigen::VectorXd& column = columns_.at(rows[static_cast<std::size_t>(c)]);
    for (Eigen::Index r = 0; r < count; ++r) out(r, c) = column[rows[static_cast<std::size_t>(r)]];
  }
  return 0.5 * (out + out.transpose());
}

}  // namespace collinea::bundle
