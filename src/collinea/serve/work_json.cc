// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/work_json.h"

#include <nlohmann/json.hpp>

#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json ring_json(const std::vector<Eigen::Vector2d>& ring) {
  json all = json::array();
  for (const Eigen::Vector2d& point : ring) all.push_back({number(point.x()), number(point.y())});
  return all;
}

}  // namespace

std::string work_json(const ProjectView& view) {
  json all = {{"masks", json::array()}, {"patches", json::array()}};
  for (const ImageMask& one : view.work.masks)
    all["masks"].push_back({{"name", one.name},
                            {"image", one.image ? json(one.image->value) : json(nullptr)},
                            {"ring", ring_json(one.ring_px)}});
  for (const SeamPatch& one : view.work.patches) {
    const auto image = view.block.images.find(one.image);
    if (image == view.block.images.end()) continue;
    all["patches"].push_back({{"name", one.name},
                              {"image", one.image.value},
                              {"file", image->second.file},
                              {"ring", ring_json(one.ring_m)}});
  }
  return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace collinea
