// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <filesystem>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string photos, project, until = "report";
  Settings settings;
  ConsoleOptions console;
};

int run_until(Asked& asked, const std::string& last) {
  auto console = Console::create(asked.console);
  if (!console) return complain(console.error());
  if (auto known = check_step_name(last); !known) return console->complain(std::move(known).error().within("--until"));
  std::error_code error;
  asked.settings.photos = std::filesystem::absolute(asked.photos, error).lexically_normal().string();
  for (auto* path : {&asked.settings.import.control, &asked.settings.import.ground, &asked.settings.import.positions,
                     &asked.settings.orient.orientation, &asked.settings.ortho.seamlines})
    if (*path) *path = std::filesystem::absolute(**path, error).lexically_normal().string();
  ImportOptions& import = asked.settings.import;
  std::optional<std::string> gps_heights = import.gps_heights;
  for (auto* heights : {&import.heights, &import.control_heights, &gps_heights})  // may be a file with a geoid grid
    if (*heights && std::filesystem::is_regular_file(**heights, error))
      *heights = std::filesystem::absolute(**heights, error).lexically_normal().string();
  import.gps_heights = *gps_heights;
  auto project = create_project(asked.project, asked.settings, console->run());
  if (!project) return console->complain(project.error());
  console->log_to(project->folder / "log.txt");
  if (auto done = bring_up_to(*project, last); !done) return console->complain(done.error());
  console->run().say("project in " + asked.project);
  return 0;
}

}  // namespace

Command run_command() {
  auto asked = std::make_shared<Asked>();
  return {"run", "photographs to oriented images, cloud, surface and terrain model, orthophoto and report",
          [asked](Flags& flags) {
            flags.positional("photos", asked->photos, "folder of photographs (searched with its subfolders)");
            flags.required("-o", "project", asked->project, "project folder; made when missing, continued when there");
            flags.add("until", asked->until, "", "last step to do");
            flags.add("seed", asked->settings.seed, "", kSeedHelp);
            flags.add_all(asked->console, "run");
            Settings::each(asked->settings,
                           [&](const char*, const char* group, auto& options) { flags.add_all(options, group); });
          },
          [asked] { return run_until(*asked, asked->until); }};
}

Command import_command() {
  auto asked = std::make_shared<Asked>();
  return {"import", "read headers, cameras, positions and control of a folder of photographs",
          [asked](Flags& flags) {
            flags.positional("photos", asked->photos, "folder of photographs (searched with its subfolders)");
            flags.required("-o", "project", asked->project, "project folder; made when missing");
            flags.add("seed", asked->settings.seed, "", kSeedHelp);
            flags.add_all(asked->console, "run");
            flags.add_all(asked->settings.import, "import");
          },
          [asked] { return run_until(*asked, "import"); }};
}

}  // namespace collinea
