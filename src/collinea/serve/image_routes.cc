// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/image_routes.h"

#include <limits>

#include "collinea/serve/control_json.h"
#include "collinea/serve/internal/json_answer.h"

namespace collinea {
namespace {

// A coordinate of a tile, or the number of an image.
std::optional<int> small_number(std::string_view text) {
  const auto number = number_of(text);
  return number && *number <= std::uint64_t(std::numeric_limits<int>::max()) ? std::optional(int(*number))
                                                                             : std::nullopt;
}

std::optional<TileAddress> tile_address(std::span<const std::string> path) {
  constexpr std::string_view kEnding = ".jpg";
  std::string_view last = path[2];
  if (!last.ends_with(kEnding)) return std::nullopt;
  last.remove_suffix(kEnding.size());
  const auto level = small_number(path[0]), column = small_number(path[1]), row = small_number(last);
  return level && column && row ? std::optional(TileAddress{*level, *column, *row}) : std::nullopt;
}

// Where tiles are kept; nothing where a link leads out of the project.
std::optional<std::filesystem::path> tile_folder(const std::filesystem::path& project) {
  std::error_code error;
  const std::filesystem::path root = std::filesystem::canonical(project, error);
  const std::filesystem::path folder = std::filesystem::weakly_canonical(root / "cache" / "tiles", error);
  return !error && folder == root / "cache" / "tiles" ? std::optional(folder) : std::nullopt;
}

HttpResponse tile_response(const HttpRequest& request, const ProjectView& view, ImageId image,
                           const TileAddress& address, TileCache& tiles) {
  const auto folder = tile_folder(view.project.folder);
  if (!folder) return error_answer(422, "cache/tiles of the project leads out of it: remove that link");
  const Camera& camera = view.block.camera_of(image);
  const auto tile =
      tiles.tile(*folder, {view.image_files.at(image), camera.width_px, camera.height_px, image.value}, address);
  if (!tile) return error_answer(tile.error());
  const std::string tag = "\"" + tile->tag + "\"";
  HttpResponse response{.type = "image/jpeg"};
  if (request.header("if-none-match") == tag)
    response.status = 304;
  else
    response.body = tile->jpeg;
  response.headers = {{"ETag", tag}, {"Cache-Control", "private, max-age=86400"}};
  return response;
}

}  // namespace

HttpResponse image_response(const HttpRequest& request, const ServedProject& project, std::span<const std::string> path,
                            ProjectViews& views) {
  const auto view = views.of(project);
  if (!view) return error_answer(view.error());
  if (path.empty()) return answer_or_error(images_json(**view));
  const auto number = small_number(path[0]);
  if (!number || !(*view)->block.images.contains(ImageId{std::uint32_t(*number)})) return not_found();
  const ImageId image{std::uint32_t(*number)};
  if (path.size() == 5 && path[1] == "tiles") {
    const auto address = tile_address(path.subspan(2));
    return address ? tile_response(request, **view, image, *address, views.tiles()) : not_found();
  }
  if (path.size() == 2 && path[1] == "residuals") return answer_or_error(residuals_json(**view, image));
  if (path.size() == 2 && path[1] == "tags") return answer_or_error(tags_json(**view, image));
  return not_found();
}

}  // namespace collinea
