// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/mark_point.h"

#include <fmt/format.h>

#include "collinea/edit/internal/words_in.h"
#include "collinea/io/text.h"

namespace collinea {

Result<MarkPoint> MarkPoint::parse(std::span<const std::string> words) {
  if (words.size() != 4 && words.size() != 5) return wrong_form(kForm);
  MarkPoint mark{.point = words[0], .image = words[1]};
  COLLINEA_TRY(check_name(mark.point, "POINT"));
  COLLINEA_TRY(check_name(mark.image, "IMAGE"));
  COLLINEA_TRY(mark.pixel.x(), number_in(words[2], "X"));
  COLLINEA_TRY(mark.pixel.y(), number_in(words[3], "Y"));
  if (words.size() == 5) {
    COLLINEA_TRY(mark.sigma_px, sigma_in(words[4], "SIGMA_PX"));
  }
  return mark;
}

std::vector<std::string> MarkPoint::words() const {
  std::vector<std::string> words = {point, image, exact(pixel.x()), exact(pixel.y())};
  if (sigma_px) words.push_back(exact(*sigma_px));
  return words;
}

Result<MarkPoint> MarkPoint::completed(const EditContext& context, const EditDefaults& defaults) const {
  MarkPoint mark = *this;
  COLLINEA_TRY(const ImageId id, context.image(image));
  mark.image = context.block().images.at(id).file;
  COLLINEA_TRY(check_name(mark.image, "IMAGE"));
  if (!mark.sigma_px) mark.sigma_px = defaults.sigma_px;
  return mark;
}

Result<> MarkPoint::apply(const EditContext& context, EditedPoint& edited) const {
  if (!edited.point)
    return fail(Errc::kNotFound,
                fmt::format("there is no point {0}: add it first (point {0} control E N H; - - - where "
                            "no coordinate is known)",
                            point));
  COLLINEA_TRY(const ImageId id, context.image(image));
  const Camera& camera = context.block().camera_of(id);
  if (!inside(camera, pixel))
    return fail(Errc::kBadInput, fmt::format("pixel {} {} lies outside {}, which has {} x {} pixels", exact(pixel.x()),
                                             exact(pixel.y()), image, camera.width_px, camera.height_px));
  edited.marks[id] = {{.point = {}, .image = id, .pixel = pixel, .sigma_px = sigma_px.value_or(1)}};
  return {};
}

}  // namespace collinea
