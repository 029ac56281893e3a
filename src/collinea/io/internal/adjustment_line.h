// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// One line of an adjustment file taken apart: words, of which those in quotes may hold blanks.
struct AdjustmentLine {
  std::size_t number = 0;
  std::vector<std::string> words;

  [[nodiscard]] std::size_t count() const { return words.size() - 1; }  ///< without the keyword
};

[[nodiscard]] tl::unexpected<Error> bad_line(std::size_t line, const std::string& what);
/// In quotes, cut where it is long.
[[nodiscard]] std::string shown(std::string_view word);

/// Word i (and the two behind it) as finite numbers; `what` is expected there.
[[nodiscard]] Result<double> finite(const AdjustmentLine& line, std::size_t i, const char* what);
[[nodiscard]] Result<Eigen::Vector3d> finite3(const AdjustmentLine& line, std::size_t i, const char* what);
/// A standard deviation from 0; infinite for "-" and "inf".
[[nodiscard]] Result<double> deviation(const AdjustmentLine& line, std::size_t i);
[[nodiscard]] Result<Eigen::Vector3d> deviation3(const AdjustmentLine& line, std::size_t i);

}  // namespace collinea
