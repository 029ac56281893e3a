// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/control_routes.h"

#include "collinea/serve/control_json.h"
#include "collinea/serve/internal/json_answer.h"
#include "collinea/serve/internal/target.h"
#include "collinea/serve/work_json.h"

namespace collinea {
namespace {

Result<std::size_t> most_of(const Target& target, std::size_t otherwise) {
  const auto found = target.query.find("most");
  if (found == target.query.end()) return otherwise;
  const auto number = number_of(found->second);
  if (!number || *number == 0) return fail(Errc::kBadInput, "most: it is a number of points, 1 or more");
  return std::size_t(*number);
}

}  // namespace

std::optional<HttpResponse> control_response(const HttpRequest& request, const Target& target,
                                             const ServedProject& project, ProjectViews& views) {
  const std::string& what = target.path[3];
  const bool asks_for_marks = what == "control" && target.path.size() == 6 && target.path[5] == "places";
  const bool asks_for_now =
      what == "control" && target.path.size() == 5 && (target.path[4] == "now" || target.path[4] == "next");
  const bool is_plain = what == "map" || what == "ties" || what == "control" || what == "work" || what == "refine";
  if (!asks_for_marks && !asks_for_now && (!is_plain || target.path.size() != 4)) return std::nullopt;
  const bool posts = request.method == "POST";
  if (posts != (what == "refine")) return method_not_allowed(posts ? "GET" : "POST");
  if (posts && !request.header("content-type").starts_with("application/json"))
    return error_answer(415, "a mark is described as application/json");
  return answer_or_error([&]() -> Result<std::string> {
    COLLINEA_TRY(const auto view, views.of(project));
    if (asks_for_marks) return predicted_marks_json(*view, target.path[4]);
    if (asks_for_now) return target.path[4] == "now" ? control_now_json(*view) : next_mark_json(*view);
    if (what == "map") return map_json(*view);
    if (what == "control") return control_json(*view);
    if (what == "work") return work_json(*view);
    if (what == "refine") return refined_json(*view, request.body);
    COLLINEA_TRY(const std::size_t most, most_of(target, 20'000));
    return ties_json(*view, most);
  }());
}

}  // namespace collinea
