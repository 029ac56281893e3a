// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/project_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "collinea/jobs/info.h"
#include "collinea/project/json_text.h"
#include "collinea/report/json_values.h"
#include "collinea/report/step_figures.h"
#include "collinea/report/step_words.h"
#include "collinea/serve/internal/bounded_json.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json step_json(Step step, const ProjectInfo& info) {
  json one = {{"name", word_of(step)}, {"done", false}};
  if (std::ranges::count(info.by_another_version, step)) one["by_another_version"] = true;
  for (const StepRecord& record : info.steps) {
    if (record.name() != word_of(step)) continue;
    one["done"] = true;
    one["seconds"] = number(record.seconds);
    one["summary"] = summary_of(record.outcome);
    one["figures"] = figures_of(record.outcome, info.setup);
  }
  return one;
}

json findings_of(const ProjectInfo& info) {
  json all = json::array();
  for (const StepRecord& record : info.steps) {
    const json figures = figures_of(record.outcome, info.setup);
    if (const auto findings = figures.find("findings"); findings != figures.end())
      for (const json& finding : *findings) all.push_back(finding);
  }
  return all;
}

// A project that was only made has no database yet.
Result<ProjectInfo> info_of(const std::filesystem::path& folder) {
  const auto store = ProjectStore::open_to_read(folder);
  if (store) return project_info(*store);
  if (store.error().code == Errc::kNotFound) return ProjectInfo{};
  return tl::unexpected(store.error());
}

json status_json(const JobStatus& status) {
  json one = {{"id", status.id},
              {"project", status.project},
              {"name", status.project_name},
              {"step", word_of(status.step)},
              {"state", word_of(status.state)},
              {"stage", status.stage},
              {"done", number(status.done)},
              {"elapsed_s", number(status.elapsed_s)},
              {"left_s", status.left_s ? number(*status.left_s) : json(nullptr)}};
  if (!status.error.empty()) one["error"] = status.error;
  if (!status.findings.empty()) one["findings"] = json::parse(status.findings);
  return one;
}

}  // namespace

std::string projects_json(std::span<const ServedProject> projects) {
  json list = json::array();
  for (const ServedProject& project : projects)
    list.push_back({{"id", project.id}, {"name", project.name}, {"folder", project.folder.string()}});
  return text_of(list);
}

Result<std::string> project_json(const ServedProject& project) {
  COLLINEA_TRY(const ProjectInfo info, info_of(project.folder));
  const OrientationRecord* orientation = info.orientation();
  json all = {{"id", project.id},
              {"name", project.name},
              {"folder", project.folder.string()},
              {"images", info.setup.images.size()},
              {"cameras", info.setup.cameras.size()},
              {"oriented", orientation ? orientation->oriented : 0},
              {"crs", info.setup.georeference ? json(info.setup.georeference->crs) : json(nullptr)},
              {"steps", json::array()},
              {"findings", findings_of(info)},
              {"files", json::array()}};
  for (const Word<Step>& step : kStepWords) all["steps"].push_back(step_json(step.value, info));
  for (const ProjectFile& file : files_of(project.folder))
    all["files"].push_back({{"path", file.path}, {"bytes", file.bytes}});
  return text_of(all);
}

Result<std::string> project_findings(const ProjectStore& store) {
  COLLINEA_TRY(const ProjectInfo info, project_info(store));
  return text_of(findings_of(info));
}

std::string changes_json(const JobChanges& changes, std::span<const GrownJournal> grown) {
  json all = {{"board", changes.board}, {"number", changes.number}, {"jobs", json::array()}, {"log", json::array()}};
  for (const JobStatus& status : changes.jobs) all["jobs"].push_back(status_json(status));
  for (const JobLine& line : changes.lines) all["log"].push_back({{"job", line.job}, {"line", line.text}});
  for (const GrownJournal& one : grown) all["edits"].push_back({{"project", one.project}, {"number", one.number}});
  return text_of(all);
}

std::string job_json(std::uint64_t id) { return text_of({{"job", id}}); }

Result<JobRequest> job_request_in(std::string_view body) {
  try {
    const json asked = bounded_json(body);
    JobRequest request;
    COLLINEA_TRY(request.step, step_named(asked.at("step").get<std::string>()));
    if (asked.contains("options")) request.options = text_of(asked.at("options"));
    return request;
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
}

}  // namespace collinea
