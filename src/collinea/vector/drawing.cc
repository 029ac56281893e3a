// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/drawing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/base/result.h"

namespace collinea {

std::optional<Eigen::Vector3d> DrawnVertex::sigma_m() const {
  if (!covariance_m2) return std::nullopt;
  return Eigen::Vector3d(covariance_m2->diagonal().cwiseMax(0).cwiseSqrt());
}

std::optional<LayerColour> colour_in(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  LayerColour colour{};
  for (std::size_t i = 0; i < 6; ++i) {
    const char c = text[i + 1];
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                             : -1;
    if (digit < 0) return std::nullopt;
    colour[i / 2] = static_cast<std::uint8_t>(16 * colour[i / 2] + digit);
  }
  return colour;
}

std::string text_of(const LayerColour& colour) {
  std::string text = "#";
  for (const std::uint8_t part : colour) {
    text += "0123456789abcdef"[part / 16];
    text += "0123456789abcdef"[part % 16];
  }
  return text;
}

DrawnFeatures::DrawnFeatures(std::initializer_list<DrawnFeature> features) {
  for (const DrawnFeature& feature : features) add(feature);
}

const DrawnFeature* DrawnFeatures::find(const std::string& id) const {
  const auto found = order_of_.find(id);
  return found == order_of_.end() ? nullptr : &by_order_.at(found->second);
}
DrawnFeature* DrawnFeatures::find(const std::string& id) {
  const auto found = order_of_.find(id);
  return found == order_of_.end() ? nullptr : &by_order_.at(found->second);
}

void DrawnFeatures::add(DrawnFeature feature) {
  const std::uint64_t order = by_order_.empty() ? 0 : by_order_.rbegin()->first + 1;
  const bool is_new = order_of_.emplace(feature.id, order).second;
  COLLINEA_CHECK(is_new);
  by_order_.emplace_hint(by_order_.end(), order, std::move(feature));
}

bool DrawnFeatures::erase(const std::string& id) {
  const auto found = order_of_.find(id);
  if (found == order_of_.end()) return false;
  by_order_.erase(found->second);
  order_of_.erase(found);
  return true;
}

std::vector<DrawingLayer> layers_of(const Drawing& drawing, std::span<const DrawingCode> codes) {
  std::vector<DrawingLayer> layers = drawing.layers;
  const auto is_known = [&](const std::string& name) {
    return std::ranges::find(layers, name, &DrawingLayer::name) != layers.end();
  };
  const std::size_t named = layers.size();
  for (const DrawingCode& code : codes) {
    const auto known = std::ranges::find(layers, code.layer, &DrawingLayer::name);
    if (known == layers.end())
      layers.push_back({code.layer, code.kind, code.colour});
    else if (std::size_t(known - layers.begin()) >= named && known->kind != code.kind)
      known->kind.reset();  // codes of several kinds share it
  }
  for (const DrawnFeature& feature : drawing.features)
    if (!is_known(feature.layer)) layers.push_back({feature.layer});
  return layers;
}

}  // namespace collinea
