// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/app/exit_code.h"
#include "collinea/jobs/verify_project.h"

namespace collinea {

Command verify_command() {
  struct Asked {
    std::string project;
    VerifyProjectOptions options;
    ConsoleOptions console;
    bool json = false;
  };
  auto asked = std::make_shared<Asked>();
  return {"verify", "whether photographs, products and report are those that the report was made of",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.add("json", asked->json, "", "as JSON, for machines");
            flags.add_all(asked->options, "verify");
            flags.add_all(asked->console, "run");
          },
          [asked](const Flags& flags) {
            auto console = Console::create(asked->console, [&flags](const auto& name) { return flags.spelled(name); });
            if (!console) return complain(console.error());
            const auto verified = verify_project(asked->project, asked->options, console->run());
            if (!verified) return console->complain(verified.error());
            std::fputs((asked->json ? verified_json(*verified) : verified_text(*verified)).c_str(), stdout);
            return verified->agrees() ? 0 : kFilesDiffer;
          }};
}

}  // namespace collinea
