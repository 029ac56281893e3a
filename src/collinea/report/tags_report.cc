// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/tags_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace collinea {

std::string tags_text(const TagsReport& report) {
  std::string text;
  for (const NamedTag& one : report.tags)
    text += fmt::format("{}: {} {} column {:.3f} row {:.3f} px, standard deviation {:.3f} px, side {:.0f} px, {}\n",
                        report.images[one.image].filename().string(), word_of(one.tag.family), one.tag.id,
                        one.tag.at.x(), one.tag.at.y(), one.tag.sigma_px(), one.tag.least_side_px(),
                        one.point.empty() ? "no mark" : "point " + one.point);
  const auto marks = std::ranges::count_if(report.tags, [](const NamedTag& one) { return !one.point.empty(); });
  return text + fmt::format("{} tags in {} images, {} of them marks: {}\n", report.tags.size(), report.images.size(),
                            marks, report.file.string());
}

}  // namespace collinea
