// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/stereo_routes.h"

#include "collinea/io/text.h"
#include "collinea/serve/internal/json_answer.h"
#include "collinea/serve/internal/target.h"
#include "collinea/serve/stereo_json.h"

namespace collinea {
namespace {

std::optional<std::pair<std::string_view, std::string_view>> halves(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  return std::pair(text.substr(0, comma), text.substr(comma + 1));
}

std::optional<ImageId> image_id(std::string_view text) {
  const auto number = number_of(text);
  return number && *number < ImageId::kNone ? std::optional(ImageId{std::uint32_t(*number)}) : std::nullopt;
}

Result<AskedStereo> asked_stereo(const Target& target) {
  AskedStereo asked;
  if (const auto found = target.query.find("at"); found != target.query.end()) {
    const auto both = halves(found->second);
    const auto east = both ? finite_number(both->first) : std::nullopt;
    const auto north = both ? finite_number(both->second) : std::nullopt;
    if (!east || !north) return fail(Errc::kBadInput, "at: it is easting and northing, as 350123.5,5412345.25");
    asked.on_map = Eigen::Vector2d(*east, *north);
  }
  if (const auto found = target.query.find("images"); found != target.query.end()) {
    const auto both = halves(found->second);
    const auto one = both ? image_id(both->first) : std::nullopt, other = both ? image_id(both->second) : std::nullopt;
    if (!one || !other) return fail(Errc::kBadInput, "images: they are two numbers of images, as 3,4");
    asked.images = std::pair(*one, *other);
  }
  return asked;
}

}  // namespace

std::optional<HttpResponse> stereo_response(const HttpRequest& request, const Target& target,
                                            const ServedProject& project, ProjectViews& views) {
  if (target.path.size() != 4 || (target.path[3] != "stereo" && target.path[3] != "ground")) return std::nullopt;
  const bool sets = target.path[3] == "ground", posts = request.method == "POST";
  if (posts != sets) return method_not_allowed(posts ? "GET" : "POST");
  if (posts && !request.header("content-type").starts_with("application/json"))
    return error_answer(415, "a mark is described as application/json");
  return answer_or_error([&]() -> Result<std::string> {
    COLLINEA_TRY(const auto view, views.of(project));
    if (sets) return ground_json(*view, request.body);
    COLLINEA_TRY(const AskedStereo asked, asked_stereo(target));
    return stereo_json(*view, asked);
  }());
}

}  // namespace collinea
