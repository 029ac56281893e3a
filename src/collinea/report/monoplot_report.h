// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/report/single_step.h"
#include "collinea/surface/monoplot.h"

namespace collinea {

/// Ground points by single image points and a surface.
struct MonoplotReport {
  struct Point {
    std::string name, image;
    bool is_oriented = false;  ///< the table of orientations has the image
    MonoplotPoint found;
  };
  bool orientations_have_sigmas = false, heights_have_sigmas = false;
  std::vector<Point> points;
};

[[nodiscard]] std::string monoplot_text(const MonoplotReport& report);
/// points.txt: point, image, outcome, X, Y, Z, their sigmas and correlations, the height's sigma, the angle.
[[nodiscard]] std::vector<NamedTable> monoplot_tables(const MonoplotReport& report);

}  // namespace collinea
