// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/adjustment_line.h"

#include <limits>

#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {

tl::unexpected<Error> bad_line(std::size_t line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

std::string shown(std::string_view word) { return "\"" + std::string(word.substr(0, 60)) + "\""; }

Result<double> finite(const AdjustmentLine& line, std::size_t i, const char* what) {
  const auto value = finite_number(line.words[i]);
  if (!value)
    return bad_line(line.number,
                    shown(line.words[i]) + " is not " + what + ": a number is expected" + number_hint(line.words[i]));
  return *value;
}

Result<Eigen::Vector3d> finite3(const AdjustmentLine& line, std::size_t i, const char* what) {
  Eigen::Vector3d v;
  for (std::size_t k = 0; k < 3; ++k) {
    COLLINEA_TRY(v[Eigen::Index(k)], finite(line, i + k, what));
  }
  return v;
}

Result<double> deviation(const AdjustmentLine& line, std::size_t i) {
  if (line.words[i] == "-" || line.words[i] == "inf") return std::numeric_limits<double>::infinity();
  COLLINEA_TRY(const double sigma, finite(line, i, "a standard deviation"));
  if (!(sigma >= 0))
    return bad_line(line.number, shown(line.words[i]) + " is not a standard deviation: a number from 0, or - for none");
  return sigma;
}

Result<Eigen::Vector3d> deviation3(const AdjustmentLine& line, std::size_t i) {
  Eigen::Vector3d v;
  for (std::size_t k = 0; k < 3; ++k) {
    COLLINEA_TRY(v[Eigen::Index(k)], deviation(line, i + k));
  }
  return v;
}

}  // namespace collinea
