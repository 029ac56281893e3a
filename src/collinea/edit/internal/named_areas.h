// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edited_point.h"

namespace collinea {

/// What commands of masks and patches say: a name, a photograph, an outline.
struct NamedArea {
  std::string name, image;
  std::vector<Eigen::Vector2d> ring;
};

/// The words behind the command. `what` names what is named, `x` and `y` the coordinates. Errors: another form, a name
/// that cannot be new, no image, an outline without an area.
[[nodiscard]] Result<NamedArea> named_area_in(std::span<const std::string> words, std::string_view form,
                                              std::string_view what, std::string_view x, std::string_view y);
[[nodiscard]] std::vector<std::string> words_of_area(const std::string& name, const std::string& image,
                                                     const std::vector<Eigen::Vector2d>& ring);
/// The name of something that is there already, alone.
[[nodiscard]] Result<std::string> known_name_in(std::span<const std::string> words, std::string_view form,
                                                std::string_view what);
/// The photograph as the block calls it. Error: none, or several.
[[nodiscard]] Result<std::string> file_named(const EditContext& context, const std::string& image);

/// Lays an area over all others; one of its name goes.
template <class Area>
void put_on_top(std::vector<Area>& areas, Area area) {
  std::erase_if(areas, [&](const Area& one) { return one.name == area.name; });
  areas.push_back(std::move(area));
}

/// Error: there is none of the name; `what` says of what.
template <class Area>
Result<> remove_named(std::vector<Area>& areas, const std::string& name, std::string_view what) {
  const auto removed = std::erase_if(areas, [&](const Area& one) { return one.name == name; });
  if (removed == 0) return fail(Errc::kNotFound, "there is no " + std::string(what) + " " + name);
  return {};
}

}  // namespace collinea
