// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/rectify_plane.h"

namespace collinea {
namespace {

// What was drawn, and which options would tell more.
std::string with_advice(const RectifiedReport& report) {
  std::string text = rectified_text(report);
  const auto& from = report.from_points;
  if (!report.shift_per_depth) text += "with --focal-px it is known where the camera stood\n";
  if (from && !from->is_lens_known)
    text += "the lens is not known (--project, --orientation): its distortion stays in the image\n";
  return text;
}

}  // namespace

Command rectify_command() {
  struct Asked {
    std::string source, out;
    RectifyOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "rectify", "a plane (a façade) at a metric scale, from a photograph or an oriented project",
      [](Flags& flags, Asked& asked) {
        flags.positional("source", asked.source, "photograph, or folder of an oriented project");
        flags.required("-o", "out", asked.out, "image to be written: .tif (GeoTIFF) or .png (and .pgw)");
        flags.add_all(asked.options, "rectify");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return rectify_plane(asked.source, asked.out, asked.options, console.run()).map(with_advice);
      });
}

}  // namespace collinea
