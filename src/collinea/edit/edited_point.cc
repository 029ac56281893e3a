// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edited_point.h"

#include "collinea/block/world_frame.h"

namespace collinea {

Result<ImageId> EditContext::image(const std::string& name) const {
  if (const auto found = images_.find(name)) return *found;
  return fail(Errc::kNotFound, "no image is called " + name +
                                   ", or several are: name one by its path below the folder of the photographs");
}

Result<std::optional<LocalFrame>> EditContext::frame() const {
  if (!frame_) frame_ = world_frame(block_);
  return *frame_;
}

}  // namespace collinea
