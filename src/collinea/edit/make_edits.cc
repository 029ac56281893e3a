// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/make_edits.h"

#include <algorithm>
#include <chrono>
#include <map>

#include "collinea/base/file.h"
#include "collinea/edit/work_in_force.h"
#include "collinea/project/settings.h"

namespace collinea {
namespace {

Result<EditDefaults> defaults_of(const std::filesystem::path& project) {
  return read_settings(project).map([](const Settings& settings) {
    return EditDefaults{settings.import.control_sigma_m, settings.import.control_sigma_px};
  });
}

/// Edits that come one after the other, each on what those before it made.
class Maker {
 public:
  Maker(const EditableSetup& setup, const EditHistory& history, const EditDefaults& defaults)
      : points_(setup, history), history_(history), defaults_(defaults) {}

  Result<NewEdit> make(const Edit& edit) {
    return std::visit(
        [&](const auto& kind) -> Result<NewEdit> {
          if constexpr (EditsPoint<std::decay_t<decltype(kind)>>) {
            COLLINEA_TRY(auto completed, kind.completed(points_.context(), defaults_));
            EditedPoint& point = point_named(kind.point);
            const EditedPoint before = point;
            COLLINEA_TRY(completed.apply(points_.context(), point));
            return NewEdit{completed, restoring(kind.point, before, point, points_.context().block())};
          } else if constexpr (EditsWork<std::decay_t<decltype(kind)>>) {
            COLLINEA_TRY(auto completed, kind.completed(points_.context(), defaults_));
            if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, DrawFeature>) name(completed);
            EditedWork& now = work();
            std::vector<Words> replaced = completed.restoring(points_.context(), now);
            COLLINEA_TRY(completed.apply(points_.context(), now));
            return NewEdit{completed, std::move(replaced)};
          } else {
            return NewEdit{kind};
          }
        },
        edit);
  }

 private:
  EditedPoint& point_named(const std::string& name) {
    const auto known = edited_.find(name);
    return known != edited_.end() ? known->second : edited_.emplace(name, points_.point(name)).first->second;
  }

  EditedWork& work() {
    if (!work_) work_ = work_in_force(points_.context(), history_);
    return *work_;
  }

  // The next id, behind all that were ever given, also to features that were undone.
  void name(DrawFeature& draw) {
    if (!last_feature_) {
      last_feature_ = 0;
      for (const EditEntry& entry : history_.entries())
        if (const auto* drawn = std::get_if<DrawFeature>(&entry.edit))
          last_feature_ = std::max(*last_feature_, DrawFeature::number_of(drawn->feature));
    }
    if (draw.feature == "*") draw.feature = DrawFeature::id_of(*last_feature_ + 1);
    last_feature_ = std::max(*last_feature_, DrawFeature::number_of(draw.feature));
  }

  PointsInForce points_;
  const EditHistory& history_;
  EditDefaults defaults_;
  std::map<std::string, EditedPoint> edited_;
  std::optional<EditedWork> work_;  // made when the first edit asks for it
  std::optional<std::uint64_t> last_feature_;
};

Result<std::vector<NewEdit>> made(std::span<const Edit> edits, Maker maker) {
  std::vector<NewEdit> all;
  for (const Edit& edit : edits) {
    COLLINEA_TRY(NewEdit one, maker.make(edit).map_error([&](Error error) {
      return edits.size() == 1 ? error : std::move(error).within(line_of(words_of(edit)));
    }));
    all.push_back(std::move(one));
  }
  return all;
}

constexpr std::chrono::milliseconds kPatience(300);  // of who waits at a screen

}  // namespace

Result<EditsMade> make_edits(const std::filesystem::path& project, Journal& journal, std::span<const Edit> edits) {
  if (!is_there(project / "block.db"))
    return fail(Errc::kNotFound, project.string() + " is not a project with photographs: import some first");
  COLLINEA_TRY(const EditDefaults defaults, defaults_of(project));
  COLLINEA_TRY(ProjectStore store, ProjectStore::open(project, kPatience));
  COLLINEA_TRY(const EditableSetup setup, store.read_editable_setup());  // waits for no writer
  EditsMade done;
  const auto make = [&](const EditHistory& history) { return made(edits, Maker(setup, history, defaults)); };
  COLLINEA_TRY(done.number, journal.append(make));
  if (const auto applied = apply_edits(store, journal); !applied) done.waiting = applied.error();
  return done;
}

namespace {

// What is in force of a journal as it is when the database is written; `all` outlives it.
EditControl control_in_force(Journal& journal, EditsInForce& all) {
  return [&](const EditableSetup& setup) -> Result<EditedControl> {
    COLLINEA_TRY(journal.refresh());
    all = edits_in_force(setup, journal.history());
    return all.edited;
  };
}

}  // namespace

Result<std::vector<UnfitEdit>> apply_edits(ProjectStore& store, Journal& journal) {
  COLLINEA_TRY(const std::uint64_t last, store.last_edit());
  COLLINEA_TRY(journal.refresh());  // behind what the store holds, which is appended before
  EditsInForce all;
  if (last == journal.number()) return all.unfit;
  COLLINEA_TRY(store.edit_setup(control_in_force(journal, all)));
  return all.unfit;
}

Result<std::vector<UnfitEdit>> write_setup_with_edits(ProjectStore& store, const Block& setup, Journal& journal) {
  COLLINEA_TRY(journal.refresh());
  EditsInForce all;
  COLLINEA_TRY(store.write_setup(setup, journal.number() > 0 ? control_in_force(journal, all) : EditControl()));
  return all.unfit;
}

}  // namespace collinea
