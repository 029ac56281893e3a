// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/edits_json.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/cloud/las.h"
#include "collinea/serve/internal/bounded_json.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json line_or_null(const EditEntry* entry) { return entry ? json(line_of(words_of(entry->edit))) : json(nullptr); }

}  // namespace

std::string edits_json(const EditHistory& history, std::uint64_t since, std::size_t most) {
  std::vector<const EditEntry*> chosen;
  for (const EditEntry& entry : history.entries())
    if (entry.changed > since) chosen.push_back(&entry);
  const std::size_t left_out = chosen.size() > most ? chosen.size() - most : 0;
  json all = {{"number", history.number()},
              {"undo", line_or_null(history.next_undo())},
              {"redo", line_or_null(history.next_redo())},
              {"entries", json::array()},
              {"left_out", left_out}};
  for (std::size_t i = left_out; i < chosen.size(); ++i)
    all["entries"].push_back({{"number", chosen[i]->number},
                              {"time", chosen[i]->time},
                              {"command", words_of(chosen[i]->edit)},
                              {"undone", chosen[i]->undone}});
  return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string cloud_json(const std::filesystem::path& project, std::span<const CloudRegion> regions) {
  const auto path_of = [&](LasForm form) -> json {
    const std::string path = "products/" + las_file_name("cloud", form);
    return is_there(project / path) ? json(path) : json(nullptr);
  };
  const json las = path_of(LasForm::kLas);
  json all = {{"file", path_of(LasForm::kCopc)}, {"other", las.is_null() ? path_of(LasForm::kLaz) : las}};
  all["regions"] = json::array();
  const auto height = [](const std::optional<double>& value) { return value ? json(*value) : json(nullptr); };
  for (const CloudRegion& region : regions) {
    json ring = json::array();
    for (const Eigen::Vector2d& point : region.ring_m) ring.push_back({point.x(), point.y()});
    const bool classifies = region.action == CloudAction::kClassify;
    all["regions"].push_back({{"action", word_of(region.action)},
                              {"class", classifies ? json(region.classification) : json(nullptr)},
                              {"ring", std::move(ring)},
                              {"low_m", height(region.low_m)},
                              {"high_m", height(region.high_m)}});
  }
  return all.dump();
}

Result<Edit> edit_in(std::string_view body) {
  try {
    const json asked = bounded_json(body);
    return parse_edit(asked.at("command").get<std::vector<std::string>>());
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
}

}  // namespace collinea
