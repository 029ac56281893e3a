// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <utility>

#include "collinea/feature/edges.h"
#include "collinea/feature/tags.h"
#include "collinea/raster/image_file.h"
#include "collinea/report/json_values.h"
#include "collinea/serve/control_json.h"

namespace collinea {

Result<std::string> tags_json(const ProjectView& view, ImageId image) {
  using json = nlohmann::ordered_json;
  COLLINEA_TRY(const GreyImage grey, read_grey(view.image_files.at(image)));
  const std::vector<Tag> tags = find_tags(as_float(grey), {});
  std::map<std::pair<TagFamily, int>, int> often;
  for (const Tag& tag : tags) ++often[{tag.family, tag.id}];
  json list = json::array();
  for (const Tag& tag : tags)
    if (often[{tag.family, tag.id}] == 1)
      list.push_back({{"family", word_of(tag.family)},
                      {"number", tag.id},
                      {"pixel", {number(tag.at.x()), number(tag.at.y())}},
                      {"sigma_px", number(std::sqrt(tag.covariance.trace() / 2))}});
  return json{{"tags", list}}.dump();
}

}  // namespace collinea
