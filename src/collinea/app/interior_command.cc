// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/interior.h"

namespace collinea {

Command interior_command() {
  struct Asked {
    std::string measurements;
    InteriorOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "interior", "interior orientation of scanned photographs by their fiducial marks",
      [](Flags& flags, Asked& asked) {
        flags.positional(
            "measurements", asked.measurements,
            "table of measured marks: image mark x[px] y[px]; or a scan, or a folder of scans, to find them in", false);
        flags.add_all(asked.options, "interior");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return interior_orientation(asked.measurements, asked.options, console.run()).map([&](const auto& report) {
          const auto& drawing = asked.options.drawing;
          const bool is_drawing_alone = drawing && report.images.empty();
          return (is_drawing_alone ? "" : interior_text(report)) +
                 (drawing ? "marks drawn: " + drawing->string() + "\n" : "");
        });
      });
}

}  // namespace collinea
