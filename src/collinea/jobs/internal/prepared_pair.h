// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/dense/epipolar_pair.h"
#include "collinea/jobs/internal/stereo_pair_options.h"
#include "collinea/raster/raster.h"
#include "collinea/report/stereo_report.h"

namespace collinea {

/// Everything matching needs of a pair whose homologous points lie in one row.
struct PreparedPair {
  GreyImage left, right;      ///< 0: the image has nothing there
  ColourImage colours;        ///< of the left image
  ColourImage right_colours;  ///< where the images are resampled
  std::optional<EpipolarPair> cameras;
  std::optional<DisparityRange> from_points;
  bool resampled = false;
  PairFrame frame{};  ///< of the cloud
};

/// The pair as it is, or resampled by its orientation. Errors: neither or both kinds of orientation, images not in it
/// or not oriented, geometry, files.
[[nodiscard]] Result<PreparedPair> prepared_pair(const std::string& left, const std::string& right,
                                                 const StereoPairOptions& pair, const Run& run);

/// The disparities to be searched. Error: nothing says them.
[[nodiscard]] Result<DisparityRange> range_for(const PreparedPair& ready, const StereoPairOptions& pair);

}  // namespace collinea
