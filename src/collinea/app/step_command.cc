// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <set>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/app/settings_paths.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  Settings flags;  ///< holds what the flags say; only those given go into the project
  Given seed_given;
  std::map<std::string, std::vector<std::pair<std::string_view, Given>>> given;  ///< by group
  ConsoleOptions console;
};

void declare(const std::string& step, Flags& flags, Asked& asked) {
  flags.positional("project", asked.project, "project folder");
  asked.seed_given = flags.add("seed", asked.flags.seed, "", kSeedHelp);
  flags.add_all(asked.console, "run");
  Settings::each(asked.flags, [&](const char* owner, const char* group, auto& options) {
    if (owner == step)
      flags.add_group(options, group, [&](const char* its, const auto& field, const Given& given) {
        asked.given[its].emplace_back(field.name, given);
      });
  });
}

// The project's settings with the options that were given.
void apply_flags(Asked& asked, Settings& settings) {
  make_paths_absolute(asked.flags);
  if (asked.seed_given()) settings.seed = asked.flags.seed;
  Settings::each(std::as_const(asked.flags), [&](const char*, const std::string& group, const auto& from) {
    const auto known = asked.given.find(group);
    if (known == asked.given.end()) return;
    std::set<std::string_view> names;
    for (const auto& [name, given] : known->second)
      if (given()) names.insert(name);
    Settings::each(settings, [&](const char*, const std::string& other, auto& to) {
      if constexpr (std::is_same_v<std::decay_t<decltype(to)>, std::decay_t<decltype(from)>>)
        if (other == group) assign_fields(from, to, [&](std::string_view name) { return names.contains(name); });
    });
  });
}

Result<std::string> run_step(Asked& asked, Step step, Console& console) {
  COLLINEA_TRY(Settings settings, read_settings(asked.project));
  apply_flags(asked, settings);
  COLLINEA_TRY(Project project, create_project(asked.project, settings, console.run()));
  console.log_to(project.folder / "log.txt");
  COLLINEA_TRY(bring_up_to(project, step));
  return std::string();
}

}  // namespace

Command step_command(Step step, const std::string& summary) {
  return console_command<Asked>(
      std::string(word_of(step)), summary + "; earlier steps are done first where they are missing",
      [step](Flags& flags, Asked& asked) { declare(std::string(word_of(step)), flags, asked); },
      [step](Asked& asked, Console& console) { return run_step(asked, step, console); });
}

}  // namespace collinea
