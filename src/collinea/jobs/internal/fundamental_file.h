// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/report/relative_report.h"

namespace collinea {

/// The fundamental matrix of pixels, three rows of three numbers, as `correlate --epipolar` reads it. Errors: missing,
/// other rows.
[[nodiscard]] Result<Eigen::Matrix3d> read_fundamental(const std::filesystem::path& file);

/// Writes fundamental.txt into the folder; where the pair has no such matrix (fundamental_matrix()) one that lies there
/// is taken away. Errors: disk.
[[nodiscard]] Result<> write_fundamental(const Camera& left, const Camera& right, const Rigid3& right_from_left,
                                         const std::filesystem::path& folder);
/// The same of a table of measurements; none of one in millimetres.
[[nodiscard]] Result<> write_fundamental(const RelativeReport& report, const std::filesystem::path& folder);

}  // namespace collinea
