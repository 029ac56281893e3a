// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/unmark_point.h"

#include "collinea/edit/internal/words_in.h"

namespace collinea {

Result<UnmarkPoint> UnmarkPoint::parse(std::span<const std::string> words) {
  if (words.size() != 2) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "POINT"));
  COLLINEA_TRY(check_name(words[1], "IMAGE"));
  return UnmarkPoint{words[0], words[1]};
}

std::vector<std::string> UnmarkPoint::words() const { return {point, image}; }

Result<UnmarkPoint> UnmarkPoint::completed(const EditContext& context, const EditDefaults&) const {
  COLLINEA_TRY(const ImageId id, context.image(image));
  const std::string& file = context.block().images.at(id).file;
  COLLINEA_TRY(check_name(file, "IMAGE"));
  return UnmarkPoint{point, file};
}

Result<> UnmarkPoint::apply(const EditContext& context, EditedPoint& edited) const {
  COLLINEA_TRY(const ImageId id, context.image(image));
  if (edited.marks.erase(id) == 0) return fail(Errc::kNotFound, "point " + point + " is not marked in " + image);
  return {};
}

}  // namespace collinea
