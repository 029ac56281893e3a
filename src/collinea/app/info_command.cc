// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/app/info_text.h"

namespace collinea {

Command info_command() {
  struct Asked {
    std::string project;
    bool json = false;
  };
  auto asked = std::make_shared<Asked>();
  return {"info", "what a project holds and how good it is",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.add("json", asked->json, "", "as JSON, for machines");
          },
          [asked](const Flags&) {
            const auto store = ProjectStore::open_to_read(asked->project);
            if (!store) return complain(store.error());
            const auto info = project_info(*store);
            if (!info) return complain(info.error());
            std::fputs((asked->json ? info_json(*info) : info_text(*info)).c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
