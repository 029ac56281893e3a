// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "collinea/project/project.h"
#include "collinea/report/ground_report.h"

namespace collinea {

struct GroundOptions {
  std::string images;
  GroundMatchOptions match;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = GroundOptions;
    visit(Field{"images", &O::images, "",
                "two photographs, LEFT,RIGHT, as the project names them; nothing: the best pair for the place"});
    visit(Part{&O::match});
  }
};

/// The ground at a place of the map, as a mark that a stereoplotter sets on it (match_ground()): from the height of the
/// surface, or of tie points, by the best pair (stereo_view()). The mark keeps its place in the left photograph, so
/// that the position moves in plan as the height does. Errors: kBadInput, no such images; those of both.
[[nodiscard]] Result<GroundReport> measure_ground(const Project& project, const Eigen::Vector2d& on_map,
                                                  const GroundOptions& options);

}  // namespace collinea
