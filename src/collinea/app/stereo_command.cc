// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/stereo_pair.h"

namespace collinea {

Command stereo_command() {
  struct Asked {
    std::string left, right, out;
    StereoPairOptions pair;
    StereoMatching matching;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "stereo", "match a single pair: disparities with sigmas, and a cloud",
      [](Flags& flags, Asked& asked) {
        flags.positional("left", asked.left, "left image");
        flags.positional("right", asked.right, "right image");
        flags.required("-o", "out", asked.out, "folder for the results; made when missing");
        flags.add_all(asked.pair, "pair");
        flags.add_all(asked.matching, "matching");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const StereoReport report,
                     match_stereo(asked.left, asked.right, asked.out, asked.pair, asked.matching, console.run()));
        std::string text = stereo_text(report);
        if (!report.cameras) text += "no cloud: the cameras are not known (--focal-px, --base-m)\n";
        return text + "in " + asked.out + "\n";
      });
}

}  // namespace collinea
