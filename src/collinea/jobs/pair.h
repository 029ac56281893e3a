// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/run.h"
#include "collinea/jobs/internal/pair_options.h"
#include "collinea/report/pair_report.h"

namespace collinea {

/// Two photographs to a surface (the chain of Karfis 2009, each step by the methods of its own command): interest
/// points and their matches, relative orientation with rejection of gross errors, refinement by least squares matching
/// and orientation again, epipolar images with a check of their y-parallaxes, surface, and with control the absolute
/// orientation. Writes into `folder`: pair.txt (the report), points.txt, epipolar_left.png, epipolar_right.png,
/// epipolar_check.png, cloud.ply, of film film_left.jpg and film_right.jpg; with control or a base in metres the files
/// of map_pair(). Errors: files, no principal distance, images that do not show the same, what the methods refuse;
/// stopped.
[[nodiscard]] Result<PairReport> orient_and_match(const std::filesystem::path& left, const std::filesystem::path& right,
                                                  const std::filesystem::path& folder, const PairChainOptions& options,
                                                  const Run& run);

}  // namespace collinea
