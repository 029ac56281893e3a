// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/enhance.h"

namespace collinea {

Command enhance_command() {
  struct Asked {
    std::string image, out;
    EnhanceOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "enhance",
      "an image for the eye: contrast, look-up tables, palettes, smoothing, reduction, dithering; statistics",
      [](Flags& flags, Asked& asked) {
        flags.positional("image", asked.image, "image (JPEG, PNG, TIFF)");
        flags.required("-o", "out", asked.out,
                       "folder for enhanced.png, statistics.txt, histogram.txt, histogram.svg; made when missing");
        flags.add_all(asked.options, "enhance");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return enhance_image(asked.image, asked.out, asked.options, console.run()).map(enhance_text);
      });
}

}  // namespace collinea
