// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/fundamental_file.h"

#include "collinea/base/file.h"
#include "collinea/epipolar/epipolar_lines.h"
#include "collinea/io/number_rows.h"
#include "collinea/report/fundamental_table.h"

namespace collinea {

Result<Eigen::Matrix3d> read_fundamental(const std::filesystem::path& file) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const std::string text, read_file(file));
  COLLINEA_TRY(const auto rows, parse_number_rows(text, false, 3, 3).map_error(within));
  if (rows.size() != 3)
    return tl::unexpected(within(Error{Errc::kBadFormat, "a fundamental matrix has three rows of three numbers"}));
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out(i, k) = rows[std::size_t(i)].numbers[std::size_t(k)];
  return out;
}

Result<> write_fundamental(const Camera& left, const Camera& right, const Rigid3& right_from_left,
                           const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "fundamental.txt";
  const auto matrix = fundamental_matrix(left, right, right_from_left);
  if (!matrix) return remove_file(file);
  return write_file(file, text_of(fundamental_table(*matrix)));
}

Result<> write_fundamental(const RelativeReport& report, const std::filesystem::path& folder) {
  if (report.frame.y_up) return remove_file(folder / "fundamental.txt");
  return write_fundamental(report.frame.camera, report.frame.camera, report.orientation.second_from_first, folder);
}

}  // namespace collinea
