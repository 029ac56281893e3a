// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/rectify_plane.h"

namespace collinea {

Command rectify_command() {
  struct Asked {
    std::string source, out;
    RectifyOptions options;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"rectify", "a plane (a façade) at a metric scale, from a photograph or an oriented project",
          [asked](Flags& flags) {
            flags.positional("source", asked->source, "photograph, or folder of an oriented project");
            flags.required("-o", "out", asked->out, "picture to be written: .tif (GeoTIFF) or .png (and .pgw)");
            flags.add_all(asked->options, "rectify");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto done = rectify_plane(asked->source, asked->out, asked->options, console->run());
            if (!done) return console->complain(done.error());
            fmt::print("{}", *done);
            return 0;
          }};
}

}  // namespace collinea
