// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/find_tags.h"

namespace collinea {

Command tags_command() {
  struct Asked {
    std::vector<std::string> images;
    std::string out;
    FindTagsOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "tags", "coded tags (AprilTag, ArUco) of photographs, as marks of control points with standard deviations",
      [](Flags& flags, Asked& asked) {
        flags.positional("images", asked.images, "photographs (JPEG, PNG, TIFF)");
        flags.required("-o", "out", asked.out, "file for the marks");
        flags.add_all(asked.options, "tags");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        const std::vector<std::filesystem::path> images(asked.images.begin(), asked.images.end());
        return find_tags_in_files(images, asked.out, asked.options, console.run()).map(tags_text);
      });
}

}  // namespace collinea
