// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/steps/simulated_project.h"
#include "collinea/synthetic/film.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

enum class World { kAerial, kFacade };
constexpr Word<World> kWorldWords[] = {{World::kAerial, "aerial", "a drone block"},
                                       {World::kFacade, "facade", "a walk before a wall"}};
constexpr std::span<const Word<World>> words(World) { return kWorldWords; }

struct SceneOptions {
  World scene = World::kAerial;
  bool observations_only = false;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SceneOptions;
    visit(Field{"scene", &O::scene, "", "what is photographed"});
    visit(Field{"observations_only", &O::observations_only, "",
                "no photographs: the folder becomes a project with features and verified pairs, from which "
                "`collinea orient` goes on (aerial only)"});
  }
};

struct Asked {
  std::string folder;
  SceneOptions scene;
  SurveyOptions aerial;
  FilmOptions film;
  FacadeOptions facade;
  ObservationOptions observations;
  ConsoleOptions console;
};

Result<> simulate_as(const Asked& asked, const Run& run) {
  const bool is_aerial = asked.scene.scene == World::kAerial;
  if (asked.scene.observations_only && !is_aerial)
    return fail(Errc::kBadInput, "only of an aerial block there are observations without photographs",
                {"observations_only"_option, "scene"_option});
  if (asked.film.film && (!is_aerial || asked.scene.observations_only))
    return fail(Errc::kBadInput, "film is of an aerial block, and scanned: there are no observations without scans",
                {"film"_option, "scene"_option, "observations_only"_option});
  if (asked.film.film) return simulate(asked.aerial, asked.film, asked.folder, run);
  if (asked.scene.observations_only) return simulate_project(asked.aerial, asked.observations, asked.folder, run);
  return is_aerial ? simulate(asked.aerial, asked.folder, run) : simulate(asked.facade, asked.folder, run);
}

}  // namespace

Command simulate_command() {
  return console_command<Asked>(
      "simulate", "render a survey of a made-up world: photographs, control and the truth beside them",
      [](Flags& flags, Asked& asked) {
        flags.positional("folder", asked.folder, "where images/, control.csv and truth/ go; made when missing");
        flags.add_all(asked.scene, "scene");
        flags.add_all(asked.aerial, "aerial");
        flags.add_all(asked.film, "film");
        flags.add_all(asked.facade, "facade");
        flags.add_all(asked.observations, "observations");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        const Run run = console.run();
        COLLINEA_TRY(simulate_as(asked, run));
        run.say("block in " + asked.folder);
        return std::string();
      });
}

}  // namespace collinea
