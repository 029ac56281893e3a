// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/drawing_routes.h"

#include "collinea/serve/drawing_json.h"
#include "collinea/serve/internal/json_answer.h"
#include "collinea/serve/internal/target.h"

namespace collinea {
namespace {

Result<std::optional<ImageId>> image_of(const Target& target) {
  const auto found = target.query.find("image");
  if (found == target.query.end()) return std::optional<ImageId>();
  const auto number = number_of(found->second);
  if (!number || *number >= ImageId::kNone) return fail(Errc::kBadInput, "image: the number of an image");
  return std::optional(ImageId{std::uint32_t(*number)});
}

}  // namespace

std::optional<HttpResponse> drawing_response(const HttpRequest& request, const Target& target,
                                             const ServedProject& project, ProjectViews& views) {
  const std::string& what = target.path[3];
  const bool is_asked = what == "vertices" || what == "figures" || what == "volume" || what == "profile";
  if ((!is_asked && what != "drawing") || target.path.size() != 4) return std::nullopt;
  const bool posts = request.method == "POST";
  if (posts != is_asked) return method_not_allowed(posts ? "GET" : "POST");
  if (posts && !request.header("content-type").starts_with("application/json"))
    return error_answer(415, "what is measured is described as application/json");
  return answer_or_error([&]() -> Result<std::string> {
    COLLINEA_TRY(const std::optional<ImageId> image, image_of(target));
    COLLINEA_TRY(const auto view, views.of(project));
    if (what == "vertices") return vertices_json(*view, request.body);
    if (what == "figures") return figures_json(*view, request.body);
    if (what == "volume") return volume_over_json(*view, request.body);
    if (what == "profile") return profile_json(*view, request.body);
    return drawing_json(*view, image);
  }());
}

}  // namespace collinea
