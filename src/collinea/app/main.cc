// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <exception>

#include "collinea/app/commands.h"

int main(int argc, char** argv) {
  using namespace collinea;
  const std::array commands = {
      run_command(),
      import_command(),
      step_command("detect", "find features (SIFT) in every image"),
      step_command("match", "match features between images and verify them"),
      step_command("orient", "find poses, cameras and tie points; adjust them with GNSS and control"),
      step_command("densify", "depth maps and fused point cloud"),
      step_command("surface", "digital surface model (GeoTIFF)"),
      step_command("ortho", "orthophoto (Cloud-Optimised GeoTIFF)"),
      step_command("report", "quality report (HTML and JSON)"),
      info_command(),
      export_command(),
      simulate_command(),
      assess_command(),
  };
  try {
    return dispatch(argc, argv, commands);
  } catch (const std::exception& defect) {
    fmt::print(stderr, "collinea has a defect, please report it: {}\n", defect.what());
    return 1;
  }
}
