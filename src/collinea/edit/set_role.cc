// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/set_role.h"

#include "collinea/edit/internal/words_in.h"
#include "collinea/edit/set_point.h"

namespace collinea {

Result<SetRole> SetRole::parse(std::span<const std::string> words) {
  if (words.size() != 2) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "NAME"));
  COLLINEA_TRY(const ControlRole role, role_in(words[1]));
  return SetRole{words[0], role};
}

std::vector<std::string> SetRole::words() const { return {point, word_of_role(role)}; }

Result<SetRole> SetRole::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> SetRole::apply(const EditContext&, EditedPoint& edited) const {
  if (!edited.point) return fail(Errc::kNotFound, "there is no point " + point);
  edited.point->role = role;
  return {};
}

}  // namespace collinea
