// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/interest.h"

namespace collinea {

Command interest_command() {
  struct Asked {
    std::string image, out;
    InterestJobOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "interest", "interest points of an image (Moravec, Harris, Foerstner, blobs), with standard deviations",
      [](Flags& flags, Asked& asked) {
        flags.positional("image", asked.image, "image (JPEG, PNG, TIFF)");
        flags.required("-o", "out", asked.out,
                       "folder for points.txt, points.png, map.tif, map.png; made when missing");
        flags.add_all(asked.options, "interest");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return find_interest(asked.image, asked.out, asked.options, console.run()).map(interest_text);
      });
}

}  // namespace collinea
