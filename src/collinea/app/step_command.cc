// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  Settings flags;  ///< holds what the flags say; only those given go into the project
  std::vector<std::function<void(Settings&)>> changes;
  ConsoleOptions console;
};

void declare(const std::shared_ptr<Asked>& asked, const std::string& step, Flags& flags) {
  flags.positional("project", asked->project, "project folder");
  const Given seed_given = flags.add("seed", asked->flags.seed, "", kSeedHelp);
  asked->changes.push_back([seed_given, asked = asked.get()](Settings& settings) {
    if (seed_given()) settings.seed = asked->flags.seed;
  });
  flags.add_all(asked->console, "run");
  Settings::each(asked->flags, [&](const char* owner, const char* group, auto& options) {
    if (owner != step) return;
    flags.add_all(options, group, [&](const auto& field, const Given& given) {
      asked->changes.push_back([given, member = field.member, from = &options](Settings& settings) {
        if (!given()) return;
        Settings::each(settings, [&](const char*, const char*, auto& target) {
          if constexpr (std::is_same_v<std::decay_t<decltype(target)>, std::decay_t<decltype(*from)>>)
            target.*member = from->*member;
        });
      });
    });
  });
}

int run_step(const Asked& asked, const std::string& step) {
  auto console = Console::create(asked.console);
  if (!console) return complain(console.error());
  auto settings = read_settings(asked.project);
  if (!settings) return console->complain(settings.error());
  for (const auto& change : asked.changes) change(*settings);
  for (auto* path : {&settings->orient.orientation, &settings->ortho.seamlines}) {
    if (*path && (*path)->empty())
      path->reset();
    else if (*path)
      *path = std::filesystem::absolute(**path).lexically_normal().string();
  }
  auto project = create_project(asked.project, *settings, console->run());
  if (!project) return console->complain(project.error());
  console->log_to(project->folder / "log.txt");
  if (auto done = bring_up_to(*project, step); !done) return console->complain(done.error());
  return 0;
}

}  // namespace

Command step_command(const std::string& step, const std::string& summary) {
  auto asked = std::make_shared<Asked>();
  return {step, summary + "; earlier steps are done first where they are missing",
          [asked, step](Flags& flags) { declare(asked, step, flags); },
          [asked, step] { return run_step(*asked, step); }};
}

}  // namespace collinea
