// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/app/exit_code.h"
#include "collinea/pipeline/project.h"

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
  flags.add_all(asked->console, "run");
  Settings::each(asked->flags, [&](const char* owner, const char* group, auto& options) {
    if (owner != step) return;
    flags.add_all(options, group, [&](const auto& field, const Given& given) {
      asked->changes.push_back([given, member = field.member, from = &options](Settings& settings) {
        if (!given()) return;
        Settings::each(settings, [&](const char*, const char*, auto& target) {
          if constexpr (std::is_same_v<decltype(&target), decltype(from)>) target.*member = from->*member;
        });
      });
    });
  });
}

int run_step(const Asked& asked, const std::string& step) {
  auto console = Console::create(asked.console);
  if (!console) return complain(console.error());
  auto settings = read_settings(asked.project);
  if (!settings) return complain(settings.error());
  for (const auto& change : asked.changes) change(*settings);
  auto project = create_project(asked.project, *settings, console->run());
  if (!project) return complain(project.error());
  console->log_to(project->folder / "log.txt");
  if (auto done = bring_up_to(*project, step); !done) {
    console->run().say("error: " + done.error().message);
    return exit_code(done.error().code);
  }
  return 0;
}

}  // namespace

Command step_command(const std::string& step, const std::string& summary) {
  auto asked = std::make_shared<Asked>();
  return {step, summary + "; earlier steps are done first where they are missing",
          [asked, step](Flags& flags) { declare(asked, step, flags); }, [asked, step] { return run_step(*asked, step); }};
}

}  // namespace collinea
