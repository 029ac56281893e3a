// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/internal/named_areas.h"

#include "collinea/edit/internal/ring_words.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {

Result<NamedArea> named_area_in(std::span<const std::string> words, std::string_view form, std::string_view what,
                                std::string_view x, std::string_view y) {
  if (words.size() < 2) return wrong_form(form);
  NamedArea area{words[0], words[1], {}};
  COLLINEA_TRY(check_new_name(area.name, what));
  COLLINEA_TRY(check_name(area.image, "IMAGE"));
  COLLINEA_TRY(area.ring, ring_in(words.subspan(2), form, x, y));
  COLLINEA_TRY(check_ring(area.ring));
  return area;
}

std::vector<std::string> words_of_area(const std::string& name, const std::string& image,
                                       const std::vector<Eigen::Vector2d>& ring) {
  std::vector<std::string> words = {name, image};
  append_words(ring, words);
  return words;
}

Result<std::string> known_name_in(std::span<const std::string> words, std::string_view form, std::string_view what) {
  if (words.size() != 1) return wrong_form(form);
  COLLINEA_TRY(check_name(words[0], what));
  return words[0];
}

Result<std::string> file_named(const EditContext& context, const std::string& image) {
  return context.image(image).map([&](ImageId id) { return context.block().images.at(id).file; });
}

}  // namespace collinea
