// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edited_work.h"

namespace collinea {

std::string patches_text(const EditedWork& work) {
  std::string text;
  for (const SeamPatch& one : work.patches) {
    text += std::to_string(one.image.value) + " " + std::to_string(one.ring_m.size()) + ":";
    for (const Eigen::Vector2d& point : one.ring_m)
      text.append(reinterpret_cast<const char*>(point.data()), sizeof(double) * 2);
  }
  return text;
}

}  // namespace collinea
