// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/stereo_pair.h"

namespace collinea {

Command stereo_command() {
  struct Asked {
    std::string left, right, out;
    StereoPairOptions pair;
    StereoOptions stereo;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"stereo", "match a single pair: disparities with sigmas, and a cloud",
          [asked](Flags& flags) {
            flags.positional("left", asked->left, "left picture");
            flags.positional("right", asked->right, "right picture");
            flags.required("-o", "out", asked->out, "folder for the results; made when missing");
            flags.add_all(asked->pair, "pair");
            flags.add_all(asked->stereo, "matching");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto done =
                match_stereo(asked->left, asked->right, asked->out, asked->pair, asked->stereo, console->run());
            if (!done) return console->complain(done.error());
            fmt::print("{}", *done);
            return 0;
          }};
}

}  // namespace collinea
