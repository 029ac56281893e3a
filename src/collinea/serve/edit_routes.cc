// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/edit_routes.h"

#include "collinea/serve/edits_json.h"
#include "collinea/serve/internal/json_answer.h"

namespace collinea {
namespace {

HttpResponse new_edit(const HttpRequest& request, const ServedProject& project, EditJournals& journals) {
  if (!request.header("content-type").starts_with("application/json"))
    return error_answer(415, "an edit is described as application/json");
  return answer_or_error(
      edit_in(request.body)
          .and_then([&](const Edit& edit) { return journals.make(project, edit); })
          .map([](const EditsMade& made) { return "{\"number\":" + std::to_string(made.number) + "}"; }));
}

}  // namespace

HttpResponse edits_response(const HttpRequest& request, const Target& target, const ServedProject& project,
                            EditJournals& journals) {
  if (request.method == "POST") return new_edit(request, project, journals);
  std::uint64_t since = 0;
  if (const auto asked = target.query.find("since"); asked != target.query.end()) {
    const auto number = number_of(asked->second);
    if (!number) return error_answer(400, "since: a number of an entry");
    since = *number;
  }
  return answer_or_error(journals.edits(project, since));
}

HttpResponse cloud_response(const ServedProject& project, EditJournals& journals) {
  return answer_or_error(journals.cloud_regions(project).map(
      [&](const std::vector<CloudRegion>& regions) { return cloud_json(project.folder, regions); }));
}

}  // namespace collinea
