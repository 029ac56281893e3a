// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/remove_point.h"

#include "collinea/edit/internal/words_in.h"

namespace collinea {

Result<RemovePoint> RemovePoint::parse(std::span<const std::string> words) {
  if (words.size() != 1) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "POINT"));
  return RemovePoint{words[0]};
}

std::vector<std::string> RemovePoint::words() const { return {point}; }

Result<RemovePoint> RemovePoint::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> RemovePoint::apply(const EditContext&, EditedPoint& edited) const {
  if (!edited.point) return fail(Errc::kNotFound, "there is no point " + point);
  if (edited.is_measured_on_ground)
    return fail(Errc::kBadInput, "measurements on the ground name point " + point +
                                     ": it cannot be removed; the command role makes it a check point");
  edited.point.reset();
  edited.marks.clear();
  return {};
}

}  // namespace collinea
