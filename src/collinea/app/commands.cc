// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"

namespace collinea {

std::vector<Command> all_commands() {
  return {
      run_command(),
      import_command(),
      step_command("detect", "find features (SIFT) in every image"),
      step_command("match", "match features between images and verify them"),
      step_command("orient", "find poses, cameras and tie points; adjust them with GNSS and control"),
      step_command("densify", "depth maps and fused point cloud"),
      step_command("surface", "digital surface model (GeoTIFF)"),
      step_command("terrain", "digital terrain model and contours (GeoTIFF, GeoPackage, DXF)"),
      step_command("ortho", "orthophoto (Cloud-Optimised GeoTIFF)"),
      step_command("report", "quality report (HTML and JSON)"),
      info_command(),
      adjust_command(),
      export_command(),
      volume_command(),
      profile_command(),
      plan_command(),
      simulate_command(),
      assess_command(),
      stereo_command(),
      rectify_command(),
  };
}

}  // namespace collinea
